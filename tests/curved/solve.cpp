// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "mpm_fem/integrators/fem_potential.hpp"
#include "tests/curved/curved_scene.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/voxelize.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::test {
namespace {

using fem::ElasticBody;
using fem::ElementMesh;
using fem::FemScene;
using fem::StaticResult;

constexpr double kOnPlane = 1e-9;    // [m] about planes
constexpr double kTolerance = 1e-7;  // of the forces

Vec3 row(const Array<double>& table, int64_t n) {
  return {table(n, 0), table(n, 1), table(n, 2)};
}

/// Forces of the scene's accelerations on the nodes of tetrahedra, by the consistent mass.
Array<double> consistent_load(const ElementMesh& mesh, const CurvedScene& scene) {
  const ElasticBody body(mesh, {scene.material});
  Array<double> load(mesh.rest.rows(), 3);
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    double M[100];
    body.element_mass(e, M);
    for (int b = 0; b < 10; ++b) {
      const Vec3 g = scene.acceleration(row(mesh.rest, mesh.elements(e, b)));
      for (int a = 0; a < 10; ++a)
        for (int d = 0; d < 3; ++d) load(mesh.elements(e, a), d) += M[10 * a + b] * g[size_t(d)];
    }
  }
  return load;
}

/// A mesh under dead loads and what the scene holds.
FemScene fem_scene(ElementMesh mesh, const CurvedScene& scene, Array<double> load) {
  FemScene fem;
  fem.mesh = std::move(mesh);
  fem.materials = {scene.material};
  fem.traction = std::move(load);
  const Array<double> rest = fem.mesh.rest;
  fem.fixed = Array<uint8_t>(rest.rows(), 3);
  for (int64_t n = 0; n < rest.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      const bool mirror = scene.octant && std::abs(rest(n, d)) < kOnPlane;
      fem.fixed(n, d) = mirror || scene.held(row(rest, n), d, 1);
    }
  fem.motion = [&scene, rest, fixed = fem.fixed](double factor, Out<double> u) {
    for (int64_t n = 0; n < rest.rows(); ++n)
      for (int d = 0; d < 3; ++d)
        if (fixed(n, d)) u(n, d) = scene.held(row(rest, n), d, factor).value_or(0);
  };
  return fem;
}

StaticResult solve_by_increments(const FemScene& fem) {
  StaticResult result = solve_static(fem, {.tolerance = kTolerance, .first_increment = 0.25});
  ELASTOGEN_CHECK(result.converged, "no equilibrium beyond the load factor ", result.load_factor,
                  ", residual ", result.residual);
  return result;
}

/// Equilibrium at full load from a displacement near it. False: it was not near enough.
bool solve_from(const FemScene& fem, Array<double>& u) {
  fem::FemPotential terms(fem);
  fem::Potential& potential = terms.potential;
  potential.set_force(fem.traction);
  fem.motion(1, u);
  std::vector<double> g(size_t(u.size()));
  potential.full_gradient(u.data(), g.data());
  double loads = 0, holds = 0;
  for (int64_t k = 0; k < u.size(); ++k)
    if (potential.is_fixed(k))
      holds += g[size_t(k)] * g[size_t(k)];
    else
      loads += fem.traction.data()[k] * fem.traction.data()[k];
  const double force = std::sqrt(std::max(loads, holds));
  const fem::NewtonResult newton =
      potential.minimise({.tolerance = kTolerance * force, .max_iterations = 15}, u.data());
  return newton.residual <= 10 * kTolerance * force;
}

/// The displacement of a coarser mesh at the nodes of another.
Array<double> interpolated(const TetSolution& coarse, const ElementMesh& mesh) {
  const TetField field(coarse.mesh);
  Array<double> u(mesh.rest.rows(), 3);
  for (int64_t n = 0; n < u.rows(); ++n) {
    Vec3 value = {};
    ELASTOGEN_CHECK(field.at(row(mesh.rest, n), coarse.u, value, 0.2), "node ", n,
                    " lies outside of the coarser mesh");
    std::copy(value.begin(), value.end(), u.row(n));
  }
  return u;
}

