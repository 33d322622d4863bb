// SPDX-License-Identifier: Apache-2.0
// Contact in steps of stages on the device against that of the CPU: bonds of friction, and what
// colliders do to pieces. Nothing is here in builds without CUDA; skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/potential/incremental_potential_device.hpp"
#include "tests/network/contact/contact_scenes.hpp"
#include "tests/network/device_numbers.hpp"
#include "tests/support/on_card.hpp"

namespace elastogen::test {
namespace {

/// Both contacts of a scene in stages, at a displacement.
struct BothContacts {
  explicit BothContacts(const Scene& s)
      : scene(s),
        terms(s, {}, {TimeScheme::kAuto, s.dt, 1}),
        potential(terms),
        u(random_field(s, 0.02 * kEdge, 3)),
        place(u) {}
  Contact& host() { return terms.contact(); }
  cuda::DeviceContact& card() { return *potential.contact(); }

  const Scene& scene;
  PotentialTerms terms;
  cuda::DevicePotential potential;
  std::vector<double> u;
  OnDevice<double> place;
};

void expect_forces_of_host(BothContacts& both) {
  std::vector<double> expected(both.u.size());
  const double energy = both.host().evaluate(both.u.data(), expected.data());
  ASSERT_GT(energy, 0);
  OnDevice<double> gradient{std::vector<double>(both.u.size())};
  both.card().start_evaluation(both.place.data(), gradient.data());
  EXPECT_LT(relative_difference(gradient.host(), expected), 1e-12);
  EXPECT_NEAR(both.card().energy(), energy, 1e-12 * energy);
}

void expect_actions_of_host(BothContacts& both) {
  const std::vector<double> v = random_field(both.scene, 1, 8);
  const std::vector<Vec3> about(size_t(both.scene.grid.pieces), Vec3{0.3, -0.2, 0.1});
  const ActionSums host = both.host().act(both.u.data(), v.data(), v.data(), about);
  OnDevice<double> speed(v);
  const ActionSums card = both.card().act(both.place.data(), speed.data(), speed.data(), about);
  EXPECT_NEAR(card.energy, host.energy, 1e-12 * host.energy);
  EXPECT_NEAR(card.bonds, host.bonds, 1e-11 * host.bonds);
  ASSERT_EQ(card.pieces.size(), host.pieces.size());
  for (size_t p = 0; p < host.pieces.size(); ++p) {
    const ContactAction &a = card.pieces[p], &b = host.pieces[p];
    EXPECT_GT(b.normal, 0);
    EXPECT_NEAR(a.normal, b.normal, 1e-12 * b.normal);
    EXPECT_NEAR(a.power, b.power, 1e-11 * b.normal);
    EXPECT_NEAR(a.rubbed, b.rubbed, 1e-11 * b.normal);
    EXPECT_NEAR(a.driven, b.driven, 1e-11 * b.normal);
    EXPECT_LT(safe_norm(minus(a.force, b.force)), 1e-12 * b.normal);
    EXPECT_LT(safe_norm(minus(a.torque, b.torque)), 1e-12 * b.normal);
  }
}

TEST_F(OnCard, BondsAndActionsOfStagesAreThoseOfTheHost) {
  Scene scene = box_in_touch();
  scene.scheme = TimeScheme::kAuto;
  BothContacts both(scene);
  double time = 0.25;
  for (unsigned step = 0; step < 3; ++step) {
    SCOPED_TRACE(concat("step ", step));
    const double dt = scene.dt / (1 + step), lag_time = time + dt / 3;
    const std::vector<double> now = random_field(scene, 0.02 * kEdge, 20 + step),
                              lag = random_field(scene, 0.02 * kEdge, 30 + step);
    OnDevice<double> from(now), of_lag(lag);
    both.host().begin_stage(now.data(), time, dt, lag.data(), lag_time);
    both.card().begin_stage(from.data(), time, dt, of_lag.data(), lag_time);
    expect_forces_of_host(both);
    expect_actions_of_host(both);
    // friction of the end, which bonds keep
    EXPECT_TRUE(both.host().renew_lag(both.u.data()));
    EXPECT_TRUE(both.card().renew_lag(both.place.data()));
    expect_forces_of_host(both);
    // that of a solve between the one before and this one, and back
    both.host().relax_lag(0.25);
    both.card().relax_lag(0.25);
    expect_forces_of_host(both);
    both.host().renew_lag(both.u.data());
    both.card().renew_lag(both.place.data());
    both.host().keep_bonds(both.u.data());
    both.card().keep_bonds(both.place.data());
    time += dt;
  }
  both.host().forget_bonds();
  both.card().forget_bonds();
  both.host().begin_stage(both.u.data(), time, scene.dt, both.u.data(), time);
  both.card().begin_stage(both.place.data(), time, scene.dt, both.place.data(), time);
  expect_forces_of_host(both);
}

}  // namespace
}  // namespace elastogen::test

#endif
