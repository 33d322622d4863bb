// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/held_diagonal.hpp"

#include "core/pcg.hpp"
#include "network/precondition/preconditioner.hpp"
#include "tests/network/fixed_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr double kCutEdge = 0.05;

Scene cut_bar(double offset, double dt) {
  return held_scene(box_surface({0, 0, 0}, {1, 0.2, 0.2}),
                    {half_space_border(true, 0.01), half_space_border(false, 0.99)}, kCutEdge,
                    {0.01 - offset * kCutEdge, 0.02, 0.02}, dt);
}

/// Iterations to 1e-6 under the weight, on the Hessian at rest.
int iterations_when_cut(const Scene& scene) {
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  Preconditioner<double> preconditioner(potential, {scene.fixed.empty()});
  std::vector<double> b(3 * size_t(scene.grid.node_count())), x(b.size());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    if (scene.pinned(n) != kPinnedNode) b[size_t(3 * n + 1)] = scene.mass(n);
  HeldNodes(scene).fold(b.data());
  const auto size = int64_t(b.size());
  PcgWork<double> work(size);
  return pcg(
             b.data(), x.data(), size, 1e-6, 500, work,
             [&](const double* p, double* Ap) { potential.rest_hessian_product(p, Ap); },
             [&](const double* r, double* z) { preconditioner.apply(r, z); })
      .iterations;
}

TEST(HeldDiagonal, IsThatOfTheFoldedOperatorWhereItIsLarger) {
  const Scene scene = cut_bar(0.7, 0.01);
  const std::vector<double> more = held_diagonal(scene, 1 / (scene.dt * scene.dt));
  // the operators on a scene whose dependent nodes are free
  Scene loose = scene;
  loose.dependent = {};
  for (int64_t n = 0; n < loose.pinned.rows(); ++n)
    if (loose.pinned(n) == kDependentNode) loose.pinned(n) = kFreeNode;
  finish_scene(loose);
  Multigrid<double> multigrid(loose, 1);
  std::vector<double> column(more.size()), product(more.size());
  const auto quadratic = [&] {
    multigrid.operator_product(column.data(), product.data());
    return dot(column, product);
  };
  int stiffer = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); n += 7)
    for (size_t d = 0; d < 3; ++d) {
      const size_t k = size_t(3 * n) + d;
      if (scene.pinned(n)) {
        EXPECT_EQ(more[k], 0);
        continue;
      }
      std::fill(column.begin(), column.end(), 0.0);
      column[k] = 1;
      const double alone = quadratic();
      scene.dependent.fill(column.data());
      const double wanted = std::max(0.0, quadratic() - alone);
      EXPECT_NEAR(more[k], wanted, 1e-9 * alone);
      stiffer += wanted > 0.1 * alone;
    }
  EXPECT_GT(stiffer, 5);
}

TEST(HeldDiagonal, KeepsTheIterationsNearThoseOfAGridThatFits) {
  for (const double dt : {100.0, 30 * kCutEdge * std::sqrt(1e-5)}) {
    const Scene fitted = held_scene(box_surface({0, 0, 0}, {1.02, 0.2, 0.2}),
                                    {half_space_border(true, 0.01), half_space_border(false, 1.01)},
                                    kCutEdge, {0.01, 0.02, 0.02}, dt);
    const int fit = iterations_when_cut(fitted);
    for (const double offset : {0.1, 0.3, 0.5, 0.7, 0.9, 0.9999}) {
      const int cut = iterations_when_cut(cut_bar(offset, dt));
      printf("dt %.3g, offset %.4f: %d iterations, %d where the grid fits\n", dt, offset, cut, fit);
      EXPECT_LE(cut, 1.3 * fit) << offset;
    }
  }
}

TEST(HeldDiagonal, KeepsTheIterationsOfFixedAxesNearThoseOfPins) {
  // an end held along x, beside it a lowest plane along y, against a pinned end
  for (const double dt : {100.0, 30 * kCutEdge * std::sqrt(1e-5)})
    for (const double offset : {0.0, kCutEdge}) {
      const Surface box = box_surface({0, 0, 0}, {1 + offset, 0.2, 0.2});
      const Border end = half_space_border(true, 0);
      const Scene pinned = held_scene(box, {end}, kCutEdge, {}, dt);
      Scene fixed = held_scene(box, {end}, kCutEdge, {}, dt);
      for (int64_t n = 0; n < fixed.pinned.rows(); ++n)
        if (fixed.grid.rest(n, 2) > 1e-9) fixed.pinned(n) = kFreeNode;
      fix_plane(fixed, 0, 0);
      fix_plane(fixed, 0, 1 + offset);
      fix_plane(fixed, 2, 0);
      const int axes = iterations_when_cut(fixed), pins = iterations_when_cut(pinned);
      printf("dt %.3g, offset %.2f: %d iterations, %d where an end is pinned\n", dt, offset, axes,
             pins);
      EXPECT_LE(axes, 1.5 * pins);
    }
}

}  // namespace
}  // namespace elastogen::test
