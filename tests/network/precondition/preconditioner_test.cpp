// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/preconditioner.hpp"

#include "core/pcg.hpp"
#include "tests/network/scenes.hpp"

#include <Eigen/Eigenvalues>
#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// Gravity, 2 % white noise, and cos(2 pi x/L) in every component with gravity's norm.
std::vector<double> load(const Scene& scene) {
  std::mt19937 random(61);
  std::normal_distribution<double> normal;
  Box box;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    box.add({scene.grid.rest(n, 0), scene.grid.rest(n, 1), scene.grid.rest(n, 2)});
  std::vector<double> gravity(3 * size_t(scene.grid.node_count())), noise(gravity), wave(gravity);
  for (size_t k = 0; k < gravity.size(); ++k) {
    const int64_t n = int64_t(k / 3);
    const double white = normal(random);
    if (scene.pinned(n)) continue;
    gravity[k] = k % 3 == 1 ? -9.81 * scene.mass(n) : 0;
    noise[k] = white;
    wave[k] = std::cos(2 * M_PI * (scene.grid.rest(n, 0) - box.lower[0]) / box.extent(0));
  }
  std::vector<double> b = gravity;
  for (size_t k = 0; k < b.size(); ++k)
    b[k] += norm(gravity) * (0.02 * noise[k] / norm(noise) + wave[k] / norm(wave));
  return b;
}

/// Iterations to 1e-1, 1e-2, 1e-4 of |r|/|b| on the Hessian at rest, from the encoder's solution.
std::array<int, 3> iterations(const Scene& scene) {
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  Preconditioner<float> preconditioner(potential, {});
  Encoder<double> encoder(potential);
  const std::vector<double> b = load(scene);
  const int64_t size = int64_t(b.size());
  const auto product = [&](const double* p, double* Ap) { potential.rest_hessian_product(p, Ap); };
  std::vector<double> x0(b.size()), r(b.size()), x(b.size());
  encoder.add(b.data(), x0.data());
  product(x0.data(), r.data());
  for (size_t k = 0; k < b.size(); ++k) r[k] = b[k] - r[k];
  PcgWork<double> work(size);
  std::array<int, 3> counts;
  const double tolerances[3] = {1e-1, 1e-2, 1e-4};
  for (size_t t = 0; t < 3; ++t)
    counts[t] = pcg(r.data(), x.data(), size, tolerances[t] * norm(b) / norm(r), 500, work, product,
                    [&](const double* s, double* z) { preconditioner.apply(s, z); })
                    .iterations;
  return counts;
}

void expect_counts(const char* name, const Scene& scene, const std::array<int, 3>& table) {
  const std::array<int, 3> counts = iterations(scene);
  printf("%s: %d / %d / %d iterations, table %d / %d / %d, %d voxels\n", name, counts[0], counts[1],
         counts[2], table[0], table[1], table[2], int(scene.grid.voxel_count()));
  for (size_t t = 0; t < 3; ++t) EXPECT_LE(counts[t], std::ceil(1.3 * table[t]) + (t == 0)) << name;
}

Scene swinging_beam(double C, double poisson) {
  const double h = 0.025;
  return clamped_beam(32, 8, 8, h, solid(young_of_courant(C, h, 1.0 / 60), poisson));
}

TEST(Preconditioner, NeedsTheIterationsOfTheTableOnAClampedBeam) {
  expect_counts("beam 32x8x8, nu 0.3", swinging_beam(10, 0.3), {4, 8, 15});
  expect_counts("beam 32x8x8, nu 0.45", swinging_beam(10, 0.45), {8, 13, 24});
}

TEST(Preconditioner, NeedsTheIterationsOfTheTableOnAFreeBall) {
  for (const double poisson : {0.3, 0.45}) {
    const double h = 0.025;
    Scene scene = scene_on(ball_grid(8 * h, h), solid(young_of_courant(10, h, 1.0 / 60), poisson));
    finish_scene(scene);
    if (poisson < 0.4)
      expect_counts("ball R/h = 8, nu 0.3", scene, {3, 6, 12});
    else
      expect_counts("ball R/h = 8, nu 0.45", scene, {7, 12, 23});
  }
}

TEST(Preconditioner, CountsGrowByHalfAtMostFromCourantTenToFifty) {
  const std::array<int, 3> soft = iterations(swinging_beam(10, 0.3)),
                           stiff = iterations(swinging_beam(50, 0.3));
  printf("beam nu 0.3: C 10 %d / %d / %d, C 50 %d / %d / %d\n", soft[0], soft[1], soft[2], stiff[0],
         stiff[1], stiff[2]);
  EXPECT_LE(stiff[1], 1.5 * soft[1]);
  EXPECT_LE(stiff[2], 1.5 * soft[2]);
}

