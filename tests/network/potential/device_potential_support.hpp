// SPDX-License-Identifier: Apache-2.0
// The potential on the device against that of the host, on ragged blocks; nets that are shipped.

#pragma once

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "network/law/mtl_weights.hpp"
#include "network/step/quasi_solver_device.hpp"
#include "tests/network/device_numbers.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {

/// Voxel edge of the ragged scenes [m].
inline constexpr double kRaggedEdge = 0.02;

/// A ragged block over several bricks, pinned on one side, of two materials.
inline Scene ragged(Law law, Hourglass hourglass = Hourglass::kFull) {
  Scene scene = scene_on(ragged_grid(19, 13, 11, kRaggedEdge, 3), solid(3e4, 0.4, law));
  scene.materials.push_back(solid(8e4, 0.3, law, 700));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    scene.material(v) = scene.grid.voxel_coord(v, 1) > 3;
  pin_below(scene, 0, -1.5 * kRaggedEdge);
  scene.gravity = {0, -9.81, 0};
  scene.hourglass = hourglass;
  finish_scene(scene);
  return scene;
}

/// Displacements that bend and shake a body.
inline std::vector<double> bent(const Scene& scene, double shake, unsigned seed) {
  std::vector<double> u = random_field(scene, shake, seed);
  for (size_t n = 0; n < u.size() / 3; ++n) {
    if (scene.pinned(int64_t(n))) continue;
    const double z = scene.grid.rest(int64_t(n), 0) / 0.3;
    u[3 * n + 1] += 0.03 * z * z, u[3 * n + 2] -= 0.02 * z * std::abs(z);
  }
  return u;
}

inline State state_at(const Scene& scene, const std::vector<double>& u) {
  State state = initial_state(scene);
  for (size_t k = 0; k < u.size(); ++k) state.x.data()[k] += u[k];
  return state;
}

/// Gradient and value by the device in T against the host's in double, within a relative bound.
template <class T>
void expect_like_host(IncrementalPotential& host, cuda::DevicePotential& device,
                      const std::vector<double>& u, double bound) {
  std::vector<double> expected(u.size());
  const PotentialValue a = host.evaluate<double>(u.data(), expected.data());
  OnDevice<double> place(u);
  OnDevice<T> gradient{std::vector<T>(u.size(), T(7))};
  const PotentialValue b = device.evaluate<T>(place.data(), gradient.data());
  EXPECT_LT(relative_difference(gradient.host(), expected), bound);
  EXPECT_NEAR(b.elastic, a.elastic, bound * a.elastic);
  EXPECT_NEAR(b.hourglass, a.hourglass, bound * a.hourglass);
  EXPECT_NEAR(b.viscous, a.viscous, bound * a.viscous);
  EXPECT_NEAR(b.inertia, a.inertia, 1e-12 * a.inertia);
  EXPECT_NEAR(b.min_j, a.min_j, bound);
  EXPECT_EQ(b.outside, a.outside);
}

inline std::shared_ptr<const LearnedLaw> shipped_net(Law law, double poisson,
                                                     Evaluation evaluation) {
  const std::string path = concat(ELASTOGEN_SHIPPED_WEIGHTS, '/', weight_file_name(law, poisson));
  return read_weights(read_file(path, 1 << 24), path, law, poisson, evaluation);
}

/// A p of the Hessian at u, as it is and projected, against the host's, which is in float.
inline void expect_hessian_of_host(IncrementalPotential& host, cuda::DevicePotential& device,
                                   const std::vector<double>& u,
                                   const std::vector<double>& direction) {
  const std::vector<float> p(direction.begin(), direction.end());
  std::vector<float> expected(p.size());
  OnDevice<double> place(u);
  OnDevice<float> from(p), to{std::vector<float>(p.size(), 7.f)};
  OnDevice<double> precise_from(direction), precise_to{std::vector<double>(p.size(), 7)};
  for (const TangentKind kind : {TangentKind::kTrue, TangentKind::kProjected}) {
    host.linearise(u.data(), kind);
    host.hessian_product(p.data(), expected.data());
    device.linearise(place.data(), kind);
    device.hessian_product(from.data(), to.data());
    EXPECT_LT(relative_difference(to.host(), expected), 2e-5);
    // in double on the same tangents, which are float
    device.hessian_product(precise_from.data(), precise_to.data());
    EXPECT_LT(relative_difference(precise_to.host(), expected), 2e-5);
  }
}

}  // namespace elastogen::test
