// SPDX-License-Identifier: Apache-2.0
#include "cli/weights.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "network/mtl_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// Poisson ratios that a law has weights for, in order.
std::string known_ratios(Law law) {
  const std::string start = std::string(law_name(law)) + '-', end = ".weights";
  std::vector<double> ratios;
  for (const std::string& folder : weight_folders()) {
    std::error_code error;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(start) || !name.ends_with(end)) continue;
      double ratio = 0;
      const char *from = name.data() + start.size(), *to = name.data() + name.size() - end.size();
      if (std::from_chars(from, to, ratio).ptr == to) ratios.push_back(ratio);
    }
  }
  std::sort(ratios.begin(), ratios.end());
  ratios.erase(std::unique(ratios.begin(), ratios.end()), ratios.end());
  return ratios.empty() ? "none" : fmt::format("{}", fmt::join(ratios, ", "));
}

std::shared_ptr<const LearnedLaw> net_of(const Material& m, Evaluation evaluation) {
  const std::string path = find_weights(m.law, m.poisson);
  ELASTOGEN_CHECK(!path.empty(), "--energy neural: there is no net of material '", m.name, "', ",
                  law_name(m.law), " with Poisson ratio ", m.poisson, "; there are those of ",
                  known_ratios(m.law), ". Choose one of them, or --energy analytic");
  constexpr int64_t kMostBytes = 1 << 24;
  return read_weights(read_file(path, kMostBytes), path, m.law, m.poisson, evaluation);
}

}  // namespace

std::vector<std::string> weight_folders() {
  std::vector<std::string> folders;
  if (const std::string named = variable("ELASTOGEN_WEIGHTS"); !named.empty())
    folders.push_back(named);
  std::string cache = variable("XDG_CACHE_HOME");
  if (cache.empty() && !variable("HOME").empty()) cache = variable("HOME") + "/.cache";
  if (!cache.empty()) folders.push_back(cache + "/elastogen/weights");
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error)
    folders.push_back((self.parent_path().parent_path() / "share/elastogen/weights").string());
  folders.push_back(ELASTOGEN_WEIGHTS_OF_SOURCE);
  return folders;
}

std::string find_weights(Law law, double poisson) {
  for (const std::string& folder : weight_folders()) {
    const std::string path = folder + '/' + weight_file_name(law, poisson);
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path;
  }
  return "";
}

LearnedLaws scene_nets(const Scene& scene, const AnimateOptions& options) {
  LearnedLaws nets;
  if (!options.neural) return nets;
  const Evaluation evaluation = options.solver.skip ? Evaluation::kTable : Evaluation::kNet;
  for (const Material& material : scene.materials) {
    const auto same = std::find_if(nets.begin(), nets.end(), [&](const auto& net) {
      return net->law() == material.law && net->poisson() == material.poisson;
    });
    nets.push_back(same != nets.end() ? *same : net_of(material, evaluation));
  }
  return nets;
}

}  // namespace elastogen
