// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/multigrid.hpp"

#include "core/pcg.hpp"
#include "network/precondition/multigrid_grid.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr double kGridH = 0.1;

/// A ragged block over several bricks and at least three levels, pinned on one side.
Scene ragged_scene(double poisson, double dt = 1.0 / 60) {
  Scene scene = scene_on(ragged_grid(14, 12, 10, kGridH, 41), solid(1e6, poisson));
  pin_below(scene, 0, -2.5 * kGridH);
  scene.dt = dt;
  finish_scene(scene);
  return scene;
}

template <class T>
std::vector<T> apply(Multigrid<T>& multigrid, const std::vector<double>& r) {
  const std::vector<T> right(r.begin(), r.end());
  std::vector<T> z(r.size());
  multigrid.apply(right.data(), z.data());
  return z;
}

template <class T>
void check_cycle(double tolerance) {
  for (const double poisson : {0.0, 0.3, 0.49})
    for (const double dt : {1.0 / 600, 1.0 / 10}) {
      const Scene scene = ragged_scene(poisson, dt);
      Multigrid<T> multigrid(scene, 1);
      EXPECT_GE(multigrid.level_count(), 3);
      for (unsigned seed = 1; seed <= 3; ++seed) {
        const std::vector<double> x = random_field(scene, 1, seed),
                                  y = random_field(scene, 1, seed + 9);
        const std::vector<T> Bx = apply(multigrid, x), By = apply(multigrid, y);
        const std::vector<double> bx(Bx.begin(), Bx.end()), by(By.begin(), By.end());
        EXPECT_NEAR(dot(x, by), dot(y, bx), tolerance * norm(x) * norm(by));
        EXPECT_GT(dot(x, bx), 0);
        for (size_t k = 0; k < x.size(); ++k)
          if (scene.pinned(int64_t(k / 3))) {
            ASSERT_EQ(bx[k], 0);
          }
      }
    }
}

TEST(Multigrid, CycleIsSymmetricAndPositiveInDouble) {
  check_cycle<double>(1e-12);
}
TEST(Multigrid, CycleIsSymmetricAndPositiveInFloat) {
  check_cycle<float>(1e-5);
}

TEST(Multigrid, SolvesItsOwnOperatorInAFewIterationsWhateverTheTimeStep) {
  int counts[2];
  for (int k = 0; k < 2; ++k) {
    const Scene scene = ragged_scene(0.3, k == 0 ? 1.0 / 30 : 1.0);
    Multigrid<double> multigrid(scene, 1);
    const std::vector<double> b = random_field(scene, 1, 7);
    std::vector<double> x(b.size());
    PcgWork<double> work(int64_t(b.size()));
    counts[k] = pcg(
                    b.data(), x.data(), int64_t(b.size()), 1e-6, 100, work,
                    [&](const double* p, double* Ap) { multigrid.operator_product(p, Ap); },
                    [&](const double* r, double* z) { multigrid.apply(r, z); })
                    .iterations;
  }
  printf("own operator to 1e-6: %d and %d iterations\n", counts[0], counts[1]);
  EXPECT_LE(counts[0], 20);
  EXPECT_LE(counts[1], 30);
}

LevelGrid finest_of(const Scene& scene) {
  return finest_level(
      scene, 1, std::make_shared<const BrickRows>(make_brick_rows(scene.grid, scene.material)));
}

