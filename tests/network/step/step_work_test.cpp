// SPDX-License-Identifier: Apache-2.0
// The parts of a step on the host, and where there is one on a card, against their formulas.

#include "network/step/step_work.hpp"

#include "core/error.hpp"
#include "network/solver.hpp"
#include "network/step/free_flight.hpp"
#include "network/step/predictor.hpp"
#include "tests/network/step/moving_scenes.hpp"

namespace elastogen::test {
namespace {

enum class Machine { kHost, kCard };

/// A step that a machine has begun, and its potential beside it.
struct Begun {
  Begun(const Scene& s, Machine machine) : Begun(s, machine, in_motion(s)) {}
  Begun(const Scene& s, Machine machine, const State& from)
      : scene(s), state(from), scheme(step_scheme(s, state)), potential(s), flight(s) {
    potential.begin_step(state, scheme);
    const EncoderChoice encoder;
    work = machine == Machine::kCard
               ? cuda::make_device_step(potential, &encoder, {})
               : make_host_step(PotentialTerms(scene, {}, scheme), &encoder, {}, true);
    work->upload(state);
    work->begin_step(scheme, state.time);
  }
  std::vector<double> start() const {
    std::vector<double> u(potential.predictor().size());
    Predictor(scene).start(state, potential.predictor(), u.data());
    return u;
  }
  std::vector<double> u() const {
    std::vector<double> u(potential.predictor().size());
    work->download_u(u.data());
    return u;
  }
  /// The start of lowest Phi by the machine becomes its u.
  void choose_start() const {
    double phi[3];
    const int count = 1 + Predictor::orders(!state.x_before.empty());
    work->evaluate_starts(count, phi);
    work->use_start(int(std::min_element(phi, phi + count) - phi));
  }
  /// The start of lowest Phi by the potential, and its order.
  std::vector<double> chosen_start() {
    std::vector<double> lowest = start(), other = lowest;
    for (int order = 1; order <= Predictor::orders(!state.x_before.empty()); ++order) {
      Predictor(scene).extrapolate(state, scheme, order, other.data());
      if (rough_phi(other) < rough_phi(lowest)) lowest = other, chosen_order = order;
    }
    return lowest;
  }
  double rough_phi(const std::vector<double>& u) {
    return potential.evaluate(u.data(), static_cast<float*>(nullptr)).total();
  }
  double phi(const std::vector<double>& u) {
    std::vector<double> gradient(u.size());
    return potential.evaluate<double>(u.data(), gradient.data()).total();
  }

