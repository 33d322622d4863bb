// SPDX-License-Identifier: Apache-2.0
#include "voxelize/lattice_mesh.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "voxelize/sheets.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kSnap = 1e-9;  // coordinates as near to a lattice plane are on it [voxel edges]

/// Turns triangles so that each piece is wound consistently. Where that is impossible, faces that
/// the file winds alike stay alike. @return triangles at edges where it is impossible.
std::vector<int32_t> orient(LatticeMesh& mesh, const Edges& edges) {
  const size_t n = mesh.triangles.size();
  OrientedSets sets(n);
  std::vector<int32_t> conflicts;
  for (const bool turned : {false, true})
    for (const Link& edge : edges.manifold)
      if (edge.turned == turned && !sets.join(edge.triangle[0], edge.triangle[1], turned))
        conflicts.push_back(edge.triangle[0]);
  std::vector<double> balance(n, 0);  // area wound as the root, minus the other area
  for (size_t t = 0; t < n; ++t) {
    const auto i = static_cast<int32_t>(t);
    balance[sets.root(i)] += (sets.turned(i) ? -1 : 1) * norm(area_vector(mesh, t));
  }
  for (size_t t = 0; t < n; ++t) {
    const auto i = static_cast<int32_t>(t);
    if (sets.turned(i) == (balance[sets.root(i)] < 0)) continue;
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    ++mesh.turned;
  }
  return conflicts;
}

}  // namespace

Vec3 Lattice::coordinates(const double* p) const {
  Vec3 result;
  for (int d = 0; d < 3; ++d) {
    const double x = (p[d] - origin[d]) / h, whole = std::round(x);
    result[d] = std::abs(x - whole) < kSnap ? whole : x;
  }
  return result;
}

Lattice choose_lattice(const Box& box, const VoxelizeOptions& options) {
  // one of h and voxels, and no edge larger than the body
  double longest = 0;
  for (int d = 0; d < 3; ++d) longest = std::max(longest, box.extent(d));
  ELASTOGEN_CHECK(options.h > 0 || options.voxels > 0, "voxels must be positive, got ",
                  options.voxels);
  ELASTOGEN_CHECK(options.h >= 0 && std::isfinite(options.h), "h must be positive, got ",
                  options.h);
  ELASTOGEN_CHECK_ASSET(longest > 0 && std::isfinite(longest), "the surface has no extent");
  ELASTOGEN_CHECK(options.h <= longest * (1 + 1e-6), "h = ", options.h,
                  " m is more than the body's longest edge, ", longest, " m");
  // as few voxels as hold the box, centred on it
  Lattice lattice;
  lattice.h = options.h > 0 ? options.h : longest / options.voxels;
  for (int d = 0; d < 3; ++d) {
    const double count = std::max(1.0, std::ceil(box.extent(d) / lattice.h - 1e-6));
    if (!(count < kLatticeLimit))
      throw Error(concat("h = ", lattice.h, " m gives ", count, " voxels along ", "xyz"[d],
                         "; the limit is 2^20, h >= ", box.extent(d) / (kLatticeLimit - 1), " m"),
                  ErrorKind::kResources);
    lattice.origin[d] = box.lower[d] + (box.extent(d) - count * lattice.h) / 2;
    // move a layer of nodes into the plane, by half an edge at most
    if (!options.align[d]) continue;
    const double plane = *options.align[d];
    ELASTOGEN_CHECK(std::isfinite(plane), "a plane to align must be finite, got ", plane);
    const double place = (plane - lattice.origin[d]) / lattice.h;
    lattice.origin[d] += lattice.h * (place - std::round(place));
  }
  return lattice;
}

LatticeMesh make_lattice_mesh(const WeldedMesh& welded, const Lattice& lattice) {
  LatticeMesh mesh;
  mesh.vertices.resize(welded.vertices.rows());
  for (int64_t v = 0; v < welded.vertices.rows(); ++v)
    mesh.vertices[v] = lattice.coordinates(welded.vertices.row(v));
  mesh.triangles.resize(welded.triangles.rows());
  for (int64_t t = 0; t < welded.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) mesh.triangles[t][k] = welded.triangles(t, k);
  mesh.role.assign(mesh.triangles.size(), Role::kSolid);

  // a closed mesh that is wound consistently needs no repair
  if (welded.closed() && welded.turned_edges == 0) return mesh;
  const Edges edges = find_edges(mesh.triangles);
  const std::vector<int32_t> conflicts = orient(mesh, edges);
  find_sheets(mesh, edges, conflicts);
  return mesh;
}

}  // namespace elastogen
