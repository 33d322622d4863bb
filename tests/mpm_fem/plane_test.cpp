// SPDX-License-Identifier: Apache-2.0
// Triangles in the plane: strain in the plane alone, metals that flow in it.

#include "core/error.hpp"
#include "mpm_fem/fem/surface_load.hpp"
#include "mpm_fem/fem/tet_surface.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using fem::PlasticBody;
using test::Element;
using test::ElementMesh;

/// A rectangle of nx x ny squares of two triangles.
ElementMesh rectangle(int nx, int ny, double h) {
  ElementMesh mesh;
  mesh.element = Element::kTri3;
  mesh.rest = Array<double>((nx + 1) * (ny + 1), 3);
  std::vector<int32_t> nodes;
  for (int32_t j = 0; j <= ny; ++j)
    for (int32_t i = 0; i <= nx; ++i) {
      const int32_t a = j * (nx + 1) + i, b = a + 1, d = a + nx + 1, c = d + 1;
      mesh.rest(a, 0) = h * i, mesh.rest(a, 1) = h * j;
      if (i < nx && j < ny) nodes.insert(nodes.end(), {a, b, c, a, c, d});
    }
  test::set_elements(mesh, nodes);
  return mesh;
}

Solid plane_solid(const Yield& yield, Law law = Law::kHencky) {
  return {test::solid(law, 1e7, 0.3, 1000), yield};
}
const MetalYield kMetal = {.stress = 2e4, .hardening = 1e6};
const Yield kPlaneYields[] = {kMetal, SandYield{.friction = 0.5, .cohesion = 0.01},
                              SnowYield{.slope = 1.2, .pressure = 5e4}};

Array<double> shaken_plane(const ElementMesh& mesh, double size, test::Random& random) {
  std::normal_distribution<double> normal(0, size);
  Array<double> u(mesh.rest.rows(), 3);
  for (int64_t n = 0; n < u.rows(); ++n)
    for (int d = 0; d < 2; ++d) u(n, d) = normal(random);
  return u;
}

TEST(Plane, MassAndRimAreThoseOfAPlateOneMetreThick) {
  const ElementMesh mesh = rectangle(3, 2, 0.1);
  const fem::ElasticBody body(mesh, {plane_solid({}).elastic});
  const Array<double> mass = body.lumped_mass();
  EXPECT_NEAR(test::total(mass, 0), 1000 * 0.3 * 0.2, 1e-12);
  EXPECT_NEAR(test::total(fem::rim_area(mesh), 0), 2 * (0.3 + 0.2), 1e-15);
  // node (1, 1) lies within
  EXPECT_EQ(fem::rim_area(mesh)(5), 0);
  EXPECT_NEAR(fem::mean_edge(mesh), 0.1, 1e-15);
}

TEST(Plane, ElasticTrianglesAreHexahedraHeldInPlaneStrain) {
  // one homogeneous state: the energy of a cube of edge 0.1 held across, per its thickness
  const Material m = plane_solid({}, Law::kNeoHookean).elastic;
  const ElementMesh plane = rectangle(1, 1, 0.1), cube = test::block(Element::kHex, 1, 1, 1, 0.1);
  const auto energy = [&](const ElementMesh& mesh) {
    Array<double> u(mesh.rest.rows(), 3);
    for (int64_t n = 0; n < u.rows(); ++n) {
      u(n, 0) = 0.05 * mesh.rest(n, 0) + 0.2 * mesh.rest(n, 1);
      u(n, 1) = -0.1 * mesh.rest(n, 1);
    }
    return fem::ElasticBody(mesh, {m}).energy(u).elastic;
  };
  EXPECT_NEAR(energy(plane), energy(cube) / 0.1, 1e-9 * energy(plane));
}

TEST(Plane, ForcesAndStiffnessAreTheDerivatives) {
  constexpr int kSamples = 6, kEnough = 5;  // a branch may end within a difference
  test::Random random(7);
  for (const Yield& yield : kPlaneYields) {
    int good = 0;
    for (int sample = 0; sample < kSamples; ++sample) {
      const ElementMesh mesh = rectangle(1, 1, 1);
      PlasticBody body(mesh, {plane_solid(yield)});
      body.set_history(body.history_after(shaken_plane(mesh, 0.05, random)));
      const Array<double> u = shaken_plane(mesh, 0.03, random), d = shaken_plane(mesh, 1, random);
      const auto force = [&](double along) {
        Array<double> x = u, f(u.rows(), 3);
        for (int64_t k = 0; k < x.size(); ++k) x.data()[k] += along * d.data()[k];
        body.add_gradient(x, f);
        return f;
      };
      constexpr double kStep = 1e-6;
      const Array<double> ahead = force(kStep), back = force(-kStep);
      double error = 0, size = 0;
      // K d, assembled from the elements
      Array<double> Kd(u.rows(), 3);
      for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
        double K[81];
        body.element_hessian(e, u, TangentKind::kTrue, K);
        for (int row = 0; row < 9; ++row)
          for (int col = 0; col < 9; ++col)
            Kd(mesh.elements(e, row / 3), row % 3) +=
                K[9 * row + col] * d(mesh.elements(e, col / 3), col % 3);
      }
      for (int64_t k = 0; k < Kd.size(); ++k) {
        const double slope = (ahead.data()[k] - back.data()[k]) / (2 * kStep);
        error += std::pow(slope - Kd.data()[k], 2), size += std::pow(Kd.data()[k], 2);
      }
      good += error < 1e-12 * size;
      for (int64_t n = 0; n < Kd.rows(); ++n) EXPECT_EQ(ahead(n, 2), 0);
    }
    EXPECT_GE(good, kEnough) << yield.index();
  }
}

