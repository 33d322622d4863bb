// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "mpm_fem/materials/associative_neo_von_mises.hpp"
#include "tests/mpm_fem/return_maps.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::Random;

/// |dev tau| at most the radius after the flow, and that where there was any; the volume stays.
template <int d, class Law>
void neo_surface(const Law& law, double radius, double hardening) {
  Random random(1);
  int flowed = 0;
  for (int k = 0; k < 3000; ++k) {
    const HenckyStrain<double, d> e = test::random_strain<d>(0.5, random);
    const Returned<double> r = test::returned(law, e, {0.02});
    const double flow = test::distance<d>(e.e, r.e), limit = radius + hardening * (0.02 + flow);
    const double stress = test::parts<d>(r.tau).size;
    EXPECT_NEAR(split_strain<d>(r.e).trace, e.trace, 1e-15);
    EXPECT_LE(stress, limit + 1e-14);
    if (flow > 0) {
      EXPECT_NEAR(stress, limit, 1e-14);
    }
    flowed += flow > 0;
  }
  EXPECT_GT(flowed, 2000);
}

TEST(NeoVonMises, FlowKeepsTheVolumeAndEndsOnTheGrownSurface) {
  for (const double hardening : {0.0, 0.1}) {
    const MetalYield yield = {.stress = 0.02, .hardening = hardening};
    const auto flat = neo_von_mises<double, 2>(test::plastic_solid(), yield);
    const auto line = neo_von_mises<double>(test::plastic_solid(), yield);
    neo_surface<2>(flat, flat.radius, flat.hardening);
    neo_surface<3>(line, line.radius, line.hardening);
    neo_surface<3>(AssociativeNeoVonMises<double>{line}, line.radius, line.hardening);
  }
}

/// In two dimensions without hardening sqrt(2) mu J sinh(sqrt(2) s) = radius.
TEST(NeoVonMises, ClosedFormInTwoDimensionsIsTheLimitOfTheRoot) {
  const auto closed = neo_von_mises<double, 2>(test::plastic_solid(), {.stress = 0.02});
  const auto root =
      neo_von_mises<double, 2>(test::plastic_solid(), {.stress = 0.02, .hardening = 1e-30});
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const auto e = test::random_strain<2>(0.5, random);
    const Returned<double> a = test::returned(closed, e), b = test::returned(root, e);
    EXPECT_LT(test::distance<2>(a.e, b.e), 1e-15);
    const double s = split_strain<2>(a.e).size;
    if (s < e.size) {
      EXPECT_NEAR(std::sqrt(2.0) * closed.mu * std::exp(e.trace) * std::sinh(std::sqrt(2.0) * s),
                  closed.radius, 1e-15);
    }
  }
}

/// mu (sqrt(J^2 + kappa^2) - 1 - t) + lambda t^2/2 + radius (a - s), kappa = radius/(sqrt(2) mu).
TEST(NeoVonMises, PotentialInTwoDimensionsIsItsClosedForm) {
  const auto law = neo_von_mises<double, 2>(test::plastic_solid(), {.stress = 0.02});
  const double mu = law.mu, kappa = law.radius / (std::sqrt(2.0) * mu);
  Random random(3);
  for (int k = 0; k < 1000; ++k) {
    const auto e = test::random_strain<2>(0.5, random);
    const double J = std::exp(e.trace), t = e.trace, s = std::asinh(kappa / J) / std::sqrt(2.0);
    const double shear =
        e.size > s ? mu * (std::sqrt(J * J + kappa * kappa) - 1 - t) + law.radius * (e.size - s)
                   : mu * (J * std::cosh(std::sqrt(2.0) * e.size) - 1 - t);
    EXPECT_NEAR(test::returned(law, e).psi, shear + law.lambda / 2 * t * t, 1e-15);
  }
}

/// With potentials: stress their gradient, tangent symmetric and convex.
template <int d, class Law>
void neo_potential(const Law& law) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    const auto e = test::random_strain<d>(0.4, random);
    EXPECT_LT(test::gradient_error(law, e, {}), 1e-8);
    const Mat3<double> D = test::returned(law, e).D;
    Symmetric3<double> S = {};
    for (int i = 0; i < d; ++i) {
      S.m[i] = D(i, i), S.m[3 + i] = D(i, (i + 1) % 3);
      for (int j = 0; j < d; ++j) EXPECT_NEAR(D(i, j), D(j, i), 1e-14);
    }
    for (const double value : eigen3(S).value) EXPECT_GT(value, -1e-14);
  }
}

