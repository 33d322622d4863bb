// SPDX-License-Identifier: Apache-2.0
// Dependent nodes in the systems of finite elements, against dense algebra with the matrix C.
#include "mpm_fem/solve/constraint.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/integrators/modes.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "mpm_fem/solve/elastic_term.hpp"
#include "mpm_fem/solve/potential.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include <random>

namespace elastogen::test {
namespace {

using fem::Constraint;
using fem::ElasticTerm;
using fem::MassMatrix;
using fem::Potential;
using fem::SparseMatrix;

/// A box of 4 x 1 x 1 elements. Nodes at x = 0 follow those at x = 2 h and, one of them, nobody; the
/// first at x = h those at x = 2 h and 4 h.
struct Box {
  FemScene scene;

  explicit Box(Element element) : scene(box_of(element, 4, 1, 1, 0.1, solid(Law::kStvk, 1e5))) {
    std::vector<std::pair<int32_t, std::vector<int32_t>>> rows;
    const std::vector<int64_t> middle = plane(scene.mesh, 0, 0.2);
    for (size_t k = 0; k < 3; ++k)
      rows.push_back({int32_t(plane(scene.mesh, 0, 0)[k]), {int32_t(middle[k])}});
    rows.push_back({int32_t(plane(scene.mesh, 0, 0)[3]), {}});
    rows.push_back({int32_t(plane(scene.mesh, 0, 0.1)[0]),
                    {int32_t(middle[0]), int32_t(plane(scene.mesh, 0, 0.4)[3])}});
    std::ranges::sort(rows);
    std::vector<int32_t> nodes, begin = {0}, parents;
    std::vector<double> weights;
    for (const auto& [node, of] : rows) {
      nodes.push_back(node);
      for (const int32_t m : of) {
        parents.push_back(m);
        weights.push_back(0.3 - 0.7 * double(weights.size()));
      }
      begin.push_back(int32_t(parents.size()));
    }
    scene.dependent = DependentNodes(nodes, begin, parents, weights);
    scene.fixed(plane(scene.mesh, 0, 0.4)[0], 1) = 1;
  }

  int64_t unknowns() const { return scene.mesh.rest.size(); }

  /// u = C y, (unknowns, unknowns); columns of dependent nodes are 0.
  Eigen::MatrixXd C() const {
    Eigen::MatrixXd C = Eigen::MatrixXd::Identity(unknowns(), unknowns());
    for (int64_t i = 0; i < scene.dependent.count(); ++i)
      for (int d = 0; d < 3; ++d) {
        const int64_t row = 3 * int64_t(scene.dependent.node(i)) + d;
        C(row, row) = 0;
        for (int64_t k = 0; k < scene.dependent.parents(i).rows; ++k)
          C(row, 3 * int64_t(scene.dependent.parents(i)(k)) + d) = scene.dependent.weights(i)(k);
      }
    return C;
  }
};

Eigen::MatrixXd dense(const SparseMatrix& A) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(A.rows(), A.rows());
  for (int64_t r = 0; r < A.rows(); ++r)
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k)
      D(r, A.column[size_t(k)]) = A.value[size_t(k)];
  return D;
}

std::vector<double> random_values(int64_t count, double size, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-size, size);
  std::vector<double> values(static_cast<size_t>(count));
  for (double& value : values) value = uniform(random);
  return values;
}

Eigen::VectorXd as_vector(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), int64_t(values.size()));
}

/// The potential of a box, with its dependent nodes or without, and inertia.
struct BoxPotential {
  ElasticTerm term;
  Potential potential;

  BoxPotential(const FemScene& scene, bool follows)
      : term(scene.mesh, scene.materials),
        potential(scene.mesh.rest, follows ? scene.fixed : Array<uint8_t>(scene.fixed.rows(), 3),
                  MassMatrix(scene, term.body()), {&term}, {},
                  follows ? Constraint(scene.dependent) : Constraint()) {
    potential.set_inertia(30, Array<double>(scene.fixed.rows(), 3));
  }
};

TEST(Constraint, FoldsHessianAndGradientAsDenseMatricesDo) {
  for (const Element element : {Element::kVoxel, Element::kHex, Element::kHexBbar})
    for (const fem::Mass mass : {fem::Mass::kLumped, fem::Mass::kConsistent}) {
      Box box(element);
      box.scene.mass_kind = mass;
      BoxPotential whole(box.scene, false), folded(box.scene, true);
      std::vector<double> u = random_values(box.unknowns(), 1e-2, 3), g(u.size()), r(u.size()),
                          step(u.size());
      box.scene.dependent.fill(u.data());
      whole.potential.evaluate(u.data(), g.data());
      folded.potential.evaluate(u.data(), r.data());
      // H as the sum of the terms, which newton_step leaves where nothing is fixed
      whole.potential.newton_step(u.data(), g.data(), TangentKind::kProjected, 1e-8, nullptr,
                                  step.data());
      folded.potential.newton_step(u.data(), r.data(), TangentKind::kProjected, 1e-8, nullptr,
                                   step.data());
      const Eigen::MatrixXd C = box.C();
      Eigen::MatrixXd H = C.transpose() * dense(whole.potential.hessian()) * C;
      Eigen::VectorXd f = C.transpose() * as_vector(g);
      const double size = H.norm();
      for (int64_t k = 0; k < box.unknowns(); ++k)
        if (folded.potential.is_bound(k)) {
          H.row(k).setZero(), H.col(k).setZero();
          H(k, k) = 1, f(k) = 0;
        }
      EXPECT_LT((H - dense(folded.potential.hessian())).norm(), 1e-14 * size);
      EXPECT_LT((f - as_vector(r)).norm(), 1e-13 * f.norm());
      const Eigen::VectorXd exact = -C * H.ldlt().solve(f);
      EXPECT_LT((exact - as_vector(step)).norm(), 1e-10 * exact.norm());
    }
}

