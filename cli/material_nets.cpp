// SPDX-License-Identifier: Apache-2.0
#include "cli/material_nets.hpp"

#include "cli/exit_code.hpp"
#include "cli/material_page.hpp"
#include "cli/typed.hpp"
#include "cli/weights.hpp"
#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "io/text_format.hpp"
#include "io/units.hpp"
#include "training/material_test.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

constexpr int64_t kMostTestBytes = 1 << 24;

/// A tension test says little about the Poisson ratio. Rubber is nearly incompressible; nearer to
/// 0.5 steps need more iterations.
constexpr double kTestPoisson = 0.48;

/// @throws Error (usage) unless the output has this ending and is not the input.
void check_output(const MaterialsTask& task, const std::string& input, const char* ending) {
  ELASTOGEN_CHECK(ending_of(task.output) == ending, task.output, ": the output must end in .",
                  ending);
  AnimateOptions names;
  names.input = input, names.state = task.output;
  check_outputs(names);
}

std::string report_line(const FitReport& r) {
  return fmt::format("stress median {:.3f} %, p99 {:.3f} %, max {:.2f} %; tangent p99 {:.2f} %: {}",
                     100 * r.stress_median, 100 * r.stress_p99, 100 * r.stress_max,
                     100 * r.tangent_p99, r.passes() ? "passes" : "MISSES its limits");
}

Json to_json(const FitReport& r) {
  return {{"stress_median", r.stress_median},
          {"stress_p99", r.stress_p99},
          {"stress_max", r.stress_max},
          {"tangent_p99", r.tangent_p99},
          {"energy_max", r.energy_max},
          {"strains", r.strains},
          {"passes", r.passes()}};
}

/// Law and Poisson ratio of a preset, or of a law with the typed ratio.
FitMaterial named_material(const MaterialsTask& task) {
  std::string presets;
  for (const MaterialPreset& preset : material_presets()) {
    const Material& m = preset.material;
    if (m.name == task.name) return fit_material(law_name(m.law), task.poisson.value_or(m.poisson));
    presets += (presets.empty() ? "" : ", ") + m.name;
  }
  try {
    law_terms(task.name);
  } catch (const Error& error) {
    throw Error(concat("'", task.name, "' is none of the presets ", presets,
                       ", and as a law: ", error.what()));
  }
  return fit_material(task.name, task.poisson.value_or(Material().poisson));
}

/// The tensors of a weight file. @throws Error unless they belong to the material.
TensorFile opened(const WeightFile& file, const FitMaterial& material) {
  TensorFile weights = decode_tensors(file.bytes, file.place);
  ELASTOGEN_CHECK_ASSET(is_of(weights, material), file.place, ": not the weights of ",
                        law_text(material.terms), " with Poisson ratio ", material.poisson);
  return weights;
}

// ---- material tests

std::string place_text(const TestPoint& point) {
  return fmt::format("{} {:.4g} (line {})", path_name(point.path), point.stretch, point.line);
}

Json to_json(const TestPoint& point) {
  return {{"mode", path_name(point.path)},
          {"stretch", point.stretch},
          {"stress", point.stress},
          {"line", point.line}};
}

Json to_json(const TestFit& fit, const std::vector<TestPoint>& points) {
  Json json = {{"law", law_name(fit.law)}};
  if (fit.impossible) {
    json["without_equilibrium"] = to_json(points[*fit.impossible]);
    return json;
  }
  json["young"] = fit.young;
  json["error"] = fit.error;
  json["worst"] = to_json(points[fit.worst]);
  json["worst"]["error"] = fit.worst_error;
  json["shape_at_end"] = fit.at_end;
  return json;
}

void print(const TestFit& fit, const std::vector<TestPoint>& points) {
  if (fit.impossible)
    return fmt::print("{:<26} without equilibrium of its free sides at {}\n", law_name(fit.law),
                      place_text(points[*fit.impossible]));
  Law shown = fit.law;
  shown.shape = parse_number(short_number(fit.law.shape, 6));
  fmt::print("{:<26} {:>10.5g} {:>9.3f} {:>9.3f}  {}{}\n", law_name(shown), fit.young,
             100 * fit.error, 100 * fit.worst_error, place_text(points[fit.worst]),
             fit.at_end ? "; shape at the end of its range" : "");
}

/// The material of a fit, rounded to six digits. Scenes and the cache of nets use these digits.
Material rounded(const TestFit& fit, double poisson, const std::vector<TestPoint>& points) {
  Material m;
  m.law = {fit.law.kind, parse_number(short_number(fit.law.shape, 6))};
  m.young = parse_number(short_number(fit_test({m.law}, poisson, points).young, 6));
  m.poisson = poisson;
  return m;
}

std::string scene_text(const Material& m, const TestFit& fit, size_t points) {
  return concat("# fitted to ", points, " points of a material test, rms error ",
                short_number(100 * fit.error, 3),
                " % of the stress\n# such a test does not tell the density: that of the preset "
                "holds\n[material]\nlaw = \"",
                law_name(m.law), "\"\nyoung = ", short_number(m.young, 6),
                "\npoisson = ", exact_number(m.poisson), '\n');
}

