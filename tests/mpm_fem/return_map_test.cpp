// SPDX-License-Identifier: Apache-2.0
// Properties of every return map.
#include "mpm_fem/materials/return_map.hpp"

#include "core/constitutive.hpp"
#include "tests/mpm_fem/return_maps.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::Random;

template <int d>
void map_tangents() {
  test::for_each_map<double, d>([](const char* name, const auto& law) {
    Random random(1);
    double most = 0;
    for (int k = 0; k < 3000; ++k)
      most = std::fmax(most, test::tangent_error(law, test::random_strain<d>(0.2, random)));
    EXPECT_LT(most, 1e-6) << name << ' ' << d;
  });
}

TEST(ReturnMap, TangentIsTheSlopeOfTheStress) {
  map_tangents<2>();
  map_tangents<3>();
}

template <int d>
void mapped_twice() {
  test::for_each_map<double, d>([](const char* name, const auto& law) {
    Random random(2);
    double strain = 0, stress = 0;
    for (int k = 0; k < 3000; ++k) {
      const HenckyStrain<double, d> e = test::random_strain<d>(0.2, random);
      typename std::decay_t<decltype(law)>::History history;
      if constexpr (requires { history.flow; }) {
        double s[3] = {std::exp(e.e[0]), std::exp(e.e[1]), std::exp(e.e[2])};
        law.commit(s, history);
      }
      const Returned<double> once = test::returned(law, e);
      const Returned<double> again = test::returned(law, split_strain<d>(once.e), history);
      strain = std::fmax(strain, test::distance<d>(once.e, again.e));
      stress = std::fmax(stress, test::distance<d>(once.tau, again.tau));
    }
    EXPECT_LT(strain, 1e-13) << name << ' ' << d;
    EXPECT_LT(stress, 1e-13) << name << ' ' << d;
  });
}

/// The strain stays, and its elastic stress is the stress that the map gave.
TEST(ReturnMap, WhatItLeavesItLeavesAgain) {
  mapped_twice<2>();
  mapped_twice<3>();
}

template <int d>
void mapped_at_once() {
  test::for_each_map<double, d>([](const char* name, const auto& law) {
    Random random(4);
    for (int k = 0; k < 1000; ++k) {
      const HenckyStrain<double, d> e = test::random_strain<d>(0.2, random);
      double s[3] = {std::exp(e.e[0]), std::exp(e.e[1]), d == 3 ? std::exp(e.e[2]) : 1};
      typename std::decay_t<decltype(law)>::History apart{0.01}, together{0.01};
      const auto r = law.template response<false>(s, apart);
      double tau[3];
      for (int i = 0; i < d; ++i) tau[i] = r.t[i] * s[i];
      law.commit(s, apart);
      const Returned<double> both = law.commit(e, together);
      EXPECT_LT(test::distance<d>(both.tau, tau), 1e-14) << name << ' ' << d;
      for (int i = 0; i < d; ++i) EXPECT_NEAR(both.e[i], std::log(s[i]), 1e-14) << name << ' ' << d;
      const auto& [a] = apart;
      const auto& [b] = together;
      EXPECT_NEAR(a, b, 1e-14) << name << ' ' << d;
    }
  });
}

/// Stress and flow of a step, asked for at once or one after the other.
TEST(ReturnMap, CommitOfAStrainIsResponseAndCommitOfStretches) {
  mapped_at_once<2>();
  mapped_at_once<3>();
}

template <int d>
void mapped_floats() {
  test::for_each_map<float, d>([](const char* name, const auto& low) {
    test::for_each_map<double, d>([&](const char* other, const auto& law) {
      if constexpr (
          requires { std::decay_t<decltype(low)>::History::flow; } ==
          requires { std::decay_t<decltype(law)>::History::flow; }) {
        if (std::string_view(name) != other) return;
        Random random(3);
        for (int k = 0; k < 300; ++k) {
          const HenckyStrain<double, d> e = test::random_strain<d>(0.2, random);
          const float f[3] = {float(e.e[0]), float(e.e[1]), float(e.e[2])};
          const Returned<float> r = low.template returned<true>(split_strain<d>(f), {});
          const Returned<double> exact = test::returned(law, e);
          for (int i = 0; i < d; ++i) EXPECT_NEAR(r.tau[i], exact.tau[i], 2e-6) << name << ' ' << k;
        }
      }
    });
  });
}

TEST(ReturnMap, InFloatTheStressIsTheSame) {
  mapped_floats<2>();
  mapped_floats<3>();
}

