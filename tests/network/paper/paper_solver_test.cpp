// SPDX-License-Identifier: Apache-2.0
#include "network/paper/paper_solver.hpp"

#include "core/error.hpp"
#include "network/paper/paper_model.hpp"
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr double kPaperH = 0.1;

Material soft(double poisson, double young = 1e4) {
  return {"soft", Law::kNeoHookean, young, poisson, 1000};
}

/// A box without pins and gravity that ends a step of dt.
Scene free_box(int n, const Material& material, double dt, Hourglass hourglass) {
  Scene scene;
  scene.grid = make_box(n, n, n, kPaperH);
  scene.materials = {material};
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  scene.dt = dt;
  scene.hourglass = hourglass;
  finish_scene(scene);
  return scene;
}

/// Stiffness of one voxel against a velocity field, read off one step: u solves
/// m (u - dt v)/dt^2 + k u = 0 for every mode of the element.
template <class Field>
double stiffness(const SolverOptions& options, double poisson, const Field& field) {
  const double dt = 0.004;
  const Scene scene = free_box(1, soft(poisson), dt, Hourglass::kVariance);
  State state = initial_state(scene);
  for (int64_t n = 0; n < 8; ++n)
    for (int i = 0; i < 3; ++i) {
      const double* X = scene.grid.rest.row(n);
      state.v(n, i) = 1e-5 * field(i, X[0] - kPaperH / 2, X[1] - kPaperH / 2, X[2] - kPaperH / 2);
    }
  const State before = state;
  Solver solver(scene, options);
  EXPECT_TRUE(solver.step(state).finite);
  double force = 0, motion = 0;  // m (dt v - u)/dt^2 . u and u . u
  for (int64_t n = 0; n < 8; ++n)
    for (int i = 0; i < 3; ++i) {
      const double u = state.x(n, i) - before.x(n, i);
      force += scene.mass(n) * (dt * before.v(n, i) - u) / (dt * dt) * u;
      motion += u * u;
    }
  return force / motion;
}

double bulk(const SolverOptions& options, double poisson) {
  return stiffness(options, poisson, [](int i, double x, double y, double z) {
    return i == 0 ? x : i == 1 ? y : z;
  });
}

double shear(const SolverOptions& options, double poisson) {
  return stiffness(options, poisson, [](int i, double x, double y, double) {
    return i == 0 ? y : i == 1 ? x : 0;
  });
}

SolverOptions paper(int outer, int inner, int modes) {
  SolverOptions options;
  options.mode = SolverMode::kPaper;
  options.paper = {outer, inner, modes};
  return options;
}

// the fixed point of the lagged loop has the geometric mean of weight and truth as its stiffness
TEST(PaperSolver, FixedPointIsSoftInVolumeAndStiffInShear) {
  SolverOptions newton;
  newton.mode = SolverMode::kNewton;
  newton.tolerance = 1e-12;
  // energy-fitted loops diverge from 3K > 4 omega on, nu = 3/8, in statics: inertia holds 0.45
  for (const double nu : {0.0, 0.32, 0.45}) {
    const SolverOptions loops = paper(400, 60, 0);
    EXPECT_NEAR(bulk(loops, nu) / bulk(newton, nu), std::sqrt(1 - 2 * nu), 1e-3) << nu;
    EXPECT_NEAR(shear(loops, nu) / shear(newton, nu), std::sqrt(1 + nu), 1e-3) << nu;
  }
  const SolverOptions loops = paper(400, 60, 0);
  EXPECT_NEAR(bulk(loops, 0.32) / bulk(newton, 0.32), 0.600, 1e-3);
  EXPECT_NEAR(shear(loops, 0.32) / shear(newton, 0.32), 1.149, 1e-3);
}

// the true solvers against the moduli themselves
TEST(PaperSolver, TheOtherModesHaveTheTrueModuli) {
  for (const SolverMode mode : {SolverMode::kNewton, SolverMode::kQuasi}) {
    SolverOptions options;
    options.mode = mode;
    options.tolerance = 1e-12;
    const Material m = soft(0.32);
    // a mode with F = I + e A has energy h^3 e^2/2 A:C:A, and sum |u|^2 = 8 (h/2)^2 e^2 |A|^2
    const double K = m.lambda() + 2 * m.mu() / 3;
    EXPECT_NEAR(bulk(options, 0.32) / (kPaperH * 9 * K / (2 * 3)), 1, 1e-4);
    EXPECT_NEAR(shear(options, 0.32) / (kPaperH * 4 * m.mu() / (2 * 2)), 1, 1e-4);
  }
}

TEST(PaperModel, FittedStretchesGiveTheEnergy) {
  for (const Law law :
       {Law::kNeoHookean, Law::kStvk, Law::kFixedCorotated, Law::kHencky, Law::kStableNeoHookean}) {
    const Material m{"m", law, 3e5, 0.3, 1000};
    const LawParameters<double> p{law, m.mu(), m.lambda()};
    for (const auto& s :
         {std::array{1.3, 0.9, 0.8}, std::array{1.0, 1.0, 1.2}, std::array{0.6, 0.7, 1.9}}) {
      double n[3], sum = 0;
      energy_fitted_stretches<double>(nullptr, p, s.data(), n);
      for (int i = 0; i < 3; ++i) sum += std::pow(s[size_t(i)] * n[i] - 1, 2);
      const double psi = elastic_response<false>(p, s.data()).psi;
      EXPECT_NEAR(m.young / 2 * sum / psi, 1, 1e-12);
    }
    const double rest[3] = {1, 1, 1};
    double n[3];
    energy_fitted_stretches<double>(nullptr, p, rest, n);
    for (const double value : n) EXPECT_EQ(value, 1);
  }
}