TEST(Preconditioner, IsSymmetricAndPositiveInATurnedStateWithContact) {
  Scene scene = scene_on(ragged_grid(9, 7, 6, 0.1, 62), solid(1e5, 0.4));
  pin_below(scene, 0, -0.2);
  scene.surface = face_points(scene.grid);
  scene.colliders = {half_space({0, 1, 0}, -0.26, 0.5)};
  finish_scene(scene);
  // a turned and shaken state that touches the floor
  State state = initial_state(scene);
  const std::vector<double> noise = random_field(scene, 0.002, 63);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const double* X = scene.grid.rest.row(n);
    const double turn = scene.pinned(n) ? 0 : 0.5;  // about y, so that the floor is kept
    state.x(n, 0) = std::cos(turn) * X[0] + std::sin(turn) * X[2] + noise[size_t(3 * n)];
    state.x(n, 2) = std::cos(turn) * X[2] - std::sin(turn) * X[0];
  }
  IncrementalPotential potential(scene);
  potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
  const std::vector<double> u = displacement(scene, state);
  potential.linearise(u.data());
  Preconditioner<double> preconditioner(potential, {});
  // with and without the stiffness of contact
  const std::vector<double> x = random_field(scene, 1, 64), y = random_field(scene, 1, 65);
  std::vector<double> Bx(x.size()), By(x.size()), free(x.size());
  preconditioner.apply(x.data(), free.data());
  preconditioner.update_contact();
  preconditioner.apply(x.data(), Bx.data());
  preconditioner.apply(y.data(), By.data());
  EXPECT_FALSE(potential.contact().stiff_nodes().empty());
  EXPECT_GT(relative_difference(Bx, free), 1e-3);  // the scaling of contact is at work
  EXPECT_NEAR(dot(x, By), dot(y, Bx), 1e-6 * norm(x) * norm(By));  // nodal rotations are float
  EXPECT_GT(dot(x, Bx), 0);
}

/// The least and the largest eigenvalue of B times the elastic operator at rest on the free
/// components, B the preconditioner with and without the encoder.
std::array<double, 2> spectrum_at_rest(const Scene& scene, bool with_encoder) {
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  Preconditioner<double> preconditioner(potential, {with_encoder});
  // free components
  std::vector<size_t> free;
  const auto size = 3 * size_t(scene.grid.node_count());
  for (size_t k = 0; k < size; ++k)
    if (!scene.pinned(int64_t(k / 3))) free.push_back(k);
  const auto count = Eigen::Index(free.size());
  // both operators by unit vectors
  Eigen::MatrixXd A(count, count), B(count, count);
  std::vector<double> unit(size), Au(size), Bu(size);
  for (Eigen::Index column = 0; column < count; ++column) {
    const size_t k = free[size_t(column)];
    unit[k] = 1;
    potential.rest_hessian_product(unit.data(), Au.data());
    preconditioner.apply(unit.data(), Bu.data());
    unit[k] = 0;
    for (Eigen::Index row = 0; row < count; ++row) {
      A(row, column) = Au[free[size_t(row)]];
      B(row, column) = Bu[free[size_t(row)]];
    }
  }
  // eigenvalues of L^T B L with A = L L^T
  const Eigen::MatrixXd L = A.llt().matrixL();
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(L.transpose() * (B + B.transpose()) / 2 * L,
                                                     Eigen::EigenvaluesOnly)
          .eigenvalues();
  return {values.minCoeff(), values.maxCoeff()};
}

TEST(Preconditioner, LeavesTheEncoderOutWhereThatHasNothingToAdd) {
  for (const auto& [C, kept] : {std::pair{2.0, false}, std::pair{100.0, true}}) {
    const Scene scene = swinging_beam(C, 0.3);
    IncrementalPotential potential(scene);
    potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
    Preconditioner<float> preconditioner(potential, {true, 5}), alone(potential, {false});
    EXPECT_EQ(preconditioner.encoder() != nullptr, kept);
    std::vector<double> r = load(scene), z(r.size()), expected(r.size());
    preconditioner.apply(r.data(), z.data());
    alone.apply(r.data(), expected.data());
    EXPECT_EQ(z == expected, !kept);
  }
}

