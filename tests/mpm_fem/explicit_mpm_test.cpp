// SPDX-License-Identifier: Apache-2.0
// Explicit steps against the same equations written out, particle by particle and node by node.

#include "mpm_fem/integrators/explicit_mpm.hpp"

#include "core/parallel.hpp"
#include "core/svd2.hpp"
#include "mpm_fem/mpm/spline.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <map>

namespace elastogen::mpm {
namespace {

constexpr double kEdge = 0.1;  // of a cell [m]

struct PlainNode {
  double mass = 0, before[3] = {}, v[3] = {}, u[3] = {}, force[3] = {};
};
using PlainNodes = std::map<std::array<int32_t, 3>, PlainNode>;

/// visit(node, w, g, r) for the nodes around a particle.
template <int d, class Visit>
void around(const double* x, PlainNodes& nodes, const Visit& visit) {
  const Spline<d> s = spline<d>(x, kEdge);
  for_nodes<d, 3>(s, 0, [&](int at, double w, const double* g, const double* r) {
    visit(nodes[{s.base[0] + at % 3, s.base[1] + at / 3 % 3, s.base[2] + at / 9}], w, g, r);
  });
}

template <int d>
void plain_momenta(const Particles& p, PlainNodes& nodes) {
  for (int64_t k = 0; k < p.count(); ++k)
    around<d>(p.x.row(k), nodes, [&](PlainNode& n, double w, const double*, const double* r) {
      n.mass += w * p.mass(k);
      for (int a = 0; a < d; ++a) {
        double v = p.v(k, a);
        for (int b = 0; b < d; ++b) v += p.C(k, 3 * a + b) * r[b];
        n.before[a] += w * p.mass(k) * v;
      }
    });
  for (auto& [place, n] : nodes)
    for (int a = 0; a < d; ++a) n.v[a] = n.before[a] /= n.mass;
}

/// f = -V tau Finc^-T grad w, v += delta (f/m + g), and nodes at or below y = 0 are held.
template <int d>
void plain_motion(const MpmScene& s, double delta, const Particles& p,
                  const std::vector<Mat3<double>>& increment, PlainNodes& nodes) {
  for (auto& [place, n] : nodes)
    for (double& f : n.force) f = 0;
  for (int64_t k = 0; k < p.count(); ++k) {
    const double* t = p.stress.row(k);
    const Mat3<double> A =
        times_transposed(Mat3<double>{t[0], t[3], t[5], t[3], t[1], t[4], t[5], t[4], t[2]},
                         inverse(increment[size_t(k)]));
    around<d>(p.x.row(k), nodes, [&](PlainNode& n, double, const double* g, const double*) {
      for (int a = 0; a < d; ++a)
        for (int b = 0; b < d; ++b) n.force[a] -= p.volume(k) * A(a, b) * g[b];
    });
  }
  for (auto& [place, n] : nodes)
    for (int a = 0; a < d; ++a) {
      n.v[a] += delta * (n.force[a] / n.mass + s.gravity[size_t(a)]);
      if (place[1] <= 0) n.v[a] = 0;
      n.u[a] += delta * n.v[a];
    }
}

/// The law from Finc before to Finc after, asked for stress and flow apart.
template <int d>
void plain_strain(const PointLaw<d>& law, const Mat3<double>& way, int64_t k, Particles& p) {
  Svd3<double> f = decompose<d>(way * load_matrix(p.F.row(k)));
  std::visit(
      [&](const auto& own) {
        auto history = history_of(own, p.history(k));
        const auto r = own.template response<false>(f.sigma, history);
        double tau[3];
        for (int i = 0; i < 3; ++i) tau[i] = r.t[i] * f.sigma[i];
        constexpr int kRow[6] = {0, 1, 2, 0, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 0};
        for (int e = 0; e < 6; ++e) {
          p.stress(k, e) = 0;
          for (int i = 0; i < 3; ++i)
            p.stress(k, e) += f.U(kRow[e], i) * tau[i] * f.U(kColumn[e], i);
        }
        own.commit(f.sigma, history);
        p.history(k) = memory_of(history);
      },
      law);
  store_matrix(first_piola(f, f.sigma), p.F.row(k));
}

template <int d>
void plain_transfer(const MpmScene& s, Particles& p, PlainNodes& nodes) {
  const Transfer kind = s.transfer.kind;
  // share of the particle's own motion that is kept
  const double back = kind == Transfer::kBlend  ? 1 - s.dt / s.transfer.blend_time
                      : kind == Transfer::kFlip ? s.transfer.flip
                                                : 0;
  for (int64_t k = 0; k < p.count(); ++k) {
    // sums over the nodes around the particle
    double v[3] = {}, C[9] = {}, moved[3] = {}, old_v[3] = {}, old_C[9] = {};
    around<d>(p.x.row(k), nodes, [&](PlainNode& n, double w, const double*, const double* r) {
      for (int a = 0; a < d; ++a) {
        v[a] += w * n.v[a], old_v[a] += w * n.before[a], moved[a] += w * n.u[a];
        for (int b = 0; b < d; ++b) {
          C[3 * a + b] += 4 / (kEdge * kEdge) * w * n.v[a] * r[b];
          old_C[3 * a + b] += 4 / (kEdge * kEdge) * w * n.before[a] * r[b];
        }
      }
    });
    // velocity, position and affine part by the kind of transfer
    for (int a = 0; a < d; ++a) {
      p.v(k, a) = v[a] + back * (p.v(k, a) - old_v[a]);
      p.x(k, a) += moved[a];
    }
    for (int e = 0; e < 9; ++e)
      p.C(k, e) = kind == Transfer::kApic    ? C[e]
                  : kind == Transfer::kRpic  ? (C[e] - C[3 * (e % 3) + e / 3]) / 2
                  : kind == Transfer::kBlend ? C[e] + back * (p.C(k, e) - old_C[e])
                                             : 0;
  }
}

template <int d>
void plain_step(const MpmScene& s, int substeps, Particles& p) {
  PlainNodes nodes;
  plain_momenta<d>(p, nodes);
  std::vector<Mat3<double>> increment(size_t(p.count()), identity<double>());
  for (int n = 0; n < substeps; ++n) {
    plain_motion<d>(s, s.dt / substeps, p, increment, nodes);
    for (int64_t k = 0; k < p.count(); ++k) {
      Mat3<double> now = identity<double>();
      around<d>(p.x.row(k), nodes, [&](PlainNode& m, double, const double* g, const double*) {
        for (int a = 0; a < d; ++a)
          for (int b = 0; b < d; ++b) now(a, b) += m.u[a] * g[b];
      });
      const PointLaw<d> law = point_law<d>(s.solids[size_t(p.solid(k))]);
      plain_strain<d>(law, now * inverse(increment[size_t(k)]), k, p);
      increment[size_t(k)] = now;
    }
  }
  plain_transfer<d>(s, p, nodes);
}

/// Particles of every solid in the same cells, of which a floor holds the lowest.
template <int d>
Particles mixture(const MpmScene& s) {
  test::Random random(31);
  std::uniform_real_distribution<double> in(-0.5, 0.5);
  Particles all;
  for (size_t n = 0; n < s.solids.size(); ++n) {
    Array<double> x(d == 2 ? 150 : 300, 3);
    for (int64_t k = 0; k < x.rows(); ++k)
      for (int a = 0; a < d; ++a) x(k, a) = 0.15 + 0.3 * (in(random) + 0.5);
    const Particles own = particles_at(x, 1e-4, int32_t(n), s.solids[n].elastic.density);
    n == 0 ? void(all = own) : append(all, own);
  }
  for (int64_t k = 0; k < all.count(); ++k)
    for (int a = 0; a < d; ++a) {
      all.v(k, a) = 0.2 * in(random);
      for (int b = 0; b < d; ++b) {
        all.C(k, 3 * a + b) = 10 * in(random);
        all.F(k, 3 * a + b) += 0.04 * in(random);
      }
    }
  return all;
}

void expect_near(const char* name, const Array<double>& a, const Array<double>& b) {
  double most = 0, off = 0;
  for (int64_t k = 0; k < b.size(); ++k) {
    most = std::max(most, std::abs(b.data()[k]));
    off = std::max(off, std::abs(a.data()[k] - b.data()[k]));
  }
  EXPECT_LE(off, 1e-10 * most) << name;
}

MpmScene mixed_scene(int dimension, Transfer kind) {
  MpmScene s;
  s.dimension = dimension, s.h = kEdge, s.dt = 2e-3;
  s.gravity = {1, -10, 0};
  s.obstacles.push_back({half_space({0, 1, 0}, 0, 0), true});
  s.transfer.kind = kind;
  Solid solid;
  solid.elastic = {"test", Law::kHencky, 1e5, 0.3, 1000};
  for (const Yield& yield :
       {Yield{}, Yield{SandYield{.friction = 0.5}}, Yield{MetalYield{.stress = 500}},
        Yield{SnowYield{.slope = 1.2, .cohesion = 0.5, .hardening = 1, .pressure = 5e3}}}) {
    solid.yield = yield;
    s.solids.push_back(solid);
  }
  solid.elastic.law = Law::kNeoHookean;
  for (const Yield& yield : {Yield{}, Yield{MetalYield{.stress = 500}}}) {
    solid.yield = yield;
    s.solids.push_back(solid);
  }
  return s;
}

template <int d>
void check_steps() {
  for (const Transfer kind : {Transfer::kApic, Transfer::kBlend, Transfer::kRpic, Transfer::kFlip})
    for (const int substeps : {1, 3}) {
      const MpmScene s = mixed_scene(d, kind);
      Particles p = mixture<d>(s), plain = p;
      ExplicitMpm<d> steps(s, substeps);
      for (int k = 0; k < 2; ++k) {
        steps.step(0, p);
        plain_step<d>(s, substeps, plain);
      }
      SCOPED_TRACE(int(kind) * 10 + substeps);
      expect_near("x", p.x, plain.x), expect_near("v", p.v, plain.v);
      expect_near("C", p.C, plain.C), expect_near("F", p.F, plain.F);
      expect_near("stress", p.stress, plain.stress);
      expect_near("history", p.history, plain.history);
    }
}

TEST(ExplicitMpm, StepsAreThoseOfSingleParticlesAndNodes) {
  check_steps<2>();
  check_steps<3>();
}

TEST(ExplicitMpm, GivesTheSameBitsOnOneThread) {
  const MpmScene s = mixed_scene(3, Transfer::kApic);
  Particles p = mixture<3>(s), one = p;
  ExplicitMpm<3>(s, 2).step(0, p);
  const ThreadLimit limit(1);
  ExplicitMpm<3>(s, 2).step(0, one);
  EXPECT_TRUE(p.x == one.x && p.v == one.v && p.C == one.C && p.F == one.F);
  EXPECT_TRUE(p.stress == one.stress && p.history == one.history);
}

}  // namespace
}  // namespace elastogen::mpm
