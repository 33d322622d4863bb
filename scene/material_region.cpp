// SPDX-License-Identifier: Apache-2.0
#include "scene/material_region.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "mpm_fem/materials/solid_presets.hpp"
#include "scene/solid_text.hpp"
#include "voxelize/labels.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <optional>
#include <set>

namespace elastogen {
namespace {

void change(Solid& solid, std::string_view text) {
  const size_t at = text.find('=');
  const std::string_view key = trimmed(text.substr(0, at));
  ELASTOGEN_CHECK(at != text.npos, "'", text, "' is no KEY=VALUE");
  change_solid(key, trimmed(text.substr(at + 1)), solid);
}

Solid parse_solid(std::string_view text) {
  size_t comma = text.find(',');
  Solid solid = solid_preset(trimmed(text.substr(0, comma))).solid;
  while (comma != text.npos) {
    text.remove_prefix(comma + 1);
    comma = text.find(',');
    change(solid, trimmed(text.substr(0, comma)));
  }
  check_solid(solid);
  return solid;
}

MaterialRegion parse(std::string_view text) {
  // split at the last colon, as names may have colons and materials have none
  const size_t colon = text.rfind(':');
  ELASTOGEN_CHECK(colon != text.npos, "the colon between selection and material is missing");
  MaterialRegion region;
  const std::string_view selection = trimmed(text.substr(0, colon));
  using Kind = MaterialRegion::Kind;
  for (const auto& [word, kind] : {std::pair("node:", Kind::kNode), {"material:", Kind::kMaterial}})
    if (selection.starts_with(word)) {
      region.kind = kind;
      region.name = trimmed(selection.substr(std::string_view(word).size()));
      ELASTOGEN_CHECK(!region.name.empty(), "nothing follows '", word, "'");
    }
  if (region.kind == Kind::kPlace) region.selection = parse_selection(selection);
  Solid solid = parse_solid(text.substr(colon + 1));
  region.material = std::move(solid.elastic);
  region.yield = solid.yield;
  return region;
}

/// Whether a name fits a pattern; * stands for any letters or none.
bool fits(std::string_view pattern, std::string_view name) {
  size_t p = 0, n = 0, star = pattern.npos, tried = 0;
  while (n < name.size())
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      tried = n;
    } else if (p < pattern.size() && pattern[p] == name[n]) {
      ++p, ++n;
    } else if (star != pattern.npos) {
      p = star + 1;
      n = ++tried;
    } else {
      return false;
    }
  return pattern.find_first_not_of('*', p) == pattern.npos;
}

/// 1 for each row whose name fits the pattern. @throws Error if none does.
template <class Rows>
std::vector<uint8_t> named(const Rows& rows, const MaterialRegion& region) {
  std::vector<uint8_t> result(rows.size());
  std::set<std::string> known;
  bool any = false;
  for (size_t k = 0; k < rows.size(); ++k) {
    if (!rows[k].name.empty()) known.insert(rows[k].name);
    result[k] = fits(region.name, rows[k].name);
    any |= result[k] != 0;
  }
  std::string list;
  for (const std::string& name : known) list += (list.empty() ? "'" : ", '") + name + "'";
  const bool node = region.kind == MaterialRegion::Kind::kNode;
  ELASTOGEN_CHECK(any, "--region '", region.text, "': the asset has no ",
                  node ? "node" : "material", " '", region.name, "'; it has ",
                  list.empty() ? "none with a name" : list);
  return result;
}

/// 1 for each triangle of a named region, (triangles).
std::vector<uint8_t> named_triangles(const Asset& asset, const Surface& surface,
                                     const MaterialRegion& region) {
  std::vector<uint8_t> result(size_t(surface.triangles.rows()));
  if (region.kind == MaterialRegion::Kind::kMaterial) {
    const std::vector<uint8_t> wanted = named(asset.materials, region);
    for (size_t t = 0; t < result.size(); ++t) {
      const int32_t m = surface.material(int64_t(t));
      result[t] = m >= 0 && wanted[size_t(m)];
    }
    return result;
  }
  const std::vector<uint8_t> wanted = named(asset.nodes, region);
  for (const SurfaceInstance& instance : surface.instances) {
    bool inside = false;
    for (int n = instance.node; n >= 0; n = asset.nodes[size_t(n)].parent)
      inside |= wanted[size_t(n)] != 0;
    std::fill_n(result.begin() + instance.first_triangle, instance.triangles, uint8_t(inside));
  }
  return result;
}

/// Drops materials that no voxel has; the others keep their order.
void drop_unused(Scene& scene, std::vector<Yield>& yields) {
  std::vector<int32_t> place(scene.materials.size(), -1);
  for (int64_t v = 0; v < scene.material.rows(); ++v) place[size_t(scene.material(v))] = 0;
  std::vector<Material> used;
  std::vector<Yield> used_yields;
  for (size_t m = 0; m < place.size(); ++m) {
    if (place[m] < 0) continue;
    place[m] = int32_t(used.size());
    used.push_back(scene.materials[m]);
    used_yields.push_back(yields[m]);
  }
  for (int64_t v = 0; v < scene.material.rows(); ++v)
    scene.material(v) = place[size_t(scene.material(v))];
  scene.materials = std::move(used);
  yields = std::move(used_yields);
}

using Holds = std::function<bool(int64_t)>;  ///< whether a region holds an element

/// Gives the elements of each region its material.
/// @param holds_of  returns Holds for a region; valid until the next call.
template <class HoldsOf>
void give(const std::vector<MaterialRegion>& regions, const char* element, Scene& scene,
          std::vector<Yield>& yields, std::vector<std::string>& warnings, const HoldsOf& holds_of) {
  for (const MaterialRegion& region : regions) {
    const Holds holds = holds_of(region);
    int64_t count = 0;
    for (int64_t e = 0; e < scene.material.rows(); ++e) {
      if (!holds(e)) continue;
      scene.material(e) = int32_t(scene.materials.size());
      ++count;
    }
    if (count > 0)
      scene.materials.push_back(region.material), yields.push_back(region.yield);
    else
      warnings.push_back(
          fmt::format("--region '{}' holds nothing: no {} lies in it", region.text, element));
  }
  drop_unused(scene, yields);
}

}  // namespace