TEST(Preconditioner, IsAsGoodWithTheEncoderAsWithoutInItsWorstDirection) {
  struct Case {
    const char* name;
    VoxelGrid grid;
    bool pinned;
  };
  const double h = 0.05;
  const Case cases[] = {{"beam", make_box(10, 3, 3, h), true},
                        {"needle", make_box(30, 1, 1, h), true},
                        {"plate", make_box(8, 8, 1, h), false},
                        {"ragged", ragged_grid(7, 6, 5, h, 66), true},
                        {"ball", ball_grid(3 * h, h), false}};
  for (const Case& c : cases)
    for (const double C : {1.0, 10.0, 100.0})
      for (const double poisson : {0.0, 0.49}) {
        Scene scene = scene_on(c.grid, solid(young_of_courant(C, h, 1.0 / 60), poisson));
        if (c.pinned) pin_below(scene, 0, c.grid.rest(0, 0) + h / 2);
        finish_scene(scene);
        const auto [low, high] = spectrum_at_rest(scene, true);
        const auto [low_alone, high_alone] = spectrum_at_rest(scene, false);
        printf("%-8s C %5g, nu %4g: %.4f ... %.3f, multigrid alone %.4f ... %.3f\n", c.name, C,
               poisson, low, high, low_alone, high_alone);
        // the encoder replaces multigrid's result where it is better, and is not added to it
        EXPECT_GT(low, 0.85 * low_alone);
        EXPECT_LT(high, 1.25 * high_alone);
        if (C == 100) {
          EXPECT_GT(low, 1.04 * low_alone);
        }
      }
}

/// The matrix of B on the free components.
Eigen::MatrixXd dense(const Scene& scene, Preconditioner<double>& B) {
  std::vector<int64_t> free;
  for (int64_t k = 0; k < 3 * scene.grid.node_count(); ++k)
    if (!scene.pinned(k / 3)) free.push_back(k);
  std::vector<double> r(3 * size_t(scene.grid.node_count())), z(r);
  Eigen::MatrixXd matrix(free.size(), free.size());
  for (size_t column = 0; column < free.size(); ++column) {
    std::fill(r.begin(), r.end(), 0);
    r[size_t(free[column])] = 1;
    B.apply(r.data(), z.data());
    for (size_t row = 0; row < free.size(); ++row)
      matrix(Eigen::Index(row), Eigen::Index(column)) = z[size_t(free[row])];
  }
  return matrix;
}

// with the share 0.8 of the encoder for every material the cubes of nu 0.499 fail
TEST(Preconditioner, IsPositiveDefiniteUpToThePoissonRatiosOfRubber) {
  const double h = 0.025, dt = 1.0 / 60;
  for (const double poisson : {0.48, 0.495, 0.499})
    for (const double C : {10.0, 1e4})
      for (const bool pinned : {false, true}) {
        Scene scene = scene_on(make_box(6, 6, 6, h), solid(young_of_courant(C, h, dt), poisson));
        if (pinned) pin_below(scene, 0, h / 2);
        finish_scene(scene);
        IncrementalPotential potential(scene);
        potential.begin_step(initial_state(scene), {TimeScheme::kEuler, dt, 1});
        Preconditioner<double> B(potential, {}, 30);
        const Eigen::MatrixXd matrix = dense(scene, B);
        EXPECT_EQ(Eigen::LLT<Eigen::MatrixXd>(matrix).info(), Eigen::Success)
            << "nu " << poisson << " C " << C << " pinned " << pinned;
      }
}

TEST(Preconditioner, AnotherInertiaIsThatOfOneBuiltWithIt) {
  // a step of a tenth of the length, and back
  Scene scene = clamped_beam(12, 4, 4, 0.05, solid(2e5, 0.3));
  Scene shorter = scene;
  shorter.dt = scene.dt / 10;
  finish_scene(shorter);
  const auto built = [](const Scene& of) {
    auto potential = std::make_unique<IncrementalPotential>(of);
    potential->begin_step(initial_state(of), {TimeScheme::kEuler, of.dt, 1});
    return potential;
  };
  const auto potential = built(scene), other = built(shorter), same = built(scene);
  Preconditioner<double> changed(*potential, {}), wanted(*other, {}), first(*same, {});
  const std::vector<double> r = random_field(scene, 1, 3);
  std::vector<double> z(r.size()), expected(r.size());
  const auto expect_same = [&](Preconditioner<double>& to) {
    changed.apply(r.data(), z.data());
    to.apply(r.data(), expected.data());
    EXPECT_LT(relative_difference(z, expected), 1e-9);
  };
  for (int turn = 0; turn < 2; ++turn) {  // the second time what was found is used again
    potential->set_scheme({TimeScheme::kEuler, shorter.dt, 1});
    changed.update_inertia();
    expect_same(wanted);
    potential->set_scheme({TimeScheme::kEuler, scene.dt, 1});
    changed.update_inertia();
    expect_same(first);
  }
}

}  // namespace
}  // namespace elastogen::test