/// Largest eigenvalue of D^-1 A by power iteration.
double largest_eigenvalue(PaperSolver& solver, int64_t nodes) {
  std::vector<double> p(3 * size_t(nodes)), f(p.size());
  for (size_t k = 0; k < p.size(); ++k) p[k] = std::sin(double(k * k % 1013) + 0.3);
  double value = 0;
  for (int it = 0; it < 400; ++it) {
    solver.product(p.data(), f.data());
    double size = 0, along = 0;
    for (int64_t n = 0; n < nodes; ++n)
      for (size_t k = size_t(3 * n); k < size_t(3 * n + 3); ++k) {
        f[k] /= solver.diagonal(n);
        along += f[k] * p[k];
        size += f[k] * f[k];
      }
    double old = 0;
    for (const double x : p) old += x * x;
    value = along / old;
    for (size_t k = 0; k < p.size(); ++k) p[k] = f[k] / std::sqrt(size);
  }
  return value;
}

struct Frozen {
  Scene scene;
  IncrementalPotential potential;
  PaperSolver solver;
  Frozen(Scene s, double amplitude)
      : scene(std::move(s)), potential(scene), solver(potential, PaperLoops{1, 1, 0}) {
    State state = initial_state(scene);
    potential.begin_step(state, step_scheme(scene, state));
    std::vector<double> u(3 * size_t(scene.grid.node_count()));
    for (size_t k = 0; k < u.size(); ++k)
      u[k] = amplitude * kPaperH * std::sin(double(k * k % 997) * 1.7);
    solver.freeze(u.data());
  }
  double largest() { return largest_eigenvalue(solver, scene.grid.node_count()); }
};

// the majorised diagonal: at most 3/2 for c_h/omega <= nmax^2, below 2 in every state
TEST(PaperSolver, MajorisedDiagonalBoundsTheSpectrum) {
  for (const double amplitude : {0.0, 0.1, 0.3}) {
    Frozen full(free_box(6, soft(0.3), 10, Hourglass::kVariance), amplitude);
    EXPECT_LE(full.largest(), 1.5 + 1e-9) << amplitude;
    EXPECT_GT(full.largest(), 0.9);
  }
}

TEST(PaperSolver, RowSumsBoundTheSpectrumOfBorderVoxels) {
  Scene scene = free_box(4, soft(0.3), 10, Hourglass::kVariance);
  for (int64_t v = 0; v < scene.grid.voxel_count(); v += 3) {
    scene.grid.fill(v) = 0.1 + 0.2 * double(v % 4);
    double sum = 0;
    for (int c = 0; c < 8; ++c) sum += scene.grid.shape_mean(v, c) = 0.02 + ((c * 5 + v) % 7);
    for (int c = 0; c < 8; ++c) scene.grid.shape_mean(v, c) /= sum;
  }
  finish_scene(scene);
  for (const double amplitude : {0.0, 0.2}) {
    Frozen ragged(scene, amplitude);
    EXPECT_LE(ragged.largest(), 2 + 1e-9) << amplitude;
  }
}

// the printed operator: (4 C^2 + 1)/(1.5 C^2 + 1) passes 2 at C = 1
TEST(PaperSolver, PrintedOperatorDivergesAboveCourantNumberOne) {
  for (const double C : {0.8, 3.0}) {
    const Material m = soft(0);
    const double dt = C * kPaperH / std::sqrt(m.young / m.density);
    Frozen printed(free_box(12, m, dt, Hourglass::kOff), 0);
    const double infinite = (4 * C * C + 1) / (1.5 * C * C + 1);
    EXPECT_NEAR(printed.largest(), infinite, 0.03) << C;
  }
}

TEST(PaperSolver, EncoderAndSweepsReachTheLaggedMinimum) {
  // cantilever: many sweeps without encoder and few with it end in one state
  Scene scene = test::clamped_beam(8, 2, 2, kPaperH, soft(0.3, 1e5));
  scene.hourglass = Hourglass::kVariance;
  finish_scene(scene);
  const auto end = [&](int inner, int modes) {
    State state = initial_state(scene);
    Solver solver(scene, paper(30, inner, modes));
    EXPECT_TRUE(solver.step(state).finite);
    return state.x;
  };
  const Array<double> a = end(2000, 0), b = end(400, 54);
  double largest = 0, moved = 0;
  for (int64_t k = 0; k < a.size(); ++k) {
    largest = std::max(largest, std::abs(a.data()[k] - b.data()[k]));
    moved = std::max(moved, std::abs(a.data()[k] - scene.grid.rest.data()[k]));
  }
  EXPECT_LT(largest, 1e-6 * moved);
}

TEST(PaperSolver, RefusesWhatItCannotDo) {
  const auto refused = [](Hourglass hourglass, const SolverOptions& options) {
    const Scene scene = free_box(2, soft(0.3), 0.01, hourglass);
    EXPECT_THROW(Solver(scene, options), Error);
  };
  refused(Hourglass::kFull, paper(1, 1, 3));
  refused(Hourglass::kVariance, paper(0, 1, 3));
  refused(Hourglass::kVariance, paper(1, 0, 3));
  refused(Hourglass::kVariance, paper(1, 1, 4));
  refused(Hourglass::kVariance, paper(1, 1, 195));
}

}  // namespace
}  // namespace elastogen