/// The voxels of a mesh at positive coordinates, with their nodes; node_of are those in the whole.
ElementMesh octant_of(const ElementMesh& mesh, std::vector<int32_t>& node_of) {
  // number the nodes in the order in which the voxels of the octant name them
  std::vector<int32_t> number(size_t(mesh.rest.rows()), -1);
  std::vector<int64_t> voxels;
  for (int64_t v = 0; v < mesh.elements.rows(); ++v) {
    const Vec3 corner = row(mesh.rest, mesh.elements(v, 0));
    if (std::min({corner[0], corner[1], corner[2]}) < -kOnPlane) continue;
    voxels.push_back(v);
    for (int c = 0; c < 8; ++c) {
      const int32_t node = mesh.elements(v, c);
      if (number[size_t(node)] >= 0) continue;
      number[size_t(node)] = int32_t(node_of.size());
      node_of.push_back(node);
    }
  }
  // copy the rows of its nodes and voxels
  ElementMesh part = mesh;
  const auto count = int64_t(voxels.size());
  part.rest = Array<double>(int64_t(node_of.size()), 3);
  for (int64_t n = 0; n < part.rest.rows(); ++n)
    std::copy_n(mesh.rest.row(node_of[size_t(n)]), 3, part.rest.row(n));
  part.elements = Array<int32_t>(count, 8);
  part.material = Array<int32_t>(count);
  part.fill = Array<double>(count);
  part.shape_mean = Array<double>(count, 8);
  part.variance = Array<double>(count, 4);
  for (int64_t k = 0; k < count; ++k) {
    const int64_t v = voxels[size_t(k)];
    for (int c = 0; c < 8; ++c) part.elements(k, c) = number[size_t(mesh.elements(v, c))];
    part.fill(k) = mesh.fill(v);
    std::copy_n(mesh.shape_mean.row(v), 8, part.shape_mean.row(k));
    std::copy_n(mesh.variance.row(v), 4, part.variance.row(k));
  }
  return part;
}

/// The scene as the command sets it up: voxels of the surface with a layer of nodes in the planes.
Scene voxel_scene(const CurvedScene& curved, int voxels, int triangles, int64_t& slivers) {
  VoxelizeOptions options;
  options.h = curved.length / voxels;
  std::copy(std::begin(curved.planes), std::end(curved.planes), options.align);
  Voxelized voxelized = voxelize(mapped_surface(curved.body, triangles), options);
  ELASTOGEN_CHECK(voxelized.report.closed && !voxelized.report.winding_number,
                  "the surface of a mapped body does not bound it");
  slivers = voxelized.report.dropped_slivers;
  Scene scene;
  scene.grid = std::move(voxelized.grid);
  scene.materials = {curved.material};
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  finish_scene(scene);
  return scene;
}

}  // namespace

TetSolution solve_tets(const CurvedScene& scene, int n, const TetSolution* coarse) {
  TetSolution solution;
  solution.mesh = mapped_tets(scene.body, n, scene.octant);
  const FemScene fem = fem_scene(solution.mesh, scene, consistent_load(solution.mesh, scene));
  if (coarse) solution.u = interpolated(*coarse, solution.mesh);
  if (!coarse || !solve_from(fem, solution.u)) solution.u = solve_by_increments(fem).u;
  solution.min_j = ElasticBody(solution.mesh, {scene.material}).min_j(solution.u);
  return solution;
}

VoxelSolution solve_voxels(const CurvedScene& curved, int voxels, int triangles) {
  VoxelSolution solution;
  solution.scene = voxel_scene(curved, voxels, triangles, solution.slivers);
  const Scene& scene = solution.scene;
  ElementMesh mesh = fem::voxel_mesh(scene, fem::Element::kVoxel);
  std::vector<int32_t> node_of;
  if (curved.octant)
    mesh = octant_of(mesh, node_of);
  else
    for (int32_t n = 0; n < mesh.rest.rows(); ++n) node_of.push_back(n);

  // lumped masses, scaled to the body's volume as those of the whole scene
  double filled = 0;
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) filled += scene.grid.fill(v);
  const double scale = scene.grid.volume / (filled * std::pow(scene.grid.h, 3));
  const Array<double> mass = ElasticBody(mesh, {curved.material}).lumped_mass();
  Array<double> load(mesh.rest.rows(), 3);
  for (int64_t n = 0; n < load.rows(); ++n) {
    const Vec3 g = curved.acceleration(row(mesh.rest, n));
    for (int d = 0; d < 3; ++d) load(n, d) = scale * mass(n) * g[size_t(d)];
  }
  const StaticResult result =
      solve_by_increments(fem_scene(std::move(mesh), curved, std::move(load)));
  solution.min_j = result.min_j;
  solution.u = Array<double>(scene.grid.node_count(), 3);
  solution.mass = Array<double>(scene.grid.node_count());
  for (int64_t n = 0; n < result.u.rows(); ++n) {
    std::copy_n(result.u.row(n), 3, solution.u.row(node_of[size_t(n)]));
    solution.mass(node_of[size_t(n)]) = scale * mass(n);
  }
  return solution;
}

Array<double> VoxelSolution::at(const Array<double>& points) const {
  const VoxelGrid& grid = scene.grid;
  Array<double> x(grid.node_count(), 3), result(points.rows(), 3);
  for (int64_t k = 0; k < x.size(); ++k) x.data()[k] = grid.rest.data()[k] + u.data()[k];
  deform_asset(grid, embed(grid, points), x, result);
  return result;
}

}  // namespace elastogen::test