TEST(NeoVonMises, AssociatedFlowHasAConvexPotential) {
  for (const double hardening : {0.0, 0.1}) {
    const MetalYield yield = {.stress = 0.02, .hardening = hardening};
    neo_potential<2>(neo_von_mises<double, 2>(test::plastic_solid(), yield));
    neo_potential<3>(
        AssociativeNeoVonMises<double>{neo_von_mises<double>(test::plastic_solid(), yield)});
  }
}

/// psi of the map is the minimum of energy and work over all flows that keep the volume.
TEST(NeoVonMises, AssociatedFlowMinimisesEnergyAndWork) {
  const AssociativeNeoVonMises<double> law = {
      neo_von_mises<double>(test::plastic_solid(), test::kMetal)};
  const auto rigid = neo_von_mises<double>(test::plastic_solid(), {.stress = 1e9});
  Random random(5);
  for (int k = 0; k < 300; ++k) {
    const auto e = test::random_strain<3>(0.3, random);
    const double psi = test::returned(law, e).psi;
    for (int trial = 0; trial < 20; ++trial) {
      const auto other = test::random_strain<3>(0.3, random);
      double after[3];
      for (int i = 0; i < 3; ++i) after[i] = e.trace / 3 + other.size * other.n[i];
      const double flow = test::distance<3>(e.e, after);
      const double value = test::returned(rigid, split_strain<3>(after)).psi +
                           law.line.radius * flow + law.line.hardening / 2 * flow * flow;
      EXPECT_GE(value, psi);
    }
  }
}

/// The line's map is not integrable in three dimensions, but nearly.
TEST(NeoVonMises, LineAndAssociatedFlowDifferByHundredths) {
  const auto line =
      neo_von_mises<double>(test::plastic_solid(), {.stress = 0.0471});  // radius 0.1 mu
  const AssociativeNeoVonMises<double> law = {line};
  Random random(6);
  double strain = 0, skew = 0;
  for (int k = 0; k < 5000; ++k) {
    const auto e = test::random_strain<3>(0.6, random);
    const Returned<double> a = test::returned(line, e), b = test::returned(law, e);
    for (int i = 0; i < 3; ++i) strain = std::fmax(strain, std::abs(a.e[i] - b.e[i]));
    for (int i = 0; i < 3; ++i)
      skew = std::fmax(skew, std::abs(a.D(i, (i + 1) % 3) - a.D((i + 1) % 3, i)));
  }
  EXPECT_NEAR(strain, 0.0024, 0.0006);
  EXPECT_GT(skew, 1e-3);
  EXPECT_LT(skew, 0.05);
}

TEST(NeoVonMises, BelowYieldItIsTheNeoHookeanLaw) {
  const auto law = neo_von_mises<double>(test::plastic_solid(), {.stress = 1e9});
  const LawParameters<double> elastic = {Law::kNeoHookean, test::plastic_solid().mu(),
                                         test::plastic_solid().lambda()};
  for (const double least : {0.999, 0.8, 0.3}) {
    const double s[3] = {1.3, 1.1, least};
    const NonsymmetricResponse<double> r = law.response<true>(s, {});
    const Response<double> exact = elastic_response<true>(elastic, s);
    EXPECT_NEAR(r.psi, exact.psi, 1e-15);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(r.t[i], exact.t[i], 1e-14);
      EXPECT_NEAR(r.D(i, i), exact.H[i], 1e-13);
      EXPECT_NEAR(r.D(i, (i + 1) % 3), exact.H[3 + i], 1e-13);
    }
  }
}

template <int d, class Law>
void neo_borders(const Law& law, const NeoVonMises<double, d>& metal) {
  Random random(7);
  for (int k = 0; k < 20; ++k) {
    const auto e = test::strain_along(test::random_strain<d>(0.1, random), 0.03, 0.2);
    // the size at which flow begins has no hardening in it
    const NeoVonMises<double, d> perfect = {metal.mu, metal.lambda, metal.radius, 0};
    const double border = perfect.size_after(e, metal.radius);
    for (const double size : {0.0, border - 1e-6, border + 1e-6})
      EXPECT_LT(test::tangent_error(law, test::strain_along(e, 0.03, size)), 1e-6) << size;
  }
}

TEST(NeoVonMises, TangentIsRightOnBothSidesOfYield) {
  const auto flat = neo_von_mises<double, 2>(test::plastic_solid(), test::kMetal);
  const auto line = neo_von_mises<double>(test::plastic_solid(), test::kMetal);
  neo_borders<2>(flat, flat);
  neo_borders<3>(line, line);
  neo_borders<3>(AssociativeNeoVonMises<double>{line}, line);
}

TEST(NeoVonMises, RejectsWhatIsNoMetal) {
  EXPECT_THROW(neo_von_mises<double>(test::plastic_solid(), {.stress = 0}), Error);
}

}  // namespace
}  // namespace elastogen
