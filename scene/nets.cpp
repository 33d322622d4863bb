// SPDX-License-Identifier: Apache-2.0
#include "scene/nets.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "network/law/mtl_weights.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMostBytes = 1 << 24;

std::string variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

std::shared_ptr<const LearnedLaw> net_of(const Material& m, Evaluation evaluation,
                                         const NetMaker& make_net) {
  check_has_net(m);
  const std::string law = law_name(m.law);
  const std::string path = find_weight_file(fmt::format("{}-{}.weights", law, m.poisson));
  if (!path.empty())
    return read_weights(read_file(path, kMostBytes), path, m.law, m.poisson, evaluation);
  ELASTOGEN_CHECK(make_net, "no net: there are no weights of ", law, " with Poisson ratio ",
                  m.poisson, " in ", fmt::format("{}", fmt::join(weight_folders(), ", ")));
  return make_net(m, evaluation);
}

}  // namespace

std::string weight_cache() {
  std::string cache = variable("XDG_CACHE_HOME");
  if (cache.empty() && !variable("HOME").empty()) cache = variable("HOME") + "/.cache";
  return cache.empty() ? "" : cache + "/elastogen/weights";
}

std::vector<std::string> weight_folders() {
  std::vector<std::string> folders;
  if (const std::string named = variable("ELASTOGEN_WEIGHTS"); !named.empty())
    folders.push_back(named);
  if (const std::string cache = weight_cache(); !cache.empty()) folders.push_back(cache);
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  if (!error)
    folders.push_back((self.parent_path().parent_path() / "share/elastogen/weights").string());
  folders.push_back(ELASTOGEN_WEIGHTS_OF_SOURCE);
  return folders;
}

std::string find_weight_file(const std::string& name) {
  for (const std::string& folder : weight_folders()) {
    const std::string path = folder + '/' + name;
    std::error_code error;
    if (fs::is_regular_file(path, error)) return path;
  }
  return "";
}

void check_has_net(const Material& m) {
  ELASTOGEN_CHECK(m.poisson <= 0.499, "no net: Poisson's ratio of '", m.name, "' is ", m.poisson,
                  ", nets are made up to 0.499");
  const double shape = m.law.shape;
  ELASTOGEN_CHECK(m.law.kind != Law::Kind::kOgden || (shape >= -4 && shape <= 8),
                  "no net: the exponent of '", m.name, "' is ", shape,
                  ", nets are made from -4 to 8");
  ELASTOGEN_CHECK(m.law.kind != Law::Kind::kGent || shape >= 7.5, "no net: the limit of '", m.name,
                  "' is ", shape, ", nets are made from 7.5 on");
}

LearnedLaws scene_nets(const Scene& scene, const RunDescription& run, const NetMaker& make_net,
                       std::vector<std::string>& notes) {
  LearnedLaws nets;
  if (run.energy == EnergySource::kAnalytic) return nets;
  const bool asked = run.energy == EnergySource::kNeural;
  const Evaluation evaluation = asked && !run.solver.skip ? Evaluation::kNet : Evaluation::kTable;
  for (const Material& material : scene.materials) {
    const auto same = std::find_if(nets.begin(), nets.end(), [&](const auto& net) {
      return net && net->law() == material.law && net->poisson() == material.poisson;
    });
    try {
      nets.push_back(same != nets.end() ? *same : net_of(material, evaluation, make_net));
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
