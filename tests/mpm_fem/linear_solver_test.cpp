// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/linear_solver.hpp"

#include "core/error.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using fem::Assembly;
using fem::LinearSolver;
using fem::SparseMatrix;

/// Stiffness at rest of a beam clamped at x = 0, and its weight.
struct Problem {
  FemScene scene;
  SparseMatrix K;
  Array<double> weight;
};

Problem beam(Element element, int across, double poisson) {
  Problem p;
  p.scene = box_of(element, 8 * across, across, across, 0.1 / across,
                   solid(Law::kNeoHookean, 1e6, poisson));
  clamp(p.scene, 0, 0);
  const ElasticBody body(p.scene.mesh, p.scene.materials);
  const int64_t nodes = p.scene.mesh.rest.rows();
  Assembly assembly(fem::stencils_of(p.scene.mesh.elements), nodes);
  const Array<double> u(nodes, 3), mass = body.lumped_mass();
  p.K = pattern_of(assembly.stencils(), nodes);
  assembly.fit(p.K);
  assembly.add([&](int64_t e, double* K) { body.element_hessian(e, u, TangentKind::kTrue, K); },
               p.K);
  p.weight = Array<double>(nodes, 3);
  for (int64_t n = 0; n < nodes; ++n)
    if (!p.scene.fixed(n, 2)) p.weight(n, 2) = -kGravity * mass(n);
  fix_unknowns(p.scene.fixed.data(), p.K, p.weight.data());
  return p;
}

LinearSolver solver(const Problem& p, double max_operations) {
  return LinearSolver(p.K, p.scene.mesh.rest, p.scene.fixed.data(),
                      {.max_operations = max_operations});
}

TEST(LinearSolver, ConjugateGradientsComeToTheDirectSolution) {
  for (const Element element : {Element::kVoxel, Element::kTet10Bbar}) {
    const Problem p = beam(element, 3, 0.45);
    LinearSolver direct = solver(p, 1e12), iterative = solver(p, 0);
    EXPECT_TRUE(direct.direct());
    EXPECT_FALSE(iterative.direct());
    ASSERT_TRUE(direct.factor(p.K) && iterative.factor(p.K));
    Eigen::VectorXd exact(p.K.rows()), x(p.K.rows());
    ASSERT_TRUE(direct.solve(p.weight.data(), exact.data(), 0));
    ASSERT_TRUE(iterative.solve(p.weight.data(), x.data(), 1e-12));
    EXPECT_LT((x - exact).norm(), 1e-9 * exact.norm());
    EXPECT_EQ(direct.iterations(), 0);
  }
}

TEST(LinearSolver, IterationsHardlyGrowWithTheNumberOfNodes) {
  // of a clamped beam; the blocks alone take 5 times as many at 2, and twice that at each doubling
  int64_t iterations[2];
  for (int k = 0; k < 2; ++k) {
    const Problem p = beam(Element::kTet10, 2 << k, 0.3);
    LinearSolver iterative = solver(p, 0);
    ASSERT_TRUE(iterative.factor(p.K));
    Array<double> x(p.weight.rows(), 3);
    ASSERT_TRUE(iterative.solve(p.weight.data(), x.data(), 1e-6));
    iterations[k] = iterative.iterations();
  }
  printf("PCG: %ld and %ld iterations\n", long(iterations[0]), long(iterations[1]));
  EXPECT_LT(iterations[1], 150);
  EXPECT_LT(double(iterations[1]), 1.4 * double(iterations[0]));
}

TEST(LinearSolver, SaysWhatIsNotPositiveDefinite) {
  for (const double operations : {0.0, 1e12}) {
    Problem p = beam(Element::kHex, 2, 0.3);
    LinearSolver s = solver(p, operations);
    // one negative eigenvalue, first within a block, then of a mode of the whole beam
    SparseMatrix broken = p.K;
    const int64_t last = p.K.rows() - 1;
    broken.at(last, last) = -1;
    EXPECT_FALSE(s.factor(broken));
    broken = p.K;
    const Array<double> mass = ElasticBody(p.scene.mesh, p.scene.materials).lumped_mass();
    for (int64_t r = 0; r <= last; ++r)
      if (!p.scene.fixed.data()[r]) broken.at(r, r) -= 100 * mass(r / 3);  // above omega_1^2
    Array<double> x(p.weight.rows(), 3);
    EXPECT_FALSE(s.factor(broken) && s.solve(p.weight.data(), x.data(), 1e-8));
    EXPECT_TRUE(s.factor(p.K) && s.solve(p.weight.data(), x.data(), 1e-8));
  }
}

TEST(LinearSolver, TakesAnotherPatternAfterReset) {
  for (const double operations : {0.0, 1e12}) {
    const Problem coarse = beam(Element::kHex, 1, 0.3), fine = beam(Element::kHex, 2, 0.3);
    LinearSolver s({.max_operations = operations});
    EXPECT_THROW(s.factor(coarse.K), Error);  // no pattern yet
    for (const Problem* p : {&coarse, &fine}) {
      s.reset(p->K, p->scene.mesh.rest, p->scene.fixed.data());
      ASSERT_TRUE(s.factor(p->K));
      Eigen::VectorXd x(p->K.rows()), expected(x);
      ASSERT_TRUE(s.solve(p->weight.data(), x.data(), 1e-12));
      LinearSolver fresh = solver(*p, operations);
      ASSERT_TRUE(fresh.factor(p->K) && fresh.solve(p->weight.data(), expected.data(), 1e-12));
      EXPECT_EQ(x, expected);
    }
    EXPECT_EQ(s.analyses(), 2);
    EXPECT_THROW(s.factor(coarse.K), Error);
  }
}

TEST(LinearSolver, CoarseSpaceGivesRigidMotionsBack) {
  // with A = I the correction is the projection on the motions of the groups
  Problem p = beam(Element::kTet4, 3, 0.3);
  const std::vector<uint8_t> fixed(size_t(p.K.rows()));
  for (int64_t r = 0; r < p.K.rows(); ++r)
    for (int32_t k = p.K.start[size_t(r)]; k < p.K.start[size_t(r) + 1]; ++k)
      p.K.value[size_t(k)] = p.K.column[size_t(k)] == r;
  fem::CoarseSpace coarse(p.K, p.scene.mesh.rest, fixed.data());
  EXPECT_GT(coarse.groups(), 3);
  EXPECT_LT(coarse.groups(), p.K.rows() / 12);
  ASSERT_TRUE(coarse.factor(p.K));
  Random random(3);
  Mat3<double> spin = {{0, -3, 2, 3, 0, -1, -2, 1, 0}};
  for (int i = 0; i < 3; ++i) spin(i, i) = 1;
  const Array<double> rigid = displaced(p.scene.mesh, spin, 0, random);
  Array<double> z(rigid.rows(), 3);
  coarse.add_correction(rigid.data(), z.data());
  for (int64_t k = 0; k < z.size(); ++k) ASSERT_NEAR(z.data()[k], rigid.data()[k], 1e-8);
}

}  // namespace
}  // namespace elastogen::test
