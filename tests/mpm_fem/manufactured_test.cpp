// SPDX-License-Identifier: Apache-2.0
// Order of convergence by a manufactured solution: u_i = A_i sin(2 pi X_i) on half a wave, of
// neo-Hookean material, is in equilibrium under the body force
//
//     b_i = 4 pi^2 u_i [mu + (mu - lambda (K - 1))/F_ii^2],   K = ln(F_11 F_22 F_33)
//
// (the static part of the field of Wallstedt and Guilkey 2008).
#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen::test {
namespace {

constexpr double kAmplitude[3] = {0.05, -0.03, 0.04};  // strains up to 31 %
constexpr double kPi = std::numbers::pi;

double exact(const Vec3& X, int i) {
  return kAmplitude[i] * std::sin(2 * kPi * X[size_t(i)]);
}

double body_force(const Vec3& X, int i, const Material& m) {
  double F[3];
  for (int d = 0; d < 3; ++d) F[d] = 1 + 2 * kPi * kAmplitude[d] * std::cos(2 * kPi * X[size_t(d)]);
  const double K = std::log(F[0] * F[1] * F[2]);
  return 4 * kPi * kPi * exact(X, i) * (m.mu() + (m.mu() - m.lambda() * (K - 1)) / (F[i] * F[i]));
}

/// Shape functions at a point of the reference element: xi in [0, 1]^3 of hexahedra, barycentric
/// coordinates of tetrahedra.
std::vector<double> shape_at(Element element, const double xi[4]) {
  std::vector<double> N;
  const int nodes = fem::nodes_of(element);
  if (nodes == 8)
    for (int c = 0; c < 8; ++c) {
      N.push_back(1);
      for (int d = 0; d < 3; ++d) N.back() *= c >> d & 1 ? xi[d] : 1 - xi[d];
    }
  if (nodes == 4) N.assign(xi, xi + 4);
  if (nodes == 10) {
    constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
    for (int a = 0; a < 4; ++a) N.push_back(xi[a] * (2 * xi[a] - 1));
    for (const auto& [a, b] : kEdges) N.push_back(4 * xi[a] * xi[b]);
  }
  return N;
}

/// Root mean square of u - exact over points inside the elements.
double error(const ElementMesh& mesh, const Array<double>& u) {
  constexpr double kPoints[4][4] = {
      {0.1, 0.2, 0.1, 0.6}, {0.6, 0.1, 0.2, 0.1}, {0.2, 0.6, 0.1, 0.1}, {0.3, 0.3, 0.3, 0.1}};
  double sum = 0, count = 0;
  for (const auto& point : kPoints) {
    const std::vector<double> N = shape_at(mesh.element, point);
    for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
      Vec3 X = {}, value = {};
      for (size_t a = 0; a < N.size(); ++a)
        for (size_t d = 0; d < 3; ++d) {
          const int32_t n = mesh.elements(e, int(a));
          X[d] += N[a] * mesh.rest(n, int(d));
          value[d] += N[a] * u(n, int(d));
        }
      for (int d = 0; d < 3; ++d) sum += std::pow(value[size_t(d)] - exact(X, d), 2), ++count;
    }
  }
  return std::sqrt(sum / count);
}

/// Error on n x n x n cells of [0, 1/2]^3, the surface held in the exact place.
double error_of(Element element, int n) {
  const Material material = solid(Law::kNeoHookean, 1e7, 0.3, 1000);
  FemScene scene = scene_of(block(element, n, n, n, 0.5 / n), material);
  // the surface is held
  for (int axis = 0; axis < 3; ++axis)
    for (const double place : {0.0, 0.5}) clamp(scene, axis, place);
  const int64_t nodes = scene.mesh.rest.rows();
  // exact displacements, and the body force that belongs to them
  Array<double> u(nodes, 3), b(nodes, 3), force(nodes, 3);
  for (int64_t k = 0; k < nodes; ++k)
    for (int i = 0; i < 3; ++i) {
      u(k, i) = exact(rest_of(scene.mesh, k), i);
      b(k, i) = body_force(rest_of(scene.mesh, k), i, material) / material.density;
    }
  scene.mass_kind = fem::Mass::kConsistent;
  const ElasticBody body(scene.mesh, scene.materials);
  fem::MassMatrix(scene, body).multiply(b.data(), force.data());
  // both grow together with the increments
  scene.motion = [&](double share, Out<double> out) {
    for (int64_t k = 0; k < out.size(); ++k) out.data[k] = share * u.data()[k];
  };
  scene.force = [&](double share, Out<double> out) {
    for (int64_t k = 0; k < out.size(); ++k) out.data[k] = share * force.data()[k];
  };
  const fem::StaticResult result = solve_static(scene);
  EXPECT_TRUE(result.converged) << element_name(element);
  return error(scene.mesh, result.u);
}

TEST(Manufactured, DisplacementsConvergeWithTheOrderOfTheElement) {
  struct Row {
    Element element;
    int coarse;
    double order;
  };
  for (const Row& row : {Row{Element::kTet4, 8, 2}, Row{Element::kHex, 6, 2},
                         Row{Element::kHexBbar, 6, 2}, Row{Element::kTet10, 4, 3}}) {
    const double coarse = error_of(row.element, row.coarse);
    const double fine = error_of(row.element, 2 * row.coarse);
    const double order = std::log2(coarse / fine);
    printf("%-8s error %.2e, %.2e, order %.3f\n", std::string(element_name(row.element)).c_str(),
           coarse, fine, order);
    EXPECT_NEAR(order, row.order, 0.1) << element_name(row.element);
  }
}

}  // namespace
}  // namespace elastogen::test