std::vector<std::string> test_warnings(const Material& m, const TestFit& fit,
                                       const std::vector<TestPoint>& points) {
  std::vector<std::string> warnings;
  const int64_t outside = points_outside(m.law, m.poisson, points);
  if (outside > 0)
    warnings.push_back(concat(outside, " of ", points.size(),
                              " points lie beyond log stretches of 0.9 or volumes of 0.5 to 2, "
                              "where nets end: --energy neural is the law itself there"));
  if (fit.at_end)
    warnings.push_back("the shape parameter is at the end of its range: another law may be nearer");
  return warnings;
}

std::vector<TestFit> fits_of(const MaterialsTask& task, double poisson,
                             const std::vector<TestPoint>& points) {
  std::vector<TestLaw> laws;
  for (const std::string& name : task.laws) laws.push_back(test_law(name));
  std::vector<TestFit> fits = fit_tests(laws.empty() ? test_laws() : laws, poisson, points);
  const TestFit& best = fits[0];
  if (best.impossible)
    throw Error(concat(task.name, ": with a Poisson ratio of ", poisson,
                       " no law that was asked for has an equilibrium of its free sides at every "
                       "point; ",
                       law_name(best.law), " has none at ", place_text(points[*best.impossible])),
                ErrorKind::kAsset);
  return fits;
}

/// Errors of the net that a scene with this material uses.
FitReport net_report(const Material& m) {
  const FitMaterial material = fit_material(law_name(m.law), m.poisson);
  const WeightFile file = weights_of(material);
  return file.made ? *file.made
                   : fit_report(material,
                                opened(file, material).get("neural_mtl", {kMtlParameters}).values);
}

}  // namespace

int report_material(const MaterialsTask& task) {
  check_output(task, "", "html");
  const FitMaterial material = named_material(task);
  const WeightFile file = weights_of(material);
  const std::string place = file.made ? file.place + ", made for this page" : file.place;
  const PageResult page = material_page(
      {material, task.name, opened(file, material), place, hex(sha256(file.bytes)), task.command});
  write_file(task.output, page.html);
  fmt::print("{}: the net of {} {} its limits\n", task.output, material.name,
             page.passes ? "passes" : "MISSES");
  return page.passes ? kExitDone : kExitDraft;
}

int generate_material(const MaterialsTask& task) {
  check_output(task, "", "weights");
  const FitMaterial material = fit_material(task.name, *task.poisson);
  const MadeWeights made = made_weights(material);
  write_file(task.output, made.bytes);
  if (task.json) {
    const Json json = {{"file", task.output},           {"law", law_text(material.terms)},
                       {"poisson", material.poisson},   {"sha256", hex(sha256(made.bytes))},
                       {"iterations", made.iterations}, {"seconds", made.seconds},
                       {"errors", to_json(made.report)}};
    fmt::print("{}\n", json.dump(2));
  } else {
    fmt::print("{}: {}\n{} iterations, {:.2f} s\n", material.name, report_line(made.report),
               made.iterations, made.seconds);
  }
  return made.report.passes() ? kExitDone : kExitDraft;
}

int fit_material_test(const MaterialsTask& task) {
  // fit the laws to the test, and a net to the best of them
  if (!task.output.empty()) check_output(task, task.name, "toml");
  const std::vector<TestPoint> points =
      read_material_test(read_file(task.name, kMostTestBytes), task.name);
  const double poisson = task.poisson.value_or(kTestPoisson);
  const std::vector<TestFit> fits = fits_of(task, poisson, points);
  const Material best = rounded(fits[0], poisson, points);
  const std::string scene = scene_text(best, fits[0], points.size());
  const std::vector<std::string> warnings = test_warnings(best, fits[0], points);
  // write its scene
  if (!task.output.empty()) write_file(task.output, scene);
  const FitReport net = net_report(best);
  // print as JSON
  if (task.json) {
    Json json = {{"points", points.size()}, {"poisson", poisson}, {"laws", Json::array()}};
    for (const TestFit& fit : fits) json["laws"].push_back(to_json(fit, points));
    json["material"] = {
        {"law", law_name(best.law)}, {"young", best.young}, {"poisson", best.poisson}};
    json["net"] = to_json(net);
    json["warnings"] = warnings;
    fmt::print("{}\n", json.dump(2));
    return kExitDone;
  }
  // print as text
  fmt::print("{} points, Poisson ratio {}{}\n\n{:<26} {:>10} {:>9} {:>9}  worst at\n",
             points.size(), poisson,
             task.poisson ? "" : ", which a tension test hardly tells: --poisson gives another",
             "law", "E [Pa]", "rms [%]", "worst [%]");
  for (const TestFit& fit : fits) print(fit, points);
  fmt::print("\n{}\nits net: {}\n", scene, report_line(net));
  for (const std::string& warning : warnings) fmt::print(stderr, "warning: {}\n", warning);
  return kExitDone;
}

}  // namespace elastogen