MaterialRegion parse_region(std::string_view text) {
  try {
    MaterialRegion region = parse(text);
    region.text = text;
    return region;
  } catch (const Error& error) {
    throw Error(concat("--region '", text, "': ", error.what(),
                       " (it reads 'SELECTION: MATERIAL', ",
                       "e.g. 'y<30%: foam' or 'node:Hat*: jelly,young=30kPa')"));
  }
}

void apply_regions(const std::vector<MaterialRegion>& regions, const Asset& asset, const Body& body,
                   Scene& scene, std::vector<Yield>& yields, std::vector<std::string>& warnings) {
  const VoxelGrid& grid = scene.grid;
  Array<int32_t> nearest;
  std::vector<uint8_t> triangles;
  give(regions, "voxel", scene, yields, warnings, [&](const MaterialRegion& region) {
    Holds holds = [&](int64_t v) {
      const double* lower = grid.rest.row(grid.corners(v, 0));
      const double half = grid.h / 2;
      return contains(region.selection, {lower[0] + half, lower[1] + half, lower[2] + half},
                      body.surface.box);
    };
    if (region.kind != MaterialRegion::Kind::kPlace) {
      ELASTOGEN_CHECK(body.is_asset, "--region '", region.text,
                      "': an asset of points has no nodes and materials; select by place");
      triangles = named_triangles(asset, body.surface, region);
      if (nearest.empty()) nearest = nearest_triangles(grid, body.surface);
      holds = [&](int64_t v) { return triangles[size_t(nearest(v))] != 0; };
    }
    return holds;
  });
}

void apply_regions(const std::vector<MaterialRegion>& regions, const fem::ElementMesh& mesh,
                   In<int32_t> region_of, const std::vector<AssetMaterial>& of_file,
                   const PlacedBox& box, Scene& scene, std::vector<Yield>& yields,
                   std::vector<std::string>& warnings) {
  std::vector<uint8_t> wanted;
  give(regions, "tetrahedron", scene, yields, warnings, [&](const MaterialRegion& region) {
    ELASTOGEN_CHECK(region.kind != MaterialRegion::Kind::kNode, "--region '", region.text,
                    "': tetrahedra have no nodes with names; select by place or material:NUMBER");
    Holds holds = [&](int64_t e) {
      Vec3 centre = {};
      const int corners = std::min(4, mesh.elements.cols());
      for (int c = 0; c < corners; ++c)
        for (int d = 0; d < 3; ++d)
          centre[size_t(d)] += mesh.rest(mesh.elements(e, c), d) / corners;
      return contains(region.selection, centre, box);
    };
    if (region.kind == MaterialRegion::Kind::kMaterial) {
      wanted = named(of_file, region);
      holds = [&](int64_t e) { return wanted[size_t(region_of(e))] != 0; };
    }
    return holds;
  });
}

}  // namespace elastogen