template <class T, int d>
void mapped_extremes() {
  // huge, small, collapsed and inverted stretches in all combinations
  const T values[] = {T(1e4),  T(30),    T(1 + 1e-7), 1,        T(0.1),
                      T(1e-3), T(1e-30), 0,           T(-0.01), T(-0.5)};
  test::for_each_map<T, d>([&](const char* name, const auto& law) {
    for (const T a : values)
      for (const T b : values)
        for (const T c : values) {
          T s[3] = {a, b, d == 3 ? c : 1};
          typename std::decay_t<decltype(law)>::History history;
          const auto r = law.template response<true>(s, history);
          // the response, and the strain that is left, are finite
          EXPECT_TRUE(std::isfinite(r.psi)) << name << ' ' << a << ' ' << b << ' ' << c;
          for (const T t : r.t)
            EXPECT_TRUE(std::isfinite(t)) << name << ' ' << a << ' ' << b << ' ' << c;
          if constexpr (requires { r.H; })
            for (const T h : r.H)
              EXPECT_TRUE(std::isfinite(h)) << name << ' ' << a << ' ' << b << ' ' << c;
          else
            for (const T h : r.D.m)
              EXPECT_TRUE(std::isfinite(h)) << name << ' ' << a << ' ' << b << ' ' << c;
          law.commit(s, history);
          for (const T x : s)
            EXPECT_TRUE(std::isfinite(x)) << name << ' ' << a << ' ' << b << ' ' << c;
        }
  });
}

TEST(ReturnMap, ExtremeStretchesStayFinite) {
  mapped_extremes<float, 2>();
  mapped_extremes<float, 3>();
  mapped_extremes<double, 2>();
  mapped_extremes<double, 3>();
}

/// Stretches apart, equal, nearly equal, all equal and inverted; within and beyond the yield
/// surface.
TEST(ReturnMap, TangentInFIsTheSlopeOfPiolasStress) {
  const double stretches[][3] = {
      {1.2, 1.05, 0.9},      {0.95, 0.95, 0.8}, {0.99, 0.99 - 1e-8, 0.95}, {0.97, 0.97, 0.97},
      {1.004, 1.002, 1.001}, {0.9, 0.5, 1e-3},  {0.9, 0.5, -0.02}};
  test::for_each_map<double, 3>([&](const char* name, const auto& law) {
    Random random(4);
    for (const auto& s : stretches) {
      const Mat3<double> F = test::stretched(s[0], s[1], s[2], random);
      double A[81], size = 0, error = 0;
      piola_gradient(law, F, TangentKind::kTrue, A);
      for (const double a : A) size = std::fmax(size, std::abs(a));
      const double step = s[2] < 0.1 ? 1e-7 : 1e-6;
      for (int l = 0; l < 9; ++l) {
        Mat3<double> above = F, below = F;
        above.m[l] += step, below.m[l] -= step;
        const Mat3<double> Pa = piola_stress(law, above), Pb = piola_stress(law, below);
        for (int k = 0; k < 9; ++k)
          error = std::fmax(error, std::abs((Pa.m[k] - Pb.m[k]) / (2 * step) - A[9 * k + l]));
      }
      EXPECT_LT(error, 1e-6 * std::fmax(size, 1)) << name << ' ' << s[0] << ' ' << s[2];
    }
  });
}

TEST(ReturnMap, TurnsWithTheBody) {
  test::for_each_map<double, 3>([](const char* name, const auto& law) {
    Random random(5);
    for (int k = 0; k < 100; ++k) {
      const Mat3<double> F = test::stretched_within(0.8, 1.2, random);
      const Mat3<double> Q = test::rotation(random), R = test::rotation(random);
      const Mat3<double> turned = piola_stress(law, times_transposed(Q * F, R));
      EXPECT_LT(test::distance(turned, times_transposed(Q * piola_stress(law, F), R)), 1e-13)
          << name;
    }
  });
}

template <int d>
void map_work() {
  test::for_each_map<double, d>([](const char* name, const auto& law) {
    if constexpr (!requires { law.slope; }) {  // snow's flow is not associated
      Random random(6);
      for (int k = 0; k < 3000; ++k) {
        const HenckyStrain<double, d> e = test::random_strain<d>(0.2, random);
        const Returned<double> r = test::returned(law, e);
        double work = 0;
        for (int i = 0; i < d; ++i) work += r.tau[i] * (e.e[i] - r.e[i]);
        EXPECT_GE(work, 0) << name << ' ' << d;
      }
    }
  });
}

TEST(ReturnMap, FlowTakesWork) {
  map_work<2>();
  map_work<3>();
}

TEST(ReturnMap, StretchesComeBackFromTheirLogarithms) {
  for (const double s : {3.0, 1.0, 0.1, 0.05, 0.0, -0.5}) {
    const double stretches[3] = {s, 1, 1};
    const HenckyStrain<double, 3> e = hencky_strain<3>(stretches), none = {};
    double back[3] = {};
    set_stretches<3>(none.e, e.e, back);
    EXPECT_NEAR(back[0], s == 1 ? 0 : s, 1e-15);  // an unchanged stretch is not written
  }
}

}  // namespace
}  // namespace elastogen