TEST(Multigrid, RestrictionIsTheTransposeOfProlongation) {
  const Scene scene = ragged_scene(0.3);
  LevelGrid fine = finest_of(scene);
  for (int level = 0; level < 3; ++level) {
    LevelGrid coarse = coarser_level(fine);
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1, 1);
    std::vector<double> f(3 * size_t(fine.nodes)), c(3 * size_t(coarse.nodes)), Pc(f.size()),
        Rf(c.size());
    for (size_t k = 0; k < f.size(); ++k) f[k] = fine.pinned[k / 3] ? 0 : uniform(random);
    for (size_t k = 0; k < c.size(); ++k) c[k] = coarse.pinned[k / 3] ? 0 : uniform(random);
    prolong_correction(fine, c.data(), Pc.data());
    restrict_residual(coarse, f.data(), Rf.data());
    EXPECT_NEAR(dot(f, Pc), dot(c, Rf), 1e-13 * norm(f) * norm(Pc));
    EXPECT_GT(norm(Pc), 0);
    for (size_t k = 0; k < c.size(); ++k)
      if (coarse.pinned[k / 3]) {
        ASSERT_EQ(Rf[k], 0);
      }
    fine = std::move(coarse);
  }
}

TEST(Multigrid, ProlongationReproducesLinearFieldsAwayFromPins) {
  Scene scene = scene_on(ragged_grid(14, 12, 10, kGridH, 42), solid(1e6, 0.3));
  finish_scene(scene);
  LevelGrid fine = finest_of(scene);
  const LevelGrid coarse = coarser_level(fine);
  std::vector<double> f(3 * size_t(fine.nodes)), c(3 * size_t(coarse.nodes));
  for (int64_t n = 0; n < coarse.nodes; ++n)
    for (int i = 0; i < 3; ++i) c[size_t(3 * n + i)] = 2 * coarse.node_coord(n, i) + 1;
  prolong_correction(fine, c.data(), f.data());
  for (int64_t n = 0; n < fine.nodes; ++n)
    for (int i = 0; i < 3; ++i) ASSERT_NEAR(f[size_t(3 * n + i)], fine.node_coord(n, i) + 1, 1e-12);
}

TEST(Multigrid, CoarseLevelsKeepMassAndStiffness) {
  // sums over the grid: mass; volume times modulus (the mean of eight children has eight times
  // their volume)
  Scene scene = scene_on(ragged_grid(14, 12, 10, kGridH, 43), solid(1e6, 0.3));
  finish_scene(scene);
  LevelGrid fine = finest_of(scene);
  const LevelGrid coarse = coarser_level(fine);
  double mass[2] = {}, stiffness[2] = {};
  const LevelGrid* levels[2] = {&fine, &coarse};
  for (int l = 0; l < 2; ++l) {
    for (const double m : levels[l]->inertia) mass[l] += m;
    for (size_t v = 0; v < levels[l]->moduli.size() / 6; ++v)
      stiffness[l] += levels[l]->moduli[6 * v] * std::pow(levels[l]->h, 3);
  }
  EXPECT_NEAR(mass[1] / mass[0], 1, 1e-12);
  EXPECT_NEAR(stiffness[1] / stiffness[0], 1, 1e-12);
}

TEST(Multigrid, LargestEigenvalueOfTheSmoothedOperatorStaysBelowTheElementBound) {
  for (const double poisson : {0.3, 0.45, 0.49}) {
    const Scene scene = ragged_scene(poisson, 1e3);  // no inertia to speak of
    Multigrid<double> multigrid(scene, 1);
    const size_t size = 3 * size_t(scene.grid.node_count());
    std::vector<double> unit(size), product(size), diagonal(size), p = random_field(scene, 1, 8);
    // the diagonal, node by node
    for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
      for (int i = 0; i < 3; ++i) unit[size_t(3 * n + i)] = 1;
      multigrid.operator_product(unit.data(), product.data());
      for (int i = 0; i < 3; ++i) {
        diagonal[size_t(3 * n + i)] = product[size_t(3 * n + i)];
        unit[size_t(3 * n + i)] = 0;
      }
    }
    // power iteration on D^-1 A
    double largest = 0;
    for (int k = 0; k < 200; ++k) {
      multigrid.operator_product(p.data(), product.data());
      for (size_t i = 0; i < size; ++i) product[i] = diagonal[i] > 0 ? product[i] / diagonal[i] : 0;
      largest = norm(product) / norm(p);
      const double length = norm(product);
      for (size_t i = 0; i < size; ++i) p[i] = product[i] / length;
    }
    // the bound of one element
    const Material& m = scene.materials[0];
    const double k = 2 * m.mu() + m.lambda(), c = (m.mu() + m.young / 2) / 2;
    const double bound = 1.03 * (k / 2) / ((k + 2 * m.mu()) / 16 + 7 * c / 48);
    EXPECT_LE(largest, bound);
    EXPECT_GT(largest, 0.3 * bound);
    printf("nu %.2f: largest eigenvalue %.2f, element bound %.2f\n", poisson, largest, bound);
  }
}

