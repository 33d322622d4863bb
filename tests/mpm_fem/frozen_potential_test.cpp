// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/materials/frozen_potential.hpp"

#include "core/constitutive.hpp"
#include "mpm_fem/materials/frozen_cam_clay.hpp"
#include "tests/mpm_fem/return_maps.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace elastogen {
namespace {

using test::kSand;
using test::kSnow;
using test::Random;

/// visit(name, potential, law) with the frozen potentials in d dimensions.
template <class T, int d, class Visit>
void for_each_potential(const Visit& visit) {
  const auto sand = drucker_prager<T, d>(test::plastic_solid(), kSand);
  const auto snow = cam_clay<T, d>(test::plastic_solid(), kSnow);
  visit("sand", FrozenDruckerPrager<T, d>{sand}, sand);
  visit("snow", FrozenCamClay<T, d>{snow}, snow);
  visit("quadratic of sand", FrozenQuadratic<DruckerPrager<T, d>, d>{sand}, sand);
  visit("quadratic of snow", FrozenQuadratic<CamClay<T, d>, d>{snow}, snow);
}

/// Stretches with log strains within `size` of 0, largest first as singular values are.
template <int d>
std::array<double, 3> sorted_stretches(double size, Random& random) {
  const auto e = test::random_strain<d>(size, random);
  std::array<double, 3> s = {std::exp(e.e[0]), std::exp(e.e[1]), d == 3 ? std::exp(e.e[2]) : 1};
  std::sort(s.begin(), s.begin() + d, std::greater<>());
  return s;
}

template <int d>
void frozen_gradient() {
  for_each_potential<double, d>([](const char* name, const auto& potential, const auto& law) {
    Random random(1);
    double most = 0;
    for (int k = 0; k < 5000; ++k) {
      auto s = sorted_stretches<d>(k % 2 ? 0.1 : 0.02, random);
      if (k % 10 == 0) s[1] = s[0];
      if (k % 50 == 0) s[d - 1] = s[0];
      const auto frozen = potential.frozen(s.data(), {});
      const Response<double> r = potential.template response<false>(s.data(), frozen);
      const NonsymmetricResponse<double> exact = law.template response<false>(s.data(), {});
      for (int i = 0; i < 3; ++i) most = std::fmax(most, std::abs(r.t[i] - exact.t[i]));
    }
    EXPECT_LT(most, 1e-14) << name << ' ' << d;
  });
}

/// In every branch, at equal stretches too.
TEST(FrozenPotential, GradientWhereItWasFrozenIsTheStressOfTheLaw) {
  frozen_gradient<2>();
  frozen_gradient<3>();
}

/// With an opening that must close before sand bears.
TEST(FrozenPotential, SandRemembersItsOpening) {
  const auto law = drucker_prager<double>(test::plastic_solid(), kSand);
  const FrozenDruckerPrager<double> potential = {law};
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const auto s = sorted_stretches<3>(0.1, random);
    const Response<double> r =
        potential.response<false>(s.data(), potential.frozen(s.data(), {0.05}));
    const NonsymmetricResponse<double> exact = law.response<false>(s.data(), {0.05});
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(r.t[i], exact.t[i], 1e-14);
  }
}

/// Away from where it was frozen, in stretches: t = dpsi/ds, H = dt/ds.
template <int d>
void frozen_derivatives() {
  for_each_potential<double, d>([](const char* name, const auto& potential, const auto&) {
    Random random(3);
    for (int k = 0; k < 500; ++k) {
      const auto frozen = potential.frozen(sorted_stretches<d>(0.06, random).data(), {});
      const auto s = sorted_stretches<d>(0.06, random);
      const Response<double> r = potential.template response<true>(s.data(), frozen);
      for (int j = 0; j < d; ++j) {
        constexpr double kStep = 1e-7;
        auto above = s, below = s;
        above[j] += kStep, below[j] -= kStep;
        const Response<double> a = potential.template response<true>(above.data(), frozen),
                               b = potential.template response<true>(below.data(), frozen);
        EXPECT_NEAR((a.psi - b.psi) / (2 * kStep), r.t[j], 1e-8) << name << ' ' << d;
        for (int i = 0; i < d; ++i) {
          const double H = i == j ? r.H[i] : r.H[i + j == 1 ? 3 : i + j == 3 ? 4 : 5];
          EXPECT_NEAR((a.t[i] - b.t[i]) / (2 * kStep), H, 1e-7) << name << ' ' << d;
        }
      }
    }
  });
}

