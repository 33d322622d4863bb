// SPDX-License-Identifier: Apache-2.0
#include "io/asset_check.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/cloud_check.hpp"

#include <numeric>

namespace elastogen {
namespace {

void check_positions(const Asset& asset, const Mesh& mesh) {
  for (size_t i = 0; i < mesh.position.size(); ++i)
    for (const double x : mesh.position[i])
      ELASTOGEN_CHECK_ASSET(std::isfinite(x), asset.path, ": mesh \"", mesh.name, "\": vertex ", i,
                            " (counted from 0) is not finite");
}

void check_indices(const Asset& asset, const Mesh& mesh) {
  for (size_t d = 0; d < mesh.position_of.size(); ++d)
    ELASTOGEN_CHECK_ASSET(
        mesh.position_of[d] >= 0 && size_t(mesh.position_of[d]) < mesh.position.size(), asset.path,
        ": mesh \"", mesh.name, "\": drawn vertex ", d, " has the position ", mesh.position_of[d],
        " of ", mesh.position.size());
  for (const TriangleGroup& group : mesh.groups) {
    ELASTOGEN_CHECK_ASSET(group.corner.size() % 3 == 0, asset.path, ": mesh \"", mesh.name,
                          "\": ", group.corner.size(), " corners are no triangles");
    ELASTOGEN_CHECK_ASSET(group.material >= -1 && group.material < int(asset.materials.size()),
                          asset.path, ": mesh \"", mesh.name, "\": there is no material ",
                          group.material);
    for (size_t k = 0; k < group.corner.size(); ++k)
      ELASTOGEN_CHECK_ASSET(
          group.corner[k] >= 0 && size_t(group.corner[k]) < mesh.position_of.size(), asset.path,
          ": mesh \"", mesh.name, "\": triangle ", k / 3, " has the vertex ", group.corner[k],
          ", there are ", mesh.position_of.size());
  }
}

/// One value for each drawn vertex, all finite.
template <size_t N>
void check_attribute(Asset& asset, const Mesh& mesh, std::vector<std::array<float, N>>& values,
                     const std::array<float, N>& value, const char* name) {
  ELASTOGEN_CHECK_ASSET(values.empty() || values.size() == mesh.position_of.size(), asset.path,
                        ": mesh \"", mesh.name, "\": ", values.size(), ' ', name, " for ",
                        mesh.position_of.size(), " vertices");
  reset_bad_rows(asset, values, value, name);
}

/// Normal of each drawn vertex by its faces, as long as twice their area.
std::vector<Vec3> area_normals(const Mesh& mesh) {
  std::vector<Vec3> sum(mesh.position_of.size(), Vec3{});
  for (const TriangleGroup& group : mesh.groups)
    for (size_t t = 0; t + 2 < group.corner.size(); t += 3) {
      Vec3 x[3];
      for (size_t k = 0; k < 3; ++k)
        x[k] = mesh.position[size_t(mesh.position_of[size_t(group.corner[t + k])])];
      const Vec3 n = cross(minus(x[1], x[0]), minus(x[2], x[0]));
      for (size_t k = 0; k < 3; ++k)
        for (size_t d = 0; d < 3; ++d) sum[size_t(group.corner[t + k])][d] += n[d];
    }
  return sum;
}

/// Gives normals the length one. Deviations within a file's rounding are neither counted nor
/// mended.
void mend_normals(Asset& asset, Mesh& mesh) {
  constexpr double kCounted = 1e-2, kRounding = 1e-6;
  const auto length_of = [](const auto& n) {
    return std::hypot(double(n[0]), double(n[1]), double(n[2]));
  };
  // by_area is made for the first normal of length zero, as few assets have one
  std::vector<Vec3> by_area;
  int64_t zero = 0, counted = 0;
  for (size_t v = 0; v < mesh.normal.size(); ++v) {
    Vec3 n = {mesh.normal[v][0], mesh.normal[v][1], mesh.normal[v][2]};
    double length = length_of(n);
    if (std::abs(length - 1) <= kRounding) continue;
    // no direction: that of the faces around the vertex, else z
    if (length == 0) {
      ++zero;
      if (by_area.empty()) by_area = area_normals(mesh);
      n = by_area[v];
      length = length_of(n);
      if (!(length > 0 && std::isfinite(length))) n = {0, 0, 1}, length = 1;
    } else {
      counted += std::abs(length - 1) > kCounted;
    }
    for (size_t d = 0; d < 3; ++d) mesh.normal[v][d] = float(n[d] / length);
  }
  const std::string where = ", the first in the mesh \"" + mesh.name + '"';
  add_finding(asset, "zero-normals", zero, "normals have no length" + where);
  add_finding(asset, "long-normals", counted, "normals are not of length one" + where);
}

/// Whether a group can show a texture.
bool has_uv(const Mesh& mesh, const TriangleGroup& group) {
  return group.has_uv && !mesh.uv.empty();
}

/// A texture needs coordinates. Triangles without them get their material without its texture, or
/// a copy of it where triangles with coordinates show the same material.
void drop_textures_without_uv(Asset& asset) {
  // materials that nobody shows with coordinates lose their texture in place
  std::vector<int> plain(asset.materials.size());  // itself, -1 if a copy must be made
  std::iota(plain.begin(), plain.end(), 0);
  for (const Mesh& mesh : asset.meshes)
    for (const TriangleGroup& group : mesh.groups)
      if (group.material >= 0 && has_uv(mesh, group)) plain[size_t(group.material)] = -1;
  // each group without coordinates gets the plain material, copied once
  std::vector<uint8_t> cleared(plain.size(), 0);
  for (Mesh& mesh : asset.meshes)
    for (TriangleGroup& group : mesh.groups) {
      const auto m = size_t(group.material);
      if (group.material < 0 || has_uv(mesh, group) || group.corner.empty()) continue;
      if (asset.materials[m].texture.empty() && !cleared[m]) continue;
      add_finding(asset, "missing-uvs", int64_t(group.corner.size() / 3),
                  "triangles with a texture have no coordinates in it, the first in the mesh \"" +
                      mesh.name + '"');
      if (plain[m] < 0) {
        plain[m] = int(asset.materials.size());
        AssetMaterial copy = asset.materials[m];
        asset.materials.push_back(std::move(copy));
      }
      group.material = plain[m];
      cleared[m] = 1;
      asset.materials[size_t(plain[m])].texture.clear();
    }
}

/// Findings about vertices, edges and faces of the welded surface.
void add_topology(Asset& asset, const Surface& surface, const WeldedMesh& w) {
  add_finding(asset, "zero-area", w.zero_area, "triangles have no area");
  add_finding(asset, "duplicate-faces", w.duplicate_faces, "triangles repeat another one");
  add_finding(asset, "double-sided", w.opposite_pairs,
              "triangles are there twice, once from each side");
  add_finding(asset, "unreferenced", w.unreferenced, "vertices belong to no triangle");
  if (asset.format == "obj" || asset.format == "ply" ||
      asset.format == "off")  // other formats split vertices by design
    add_finding(asset, "duplicate-vertices", w.merged - repeated_positions(asset),
                "vertices lie on another one");
  add_finding(asset, "non-manifold", w.nonmanifold_edges, "edges have three faces or more");
  add_finding(asset, "open", w.border_edges, "edges have one face: the surface is open");
  add_finding(asset, "mixed-winding", w.turned_edges,
              "edges lie between two triangles of opposite winding");
  // some bodies inside out among others: the volume may be nothing but rounding
  const double box_volume = surface.box.extent(0) * surface.box.extent(1) * surface.box.extent(2);
  if (w.closed() && w.balanced() && w.volume < -1e-9 * box_volume)
    add_finding(asset, "flipped", surface.triangles.rows(),
                "triangles are wound inside out, all of them");
  if (w.pieces > 1) add_finding(asset, "pieces", w.pieces, "pieces are not joined by an edge");
}

}  // namespace

void add_finding(Asset& asset, const std::string& what, int64_t count, const std::string& text) {
  if (count == 0) return;
  for (Finding& finding : asset.findings) {
    if (finding.what != what) continue;
    finding.count += count;
    return;
  }
  asset.findings.push_back({what, count, text});
}

void check_asset(Asset& asset) {
  if (asset.points || asset.splats) return check_cloud(asset);
  // the document of a glTF file is kept as it is
  const bool is_gltf = asset.format == "glb" || asset.format == "gltf";
  for (Mesh& mesh : asset.meshes) {
    check_positions(asset, mesh);
    check_indices(asset, mesh);
    check_attribute(asset, mesh, mesh.uv, {0, 0}, "uvs");
    check_attribute(asset, mesh, mesh.normal, {0, 0, 1}, "normals");
    check_attribute(asset, mesh, mesh.colour, {1, 1, 1, 1}, "colours");
    if (!is_gltf) mend_normals(asset, mesh);
  }
  if (!is_gltf) drop_textures_without_uv(asset);
  const Surface surface = pose_surface(asset);
  const WeldedMesh welded = weld(surface);
  ELASTOGEN_CHECK_ASSET(welded.zero_area < surface.triangles.rows(), asset.path,
                        ": no triangle has an area: nothing to simulate");
  add_topology(asset, surface, welded);
}

}  // namespace elastogen