TEST(Multigrid, OperatorOnAffineFieldsHasTheClosedForm) {
  // p.A p = sum_e k_ie G_ie^2 (filled volume) + a0/dt^2 sum_n m_n p_n^2, free body
  for (const bool ragged : {false, true}) {
    Scene scene = scene_on(ragged ? ragged_grid(9, 9, 9, kGridH, 44) : make_box(9, 5, 5, kGridH),
                           solid(1e6, 0.4));
    finish_scene(scene);
    const double a0 = 2.25;
    Multigrid<double> multigrid(scene, a0);
    const double G[3][3] = {{0.3, -0.2, 0.5}, {0.7, 0.1, -0.4}, {-0.6, 0.2, 0.9}};
    std::vector<double> p(3 * size_t(scene.grid.node_count())), Ap(p.size());
    double expected = 0, volume = 0;
    for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
      volume += scene.grid.fill(v) * kGridH * kGridH * kGridH;
    const double mu = scene.materials[0].mu(), lambda = scene.materials[0].lambda();
    for (int i = 0; i < 3; ++i)
      for (int e = 0; e < 3; ++e)
        expected += (i == e ? 2 * mu + lambda : mu) * G[i][e] * G[i][e] * volume;
    for (int64_t n = 0; n < scene.grid.node_count(); ++n)
      for (int i = 0; i < 3; ++i) {
        double value = 0.2;
        for (int e = 0; e < 3; ++e) value += G[i][e] * scene.grid.rest(n, e);
        p[size_t(3 * n + i)] = value;
        expected += a0 * scene.mass(n) / (scene.dt * scene.dt) * value * value;
      }
    multigrid.operator_product(p.data(), Ap.data());
    EXPECT_NEAR(dot(p, Ap) / expected, 1, 1e-12);
  }
}

TEST(Multigrid, LevelsAreTheSameForOneAndTwoThreads) {
  const Scene scene = ragged_scene(0.3);
  std::unique_ptr<Multigrid<float>> built[2];
  for (int threads = 1; threads <= 2; ++threads) {
    const ThreadLimit limit(threads);
    built[threads - 1] = std::make_unique<Multigrid<float>>(scene, 1);
  }
  ASSERT_EQ(built[0]->level_count(), built[1]->level_count());
  for (int l = 0; l < built[0]->level_count(); ++l) {
    const MultigridLevel<float> a = built[0]->level(l), b = built[1]->level(l);
    EXPECT_EQ(a.moduli, b.moduli);
    EXPECT_EQ(a.added, b.added);
    EXPECT_EQ(a.inverse_diagonal, b.inverse_diagonal);
    EXPECT_EQ(a.pinned, b.pinned);
    EXPECT_EQ(a.node_coord, b.node_coord);
    EXPECT_EQ(a.lambda_max, b.lambda_max);
    EXPECT_EQ(a.unit, b.unit);
  }
  // which have the dense inverse too
  const std::vector<double> random = random_field(scene, 1, 9);
  const std::vector<float> r(random.begin(), random.end());
  std::vector<float> z[2] = {std::vector<float>(r.size()), std::vector<float>(r.size())};
  for (int k = 0; k < 2; ++k) built[k]->apply(r.data(), z[k].data());
  EXPECT_EQ(z[0], z[1]);
}

}  // namespace
}  // namespace elastogen::test
