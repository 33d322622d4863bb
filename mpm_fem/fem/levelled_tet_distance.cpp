// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/levelled_tet_distance.hpp"

#include "core/mat3.hpp"
#include "core/vec3.hpp"

#include <cmath>

namespace elastogen::fem {
namespace {

constexpr int kSamples = 12;  // sample points along an edge

struct WeightedMean {
  double weight = 0, sum = 0;
  void add(double value, double w) { weight += w, sum += w * value; }
};

}  // namespace

LevelledTetDistance::LevelledTetDistance(const ElementMesh& mesh, const Border& border,
                                         const std::vector<int32_t>& elements)
    : mesh_(mesh), border_(border) {
  if (border.is_plane || mesh.elements.cols() != 4) return;
  std::map<int32_t, WeightedMean> near, next;
  for (const int32_t e : elements) {
    double area = 0;
    const double mean = mean_on_border(e, area);
    for (int a = 0; a < 4 && area > 0; ++a) near[mesh.elements(e, a)].add(mean, area);
  }
  for (const auto& [node, mean] : near) excess_[node] = mean.sum / mean.weight;
  // the nodes around them
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int a = 0; a < 4; ++a)
      for (int b = 0; b < 4; ++b) {
        const int32_t from = mesh.elements(e, a), to = mesh.elements(e, b);
        if (near.contains(from) && !near.contains(to)) next[to].add(excess_.at(from), 1);
      }
  for (const auto& [node, mean] : next) excess_[node] = mean.sum / mean.weight;
}

Vec3 LevelledTetDistance::rest(int32_t node) const {
  return {mesh_.rest(node, 0), mesh_.rest(node, 1), mesh_.rest(node, 2)};
}

/// The mean over points of a lattice within half a spacing of the border, moved onto it.
/// @param area  gets the share of the border in the element, up to a factor of all elements.
double LevelledTetDistance::mean_on_border(int32_t element, double& area) const {
  Vec3 X[4];
  double d[4];
  for (int a = 0; a < 4; ++a) d[a] = distance(border_, X[a] = rest(mesh_.elements(element, a)));
  // the gradient of the interpolant
  Mat3<double> J;
  for (int a = 0; a < 3; ++a)
    for (size_t k = 0; k < 3; ++k) J(a, int(k)) = X[a + 1][k] - X[0][k];
  const Mat3<double> inverse_J = inverse(J);
  Vec3 G = {};
  for (size_t k = 0; k < 3; ++k)
    for (int a = 0; a < 3; ++a) G[k] += inverse_J(int(k), a) * (d[a + 1] - d[0]);
  // sample points
  const double volume = determinant(J) / 6, spacing = std::cbrt(6 * volume) / kSamples;
  WeightedMean mean;
  for (int i = 0; i < kSamples; ++i)
    for (int j = 0; i + j < kSamples; ++j)
      for (int k = 0; i + j + k < kSamples; ++k) {
        const double share[3] = {(i + 0.25) / kSamples, (j + 0.25) / kSamples,
                                 (k + 0.25) / kSamples};
        Vec3 x = X[0];
        double value = d[0];
        for (size_t a = 0; a < 3; ++a) {
          x = plus(x, scaled(minus(X[a + 1], X[0]), share[a]));
          value += share[a] * (d[a + 1] - d[0]);
        }
        const double away = distance(border_, x);
        if (std::abs(away) > spacing) continue;
        mean.add(value - away * dot(G, distance_gradient(border_, x)), volume / spacing);
      }
  area = mean.weight;
  return area > 0 ? mean.sum / mean.weight : 0;
}

double LevelledTetDistance::operator()(int32_t node) const {
  const double d = distance(border_, rest(node));
  const auto e = excess_.find(node);
  return e == excess_.end() ? d : d - e->second;
}

}  // namespace elastogen::fem
