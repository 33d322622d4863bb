// SPDX-License-Identifier: Apache-2.0
#include "training/mtl_files.hpp"

#include "network/law/neural_mtl.hpp"

#include <algorithm>
#include <charconv>

namespace elastogen {

std::string shortest_text(double value) {
  char text[32];
  return std::string(text, std::to_chars(text, text + sizeof text, value).ptr);
}

TensorFile mtl_file(const FitMaterial& material, std::span<const float> weights,
                    const FitReport& report, const TrainerCard& trainer) {
  TensorFile file;
  file.text = {{"form", kMtlForm},
               {"law", law_text(material.terms)},
               {"poisson", shortest_text(material.poisson)},
               {"error.stress.median", shortest_text(report.stress_median)},
               {"error.stress.p99", shortest_text(report.stress_p99)},
               {"error.stress.max", shortest_text(report.stress_max)},
               {"error.tangent.p99", shortest_text(report.tangent_p99)},
               {"error.energy.max", shortest_text(report.energy_max)},
               {"error.strains", std::to_string(report.strains)},
               {"error.passes", report.passes() ? "yes" : "no"}};
  file.text.insert(trainer.begin(), trainer.end());
  file.tensors = {{"neural_mtl", {kMtlParameters}, {weights.begin(), weights.end()}}};
  return file;
}

TensorFile hidden_file(std::span<const float> weights, const TrainerCard& trainer) {
  TensorFile file;
  file.text = {{"form", kMtlForm}};
  file.text.insert(trainer.begin(), trainer.end());
  std::vector<float> values(weights.begin(), weights.end());
  std::fill(values.end() - kMtlLast, values.end(), 0.0f);
  file.tensors = {{"neural_mtl", {kMtlParameters}, std::move(values)}};
  return file;
}

std::string report_table(const std::vector<FitMaterial>& materials,
                         const std::vector<FitReport>& reports) {
  std::string table =
      "name,law,poisson,stress_median,stress_p99,stress_max,tangent_p99,energy_max,passes\n";
  for (size_t n = 0; n < materials.size(); ++n) {
    const FitReport& r = reports[n];
    table += materials[n].name + ',' + law_text(materials[n].terms) + ',' +
             shortest_text(materials[n].poisson);
    for (const double error :
         {r.stress_median, r.stress_p99, r.stress_max, r.tangent_p99, r.energy_max})
      table += ',' + shortest_text(error);
    table += r.passes() ? ",yes\n" : ",no\n";
  }
  return table;
}

}  // namespace elastogen
