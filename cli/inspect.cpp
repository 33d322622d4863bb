// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/scene_options.hpp"
#include "cli/verbs.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "io/json_text.hpp"
#include "io/scene_file.hpp"
#include "io/scene_keys.hpp"
#include "scene/asset_stages.hpp"
#include "voxelize/budget.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <optional>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMaxCounted = 2e6;  ///< voxels up to which inspect counts instead of estimating

/// Resolution and its cost.
struct Cost {
  double h = 0;        ///< [m]
  double at_most = 0;  ///< voxels, estimated from extents and areas
  int64_t voxels = 0;  ///< counted; 0 if counting would need long
  double bytes() const { return (voxels > 0 ? double(voxels) : at_most) * double(kBytesPerVoxel); }
};

Cost cost_of(const Body& body, double longest_edge, const AnimateOptions& o) {
  Cost cost;
  cost.h = o.h > 0 ? o.h : longest_edge / o.voxels;
  if (o.shape && o.shape->in_plane()) return cost;  // a run with particles only
  cost.at_most = estimate_voxels(weld(body.surface), cost.h);
  if (cost.at_most <= kMaxCounted)
    cost.voxels = voxelize(body.surface, resolution(o)).grid.voxel_count();
  return cost;
}

Json counts_of(const Asset& asset) {
  size_t vertices = 0, triangles = 0;
  for (const Mesh& mesh : asset.meshes) {
    vertices += mesh.position.size();
    for (const TriangleGroup& group : mesh.groups) triangles += group.corner.size() / 3;
  }
  return {{"meshes", asset.meshes.size()},
          {"vertices", int64_t(vertices) - repeated_positions(asset)},
          {"triangles", triangles},
          {"points", asset.points ? asset.points->position.size() : 0},
          {"splats", asset.splats ? asset.splats->position.size() : 0}};
}

template <class Items>
Json names_of(const Items& items) {
  Json names = Json::array();
  for (const auto& item : items) names.push_back(item.name);
  return names;
}

Json provenance(const Provenance& from) {
  return {{"guessed", from.guessed}, {"reason", from.reason}};
}

Json describe(const Asset& asset, const Body& body, const AssetSummary& summary, const Cost& cost) {
  // size and direction, each with its reason
  const PlacedBox& box = body.surface.box;
  Json size = {{"longest_edge", summary.size.longest_edge}};
  size.update(provenance(summary.size.from));
  Json up = {{"axis", up_name(summary.up.up)}};
  up.update(provenance(summary.up.from));
  // what readers and check noticed
  Json findings = Json::array();
  for (const Finding& f : summary.findings)
    findings.push_back({{"what", f.what},
                        {"severity", severity_name(kind_of(f).severity)},
                        {"count", f.count},
                        {"text", f.text}});
  // voxels are counted where that is quick, else estimated
  Json counted = cost.voxels > 0 ? Json(cost.voxels) : Json();
  return {{"path", asset.path},
          {"format", asset.format},
          {"counts", counts_of(asset)},
          {"nodes", names_of(asset.nodes)},
          {"materials", names_of(asset.materials)},
          {"box", {{"lower", plus(box.lower, box.origin)}, {"upper", plus(box.upper, box.origin)}}},
          {"metres_per_unit", body.surface.scale},
          {"size", size},
          {"up", up},
          {"h", cost.h},
          {"voxels", counted},
          {"voxels_at_most", cost.at_most},
          {"memory_bytes", cost.bytes()},
          {"findings", findings},
          {"warning", summary.size.warning}};
}

std::string joined(const Json& names) {
  std::string text;
  for (const Json& name : names) text += (text.empty() ? "" : ", ") + name.get<std::string>();
  return text.empty() ? "none" : text;
}

void print_text(const Json& d) {
  const auto number = [&](const char* key) { return d[key].get<double>(); };
  // the asset
  const auto& lower = d["box"]["lower"];
  const auto& upper = d["box"]["upper"];
  fmt::print("{}: {}\n", d["path"].get<std::string>(), d["format"].get<std::string>());
  for (const auto& [what, count] : d["counts"].items())
    if (count != 0) fmt::print("  {}: {}\n", what, count.get<int64_t>());
  fmt::print("  nodes: {}\n  materials: {}\n", joined(d["nodes"]), joined(d["materials"]));
  // extent, size and direction
  for (size_t k = 0; k < 3; ++k)
    fmt::print("  {}: {:.6g} ... {:.6g} m\n", "xyz"[k], lower[k].get<double>(),
               upper[k].get<double>());
  fmt::print("  longest edge {:.4g} m ({})\n", d["size"]["longest_edge"].get<double>(),
             d["size"]["reason"].get<std::string>());
  fmt::print("  {} up ({})\n", d["up"]["axis"].get<std::string>(),
             d["up"]["reason"].get<std::string>());
  // voxels and memory that a run needs
  if (d["voxels"].is_null())
    fmt::print("  voxels of {:.4g} m: at most {:.3g}\n", number("h"), number("voxels_at_most"));
  else
    fmt::print("  voxels of {:.4g} m: {}\n", number("h"), d["voxels"].get<int64_t>());
  fmt::print("  memory: about {:.3g} MB\n", number("memory_bytes") / 1e6);
  // findings
  for (const Json& f : d["findings"])
    fmt::print("  {} ({}): {}\n", f["what"].get<std::string>(), f["count"].get<int64_t>(),
               f["text"].get<std::string>());
  if (d["warning"] != "") fmt::print("  warning: {}\n", d["warning"].get<std::string>());
}

}  // namespace

int inspect(const InspectTask& task) {
  const AnimateOptions& o = task.scene;
  if (task.schema) {
    fmt::print("{}", scene_schema());
    return kExitDone;
  }
  if (o.print_resolved) {
    fmt::print("{}", scene_json(resolved_scene(o)));
    return kExitDone;
  }
  std::optional<ThreadLimit> threads;
  if (o.threads > 0) threads.emplace(o.threads);
  const Asset asset = run_asset(o);
  const Body body = make_body(asset, o.size, resolution(o));
  const AssetSummary summary = summary_of(asset, body, o);
  Json described = describe(asset, body, summary, cost_of(body, summary.size.longest_edge, o));
  if (task.is_scene) described["scene"] = parsed_json(scene_json(resolved_scene(o)));
  if (task.json)
    fmt::print("{}\n", described.dump(2, ' ', false, Json::error_handler_t::replace));
  else
    print_text(described);
  return kExitDone;
}

}  // namespace elastogen
