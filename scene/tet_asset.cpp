// SPDX-License-Identifier: Apache-2.0
#include "scene/tet_asset.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "mpm_fem/fem/tet_mesh.hpp"
#include "mpm_fem/fem/tet_surface.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {
namespace {

/// The surface as a mesh, and the node of each of its positions.
Mesh surface_mesh(const fem::ElementMesh& tets, Array<int32_t>& node_of) {
  const Array<int32_t> triangles = fem::outer_triangles(tets);
  std::vector<int32_t> place(size_t(tets.rest.rows()), -1);
  for (int64_t k = 0; k < triangles.size(); ++k) place[size_t(triangles.data()[k])] = 0;
  Mesh mesh;
  mesh.name = "surface";
  std::vector<int32_t> nodes;
  for (size_t n = 0; n < place.size(); ++n) {
    if (place[n] < 0) continue;
    place[n] = int32_t(nodes.size());
    nodes.push_back(int32_t(n));
    const double* x = tets.rest.row(int64_t(n));
    mesh.position.push_back({x[0], x[1], x[2]});
    mesh.position_of.push_back(place[n]);
  }
  TriangleGroup& group = mesh.groups.emplace_back();
  for (int64_t k = 0; k < triangles.size(); ++k)
    group.corner.push_back(place[size_t(triangles.data()[k])]);
  node_of = Array<int32_t>(int64_t(nodes.size()));
  std::copy(nodes.begin(), nodes.end(), node_of.data());
  return mesh;
}

std::vector<Finding> findings_of(const tets::TetFile& file) {
  std::vector<Finding> findings;
  const auto add = [&](const char* what, int64_t count, const char* text) {
    if (count > 0) findings.push_back({what, count, text});
  };
  const bool plane = file.elements.cols() == 3;
  add("turned-tetrahedra", file.turned,
      plane ? "triangles had negative areas" : "tetrahedra had negative volumes");
  add("skipped-elements", file.skipped,
      plane ? "points, lines and faces are no linear triangles"
            : "points, lines and faces are no tetrahedra");
  add("unused-nodes", file.unused,
      plane ? "nodes belong to no triangle" : "nodes belong to no tetrahedron");
  return findings;
}

}  // namespace

bool is_tet_file(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == "msh" || ending == "vtk" || ending == "vtu";
}

TetAsset read_tet_asset(const std::string& path) {
  tets::TetFile file = tets::read_tets(path);
  TetAsset tets;
  tets.mesh = fem::take_mesh(file);
  try {
    fem::check_mesh(tets.mesh);  // quadratic tetrahedra may be inverted between their corners
  } catch (const Error& error) {
    throw Error(concat(path, ": ", error.what()), ErrorKind::kAsset);
  }
  tets.asset.path = path;
  tets.asset.format = ending_of(path);
  tets.asset.meshes.push_back(surface_mesh(tets.mesh, tets.node_of));
  tets.asset.nodes.push_back({.name = "surface", .mesh = 0});
  tets.asset.findings = findings_of(file);
  tets.region = std::move(file.region);
  for (const int64_t id : file.region_ids) tets.regions.emplace_back().name = fmt::to_string(id);
  return tets;
}

fem::Element element_of(const TetAsset& tets, const FemOptions& options) {
  if (!options.named) return tets.mesh.element;
  const bool fits = fem::nodes_of(options.element) == tets.mesh.elements.cols();
  ELASTOGEN_CHECK(fits, "--element ", fem::element_name(options.element), ": ", tets.asset.path,
                  " has ",
                  fem::is_plane(tets.mesh.element) ? "plane triangles, which are tri3"
                  : tets.mesh.element == fem::Element::kTet4
                      ? "linear tetrahedra, which are tet4"
                      : "quadratic tetrahedra, which are tet10 or tet10-bbar");
  return options.element;
}

}  // namespace elastogen
