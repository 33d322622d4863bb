// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "tests/curved/curved_scene.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace elastogen::test {
namespace {

constexpr double kNudge = 1e-9;  // [m] from the planes of an octant into it

/// Lists that become Points.
struct PointList {
  std::vector<Vec3> place, u;
  std::vector<double> weight;

  Points points() const {
    const auto count = int64_t(place.size());
    Points result{Array<double>(count, 3), Array<double>(count), Array<double>(count, 3)};
    for (int64_t p = 0; p < count; ++p) {
      std::copy_n(place[size_t(p)].data(), 3, result.place.row(p));
      std::copy_n(u[size_t(p)].data(), 3, result.u.row(p));
      result.weight(p) = weight[size_t(p)];
    }
    return result;
  }
};

/// Nodes of the faces that only one element has.
std::set<int32_t> boundary_nodes(const fem::ElementMesh& tets) {
  constexpr int kFace[4][6] = {
      {1, 2, 3, 5, 9, 8}, {0, 2, 3, 6, 9, 7}, {0, 1, 3, 4, 8, 7}, {0, 1, 2, 4, 5, 6}};
  std::map<std::array<int32_t, 3>, std::pair<int64_t, int>> open;  // element and face
  for (int64_t e = 0; e < tets.elements.rows(); ++e)
    for (int f = 0; f < 4; ++f) {
      std::array<int32_t, 3> key;
      for (size_t k = 0; k < 3; ++k) key[k] = tets.elements(e, kFace[f][k]);
      std::sort(key.begin(), key.end());
      if (!open.try_emplace(key, e, f).second) open.erase(key);
    }
  std::set<int32_t> nodes;
  for (const auto& [key, face] : open)
    for (const int k : kFace[face.second]) nodes.insert(tets.elements(face.first, k));
  return nodes;
}

}  // namespace

Points points_inside(const VoxelSolution& grid, const TetSolution& truth) {
  const TetField field(truth.mesh);
  PointList list;
  for (int64_t n = 0; n < grid.mass.rows(); ++n) {
    const double* rest = grid.scene.grid.rest.row(n);
    Vec3 X = {rest[0], rest[1], rest[2]}, u;
    if (grid.mass(n) == 0 || !field.at(X, truth.u, u)) continue;
    list.place.push_back(X);
    list.u.push_back(u);
    list.weight.push_back(grid.mass(n));
  }
  return list.points();
}

Points points_on_surface(const CurvedScene& scene, const TetSolution& coarse,
                         const TetSolution& truth) {
  const TetField field(truth.mesh);
  PointList list;
  for (const int32_t n : boundary_nodes(coarse.mesh)) {
    const double* rest = coarse.mesh.rest.row(n);
    const Vec3 X = {rest[0], rest[1], rest[2]};
    if (scene.octant && std::min({X[0], X[1], X[2]}) < kNudge) continue;
    Vec3 u;
    ELASTOGEN_CHECK(field.at(X, truth.u, u, 1e-6),
                    "a node of the coarse boundary lies off the "
                    "fine one");
    list.place.push_back(X);
    list.u.push_back(u);
    list.weight.push_back(1);
  }
  return list.points();
}

double relative_error(const Array<double>& u, const Points& truth) {
  double error = 0, size = 0;
  for (int64_t p = 0; p < u.rows(); ++p)
    for (int d = 0; d < 3; ++d) {
      error += truth.weight(p) * std::pow(u(p, d) - truth.u(p, d), 2);
      size += truth.weight(p) * std::pow(truth.u(p, d), 2);
    }
  return std::sqrt(error / size);
}

}  // namespace elastogen::test
