// SPDX-License-Identifier: Apache-2.0
// discretisation_curved SCENE [VOXELS ...]: errors of the network's element on grids of so many
// voxels along a body that the grid cuts, against quadratic tetrahedra, as one JSON object;
// without a scene the names of all.

#include "core/error.hpp"
#include "tests/curved/curved_scene.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>
#include <exception>

namespace elastogen::test {
namespace {

/// From one reference to the next, over what the finest has.
double change(const TetSolution& rough, const TetSolution& fine, const Points& points) {
  const TetField before(rough.mesh), after(fine.mesh);
  Array<double> u(points.place.rows(), 3);
  for (int64_t p = 0; p < u.rows(); ++p) {
    // points at the border may lie outside of coarse curved elements by a little
    const Vec3 X = {points.place(p, 0), points.place(p, 1), points.place(p, 2)};
    Vec3 a = {}, b = {};
    const bool found = before.at(X, rough.u, a, 0.05) && after.at(X, fine.u, b, 0.05);
    ELASTOGEN_CHECK(found, "a point of the body lies outside of a reference");
    for (size_t d = 0; d < 3; ++d) u(p, int(d)) = points.u(p, int(d)) + a[d] - b[d];
  }
  return relative_error(u, points);
}

double largest(const Array<double>& u) {
  double square = 0;
  for (int64_t n = 0; n < u.rows(); ++n)
    square = std::max(square, u(n, 0) * u(n, 0) + u(n, 1) * u(n, 1) + u(n, 2) * u(n, 2));
  return std::sqrt(square);
}

/// What the finest of three references is off by at points, by Richardson: the changes d1, d2 from
/// one to the next fall by 2^p, and what is left is d2/(2^p - 1).
nlohmann::json own_error(const std::vector<TetSolution>& references, const Points& points) {
  const double to_middle = change(references[0], references[1], points);
  const double to_fine = change(references[1], references[2], points);
  const double order = std::log2(to_middle / to_fine);
  return {{"changes", {to_middle, to_fine}},
          {"order", order},
          {"error", to_fine / (std::exp2(order) - 1)}};
}

nlohmann::json study(const CurvedScene& scene, const std::vector<int>& voxels) {
  std::vector<TetSolution> references;
  nlohmann::json tets = nlohmann::json::array();
  // references on three meshes; each has twice as many cells along an edge as the one before
  for (const int n : {scene.tets, 2 * scene.tets, 4 * scene.tets}) {
    references.push_back(solve_tets(scene, n, references.empty() ? nullptr : &references.back()));
    tets.push_back(references.back().mesh.elements.rows());
  }
  const TetSolution& truth = references.back();
  const Points surface = points_on_surface(scene, references[0], truth);
  // errors of each grid; the first one chooses the points inside
  Points inside;
  nlohmann::json grids = nlohmann::json::array();
  for (const int count : voxels) {
    const VoxelSolution solution = solve_voxels(scene, count);
    if (inside.place.empty()) inside = points_inside(solution, truth);
    grids.push_back({{"voxels", count},
                     {"h", solution.scene.grid.h},
                     {"active", solution.scene.grid.voxel_count()},
                     {"slivers", solution.slivers},
                     {"inside", relative_error(solution.at(inside.place), inside)},
                     {"surface", relative_error(solution.at(surface.place), surface)},
                     {"min_j", solution.min_j}});
  }
  return {{"load", scene.load},
          {"grids", grids},
          {"points", {inside.place.rows(), surface.place.rows()}},
          {"tets", tets},
          {"shape", worst_shape(truth.mesh)},
          {"min_j", truth.min_j},
          {"largest", largest(truth.u) / scene.length},
          {"reference_inside", own_error(references, inside)},
          {"reference_surface", own_error(references, surface)}};
}

int run(int count, char** words) {
  if (count < 2) {
    for (const auto& [name, scene] : curved_scenes()) std::printf("%s\n", name.c_str());
    return 0;
  }
  std::vector<int> voxels;
  for (int k = 2; k < count; ++k) voxels.push_back(std::atoi(words[k]));
  if (voxels.empty()) voxels = {16, 32, 64};
  std::printf("%s\n", study(curved_scenes().at(words[1]), voxels).dump().c_str());
  return 0;
}

}  // namespace
}  // namespace elastogen::test

int main(int count, char** words) {
  try {
    return elastogen::test::run(count, words);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
