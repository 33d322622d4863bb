// SPDX-License-Identifier: Apache-2.0
// Nets that the device evaluates themselves, without their tables, against the CPU. Nothing is here
// in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "network/paper/paper_solver.hpp"
#include "network/paper/paper_solver_device.hpp"
#include "network/solver.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/potential/device_potential_support.hpp"

namespace elastogen::test {
namespace {

using NetOnCard = OnCard;

constexpr Law kFitted[] = {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean,
                           Law::kStvk, Law::kHencky};
const StepScheme kBegun{TimeScheme::kEuler, 1.0 / 60, 1};

/// Laws of the materials of a ragged block: a net and a law, two nets, a net and a table.
std::vector<LearnedLaws> mixtures(Law law) {
  const auto net = [law](double poisson, Evaluation evaluation) {
    return shipped_net(law, poisson, evaluation);
  };
  return {{net(0.4, Evaluation::kNet), nullptr},
          {net(0.4, Evaluation::kNet), net(0.3, Evaluation::kNet)},
          {net(0.4, Evaluation::kNet), net(0.3, Evaluation::kTable)}};
}

TEST_F(NetOnCard, EnergyAndGradientAreThoseOfTheHost) {
  for (const Law law : kFitted) {
    const Scene scene = ragged(law);
    for (const LearnedLaws& nets : mixtures(law))
      for (const double shake : {0.03, 0.9}) {  // the second leaves the box of the nets
        SCOPED_TRACE(concat(law_name(law), " shaken by ", shake));
        const std::vector<double> now = bent(scene, 0.02 * kRaggedEdge, 5),
                                  u = bent(scene, shake * kRaggedEdge, 6);
        IncrementalPotential host(scene, nets);
        host.begin_step(state_at(scene, now), kBegun);
        cuda::DevicePotential device(host);
        device.begin_step(host);
        // f of nets of St. Venant-Kirchhoff's law is a sum of terms of up to 50, a hundred times f
        expect_like_host<double>(host, device, u, law == Law(Law::kStvk) ? 1e-11 : 1e-12);
        if (shake < 0.1) expect_like_host<float>(host, device, u, 2e-5);
      }
  }
}

/// Log stretches of a body, one along x and two across.
struct Stretch {
  double along, across;
};

/// Inside the fitted box, on either side of its borders, where nets are blended out, and beyond.
TEST_F(NetOnCard, StretchesAtTheBordersOfTheBoxAreThoseOfTheHost) {
  constexpr double kLittle = 1e-9;
  // the box ends at a stretch and at a trace
  const double share = kFittedTrace / 3, out = kBlendedTrace / 3;
  const Stretch stretches[] = {{0.3, -0.1},  // inside
                               {kFittedStretch - kLittle, -0.4},
                               {kFittedStretch + kLittle, -0.4},
                               {-kFittedStretch + kLittle, 0.3},
                               {-kFittedStretch - kLittle, 0.3},
                               {share - kLittle, share},
                               {share + kLittle, share},
                               {1.1, -0.5},  // blended
                               {kBlendedStretch - kLittle, -1},
                               {kBlendedStretch + kLittle, -1},
                               {out - kLittle, out},
                               {out + kLittle, out},
                               {2, -1.5}};  // the law alone
  // a homogeneous body, so that all voxels have these stretches
  Scene scene = scene_on(make_box(9, 3, 2, kRaggedEdge), solid(3e4, 0.4));
  scene.hourglass = Hourglass::kOff;  // whose energy would be rounding
  finish_scene(scene);
  IncrementalPotential host(scene, {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kNet)});
  host.begin_step(initial_state(scene), kBegun);
  cuda::DevicePotential device(host);
  device.begin_step(host);
  for (const Stretch& e : stretches) {
    SCOPED_TRACE(concat("log stretches ", e.along, " and ", e.across));
    std::vector<double> u(3 * size_t(scene.grid.node_count()));
    for (size_t k = 0; k < u.size(); ++k)
      u[k] = std::expm1(k % 3 == 0 ? e.along : e.across) * scene.grid.rest.data()[k];
    expect_like_host<double>(host, device, u, 1e-12);
  }
}

TEST_F(NetOnCard, HessianIsThatOfTheHost) {
  for (const Law law : kFitted) {
    const Scene scene = ragged(law);
    for (const LearnedLaws& nets : mixtures(law)) {
      SCOPED_TRACE(law_name(law));
      const std::vector<double> now = bent(scene, 0.02 * kRaggedEdge, 5),
                                u = bent(scene, 0.03 * kRaggedEdge, 6);
      IncrementalPotential host(scene, nets);
      host.begin_step(state_at(scene, now), kBegun);
      cuda::DevicePotential device(host);
      device.begin_step(host);
      expect_hessian_of_host(host, device, u, bent(scene, 0.5 * kRaggedEdge, 7));
    }
  }
}

/// Positions and reports at the end of some steps.
struct NetRun {
  State state;
  int converged = 0, outer = 0;
};

NetRun run_by_net(const Scene& scene, SolverOptions options, Device device, int steps) {
  options.device = device;
  options.learned = {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kNet)};
  Solver solver(scene, options);
  EXPECT_EQ(solver.device() == "cpu", device == Device::kCpu);
  NetRun run{initial_state(scene, {.velocity = {0, -0.5, 0.3}})};
  for (int k = 0; k < steps; ++k) {
    const StepReport report = solver.step(run.state);
    run.converged += report.converged;
    run.outer += report.outer;
  }
  return run;
}

TEST_F(NetOnCard, StepsEndInTheStatesOfTheHost) {
  constexpr int kSteps = 3;
  const Scene scene = clamped_beam(12, 3, 3, 0.05, solid(2e5, 0.4));
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    SCOPED_TRACE(solver_name(mode));
    const SolverOptions options{.mode = mode, .tolerance = 1e-6};
    const NetRun a = run_by_net(scene, options, Device::kCpu, kSteps);
    const NetRun b = run_by_net(scene, options, Device::kCuda, kSteps);
    EXPECT_EQ(a.converged, kSteps);
    EXPECT_EQ(b.converged, kSteps);
    EXPECT_LT(distance_of_ways(scene, b.state, a.state), 1e-5);
    EXPECT_NEAR(b.outer, a.outer, 1 + a.outer / 10);
    const NetRun again = run_by_net(scene, options, Device::kCuda, kSteps);
    EXPECT_EQ(again.state.x, b.state.x);  // the same bits
  }
}

TEST_F(NetOnCard, PaperLoopsEndWhereThoseOfTheHostEnd) {
  const Scene beam = [] {
    Scene scene = clamped_beam(12, 3, 3, 0.05, solid(2e5, 0.4));
    scene.hourglass = Hourglass::kVariance;
    finish_scene(scene);
    return scene;
  }();
  IncrementalPotential potential(beam, {shipped_net(Law::kNeoHookean, 0.4, Evaluation::kNet)});
  const State state = initial_state(beam, {.velocity = {0, -0.5, 0.3}});
  potential.begin_step(state, step_scheme(beam, state));
  const PaperLoops loops{3, 4, 0};
  const auto never = [] { return false; };
  std::vector<double> host(potential.predictor().size()), device = host;
  PaperSolver(potential, loops).solve(host.data(), never);
  cuda::DeviceQuasi quasi(potential);
  quasi.begin_step(potential);
  cuda::DevicePaper(quasi, loops, true).solve(never);
  quasi.download_u(device.data());
  EXPECT_LT(relative_difference(device, host), 1e-12);
}

}  // namespace
}  // namespace elastogen::test

#endif