TEST(FrozenPotential, StressIsItsGradientAndTheTangentItsHessian) {
  frozen_derivatives<2>();
  frozen_derivatives<3>();
}

/// Convex in log strain: psi(b) >= psi(a) + tau(a).(b - a).
template <int d>
void frozen_convexity() {
  for_each_potential<double, d>([](const char* name, const auto& potential, const auto&) {
    if constexpr (requires { potential.template returned<false>({}, {}); }) {
      Random random(4);
      for (int k = 0; k < 3000; ++k) {
        const auto frozen = potential.frozen(sorted_stretches<d>(0.1, random).data(), {});
        const auto a = test::random_strain<d>(0.2, random), b = test::random_strain<d>(0.2, random);
        const Returned<double> from = potential.template returned<false>(a, frozen);
        double plane = from.psi;
        for (int i = 0; i < d; ++i) plane += from.tau[i] * (b.e[i] - a.e[i]);
        EXPECT_GE(potential.template returned<false>(b, frozen).psi, plane - 1e-16) << name;
      }
    }
  });
}

TEST(FrozenPotential, SandAndSnowAreConvexInLogStrain) {
  frozen_convexity<2>();
  frozen_convexity<3>();
}

TEST(FrozenPotential, EnergyTurnsWithTheBody) {
  for_each_potential<double, 3>([](const char* name, const auto& potential, const auto&) {
    Random random(5);
    for (int k = 0; k < 50; ++k) {
      const auto frozen = potential.frozen(sorted_stretches<3>(0.1, random).data(), {});
      const Mat3<double> F = test::stretched_within(0.9, 1.1, random);
      const Mat3<double> Q = test::rotation(random), R = test::rotation(random);
      EXPECT_NEAR(energy_density(potential, times_transposed(Q * F, R), frozen),
                  energy_density(potential, F, frozen), 1e-15)
          << name;
    }
  });
}

/// The quadratic of a law with a convex potential has the law's tangent as well as its stress.
TEST(FrozenPotential, QuadraticOfMetalHasItsTangent) {
  const auto law = von_mises<double>(test::plastic_solid(), test::kMetal);
  const FrozenQuadratic<VonMises<double>> potential = {law};
  Random random(6);
  for (int k = 0; k < 500; ++k) {
    const auto s = sorted_stretches<3>(0.1, random);
    const Response<double> r = potential.response<true>(s.data(), potential.frozen(s.data(), {}));
    const Response<double> exact = law.response<true>(s.data(), {});
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(r.t[i], exact.t[i], 1e-14);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(r.H[i], exact.H[i], 1e-13);
  }
}

template <class T, int d>
void frozen_extremes() {
  const T values[] = {T(1e4), 1, T(0.1), T(1e-3), 0, T(-0.5)};
  for_each_potential<T, d>([&](const char* name, const auto& potential, const auto&) {
    for (const T a : values)
      for (const T b : values)
        for (const T c : values)
          for (const T x : {T(1), a}) {
            const T at[3] = {x, b, d == 3 ? c : 1}, s[3] = {a, b, d == 3 ? c : 1};
            const Response<T> r = potential.template response<true>(s, potential.frozen(at, {}));
            bool is_finite = std::isfinite(r.psi);
            for (const T t : r.t) is_finite &= std::isfinite(t);
            for (const T h : r.H) is_finite &= std::isfinite(h);
            EXPECT_TRUE(is_finite) << name << ' ' << a << ' ' << b << ' ' << c << ' ' << x;
          }
  });
}

TEST(FrozenPotential, ExtremeStretchesStayFinite) {
  frozen_extremes<float, 2>();
  frozen_extremes<float, 3>();
  frozen_extremes<double, 2>();
  frozen_extremes<double, 3>();
}

}  // namespace
}  // namespace elastogen
