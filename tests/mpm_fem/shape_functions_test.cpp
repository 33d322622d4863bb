// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/shape_functions.hpp"

#include "core/vec3.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using fem::Element;

constexpr Element kKinds[3] = {Element::kHex, Element::kTet4, Element::kTet10};

/// Reference positions of the nodes.
std::vector<Vec3> reference_nodes(Element element) {
  std::vector<Vec3> nodes;
  if (element == Element::kHex) {
    for (int c = 0; c < 8; ++c)
      nodes.push_back({double(c & 1), double(c >> 1 & 1), double(c >> 2)});
    return nodes;
  }
  nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  if (element == Element::kTet4) return nodes;
  for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}})
    nodes.push_back(scaled(plus(nodes[size_t(a)], nodes[size_t(b)]), 0.5));
  return nodes;
}

TEST(ShapeFunctions, AreOneAtTheirNodeAndZeroAtTheOthers) {
  for (const Element element : kKinds) {
    const std::vector<Vec3> nodes = reference_nodes(element);
    ASSERT_EQ(int(nodes.size()), fem::nodes_of(element));
    for (size_t a = 0; a < nodes.size(); ++a) {
      double N[fem::kMaxNodes];
      fem::shape_functions(element, nodes[a], N);
      for (size_t b = 0; b < nodes.size(); ++b) EXPECT_EQ(N[b], a == b) << a << ' ' << b;
    }
  }
}

TEST(ShapeFunctions, SumToOneAndTheirGradientsAreTheDerivatives) {
  constexpr double d = 1e-5;
  const Vec3 xi = {0.21, 0.34, 0.17};
  for (const Element element : kKinds) {
    double N[fem::kMaxNodes], up[fem::kMaxNodes], down[fem::kMaxNodes], dN[fem::kMaxDofs];
    fem::shape_functions(element, xi, N);
    fem::shape_gradients(element, xi, dN);
    double sum = 0;
    for (int a = 0; a < fem::nodes_of(element); ++a) sum += N[a];
    EXPECT_NEAR(sum, 1, 1e-15);
    for (size_t axis = 0; axis < 3; ++axis) {
      Vec3 above = xi, below = xi;
      above[axis] += d, below[axis] -= d;
      fem::shape_functions(element, above, up);
      fem::shape_functions(element, below, down);
      for (size_t a = 0; a < size_t(fem::nodes_of(element)); ++a)
        EXPECT_NEAR(dN[3 * a + axis], (up[a] - down[a]) / (2 * d), 1e-10);
    }
  }
}

double factorial(int n) {
  return std::tgamma(n + 1.0);
}

/// Integral of xi^i eta^j zeta^k over the reference element.
double moment(Element element, int i, int j, int k) {
  if (element == Element::kHex) return 1.0 / ((i + 1) * (j + 1) * (k + 1));
  return factorial(i) * factorial(j) * factorial(k) / factorial(i + j + k + 3);
}

/// Largest relative error of a rule on the monomials of a degree: in each direction for hexahedra,
/// in all for tetrahedra.
double worst_error(Element element, const std::vector<fem::QuadraturePoint>& rule, int degree) {
  double worst = 0;
  for (int i = 0; i <= degree; ++i)
    for (int j = 0; j <= degree; ++j)
      for (int k = 0; k <= degree; ++k) {
        if (element != Element::kHex && i + j + k > degree) continue;
        double sum = 0;
        for (const auto& [xi, weight] : rule)
          sum += weight * std::pow(xi[0], i) * std::pow(xi[1], j) * std::pow(xi[2], k);
        worst = std::max(worst, std::abs(sum / moment(element, i, j, k) - 1));
      }
  return worst;
}

TEST(ShapeFunctions, RulesAreExactToTheirDegreeAndNotBeyond) {
  const struct {
    Element element;
    bool for_mass;
    size_t points;
    int degree;
  } rules[] = {{Element::kHex, false, 8, 3},   {Element::kTet4, false, 1, 1},
               {Element::kTet10, false, 4, 2}, {Element::kHex, true, 27, 5},
               {Element::kTet4, true, 14, 5},  {Element::kTet10, true, 14, 5}};
  for (const auto& [element, for_mass, points, degree] : rules) {
    const std::vector<fem::QuadraturePoint>& rule =
        for_mass ? fem::mass_rule(element) : fem::potential_rule(element);
    EXPECT_EQ(rule.size(), points);
    for (const auto& point : rule) EXPECT_GT(point.weight, 0);
    EXPECT_LE(worst_error(element, rule, degree), 2e-15) << fem::element_name(element);
    EXPECT_GE(worst_error(element, rule, degree + 1), 1e-4) << fem::element_name(element);
  }
}

}  // namespace
}  // namespace elastogen
