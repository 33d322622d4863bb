// SPDX-License-Identifier: Apache-2.0
#include "cli/weights.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "network/mtl_weights.hpp"
#include "training/last_layer_fit.hpp"
#include "training/mtl_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHiddenLayers = "hidden.tensors";

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

constexpr int64_t kMostBytes = 1 << 24;

/// Folder of the user's cache, "" where there is no home.
std::string cache_folder() {
  std::string cache = variable("XDG_CACHE_HOME");
  if (cache.empty() && !variable("HOME").empty()) cache = variable("HOME") + "/.cache";
  return cache.empty() ? "" : cache + "/elastogen/weights";
}

/// Path of a file in the first folder that has it, "" if none has.
std::string find_file(const std::string& name) {
  for (const std::string& folder : weight_folders()) {
    const std::string path = folder + '/' + name;
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path;
  }
  return "";
}

/// @throws Error for what no fit has kept its limits for (docs/materials.md).
void check_has_net(const Material& m) {
  ELASTOGEN_CHECK(m.poisson <= 0.499, "no net: Poisson's ratio of '", m.name, "' is ", m.poisson,
                  ", nets are made up to 0.499");
  const double shape = m.law.shape;
  ELASTOGEN_CHECK(m.law.kind != Law::Kind::kOgden || (shape >= -4 && shape <= 8),
                  "no net: the exponent of '", m.name, "' is ", shape,
                  ", nets are made from -4 to 8");
  ELASTOGEN_CHECK(m.law.kind != Law::Kind::kGent || shape >= 12, "no net: the limit of '", m.name,
                  "' is ", shape, ", nets are made from 12 on");
}

/// The bytes of a weight file for a material, fitted on hidden layers.
std::string fitted_weights(const Material& m, const TensorFile& hidden, const std::string& hash) {
  const FitMaterial material = fit_material(law_name(m.law), m.poisson);
  LastLayerOptions options;
  options.enough = 1e-4;  // rms; the limits are on the median, p99 and largest error
  const LastLayer layer(hidden.get("neural_mtl", {kMtlParameters}).values, options);
  const LastLayerFit fit = layer.fit(material);
  const FitReport report = fit_report(material, fit.weights);
  ELASTOGEN_CHECK(report.passes(), "no net: the fit to material '", m.name, "', ", law_name(m.law),
                  " with Poisson ratio ", m.poisson, ", misses its limits: stress errors ",
                  report.stress_median, " / ", report.stress_p99, " / ", report.stress_max,
                  ", tangent ", report.tangent_p99);
  const TrainerCard trainer = {{"trainer.hidden", hash},
                               {"trainer.last_layer", std::to_string(fit.iterations)}};
  return encode_tensors(mtl_file(material, fit.weights, report, trainer));
}

/// A net that no file is shipped for, of the cache or fitted now.
std::shared_ptr<const LearnedLaw> fitted_net(const Material& m, Evaluation evaluation) {
  const std::string path = find_file(kHiddenLayers);
  ELASTOGEN_CHECK(!path.empty(), "no net: there is none of material '", m.name, "', ",
                  law_name(m.law), " with Poisson ratio ", m.poisson, ", and no ", kHiddenLayers,
                  " to fit one on in ", fmt::format("{}", fmt::join(weight_folders(), ", ")));
  const std::string bytes = read_file(path, kMostBytes);
  const std::string hash = hex(sha256(bytes));
  std::string cached = cache_folder();
  if (!cached.empty())
    cached += '/' + hash.substr(0, 16) + '-' + weight_file_name(m.law, m.poisson);
  std::error_code error;
  try {
    if (fs::is_regular_file(cached, error))
      return read_weights(read_file(cached, kMostBytes), cached, m.law, m.poisson, evaluation);
  } catch (const Error&) {  // damaged: made again
  }
  const std::string made = fitted_weights(m, decode_tensors(bytes, path), hash);
  try {
    fs::create_directories(cache_folder(), error);
    if (!cached.empty()) write_file(cached, made);
  } catch (const Error&) {  // the next run fits again
  }
  return read_weights(made, weight_file_name(m.law, m.poisson), m.law, m.poisson, evaluation);
}

}  // namespace

std::vector<std::string> weight_folders() {
  std::vector<std::string> folders;
  if (const std::string named = variable("ELASTOGEN_WEIGHTS"); !named.empty())
    folders.push_back(named);
  if (const std::string cache = cache_folder(); !cache.empty()) folders.push_back(cache);
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error)
    folders.push_back((self.parent_path().parent_path() / "share/elastogen/weights").string());
  folders.push_back(ELASTOGEN_WEIGHTS_OF_SOURCE);
  return folders;
}

std::string find_weights(Law law, double poisson) {
  return find_file(weight_file_name(law, poisson));
}

std::shared_ptr<const LearnedLaw> net_of(const Material& m, Evaluation evaluation) {
  check_has_net(m);
  const std::string path = find_weights(m.law, m.poisson);
  if (path.empty()) return fitted_net(m, evaluation);
  return read_weights(read_file(path, kMostBytes), path, m.law, m.poisson, evaluation);
}

LearnedLaws scene_nets(const Scene& scene, const AnimateOptions& options,
                       std::vector<std::string>& notes) {
  LearnedLaws nets;
  if (options.energy == EnergySource::kAnalytic) return nets;
  const bool asked = options.energy == EnergySource::kNeural;
  const Evaluation evaluation =
      asked && !options.solver.skip ? Evaluation::kNet : Evaluation::kTable;
  for (const Material& material : scene.materials) {
    const auto same = std::find_if(nets.begin(), nets.end(), [&](const auto& net) {
      return net && net->law() == material.law && net->poisson() == material.poisson;
    });
    try {
      nets.push_back(same != nets.end() ? *same : net_of(material, evaluation));
    } catch (const Error& error) {
      if (asked) throw;
      nets.push_back(nullptr);
      notes.push_back(concat("material '", material.name, "' is taken by its law: ", error.what()));
    }
  }
  const bool none = std::all_of(nets.begin(), nets.end(), [](const auto& net) { return !net; });
  return none ? LearnedLaws() : nets;
}

}  // namespace elastogen
