// SPDX-License-Identifier: Apache-2.0
// Particles in packs: every one once, sums as of single particles, and the frozen Hessian.

#include "mpm_fem/materials/frozen_potential.hpp"
#include "mpm_fem/mpm/p2g.hpp"
#include "mpm_fem/mpm/pack_laws.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>

namespace elastogen::mpm {
namespace {

constexpr double kSpacing = 0.1;

template <int d>
Array<double> places(int64_t count) {
  test::Random random(21);
  std::uniform_real_distribution<double> in(-0.4, 0.4);
  Array<double> x(count, 3);
  for (int64_t k = 0; k < count; ++k)
    for (int a = 0; a < d; ++a) x(k, a) = in(random);
  return x;
}

template <int d>
void check_packs(int64_t count) {
  const Array<double> x = places<d>(count);
  ParticleGrid<d> grid(kSpacing);
  grid.update(x);
  std::vector<int> seen(size_t(count), 0);
  for (int64_t b = 0; b < grid.blocks(); ++b)
    for (int64_t k = grid.first_pack(b); k < grid.first_pack(b + 1); ++k) {
      const CellPack& pack = grid.packs()[size_t(k)];
      ASSERT_GE(pack.count, 1);
      ASSERT_LE(pack.count, kLanes);
      for (int lane = 0; lane < kLanes; ++lane) {
        const int32_t p = pack.particle[lane];
        EXPECT_EQ(p, pack.particle[lane < pack.count ? lane : 0]);
        if (lane < pack.count) ++seen[size_t(p)];
        for (int a = 0; a < 3; ++a) EXPECT_EQ(pack.x[a][lane], x(p, a));
        for (int a = 0; a < d; ++a) EXPECT_EQ(pack.base[a], first_node(x(p, a) / kSpacing));
      }
      const int32_t node = grid.tile(b)[pack.place];
      for (size_t a = 0; a < 3; ++a) EXPECT_EQ(grid.place(node)[a], pack.base[a]);
    }
  EXPECT_EQ(seen, std::vector<int>(size_t(count), 1));
}

TEST(CellPacks, HaveEveryParticleOnceWithTheNodesOfItsCell) {
  check_packs<2>(700);
  check_packs<3>(2000);  // four in a cell
  check_packs<3>(9000);  // eighteen
  check_packs<3>(1);
  check_packs<3>(0);
}

/// Masses and momenta of the nodes as sums over single particles.
template <int d>
void check_sums() {
  test::Random random(22);
  std::uniform_real_distribution<double> in(-1, 1);
  Particles p = particles_at(places<d>(3000), 1e-4, 0, 1000);
  for (int64_t k = 0; k < p.count(); ++k) {
    p.mass(k) *= 1.5 + in(random);
    for (int a = 0; a < d; ++a) {
      p.v(k, a) = in(random);
      for (int b = 0; b < d; ++b) p.C(k, 3 * a + b) = in(random);
    }
  }
  // sums over single particles
  std::map<std::array<int32_t, 3>, std::array<double, 4>> sums;
  for (int64_t k = 0; k < p.count(); ++k) {
    const Spline<d> s = spline<d>(p.x.row(k), kSpacing);
    for_nodes<d, 3>(s, 0, [&](int at, double w, const double*, const double r[3]) {
      std::array<double, 4>& sum =
          sums[{s.base[0] + at % 3, s.base[1] + at / 3 % 3, s.base[2] + at / 9}];
      for (int a = 0; a < d; ++a) {
        double v = p.v(k, a);
        for (int b = 0; b < d; ++b) v += p.C(k, 3 * a + b) * r[b];
        sum[size_t(a)] += w * p.mass(k) * v;
      }
      sum[3] += w * p.mass(k);
    });
  }
  // sums by packs
  ParticleGrid<d> grid(kSpacing);
  grid.update(p.x);
  Zeroed<double> scratch;
  const NodeMotion nodes = particles_to_grid<d>(grid, p, scratch);
  ASSERT_EQ(grid.nodes(), int64_t(sums.size()));
  for (int64_t i = 0; i < grid.nodes(); ++i) {
    const std::array<double, 4>& sum = sums.at(grid.place(i));
    EXPECT_NEAR(nodes.mass(i), sum[3], 1e-13);
    for (int a = 0; a < d; ++a)
      EXPECT_NEAR(nodes.mass(i) * nodes.velocity(i, a), sum[size_t(a)], 1e-13);
  }
}

TEST(CellPacks, GiveNodesTheSumsOfSingleParticles) {
  check_sums<2>();
  check_sums<3>();
}

/// Packs of eight random states, on every branch of the law.
template <int d, class Law, class Frozen>
void check_frozen(const Law& law, const Frozen& frozen) {
  test::Random random(23);
  std::uniform_real_distribution<double> in(-0.02, 0.02);
  for (int n = 0; n < 200; ++n) {
    Eight s[3] = {}, t[3] = {};
    Mat3<Eight> D = {};
    PrincipalHessian<double> expected[kLanes];
    double size = 0;
    for (int lane = 0; lane < kLanes; ++lane) {
      double own[3] = {1, 1, 1};
      for (int i = 0; i < d; ++i) own[i] = 0.99 + in(random);
      std::sort(own, own + d, std::greater<>());
      const auto r = law.template response<true>(own, {});
      for (int i = 0; i < 3; ++i) s[i][lane] = own[i], t[i][lane] = r.t[i];
      set_lane(lane, derivative(r), D);
      expected[lane] = positive_part(principal_hessian(own, frozen(own)));
      for (const double a : expected[lane].A.m) size = std::max(size, std::abs(a));
    }
    const PrincipalHessian<Eight> h = frozen_hessian<d>(s, t, hessian_lanes(s, t, D));
    for (int lane = 0; lane < kLanes; ++lane)
      for (int e = 0; e < (d == 3 ? 6 : 2); ++e)
        EXPECT_NEAR(h.A.m[e][lane], expected[lane].A.m[e], 1e-9 * size) << n << " " << lane;
  }
}

TEST(FrozenHessian, IsThatOfTheFrozenPotentialOfSand) {
  const Material elastic = {"sand", Law::kHencky, 1e6, 0.3, 1000};
  const auto law = drucker_prager<double>(elastic, {std::numbers::pi / 6, 0, false});
  const FrozenDruckerPrager<double> frozen{law};
  check_frozen<3>(law,
                  [&](const double* s) { return frozen.response<true>(s, frozen.frozen(s, {})); });
  const auto plane = drucker_prager<double, 2>(elastic, {std::numbers::pi / 6, 0, false});
  const FrozenDruckerPrager<double, 2> frozen_plane{plane};
  check_frozen<2>(plane, [&](const double* s) {
    return frozen_plane.response<true>(s, frozen_plane.frozen(s, {}));
  });
}

TEST(FrozenHessian, IsThePositivePartWhereTheTangentIsSymmetric) {
  const Material elastic = {"elastic", Law::kNeoHookean, 1e6, 0.3, 1000};
  const ElasticLaw<double> law{{elastic.law, elastic.mu(), elastic.lambda()}};
  check_frozen<3>(law, [&](const double* s) { return law.response<true>(s, {}); });
}

}  // namespace
}  // namespace elastogen::mpm
