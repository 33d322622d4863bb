// SPDX-License-Identifier: Apache-2.0
#include "training/mtl_files.hpp"

#include <charconv>

namespace elastogen {
namespace {

/// The shortest text that reads back as the same number.
template <class Number>
std::string text_of(Number value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

}  // namespace

TensorFile mtl_file(const FitMaterial& material, std::span<const float> weights,
                    const FitReport& report, const FitOptions& options) {
  TensorFile file;
  file.text = {{"law", law_text(material.terms)},
               {"poisson", text_of(material.poisson)},
               {"error.stress.median", text_of(report.stress_median)},
               {"error.stress.p99", text_of(report.stress_p99)},
               {"error.stress.max", text_of(report.stress_max)},
               {"error.tangent.p99", text_of(report.tangent_p99)},
               {"error.energy.max", text_of(report.energy_max)},
               {"error.strains", text_of(report.strains)},
               {"error.passes", report.passes() ? "yes" : "no"},
               {"trainer.steps", text_of(options.steps)},
               {"trainer.samples", text_of(options.samples)},
               {"trainer.rate", text_of(options.rate)},
               {"trainer.seed", text_of(options.seed)},
               {"trainer.start", start_name(options)}};
  file.tensors = {{"neural_mtl", {kMtlParameters}, {weights.begin(), weights.end()}}};
  return file;
}

std::string report_table(const std::vector<FitMaterial>& materials,
                         const std::vector<FitReport>& reports) {
  std::string table =
      "name,law,poisson,stress_median,stress_p99,stress_max,tangent_p99,energy_max,passes\n";
  for (size_t n = 0; n < materials.size(); ++n) {
    const FitReport& r = reports[n];
    table += materials[n].name + ',' + law_text(materials[n].terms) + ',' +
             text_of(materials[n].poisson);
    for (const double error :
         {r.stress_median, r.stress_p99, r.stress_max, r.tangent_p99, r.energy_max})
      table += ',' + text_of(error);
    table += r.passes() ? ",yes\n" : ",no\n";
  }
  return table;
}

}  // namespace elastogen
