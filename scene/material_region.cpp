// SPDX-License-Identifier: Apache-2.0
#include "scene/material_region.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "mpm_fem/materials/solid_presets.hpp"
#include "scene/asset_part.hpp"
#include "scene/solid_text.hpp"

#include <fmt/format.h>

#include <algorithm>

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
  region.selection = parse_selection(text.substr(0, colon));
  Solid solid = parse_solid(text.substr(colon + 1));
  region.material = std::move(solid.elastic);
  region.yield = solid.yield;
  return region;
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

/// Gives the elements of each region its material.
/// @param centre_of  centre of an element, by which places select.
template <class CentreOf>
void give(const std::vector<MaterialRegion>& regions, const std::vector<AssetPart>& parts,
          const PlacedBox& box, const char* element, const CentreOf& centre_of, Scene& scene,
          std::vector<Yield>& yields, std::vector<std::string>& warnings) {
  for (const MaterialRegion& region : regions) {
    const Selection& selection = region.selection;
    const AssetPart* part = selection.is_place() ? nullptr : &part_of(parts, selection);
    int64_t count = 0;
    for (int64_t e = 0; e < scene.material.rows(); ++e) {
      if (part ? !part->elements(e) : !contains(selection, centre_of(e), box)) continue;
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

void apply_regions(const std::vector<MaterialRegion>& regions, const std::vector<AssetPart>& parts,
                   const PlacedBox& box, Scene& scene, std::vector<Yield>& yields,
                   std::vector<std::string>& warnings) {
  const VoxelGrid& grid = scene.grid;
  const auto centre_of = [&](int64_t v) {
    const double* lower = grid.rest.row(grid.corners(v, 0));
    const double half = grid.h / 2;
    return Vec3{lower[0] + half, lower[1] + half, lower[2] + half};
  };
  give(regions, parts, box, "voxel", centre_of, scene, yields, warnings);
}

void apply_regions(const std::vector<MaterialRegion>& regions, const std::vector<AssetPart>& parts,
                   const fem::ElementMesh& mesh, const PlacedBox& box, Scene& scene,
                   std::vector<Yield>& yields, std::vector<std::string>& warnings) {
  const auto centroid_of = [&](int64_t e) {
    Vec3 centre = {};
    const int corners = std::min(4, mesh.elements.cols());
    for (int c = 0; c < corners; ++c)
      for (int d = 0; d < 3; ++d) centre[size_t(d)] += mesh.rest(mesh.elements(e, c), d) / corners;
    return centre;
  };
  give(regions, parts, box, "tetrahedron", centroid_of, scene, yields, warnings);
}

}  // namespace elastogen
