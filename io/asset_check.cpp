// SPDX-License-Identifier: Apache-2.0
#include "io/asset_check.hpp"

#include "core/error.hpp"
#include "io/cloud_check.hpp"

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

/// What the welded triangles tell.
void add_topology(Asset& asset, const Surface& surface, const WeldedMesh& w) {
  add_finding(asset, "zero-area", w.zero_area, "triangles have no area");
  add_finding(asset, "duplicate-faces", w.duplicate_faces, "triangles repeat another one");
  add_finding(asset, "double-sided", w.opposite_pairs,
              "triangles are there twice, once from each side");
  add_finding(asset, "unreferenced", w.unreferenced, "vertices belong to no triangle");
  if (asset.format == "obj" || asset.format == "ply" ||
      asset.format == "off")  // the others split vertices by design
    add_finding(asset, "duplicate-vertices", w.merged - repeated_positions(asset),
                "vertices lie on another one");
  add_finding(asset, "non-manifold", w.nonmanifold_edges, "edges have three faces or more");
  add_finding(asset, "open", w.border_edges, "edges have one face: the surface is open");
  add_finding(asset, "mixed-winding", w.turned_edges,
              "edges lie between two triangles of opposite winding");
  if (w.closed() && w.balanced() && w.volume < 0)
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
  for (Mesh& mesh : asset.meshes) {
    check_positions(asset, mesh);
    check_indices(asset, mesh);
    check_attribute(asset, mesh, mesh.uv, {0, 0}, "uvs");
    check_attribute(asset, mesh, mesh.normal, {0, 0, 1}, "normals");
    check_attribute(asset, mesh, mesh.colour, {1, 1, 1, 1}, "colours");
  }
  const Surface surface = pose_surface(asset);
  const WeldedMesh welded = weld(surface);
  ELASTOGEN_CHECK_ASSET(welded.zero_area < surface.triangles.rows(), asset.path,
                        ": no triangle has an area: nothing to simulate");
  add_topology(asset, surface, welded);
}

}  // namespace elastogen
