// SPDX-License-Identifier: Apache-2.0
#include "cli/asset_stages.hpp"
#include "cli/exit_code.hpp"
#include "cli/verbs.hpp"
#include "core/parallel.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <optional>
#include <string_view>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

/// What becomes of a finding; without text it is left as it is.
struct Remedy {
  std::string_view what, text;
};

// every finding that the program can make, which tests/python/test_findings.py checks
constexpr Remedy kRemedies[] = {
    {"bad-uvs", "set to 0"},
    {"bad-normals", "set to (0, 0, 1)"},
    {"bad-colours", "set to white"},
    {"bad-points", "left out, of the output too"},
    {"bad-splats", "left out, of the output too"},
    {"bad-rotations", "set to no rotation"},
    {"bad-harmonics", "set to 0"},
    {"harmonics", "left out; the colours do not depend on the view"},
    {"zero-area", "passed over by the physics; the output keeps them"},
    {"duplicate-faces", "one of each counts for the physics; the output keeps them"},
    {"double-sided", "one of them or the pair counts for the physics; the output keeps both"},
    {"duplicate-vertices", "joined for the physics; the output keeps them"},
    {"unreferenced", "passed over by the physics; they move with the nearest voxel"},
    {"open", "filled by the winding number, or as sheets where nothing is bounded"},
    {"sheet", "filled as layers of full voxels"},
    {"winding-number", "the inside is found by it"},
    {"non-manifold", "the inside is found by the winding number"},
    {"mixed-winding", "turned where that makes neighbours agree, for the physics"},
    {"turned-faces", "turned, for the physics; the output keeps its winding"},
    {"flipped", "taken as the inside's border all the same; the output keeps its winding"},
    {"pieces", ""},
    {"loose-pieces", ""},
    {"hinges", ""},
    {"splats", "the solid is built of the others; they move with what is nearest"},
    {"floaters", "the solid is built of the others; they move with what is nearest"},
    {"coarse", "the solid is built with a wider spacing"},
    {"shell", "filled as a shell"},
    {"short-face", "left out"},
    {"free-form", "left out"},
    {"not-triangles", "left out of the physics"},
    {"points-and-lines", "left out"},
    {"scene-roots", "they stand without their parent, or below the root that is named too"},
    {"animations", "replaced"},
    {"skins", "left out"},
    {"morph-targets", "left out"},
    {"embedded-texture", "shown without"},
    {"missing-texture", "shown without"},
    {"missing-normals", "the normals of the file are not used"},
    {"missing-material-file", "shown in the default colour"},
    {"vdb-grids", "left out"},
};

/// What was repaired and how; "" where nothing was.
std::string remedy_of(const Finding& finding) {
  for (const Remedy& remedy : kRemedies)
    if (remedy.what == finding.what) return std::string(remedy.text);
  return "";
}

/// What came of the file: findings and counts, or why it cannot be used.
struct Diagnosis {
  RunReport report;
  std::string error;
  ExitCode code = kExitDone;
};

Diagnosis diagnose(const AnimateOptions& options) {
  Diagnosis d;
  try {
    voxelize_asset(options, d.report);
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kAsset) throw;
    d.error = error.what();
    d.code = kExitAsset;
  }
  return d;
}

void print_json(const Diagnosis& d, const std::string& path) {
  Json findings = Json::array();
  for (const Finding& f : d.report.asset.findings) {
    const std::string remedy = remedy_of(f);
    findings.push_back({{"what", f.what},
                        {"count", f.count},
                        {"text", f.text},
                        {"repaired", !remedy.empty()},
                        {"remedy", remedy}});
  }
  const Json json = {{"path", path},
                     {"usable", d.code == kExitDone},
                     {"error", d.error},
                     {"format", d.report.asset.format},
                     {"closed", d.report.asset.closed},
                     {"voxels", d.report.voxels},
                     {"h", d.report.h},
                     {"findings", findings},
                     {"warnings", d.report.warnings}};
  fmt::print("{}\n", json.dump(2, ' ', false, Json::error_handler_t::replace));
}

void print_text(const Diagnosis& d, const std::string& path) {
  const RunReport& r = d.report;
  if (d.code == kExitDone)
    fmt::print("{}: usable: {}, {}, {} voxels of {:.4g} m\n", path, r.asset.format,
               r.asset.closed ? "closed" : "open", r.voxels, r.h);
  else
    fmt::print("{}: not usable\n", path);
  for (const Finding& f : r.asset.findings) {
    const std::string remedy = remedy_of(f);
    fmt::print("  {} ({}): {}; {}\n", f.what, f.count, f.text,
               remedy.empty() ? "left as it is" : remedy);
  }
  for (const std::string& warning : r.warnings) fmt::print("  warning: {}\n", warning);
  if (r.asset.findings.empty() && d.code == kExitDone) fmt::print("  nothing is odd\n");
}

}  // namespace

int doctor(const DoctorTask& task) {
  std::optional<ThreadLimit> threads;
  if (task.scene.threads > 0) threads.emplace(task.scene.threads);
  const Diagnosis d = diagnose(task.scene);
  (task.json ? print_json : print_text)(d, task.scene.input);
  if (d.code != kExitDone) fmt::print(stderr, "elastogen: {}\n", d.error);
  return d.code;
}

}  // namespace elastogen