  const Scene& scene;
  State state;
  StepScheme scheme;
  IncrementalPotential potential;
  FreeFlight flight;
  std::unique_ptr<StepWork> work;
  int chosen_order = 0;
};

double farthest(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0;
  for (size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

void expect_starts(Machine machine) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    Begun b(scene, machine);
    const Zeroed<double>& of_now = b.potential.now();
    const std::vector<double> expected = b.start(), now(of_now.begin(), of_now.end());
    EXPECT_LT(relative_difference(b.u(), expected), 1e-12);
    const double way = farthest(expected, now);
    EXPECT_NEAR(b.work->farthest(), way, 1e-12 * way);
    EXPECT_NEAR(b.work->phi(), b.phi(expected), 1e-11 * b.phi(expected));
    EXPECT_NEAR(b.work->phi_now(), b.phi(now), 1e-11 * b.phi(now));
    b.choose_start();
    EXPECT_LT(relative_difference(b.u(), b.chosen_start()), 1e-12);
    b.work->return_to_now();
    EXPECT_LT(relative_difference(b.u(), now), 1e-12);
    b.work->upload_u(expected.data());
    EXPECT_EQ(b.work->clear_start(), nullptr);
    EXPECT_EQ(b.work->is_below_clear_start(), b.rough_phi(expected) < b.rough_phi(now));
    b.work->return_to_clear_start();
    EXPECT_LT(relative_difference(b.u(), now), 1e-12);
  }
}

void expect_starts_of_each_order(Machine machine) {
  struct Case {
    TimeScheme scheme;
    double faster, before;  ///< factors of the velocities, and of those before to them
    int order;              ///< of the lowest start
  };
  for (const Case& c : {Case{TimeScheme::kBdf2, 20, 0.5, 0}, Case{TimeScheme::kEuler, 1, 0, 1},
                        Case{TimeScheme::kEuler, 20, -3, 2}}) {
    SCOPED_TRACE(concat("order ", c.order));
    const Scene scene = beam_of_regions(c.scheme);
    State state = in_motion(scene);
    for (int64_t k = 0; k < state.v.size(); ++k) {
      state.v.data()[k] *= c.faster;
      state.v_before.data()[k] = c.before * state.v.data()[k];
    }
    Begun b(scene, machine, state);
    b.choose_start();
    EXPECT_LT(relative_difference(b.u(), b.chosen_start()), 1e-12);
    EXPECT_EQ(b.chosen_order, c.order);
  }
}

void expect_state_comes_back(Machine machine) {
  const Scene scene = three_blocks(TimeScheme::kBdf2);
  Begun b(scene, machine);
  State read;
  b.work->download(read, StateParts::kPositions);
  EXPECT_EQ(read.x, b.state.x);
  EXPECT_TRUE(read.v.empty());
  b.work->download(read, StateParts::kAll);
  EXPECT_EQ(read.v, b.state.v);
  EXPECT_EQ(read.x_before, b.state.x_before);
  EXPECT_EQ(read.v_before, b.state.v_before);
}

/// The end of a step by plain loops.
struct End {
  State state;
  MotionEnergy energy;
};

End plain_end(Begun& b, std::vector<double> u) {
  const Scene& scene = b.scene;
  const Zeroed<double>& aim = b.potential.predictor();
  if (b.flight.exists())
    b.flight.match_means(u.data(), [&](size_t n, size_t d) { return aim[3 * n + d]; });
  // x = X + u and the velocity of the scheme; pinned nodes rest
  State next = b.state;
  std::swap(next.x_before, next.x), std::swap(next.v_before, next.v);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (int d = 0; d < 3; ++d) {
      const double now = b.state.x(n, d);
      next.x(n, d) = scene.pinned(n) ? now : scene.grid.rest(n, d) + u[size_t(3 * n + d)];
      next.v(n, d) =
          scene.pinned(n) ? 0 : velocity_after(b.scheme, next.x(n, d), now, b.state.x_before(n, d));
    }
  if (b.flight.exists())
    b.flight.match_means(next.v.data(), [&](size_t n, size_t d) {
      const auto node = int64_t(n);
      return free_velocity(b.scheme, b.state.v(node, int(d)), b.state.v_before(node, int(d)),
                           scene.gravity[d]);
    });
  // energies of the new state
  MotionEnergy energy;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (int d = 0; d < 3; ++d) {
      energy.kinetic += scene.mass(n) / 2 * next.v(n, d) * next.v(n, d);
      energy.gravity -= scene.mass(n) * scene.gravity[size_t(d)] * next.x(n, d);
    }
  return {next, energy};
}

void expect_end(Machine machine) {
  for (const Scene& scene : scenes()) {
    SCOPED_TRACE(concat(scene.grid.voxel_count(), " voxels, scheme ", int(scene.scheme)));
    Begun b(scene, machine);
    // end the step at its start plus a random displacement
    std::vector<double> u = b.start();
    const std::vector<double> shake = random_field(scene, 0.02 * scene.grid.h, 8);
    for (size_t k = 0; k < u.size(); ++k) u[k] += shake[k];
    b.work->upload_u(u.data());
    const Certificate found = b.work->certify();
    const MotionEnergy energy = b.work->finish();
    const End end = plain_end(b, u);
    // certificate and energies
    std::vector<double> expected(u.size()), gradient(u.size());
    const PotentialValue value =
        b.potential.residual(displacement(scene, end.state).data(), expected.data());
    b.work->download_gradient(gradient.data());
    EXPECT_TRUE(found.finite);
    EXPECT_LT(relative_difference(gradient, expected), 1e-11);
    EXPECT_NEAR(found.size, norm(expected), 1e-11 * found.size);
    EXPECT_NEAR(found.value.total(), value.total(), 1e-11 * value.total());
    EXPECT_NEAR(found.value.min_corner_j, value.min_corner_j, 1e-11);
    EXPECT_NEAR(energy.kinetic, end.energy.kinetic, 1e-11 * energy.kinetic);
    EXPECT_NEAR(energy.gravity, end.energy.gravity, 1e-11 * std::abs(energy.gravity));
    // the new state
    State read;
    b.work->download(read, StateParts::kAll);
    EXPECT_LT(relative_difference(read.x, end.state.x), 1e-14);
    EXPECT_LT(relative_difference(read.v, end.state.v), 1e-11);
    EXPECT_EQ(read.x_before, b.state.x);
    EXPECT_EQ(read.v_before, b.state.v);
  }
}

void expect_not_finite_is_seen(Machine machine) {
  const Scene scene = beam_of_regions(TimeScheme::kEuler);
  Begun b(scene, machine);
  std::vector<double> u = b.start();
  u.back() = NAN;
  b.work->upload_u(u.data());
  EXPECT_FALSE(b.work->certify().finite);
}

TEST(StepWork, StartsByItsFormulas) {
  expect_starts(Machine::kHost);
}

TEST(StepWork, StartsOfEachOrderAreTaken) {
  expect_starts_of_each_order(Machine::kHost);
}

TEST(StepWork, StateComesBackAsItWent) {
  expect_state_comes_back(Machine::kHost);
}

TEST(StepWork, EndsByItsFormulas) {
  expect_end(Machine::kHost);
}

TEST(StepWork, DisplacementsThatAreNotFiniteAreSeen) {
  expect_not_finite_is_seen(Machine::kHost);
}

TEST(StepWork, TheHostStepsInTheArraysOfABorrowedState) {
  const Scene scene = falling_bar(TimeScheme::kEuler);
  Begun b(scene, Machine::kHost);
  State state = b.state;
  const double* x = state.x.data();
  b.work->borrow(state);
  b.work->begin_step(b.scheme, state.time);
  b.work->certify();
  b.work->finish();
  b.work->give_back(state);
  EXPECT_EQ(state.x_before.data(), x);
  EXPECT_EQ(state.x_before, b.state.x);
  State own;
  b.work->download(own, StateParts::kAll);
  EXPECT_EQ(own.x, b.state.x);  // of the clip
}

#ifdef ELASTOGEN_CUDA

TEST_F(OnCard, StartsByTheFormulasOfAStep) {
  expect_starts(Machine::kCard);
}

TEST_F(OnCard, StartsOfEachOrderAreTaken) {
  expect_starts_of_each_order(Machine::kCard);
}

TEST_F(OnCard, StateComesBackAsItWent) {
  expect_state_comes_back(Machine::kCard);
}

TEST_F(OnCard, EndsByTheFormulasOfAStep) {
  expect_end(Machine::kCard);
}

TEST_F(OnCard, DisplacementsThatAreNotFiniteAreSeen) {
  expect_not_finite_is_seen(Machine::kCard);
}

TEST_F(OnCard, StateOfSeveralChunksComesBackAsItWent) {
  // 5.4 MB an array, which go through two chunks of 2 MB by turns, the last of them in part
  const Scene scene = clamped_beam(60, 60, 60, 0.02, solid(1e5, 0.3));
  Begun b(scene, Machine::kCard);
  State read;
  for (int k = 0; k < 2; ++k) {
    b.work->download(read, StateParts::kAll);
    EXPECT_TRUE(read.x == b.state.x);
    EXPECT_TRUE(read.v == b.state.v);
    EXPECT_TRUE(read.x_before == b.state.x_before);
    EXPECT_TRUE(read.v_before == b.state.v_before);
    std::swap(b.state.x, b.state.x_before);
    b.work->upload(b.state);
  }
}

#endif

}  // namespace
}  // namespace elastogen::test
