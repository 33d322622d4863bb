// SPDX-License-Identifier: Apache-2.0
// Implicit and explicit substeps between two transfers have one limit; implicit ones tend to it in
// first order. The limit needs a fixed time between transfers: each transfer smooths velocities.
#include "mpm_fem/integrators/explicit_mpm.hpp"
#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "tests/mpm_fem/particle_scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen::mpm {
namespace {

using test::column, test::column_scene, test::kH, test::particle_solid, test::sand;

constexpr int kLongest = 100;  // from transfer to transfer, in stable explicit steps
constexpr int kSubsteps[] = {1, 3, 10, 30};

/// Places of particles after some transfers.
struct Refinement {
  MpmScene scene;
  Particles start;
  int transfers;

  Refinement(const MpmScene& of, const Particles& from, int count)
      : scene(of), start(from), transfers(count) {
    scene.dt = kLongest * ExplicitMpm<2>(scene).stable_step();
  }
  Particles explicitly(int substeps) const {
    Particles p = start;
    ExplicitMpm<2> steps(scene, substeps);
    for (int k = 0; k < transfers; ++k) steps.step(k * scene.dt, p);
    return p;
  }
  Particles implicitly(int substeps) const {
    Particles p = start;
    // the longest take more Newton steps than the default, where users' are halved
    ImplicitMpm<2> steps(scene, {.tolerance = 1e-7, .max_newton = 300, .substeps = substeps});
    for (int k = 0; k < transfers; ++k) {
      const MpmStepReport report = steps.step(k * scene.dt, p);
      EXPECT_TRUE(report.converged) << substeps << ": " << report.residual;
    }
    return p;
  }
};

/// Root mean square of the distances between the particles of two clouds [m].
double rms_apart(const Particles& a, const Particles& b) {
  double sum = 0;
  for (int64_t k = 0; k < a.x.size(); ++k) sum += std::pow(a.x.data()[k] - b.x.data()[k], 2);
  return std::sqrt(sum / double(a.count()));
}

void check_order(const Refinement& of) {
  const Particles exact = of.explicitly(4 * kLongest);
  const double moved = rms_apart(exact, of.start);
  double before = 0;
  for (size_t k = 0; k < std::size(kSubsteps); ++k) {
    const double error = rms_apart(of.implicitly(kSubsteps[k]), exact);
    if (k > 0) {
      const double ratio = double(kSubsteps[k]) / kSubsteps[k - 1];
      EXPECT_NEAR(std::log(before / error) / std::log(ratio), 1, 0.1)
          << kLongest / kSubsteps[k] << " x: " << error << " of " << moved;
    }
    before = error;
  }
}

/// A bar held at one end bends under its weight: far more slowly than waves cross a cell.
TEST(MpmRefinement, ImplicitSubstepsOfAnElasticBarAreFirstOrder) {
  MpmScene scene = column_scene(particle_solid(2e7, 1000), 1);
  scene.obstacles = {{half_space({1, 0, 0}, 0, 0), true}};
  Particles bar = column(40, 2);
  for (int64_t k = 0; k < bar.count(); ++k) bar.x(k, 0) += 10 * kH;
  check_order({scene, bar, 6});
}

/// Sand that begins to flow.
TEST(MpmRefinement, ImplicitSubstepsOfAColumnOfSandAreFirstOrder) {
  check_order({column_scene(sand(2e8), 1), column(4, 12), 6});
}

}  // namespace
}  // namespace elastogen::mpm
