// SPDX-License-Identifier: Apache-2.0
// Tetrahedra that borders cut: a bar 1 x 0.2 x 0.2 m of them, held at x < 0.01 and x > 0.99, on meshes
// that are shifted against these borders, against one whose nodes lie on them.
#include "core/vec3.hpp"
#include "mpm_fem/fem/cut_tets.hpp"
#include "mpm_fem/fem/dependent_tet_nodes.hpp"
#include "mpm_fem/fem/point_location.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/mpm_fem/scenes.hpp"
#include "tests/network/held_scenes.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

namespace elastogen::test {
namespace {

constexpr double kLeft = 0.01, kRight = 0.99;  // borders [m]
constexpr double kCell = 0.05;                 // four cells across the bar
constexpr double kFreeWeight = 1000 * 9.81 * (kRight - kLeft) * 0.2 * 0.2;

/// A bar of cells of a length, which begins at a place and is held by borders that cut it, or by the
/// nodes at its ends.
FemScene tet_bar(Element element, double begin, int cells, double length,
                 const std::vector<Border>& borders) {
  const Material material = solid(Law::kStvk, 1e8, 0.3);
  ElementMesh mesh = block(element, cells, 4, 4, kCell);
  for (int64_t n = 0; n < mesh.rest.rows(); ++n)
    mesh.rest(n, 0) = begin + mesh.rest(n, 0) * length / kCell;
  FemScene scene = scene_of(mesh, material);
  scene.gravity = {0, -9.81, 0};
  if (borders.empty()) {
    clamp(scene, 0, begin);
    clamp(scene, 0, begin + cells * length);
    return scene;
  }
  auto cut = fem::cut_tets(mesh, borders);
  // nodes of no element rest
  Array<uint8_t> pinned(mesh.rest.rows());
  pinned.fill(1);
  for (int64_t k = 0; k < cut.mesh.elements.size(); ++k) pinned(cut.mesh.elements.data()[k]) = 0;
  for (int64_t n = 0; n < pinned.rows(); ++n) std::fill_n(scene.fixed.row(n), 3, pinned(n));
  scene.dependent = fem::dependent_tet_nodes(cut.mesh, borders, cut.cut, pinned);
  scene.mesh = std::move(cut.mesh);
  return scene;
}

FemScene shifted_bar(Element element, double offset) {
  return tet_bar(element, -offset * kCell, 22, kCell,
                 {half_space_border(true, kLeft), half_space_border(false, kRight)});
}

/// Displacement of a point [m].
Vec3 displacement(const FemScene& scene, const Array<double>& u, const Vec3& point) {
  const int nodes = fem::nodes_of(scene.mesh.element);
  std::vector<double> weights(static_cast<size_t>(nodes));
  const int64_t e =
      fem::locate(scene.mesh, 0, scene.mesh.elements.rows(), point.data(), weights.data());
  Vec3 sum = {};
  for (int a = 0; a < nodes; ++a)
    for (int d = 0; d < 3; ++d)
      sum[size_t(d)] += weights[size_t(a)] * u(scene.mesh.elements(e, a), d);
  return sum;
}

/// Sags at a quarter, the middle and three quarters of the free length, the largest motion of points
/// on the borders [m], and the force that holds the bar [N].
struct TetSag {
  double quarter = 0, middle = 0, other = 0, faces = 0, reaction = 0;
};

TetSag sag_of_tets(const FemScene& scene) {
  const fem::StaticResult result = solve_static(scene, {.tolerance = 1e-10});
  EXPECT_TRUE(result.converged);
  const auto at = [&](double x, double y = 0.1, double z = 0.1) {
    return displacement(scene, result.u, {x, y, z});
  };
  const double length = kRight - kLeft;
  TetSag sag{-at(kLeft + length / 4)[1], -at(kLeft + length / 2)[1], -at(kRight - length / 4)[1]};
  for (const double x : {kLeft, kRight})
    for (int k = 0; k < 81; ++k)
      sag.faces = std::max(sag.faces, elastogen::norm(at(x, 0.025 * (k % 9), 0.025 * (k / 9))));
  for (int64_t n = 0; n < result.u.rows(); ++n) sag.reaction += result.reaction(n, 1);
  return sag;
}

TEST(HeldTets, SagAlikeOnMeshesThatAreShifted) {
  // a border that cuts elements obliquely moves by what slopes differ between their nodes
  for (const auto& [element, off, faces] :
       {std::tuple{Element::kTet4, 0.04, 0.06}, std::tuple{Element::kTet10, 0.02, 0.04}}) {
    const TetSag fit = sag_of_tets(tet_bar(element, kLeft, 20, (kRight - kLeft) / 20, {}));
    double least = 1e300, most = 0;
    for (const double offset : {0.1, 0.5, 0.95}) {
      const TetSag sag = sag_of_tets(shifted_bar(element, offset));
      least = std::min(least, sag.middle), most = std::max(most, sag.middle);
      printf(
          "%s, offset %.2f: %.4f of the sag of a mesh that fits, left-right %.2f %%, faces %.2f "
          "%%\n",
          element_name(element).data(), offset, sag.middle / fit.middle,
          100 * std::abs(sag.quarter - sag.other) / sag.middle, 100 * sag.faces / sag.middle);
      EXPECT_NEAR(sag.middle / fit.middle, 1, off) << offset;
      EXPECT_LT(std::abs(sag.quarter - sag.other), 0.02 * sag.middle) << offset;
      EXPECT_NEAR(sag.reaction, kFreeWeight, 1e-6 * kFreeWeight) << offset;
      EXPECT_LT(sag.faces, faces * sag.middle) << offset;
    }
    EXPECT_LT(most, (1 + off) * least);
  }
}

TEST(HeldTets, OfABorderBesideTheMeshAreFree) {
  const FemScene beside = tet_bar(Element::kTet4, 0, 4, kCell, {half_space_border(true, -0.05)});
  EXPECT_TRUE(beside.dependent.empty());
  const FemScene none = tet_bar(Element::kTet4, 0, 4, kCell, {});
  EXPECT_EQ(beside.mesh.elements, none.mesh.elements);
}

}  // namespace
}  // namespace elastogen::test
