// SPDX-License-Identifier: Apache-2.0
// Start of the command to its first step, and its memory, on a solid sphere of 20448 triangles.
#include "bench/bench.hpp"
#include "bench/process.hpp"
#include "core/error.hpp"
#include "io/safe_file.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <numbers>

namespace elastogen::bench {
namespace {

/// A sphere of radius 0.5 m as OBJ.
std::string sphere() {
  constexpr int kRings = 72, kSectors = 144;
  std::string text;
  for (int i = 0; i <= kRings; ++i)
    for (int j = 0; j < kSectors; ++j) {
      const double t = std::numbers::pi * i / kRings, p = 2 * std::numbers::pi * j / kSectors;
      text += fmt::format("v {:.9f} {:.9f} {:.9f}\n", std::sin(t) * std::cos(p) / 2,
                          std::cos(t) / 2, std::sin(t) * std::sin(p) / 2);
    }
  for (int i = 0; i < kRings; ++i)
    for (int j = 0; j < kSectors; ++j) {
      const int a = i * kSectors + j + 1, b = i * kSectors + (j + 1) % kSectors + 1;
      if (i > 0) text += fmt::format("f {} {} {}\n", a, b, a + kSectors);
      if (i < kRings - 1) text += fmt::format("f {} {} {}\n", b, b + kSectors, a + kSectors);
    }
  return text;
}

struct Run {
  const char *material, *solver;
  int along;  ///< voxels along the longest edge
};

/// Of the sizes that are asked for, else what the table of the documentation has.
std::vector<Run> runs_of(const BenchTask& task) {
  if (task.sizes.empty())
    return {{"rubber", "auto", 48},
            {"jelly", "quasi", 58},
            {"rubber", "newton", 58},
            {"jelly", "quasi", 90}};
  std::vector<Run> runs;
  for (const double size : task.sizes)  // pi/6 of the cube
    runs.push_back(
        {"rubber", "auto", std::max(4, int(std::lround(std::cbrt(6 * size / std::numbers::pi))))});
  return runs;
}

Json row_of(const Run& run, const BenchTask& task, const std::string& folder) {
  // time a new process that makes one step
  const std::string report = folder + "/report.json";
  const auto begin = std::chrono::steady_clock::now();
  const int code = run_program(std::filesystem::read_symlink("/proc/self/exe").string(),
                               {"animate",
                                folder + "/sphere.obj",
                                "--material",
                                run.material,
                                "--solver",
                                run.solver,
                                "--voxels",
                                std::to_string(run.along),
                                "--pin",
                                "y<5%",
                                "--frames",
                                "1",
                                "--fps",
                                "60",
                                "--substeps",
                                "1",
                                "--quiet",
                                "--device",
                                resolved(task.device) == Device::kCuda ? "auto" : "cpu",
                                "--report",
                                report,
                                "-o",
                                folder + "/out.glb"});
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  ELASTOGEN_CHECK(code == 0, "animate ended with exit code ", code);
  const Json r = Json::parse(read_file(report));
  const Json stages = r["stage_seconds"];
  const double a_voxel = r["peak_memory_bytes"].get<double>() / r["voxels"].get<double>();
  fmt::print(
      "{} {} {} voxels: set-up {:.2f} s, first step {:.2f} s, all {:.2f} s, {:.0f} B a voxel\n",
      run.material, run.solver, r["voxels"].get<int64_t>(), stages["setup"].get<double>(),
      stages["steps"].get<double>(), seconds, a_voxel);
  return {{"material", run.material}, {"solver", run.solver},    {"voxels", r["voxels"]},
          {"device", r["device"]},    {"stage_seconds", stages}, {"seconds", seconds},
          {"bytes_a_voxel", a_voxel}};
}

}  // namespace

Json measure_startup(const BenchTask& task) {
  const TemporaryFolder folder;
  write_file(folder.path() + "/sphere.obj", sphere());
  Json rows = Json::array();
  for (const Run& run : runs_of(task)) rows.push_back(row_of(run, task, folder.path()));
  return rows;
}

}  // namespace elastogen::bench
