// SPDX-License-Identifier: Apache-2.0
#include "training/train_mtl.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "training/mtl_files.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

std::vector<FitMaterial> materials_of(const TrainMtl& task) {
  if (task.list.empty()) return {fit_material(task.law, task.poisson)};
  return read_fit_materials(read_file(task.list, 1 << 20), task.list);
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error)
    throw Error(concat("cannot make the folder ", path, ": ", error.message()),
                ErrorKind::kResources);
}

/// @return how many pass.
int64_t say_reports(const std::vector<FitMaterial>& materials,
                    const std::vector<FitReport>& reports, const FitHooks& hooks) {
  for (size_t n = 0; n < reports.size(); ++n) {
    const FitReport& r = reports[n];
    char line[256];
    std::snprintf(line, sizeof line,
                  "%s: stress median %.3f %%, p99 %.3f %%, max %.2f %%; tangent p99 %.2f %%: %s",
                  materials[n].name.c_str(), 100 * r.stress_median, 100 * r.stress_p99,
                  100 * r.stress_max, 100 * r.tangent_p99, r.passes() ? "passes" : "FAILS");
    hooks.say(line);
  }
  const auto passing =
      std::count_if(reports.begin(), reports.end(), [](const FitReport& r) { return r.passes(); });
  hooks.say(concat(passing, " of ", reports.size(), " inside all limits"));
  return passing;
}

}  // namespace

TrainEnd train_mtl(const TrainMtl& task, const FitHooks& hooks) {
  const std::vector<FitMaterial> materials = materials_of(task);
  ELASTOGEN_CHECK(!task.out.empty(), "name an output");
  const bool many = !task.list.empty();
  if (many) make_folder(task.out);
  FitOptions options = task.fit;
  if (!task.start.empty()) {
    const TensorFile file = decode_tensors(read_file(task.start, 1 << 24), task.start);
    options.start = file.get("neural_mtl", {kMtlParameters}).values;
  }
  options.checkpoint = many ? task.out + "/checkpoint.part" : task.out + ".part";

  const FitOutcome outcome = fit_neural_mtl(materials, options, hooks);
  if (outcome.steps < options.steps) {
    hooks.say(concat("stopped at step ", outcome.steps, "; --resume goes on"));
    return TrainEnd::kStopped;
  }
  ReportOptions on_device;
  on_device.device = options.device;
  const std::vector<FitReport> reports = fit_reports(materials, outcome.weights, on_device);
  const int64_t passing = say_reports(materials, reports, hooks);

  for (size_t n = 0; n < materials.size(); ++n) {
    const float* row = outcome.weights.row(int64_t(n));
    const TensorFile file =
        mtl_file(materials[n], {row, size_t(kMtlParameters)}, reports[n], options);
    const std::string path = many ? task.out + '/' + materials[n].name + ".weights" : task.out;
    write_file(path, encode_tensors(file));
  }
  if (many) write_file(task.out + "/report.csv", report_table(materials, reports));
  std::error_code ignored;
  fs::remove(options.checkpoint, ignored);
  return passing == int64_t(reports.size()) ? TrainEnd::kPassing : TrainEnd::kFailing;
}

}  // namespace elastogen
