// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/shape_functions.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

/// The two corners of each edge of a tetrahedron, in the order of the nodes in the middle.
constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
constexpr double kBarycentricGradient[4][3] = {{-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

void barycentric(const Vec3& xi, double L[4]) {
  L[0] = 1 - xi[0] - xi[1] - xi[2];
  for (int d = 0; d < 3; ++d) L[d + 1] = xi[size_t(d)];
}

/// The factor of corner c along an axis, and its slope.
double edge_factor(int c, int axis, const Vec3& xi) {
  return c >> axis & 1 ? xi[size_t(axis)] : 1 - xi[size_t(axis)];
}
double edge_slope(int c, int axis) {
  return c >> axis & 1 ? 1 : -1;
}

void quadratic_gradients(const double L[4], double* dN) {
  for (int d = 0; d < 3; ++d) {
    for (int a = 0; a < 4; ++a) dN[3 * a + d] = (4 * L[a] - 1) * kBarycentricGradient[a][d];
    for (int e = 0; e < 6; ++e) {
      const auto [a, b] = kEdges[e];
      dN[3 * (4 + e) + d] =
          4 * (L[a] * kBarycentricGradient[b][d] + L[b] * kBarycentricGradient[a][d]);
    }
  }
}

/// Tensor product of a rule on [0, 1].
std::vector<QuadraturePoint> product_rule(const std::vector<std::array<double, 2>>& line) {
  std::vector<QuadraturePoint> rule;
  for (const auto& [z, wz] : line)
    for (const auto& [y, wy] : line)
      for (const auto& [x, wx] : line) rule.push_back({{x, y, z}, wx * wy * wz});
  return rule;
}

/// Adds the points whose barycentric coordinates are those of one corner `a` and of the others
/// (1 - a)/3.
void add_corner_orbit(double a, double weight, std::vector<QuadraturePoint>& rule) {
  const double b = (1 - a) / 3;
  rule.push_back({{b, b, b}, weight});
  for (size_t d = 0; d < 3; ++d) {
    rule.push_back({{b, b, b}, weight});
    rule.back().xi[d] = a;
  }
}

/// Adds the points whose barycentric coordinates are a at the ends of an edge, 1/2 - a elsewhere.
void add_edge_orbit(double a, double weight, std::vector<QuadraturePoint>& rule) {
  for (const auto& edge : kEdges) {
    double L[4];
    for (double& l : L) l = 0.5 - a;
    L[edge[0]] = L[edge[1]] = a;
    rule.push_back({{L[1], L[2], L[3]}, weight});
  }
}

std::vector<QuadraturePoint> four_points() {
  std::vector<QuadraturePoint> rule;
  add_corner_orbit((5 + 3 * std::sqrt(5.0)) / 20, 1.0 / 24, rule);
  return rule;
}

std::vector<QuadraturePoint> fourteen_points() {
  std::vector<QuadraturePoint> rule;
  add_corner_orbit(0.067342242210098171, 0.018781320953002642, rule);
  add_corner_orbit(0.72179424906732633, 0.012248840519393658, rule);
  add_edge_orbit(0.045503704125649649, 0.0070910034628469111, rule);
  return rule;
}

bool is_hexahedron(Element element) {
  return nodes_of(element) == 8;
}

bool is_linear(Element element) {
  return element == Element::kTet4 || element == Element::kTri3;
}

}  // namespace

void shape_functions(Element element, const Vec3& xi, double* N) {
  if (is_hexahedron(element)) {
    for (int c = 0; c < 8; ++c)
      N[c] = edge_factor(c, 0, xi) * edge_factor(c, 1, xi) * edge_factor(c, 2, xi);
    return;
  }
  double L[4];
  barycentric(xi, L);
  const bool linear = is_linear(element);
  for (int a = 0; a < std::min(4, nodes_of(element)); ++a)
    N[a] = linear ? L[a] : L[a] * (2 * L[a] - 1);
  if (linear) return;
  for (int e = 0; e < 6; ++e) N[4 + e] = 4 * L[kEdges[e][0]] * L[kEdges[e][1]];
}

void shape_gradients(Element element, const Vec3& xi, double* dN) {
  if (is_hexahedron(element)) {
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 3; ++d) {
        const int e = (d + 1) % 3, f = (d + 2) % 3;
        dN[3 * c + d] = edge_slope(c, d) * edge_factor(c, e, xi) * edge_factor(c, f, xi);
      }
    return;
  }
  double L[4];
  barycentric(xi, L);
  if (!is_linear(element)) return quadratic_gradients(L, dN);
  for (int a = 0; a < nodes_of(element); ++a)
    for (int d = 0; d < 3; ++d)
      dN[3 * a + d] = is_plane(element) && d == 2 ? 0 : kBarycentricGradient[a][d];
}

void jacobian(Element element, const double* X, const double* dN, double J[9]) {
  for (int k = 0; k < 9; ++k) J[k] = 0;
  for (int a = 0; a < nodes_of(element); ++a)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) J[3 * i + j] += X[3 * a + i] * dN[3 * a + j];
  if (is_plane(element)) J[8] = 1;
}

const std::vector<QuadraturePoint>& potential_rule(Element element) {
  const double offset = std::sqrt(3.0) / 6;
  static const std::vector<QuadraturePoint> hexahedron =
      product_rule({{0.5 - offset, 0.5}, {0.5 + offset, 0.5}});
  static const std::vector<QuadraturePoint> centre = {{{0.25, 0.25, 0.25}, 1.0 / 6}};
  static const std::vector<QuadraturePoint> tetrahedron = four_points();
  static const std::vector<QuadraturePoint> triangle = {{{1.0 / 3, 1.0 / 3, 0}, 0.5}};
  if (is_hexahedron(element)) return hexahedron;
  if (is_plane(element)) return triangle;
  return element == Element::kTet4 ? centre : tetrahedron;
}

const std::vector<QuadraturePoint>& mass_rule(Element element) {
  const double offset = std::sqrt(0.15);
  static const std::vector<QuadraturePoint> hexahedron =
      product_rule({{0.5 - offset, 5.0 / 18}, {0.5, 8.0 / 18}, {0.5 + offset, 5.0 / 18}});
  static const std::vector<QuadraturePoint> tetrahedron = fourteen_points();
  static const std::vector<QuadraturePoint> triangle = {
      {{0.5, 0, 0}, 1.0 / 6}, {{0.5, 0.5, 0}, 1.0 / 6}, {{0, 0.5, 0}, 1.0 / 6}};
  if (is_plane(element)) return triangle;
  return is_hexahedron(element) ? hexahedron : tetrahedron;
}

}  // namespace elastogen::fem
