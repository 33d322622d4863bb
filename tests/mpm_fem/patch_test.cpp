// SPDX-License-Identifier: Apache-2.0
// Patch tests on distorted meshes: a uniform state on the boundary is the state inside.

#include "tests/mpm_fem/bodies.hpp"
#include "tests/support/element_assembly.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::ElasticBody;
using test::Element;
using test::ElementMesh;
using test::Random;

/// 3 cubes of edge 0.5 along each axis, inner nodes moved by up to a quarter; of voxels not moved.
ElementMesh patch(Element element) {
  if (element != Element::kVoxel) return test::block(element, 3, 3, 3, 0.5, 0.25);
  return fem::voxel_mesh(test::voxel_scene(make_box(3, 3, 3, 0.5), test::solid()), element);
}

/// The displacements of the boundary of a patch.
std::map<int, double> hold_boundary(const ElementMesh& mesh, const Eigen::VectorXd& u) {
  std::map<int, double> held;
  for (int64_t n = 0; n < mesh.rest.rows(); ++n)
    if (test::on_boundary(mesh, n, 1.5))
      for (int i = 0; i < 3; ++i) held[int(3 * n + i)] = u(3 * n + i);
  return held;
}

/// Mean stress of an element from the forces K u on its nodes: sum of f (x) X over the volume.
Mat3<double> virial_stress(const ElasticBody& body, int64_t element, const Eigen::VectorXd& u) {
  const ElementMesh& mesh = body.mesh();
  const Array<double> rest(mesh.rest.rows(), 3);
  const Eigen::MatrixXd K = test::element_hessian(body, element, rest, TangentKind::kTrue);
  Eigen::VectorXd local(K.rows());
  for (int k = 0; k < K.rows(); ++k) local(k) = u(3 * mesh.elements(element, k / 3) + k % 3);
  const Eigen::VectorXd f = K * local;
  Mat3<double> stress{};
  for (int k = 0; k < K.rows(); ++k)
    for (int j = 0; j < 3; ++j)
      stress(k % 3, j) += f(k) * mesh.rest(mesh.elements(element, k / 3), j);
  return test::scaled(stress, 1 / body.volume()(element));
}

TEST(Patch, LinearPatchIsExactForEveryElement) {
  constexpr double kStrain = 5e-4;
  Mat3<double> F = test::scaled({{2, 1, 1, 1, 2, 1, 1, 1, 2}}, kStrain);
  for (int i = 0; i < 3; ++i) F(i, i) += 1;
  Random random(1);
  for (const Element element : test::kAllElements) {
    const ElasticBody body(patch(element), {test::solid(Law::kNeoHookean, 1e6, 0.25)});
    const Eigen::VectorXd exact = test::vector_of(test::displaced(body.mesh(), F, 0, random));
    const std::map<int, double> held = hold_boundary(body.mesh(), exact);
    ASSERT_LT(int64_t(held.size()), exact.size());
    const Array<double> rest(body.mesh().rest.rows(), 3);
    const Eigen::VectorXd u =
        test::solve(test::hessian(body, rest), Eigen::VectorXd::Zero(exact.size()), held);
    EXPECT_LE((u - exact).norm(), 1e-12 * exact.norm()) << fem::element_name(element);
    for (int64_t e = 0; e < body.mesh().elements.rows(); ++e) {
      const Mat3<double> stress = virial_stress(body, e, u);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) ASSERT_NEAR(stress(i, j), i == j ? 2000 : 400, 2e-7);
    }
  }
}

TEST(Patch, FinitePatchEndsInTheUniformGradientForEveryElementAndLaw) {
  const Mat3<double> F = {{1.2, 0.3, -0.1, 0.05, 0.85, 0.1, 0.1, -0.2, 1.1}};
  Random random(2);
  for (const Element element : test::kAllElements)
    for (const Law law : test::kLaws) {
      const ElasticBody body(patch(element), {test::solid(law)});
      const Eigen::VectorXd exact = test::vector_of(test::displaced(body.mesh(), F, 0, random));
      std::map<int, double> held = hold_boundary(body.mesh(), exact);
      // inner nodes start off their place, near enough for Newton's method without a line search
      Eigen::VectorXd u = test::vector_of(test::displaced(body.mesh(), F, 0.01, random));
      for (auto& [dof, value] : held) u(dof) = exact(dof), value = 0;
      ASSERT_GE((u - exact).norm(), 0.005);
      for (int k = 0; k < 7; ++k)
        u -= test::solve(test::hessian(body, test::array_of(u)),
                         test::gradient(body, test::array_of(u)), held);
      EXPECT_LE((u - exact).norm(), 1e-12 * exact.norm())
          << fem::element_name(element) << ' ' << law_name(law);
    }
}

}  // namespace
}  // namespace elastogen