TEST(Constraint, GradientIsThatOfTheEnergyInFreeUnknowns) {
  Box box(Element::kHexBbar);
  BoxPotential of(box.scene, true);
  std::vector<double> u = random_values(box.unknowns(), 1e-2, 5),
                      p = random_values(box.unknowns(), 1, 6), g(u.size()), end(u.size());
  for (size_t k = 0; k < p.size(); ++k)
    if (of.potential.is_fixed(int64_t(k))) p[k] = 0;
  of.potential.set_offset(Array<double>(box.scene.dependent.count(), 3));
  of.potential.constraint().place(u.data());
  of.potential.constraint().follow(p.data());
  of.potential.evaluate(u.data(), g.data());
  double values[2];
  for (const int side : {0, 1}) {
    for (size_t k = 0; k < u.size(); ++k) end[k] = u[k] + (side ? 1e-6 : -1e-6) * p[k];
    std::vector<double> ignored(u.size());
    values[side] = of.potential.evaluate(end.data(), ignored.data()).value;
  }
  const double slope = elastogen::dot(g.data(), p.data(), int64_t(g.size()));
  EXPECT_NEAR((values[1] - values[0]) / 2e-6, slope, 1e-7 * std::abs(slope));
}

TEST(Constraint, MovesTheBodyAlongWithItsOffsets) {
  // a rigid motion of a body of which two nodes depend on others by any weights
  Box box(Element::kHex);
  const auto rigid = [](const double* X, double share) -> Vec3 {
    const double angle = 0.8 * share, c = std::cos(angle), s = std::sin(angle);
    return {c * X[0] - s * X[1] - X[0] + 0.3 * share, s * X[0] + c * X[1] - X[1], 0.1 * share};
  };
  const FemScene& fixed = box.scene;
  box.scene.dependent_motion = [&](double share, Out<double> offset) {
    for (int64_t i = 0; i < offset.rows; ++i) {
      const Vec3 own = rigid(fixed.mesh.rest.row(fixed.dependent.node(i)), share);
      for (int d = 0; d < 3; ++d) offset(i, d) = own[size_t(d)];
      for (int64_t k = 0; k < fixed.dependent.parents(i).rows; ++k) {
        const Vec3 of = rigid(fixed.mesh.rest.row(fixed.dependent.parents(i)(k)), share);
        for (int d = 0; d < 3; ++d) offset(i, d) -= fixed.dependent.weights(i)(k) * of[size_t(d)];
      }
    }
  };
  box.scene.motion = [&](double share, Out<double> u) {
    for (int64_t n = 0; n < u.rows; ++n) {
      const Vec3 own = rigid(fixed.mesh.rest.row(n), share);
      std::copy(own.begin(), own.end(), u.row(n));
    }
  };
  const fem::StaticResult result = solve_static(box.scene, {.tolerance = 1e-9});
  ASSERT_TRUE(result.converged);
  EXPECT_LE(result.increments, 1);
  for (int64_t n = 0; n < result.u.rows(); ++n) {
    const Vec3 own = rigid(fixed.mesh.rest.row(n), 1);
    for (int d = 0; d < 3; ++d) EXPECT_NEAR(result.u(n, d), own[size_t(d)], 1e-9);
  }
}

TEST(Constraint, ModesAreThoseOfTheFoldedMatrices) {
  Box box(Element::kHex);
  FemScene& scene = box.scene;
  BoxPotential of(scene, false);
  of.potential.set_inertia(0, Array<double>(scene.fixed.rows(), 3));
  std::vector<double> u(size_t(box.unknowns())), g(u.size()), step(u.size());
  of.potential.newton_step(u.data(), g.data(), TangentKind::kTrue, 1e-8, nullptr, step.data());
  const fem::Modes modes = vibration_modes(scene, 3);
  const Eigen::MatrixXd K = dense(of.potential.hessian());
  for (int k = 0; k < 3; ++k) {
    std::vector<double> shape(modes.shape.row(k), modes.shape.row(k) + box.unknowns()),
        Mphi(shape.size());
    of.potential.mass().multiply(shape.data(), Mphi.data());
    const Eigen::VectorXd phi = as_vector(shape);
    Eigen::VectorXd r =
        box.C().transpose() * (K * phi - modes.omega_squared[size_t(k)] * as_vector(Mphi));
    for (int64_t n = 0; n < box.unknowns(); ++n)
      if (scene.fixed.data()[n]) r(n) = 0;
    EXPECT_LT(r.norm(), 1e-7 * (K * phi).norm() + 1e-6);
    EXPECT_NEAR(phi.dot(as_vector(Mphi)), 1, 1e-9);
    EXPECT_LT((box.C() * phi - phi).norm(), 1e-12 * phi.norm());
  }
}

TEST(Constraint, RefusesDependentNodesThatAreFixedOrNotThere) {
  Box box(Element::kHex);
  box.scene.fixed(box.scene.dependent.node(0), 2) = 1;
  EXPECT_THROW(BoxPotential(box.scene, true), Error);
  box.scene.fixed.fill(0);
  Constraint constraint(box.scene.dependent);
  EXPECT_THROW(constraint.set_offset(Array<double>(1, 3)), Error);
  box.scene.dependent = DependentNodes({int32_t(box.unknowns())}, {0, 0}, {}, {});
  EXPECT_THROW(BoxPotential(box.scene, true), Error);
}

}  // namespace
}  // namespace elastogen::test