TEST(Plane, ABarYieldsAtItsStressAndHardensWithTheSlopeOfThePlane) {
  // E_2 = E/(1 - nu^2) in the place of E: nothing moves across
  const double young = 1e7 / (1 - 0.09), yield = kMetal.stress / young;
  const double slope = young * kMetal.hardening / (young + kMetal.hardening);
  for (const Law law : {Law::kHencky, Law::kNeoHookean}) {
    test::FemScene scene = test::scene_of(rectangle(2, 1, 1), plane_solid(kMetal, law).elastic);
    scene.yields = {kMetal};
    scene.dt = 1e4;  // so long that inertia does not count
    for (int64_t n = 0; n < scene.fixed.rows(); ++n) scene.fixed(n, 2) = 1;
    test::fix(scene, 0, 0, 0);
    test::fix(scene, 1, 0, 1);
    test::fix(scene, 0, 2, 0);
    const std::vector<int64_t> end = test::plane(scene.mesh, 0, 2);
    const std::vector<double> strains = {0.5 * yield, 0.999 * yield, 0.01, 0.02};
    scene.motion = [&](double time, Out<double> u) {
      const auto step = size_t(std::lround(time / 1e4));
      for (const int64_t n : end) u(n, 0) = 2 * std::expm1(step == 0 ? 0 : strains[step - 1]);
    };
    fem::ImplicitFem solver(scene);
    fem::FemState state = rest_state(scene);
    for (const double strain : strains) {
      EXPECT_LT(solver.step(state).residual, 1e-6);
      PlasticBody body(scene.mesh, {plane_solid(kMetal, law)});
      body.set_history(state.plastic);
      Array<double> f(state.u.rows(), 3);
      body.add_gradient(state.u, f);
      double force = 0;
      for (const int64_t n : end) force += f(n, 0);
      // Kirchhoff's stress: force times length; J = 1 but for elastic strains, which the
      // neo-Hookean law has to first order as Hencky's
      const double stress = force * std::exp(strain);
      const double line =
          strain < yield ? young * strain : kMetal.stress + slope * (strain - yield);
      EXPECT_NEAR(stress, line, (law == Law::kHencky ? 1e-6 : 5e-3) * kMetal.stress) << strain;
    }
  }
}

TEST(Plane, FlowStaysInThePlaneAndKeepsItsArea) {
  test::Random random(8);
  const ElementMesh mesh = rectangle(2, 2, 1);
  const PlasticBody body(mesh, {plane_solid(MetalYield{.stress = 2e4})});
  const fem::PlasticHistory after = body.history_after(shaken_plane(mesh, 0.1, random));
  double largest = 0;
  for (int64_t k = 0; k < after.memory.rows(); ++k) {
    Mat3<double> Fp_inverse;
    std::copy_n(after.Fp_inverse.row(k), 9, Fp_inverse.m);
    EXPECT_NEAR(determinant(Fp_inverse), 1, 1e-12);
    EXPECT_EQ(Fp_inverse(2, 2), 1);
    largest = std::max(largest, after.memory(k));
  }
  EXPECT_GT(largest, 0.05);
}

TEST(Plane, RejectsWhatItsDocumentationForbids) {
  ElementMesh mesh = rectangle(1, 1, 1);
  Array<uint8_t> all(mesh.rest.rows());
  all.fill(1);
  EXPECT_THROW(fem::surface_load(mesh, all, {1, 0, 0}), Error);
  EXPECT_THROW(fem::pressure_load(mesh, all, 1), Error);
  mesh.rest(0, 2) = 1e-3;
  EXPECT_THROW(fem::check_mesh(mesh), Error);
  mesh.rest(0, 2) = 0;
  std::swap(mesh.elements(0, 1), mesh.elements(0, 2));
  EXPECT_THROW(fem::check_mesh(mesh), Error);
}

}  // namespace
}  // namespace elastogen
