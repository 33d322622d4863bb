// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/mpm_equations.hpp"

#include "core/constants.hpp"
#include "core/constitutive.hpp"
#include "core/svd2.hpp"
#include "mpm_fem/fem/inversion_bound.hpp"
#include "mpm_fem/mpm/end_step.hpp"
#include "mpm_fem/mpm/g2p.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::mpm {
namespace {

template <class Block>
void scale(const Eight& factor, PrincipalHessian<Eight, Block>& h) {
  for (Eight& a : h.A.m) a *= factor;
  for (int i = 0; i < 3; ++i) h.twist[i] *= factor, h.flip[i] *= factor;
}

}  // namespace

template <int d>
MpmEquations<d>::MpmEquations(const MpmScene& scene) : scene_(scene), grid_(scene.h) {
  check_scene(scene);
  for (const Solid& solid : scene.solids) laws_.push_back(point_law<d>(solid));
}

template <int d>
void MpmEquations<d>::begin(const Particles& particles, double time, double dt) {
  particles_ = &particles;
  dt_ = dt;
  has_cells_ = false;
  grid_.update(particles.x);
  start_ = particles_to_grid<d>(grid_, particles, scratch_);
  // strain and volume of the particles, pack by pack
  pack_.resize(grid_.packs().size());
  for_each(int64_t(pack_.size()), [&](int64_t k) {
    const CellPack& pack = grid_.packs()[size_t(k)];
    pack_[size_t(k)] = {matrix_lanes(particles.F, pack), identity<Eight>(),
                        counted_lanes(particles.volume, pack, 0)};
  });
  go_on(time);
  // roots of the masses, which scale the unknowns
  root_mass_.resize(size_t(grid_.nodes()));
  inverse_root_.resize(root_mass_.size());
  double total = 0;
  for (size_t i = 0; i < root_mass_.size(); ++i) {
    const double m = start_.mass(int64_t(i));
    total += m;
    root_mass_[i] = std::sqrt(m);
    inverse_root_[i] = m > 0 ? 1 / root_mass_[i] : 0;
  }
  reference_ = kReferenceGravity * std::sqrt(total);
  // arrays that the steps work in
  u_ = force_ = motion_ = Array<double>(grid_.nodes(), 3);
  before_ = start_.velocity;
  r0_.assign(size_t(unknowns()), 0);
}

template <int d>
void MpmEquations<d>::go_on(double time) {
  obstacles_.begin(grid_, scene_.obstacles, time, dt_);
  obstacle_tangent_.resize(size_t(obstacles_.count()));
}

template <int d>
void MpmEquations<d>::predict(double* y) const {
  std::vector<double> free(r0_.size());
  for_each(grid_.nodes(), [&](int64_t i) {
    for (int a = 0; a < d; ++a) free[size_t(3 * i + a)] = root_mass_[size_t(i)] * predicted(i, a);
  });
  apply_obstacles(free.data(), y);
}

template <int d>
void MpmEquations<d>::motion(const double* y, Out<double> u) const {
  for_each(grid_.nodes(), [&](int64_t i) {
    for (int a = 0; a < 3; ++a) u(i, a) = inverse_root_[size_t(i)] * y[3 * i + a];
  });
}

/// result = M^1/2 Pi(M^-1/2 free).
template <int d>
void MpmEquations<d>::apply_obstacles(const double* free, double* result) const {
  std::copy(free, free + unknowns(), result);
  for_each(obstacles_.count(), [&](int64_t k) {
    const int64_t i = obstacles_.node(k);
    const double scale = inverse_root_[size_t(i)];
    if (scale == 0) return;
    const Vec3 m = obstacles_.allowed(
        k, {scale * free[3 * i], scale * free[3 * i + 1], scale * free[3 * i + 2]}, nullptr);
    for (int a = 0; a < 3; ++a) result[3 * i + a] = m[size_t(a)] / scale;
  });
}

template <int d>
Mat3<Eight> MpmEquations<d>::piola(int64_t k, const Mat3<Eight>& F) {
  const Svd3<Eight> svd = decompose_lanes<d>(F);
  Eight t[3];
  respond<false, d>(laws_, *particles_, grid_.packs()[size_t(k)], svd.sigma, t, nullptr);
  return first_piola(svd, t);
}

template <int d>
PrincipalHessian<Eight, Mat3<Eight>> MpmEquations<d>::piola_derivative(int64_t k,
                                                                       const Svd3<Eight>& F,
                                                                       Eight t[3]) {
  Mat3<Eight> D;
  respond<true, d>(laws_, *particles_, grid_.packs()[size_t(k)], F.sigma, t, &D);
  return hessian_lanes(F.sigma, t, D);
}

/// Writes the forces of the stress at u_ to force_; `magnitude`: those of the magnitudes of its
/// parts.
template <int d>
void MpmEquations<d>::add_stress(bool magnitude) {
  const auto add = [&](int64_t k, const PackSpline<d>& s, const double* read, double* write) {
    const Start& own = pack_[size_t(k)];
    const Mat3<Eight> F = own.after(nodal_gradient<d>(grid_, k, s, read)) * own.F;
    Mat3<Eight> A = times_transposed(piola(k, F), own.F);
    for (Eight& a : A.m) a *= own.volume;
    if (!magnitude) return add_nodal_product<d>(grid_, k, s, A, write);
    Eight size = {};
    for (const Eight& a : A.m) size += absolute(a);
    for_pack_nodes<d>(grid_, k, s, [&](int at, const Eight&, const Eight g[3], const Eight*) {
      const Eight slope = absolute(g[0]) + absolute(g[1]) + absolute(g[2]);
      add_sums(size * slope, Eight{}, Eight{}, Eight{}, write + kFour * at);
    });
  };
  gather_scatter<d>(grid_, u_, scratch_, force_, add);
}

template <int d>
void MpmEquations<d>::equilibrium(const double* y, double* r0) {
  motion(y, u_);
  add_stress(false);
  for_each(grid_.nodes(), [&](int64_t i) {
    const size_t n = size_t(i);
    for (int a = 0; a < 3; ++a)
      r0[3 * i + a] = (y[3 * i + a] - root_mass_[n] * predicted(i, a)) / (dt_ * dt_) +
                      inverse_root_[n] * force_(i, a);
  });
}

template <int d>
void MpmEquations<d>::residual(const double* y, double* r) {
  equilibrium(y, r0_.data());
  std::vector<double> free(r0_.size());
  for_each(unknowns(), [&](int64_t k) { free[size_t(k)] = y[k] - dt_ * dt_ * r0_[size_t(k)]; });
  apply_obstacles(free.data(), r);
  // without a collider r is r0 itself, which has lost no digits
  for_each(unknowns(), [&](int64_t k) {
    const double moved = y[k] - r[k];
    r[k] = r[k] == free[size_t(k)] ? r0_[size_t(k)] : moved / (dt_ * dt_);
  });
}

template <int d>
double MpmEquations<d>::noise(const double* y) {
  motion(y, u_);
  add_stress(true);
  const double square = ordered_sum(grid_.nodes(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t i = begin; i < end; ++i) {
      double size = inverse_root_[size_t(i)] * force_(i, 0);
      for (int a = 0; a < d; ++a) size += std::abs(y[3 * i + a]) / (dt_ * dt_);
      sum += size * size;
    }
    return sum;
  });
  return 4 * std::numeric_limits<double>::epsilon() * std::sqrt(square);
}

template <int d>
double MpmEquations<d>::longest_step(const double* y, const double* end) {
  Array<double> from(grid_.nodes(), 3), moved(grid_.nodes(), 3);
  motion(y, from);
  motion(end, moved);
  for_each(moved.size(), [&](int64_t k) { moved.data()[k] -= from.data()[k]; });
  std::vector<double> share(size_t(grid_.blocks()), 1.0);
  run_tasks(grid_.blocks(), [&](int64_t b) {
    alignas(64) double at[kFour * ParticleGrid<d>::kTile], to[kFour * ParticleGrid<d>::kTile];
    read_tile(grid_, b, from, at);
    read_tile(grid_, b, moved, to);
    for_packs<d>(grid_, b, [&](int64_t k, const PackSpline<d>& s) {
      const Mat3<Eight> now = pack_[size_t(k)].after(nodal_gradient<d>(grid_, k, s, at));
      Mat3<Eight> then = nodal_gradient<d>(grid_, k, s, to);
      for (int e = 0; e < 9; ++e) then.m[e] += now.m[e];
      for (int lane = 0; lane < grid_.packs()[size_t(k)].count; ++lane)
        share[size_t(b)] = std::min(
            share[size_t(b)], fem::share_before_inversion(lane_of(now, lane), lane_of(then, lane)));
    });
  });
  return share.empty() ? 1 : *std::min_element(share.begin(), share.end());
}

/// Sets the tangent of a pack; returns the frozen Hessian. Both are times the volume.
template <int d>
PrincipalHessian<Eight> MpmEquations<d>::set_tangent(int64_t k, const Mat3<Eight>& gradient) {
  const Start& own = pack_[size_t(k)];
  Tangent& tangent = tangent_[size_t(k)];
  tangent.frame = decompose_lanes<d>(own.after(gradient) * own.F);
  Eight t[3];
  tangent.hessian = piola_derivative(k, tangent.frame, t);
  PrincipalHessian<Eight> frozen = frozen_hessian<d>(tangent.frame.sigma, t, tangent.hessian);
  scale(own.volume, tangent.hessian);
  scale(own.volume, frozen);
  tangent.frame.V = own.F * tangent.frame.V;
  return frozen;
}

template <int d>
void MpmEquations<d>::linearise(const double* y) {
  constexpr int kBlock = 8;  // numbers of a node in a tile; its block has six
  tangent_.resize(pack_.size());
  motion(y, u_);
  Array<double> block(grid_.nodes(), 6);
  add_tiles<d, kBlock>(grid_, scratch_, block, [&](int64_t b, double* write) {
    alignas(64) double read[kFour * ParticleGrid<d>::kTile];
    read_tile(grid_, b, u_, read);
    for_packs<d>(grid_, b, [&](int64_t k, const PackSpline<d>& s) {
      const PrincipalHessian<Eight> frozen = set_tangent(k, nodal_gradient<d>(grid_, k, s, read));
      const Svd3<Eight>& frame = tangent_[size_t(k)].frame;
      for_pack_nodes<d>(grid_, k, s, [&](int at, const Eight&, const Eight g[3], const Eight*) {
        Eight B[6];
        node_block(frozen, frame, g, B);
        add_sums(B[0], B[1], B[2], B[3], write + kBlock * at);
        add_sums(B[4], B[5], Eight{}, Eight{}, write + kBlock * at + 4);
      });
    });
  });
  linearise_obstacles(y);
  invert_blocks(block);
}

template <int d>
Vec3 MpmEquations<d>::free_motion(int64_t k, const double* y) const {
  const int64_t i = obstacles_.node(k);
  Vec3 free;
  for (int a = 0; a < 3; ++a)
    free[size_t(a)] =
        inverse_root_[size_t(i)] * (y[3 * i + a] - dt_ * dt_ * r0_[size_t(3 * i + a)]);
  return free;
}

template <int d>
void MpmEquations<d>::linearise_obstacles(const double* y) {
  for_each(obstacles_.count(), [&](int64_t k) {
    obstacles_.allowed(k, free_motion(k, y), &obstacle_tangent_[size_t(k)]);
  });
}

/// Inverts the blocks of dr/dy, which are B/m + I/dt^2, and at colliders
/// (I - dPi (I - dt^2 (B/m + I/dt^2)))/dt^2.
template <int d>
void MpmEquations<d>::invert_blocks(In<double> sums) {
  Array<double> block(grid_.nodes(), 9);
  const double inertia = 1 / (dt_ * dt_);
  for_each(grid_.nodes(), [&](int64_t i) {
    const double scale = inverse_root_[size_t(i)] * inverse_root_[size_t(i)];
    const double* B = sums.row(i);
    store_matrix(Mat3<double>{B[0], B[3], B[5], B[3], B[1], B[4], B[5], B[4], B[2]}, block.row(i));
    for (int e = 0; e < 9; ++e) block(i, e) = scale * block(i, e) + (e % 4 == 0 ? inertia : 0);
  });
  for_each(obstacles_.count(), [&](int64_t k) {
    const int64_t i = obstacles_.node(k);
    Mat3<double> left = load_matrix(block.row(i));
    for (int e = 0; e < 9; ++e) left.m[e] = (e % 4 == 0) - left.m[e] / inertia;
    const Mat3<double> after = obstacle_tangent_[size_t(k)] * left;
    for (int e = 0; e < 9; ++e) block(i, e) = ((e % 4 == 0) - after.m[e]) * inertia;
  });
  inverse_block_.resize(size_t(grid_.nodes()));
  for_each(grid_.nodes(),
           [&](int64_t i) { inverse_block_[size_t(i)] = inverse(load_matrix(block.row(i))); });
}

template <int d>
void MpmEquations<d>::product(const double* p, double* Jp) {
  motion(p, u_);
  gather_scatter<d>(grid_, u_, scratch_, force_,
                    [&](int64_t k, const PackSpline<d>& s, const double* read, double* write) {
                      const Tangent& t = tangent_[size_t(k)];
                      const Mat3<Eight> A =
                          apply(t.hessian, t.frame, nodal_gradient<d>(grid_, k, s, read));
                      add_nodal_product<d>(grid_, k, s, A, write);
                    });
  const double inertia = 1 / (dt_ * dt_);
  for_each(grid_.nodes(), [&](int64_t i) {
    for (int a = 0; a < 3; ++a)
      Jp[3 * i + a] = inertia * p[3 * i + a] + inverse_root_[size_t(i)] * force_(i, a);
  });
  for_each(obstacles_.count(), [&](int64_t k) {
    const int64_t i = obstacles_.node(k);
    double left[3];
    for (int a = 0; a < 3; ++a) left[a] = p[3 * i + a] - Jp[3 * i + a] / inertia;
    const Mat3<double>& D = obstacle_tangent_[size_t(k)];
    for (int a = 0; a < 3; ++a)
      Jp[3 * i + a] =
          inertia * (p[3 * i + a] - (D(a, 0) * left[0] + D(a, 1) * left[1] + D(a, 2) * left[2]));
  });
}

template <int d>
void MpmEquations<d>::precondition(const double* p, double* z) const {
  for_each(grid_.nodes(), [&](int64_t i) {
    const Mat3<double>& B = inverse_block_[size_t(i)];
    for (int a = 0; a < 3; ++a)
      z[3 * i + a] = B(a, 0) * p[3 * i] + B(a, 1) * p[3 * i + 1] + B(a, 2) * p[3 * i + 2];
  });
}

template <int d>
const fem::SparseMatrix& MpmEquations<d>::jacobian() {
  if (!has_cells_) cells_.update(grid_);
  has_cells_ = true;
  jacobian_ = cells_.pattern();
  cells_.add(
      grid_,
      [&](int64_t k, Eight* D) {
        write_matrix(tangent_[size_t(k)].hessian, tangent_[size_t(k)].frame, D);
      },
      jacobian_);
  const double inertia = 1 / (dt_ * dt_);
  for_each(jacobian_.rows(), [&](int64_t r) {
    for (int32_t k = jacobian_.start[size_t(r)]; k < jacobian_.start[size_t(r) + 1]; ++k) {
      const int32_t c = jacobian_.column[size_t(k)];
      jacobian_.value[size_t(k)] *= inverse_root_[size_t(r / 3)] * inverse_root_[size_t(c / 3)];
      if (c == r) jacobian_.value[size_t(k)] += inertia;
    }
  });
  for_each(obstacles_.count(),
           [&](int64_t k) { put_obstacle(obstacles_.node(k), obstacle_tangent_[size_t(k)]); });
  return jacobian_;
}

/// The rows J of a node at a collider become dPi J + (I - dPi)/dt^2.
template <int d>
void MpmEquations<d>::put_obstacle(int64_t node, const Mat3<double>& D) {
  double* row[3];
  for (int a = 0; a < 3; ++a)
    row[a] = jacobian_.value.data() + jacobian_.start[size_t(3 * node + a)];
  const int32_t length = jacobian_.start[size_t(3 * node + 1)] - jacobian_.start[size_t(3 * node)];
  for (int32_t k = 0; k < length; ++k) {
    const double J[3] = {row[0][k], row[1][k], row[2][k]};
    for (int a = 0; a < 3; ++a) row[a][k] = D(a, 0) * J[0] + D(a, 1) * J[1] + D(a, 2) * J[2];
  }
  Mat3<double> rest;
  for (int e = 0; e < 9; ++e) rest.m[e] = ((e % 4 == 0) - D.m[e]) / (dt_ * dt_);
  jacobian_.add_block(node, node, rest.m);
}

template <int d>
void MpmEquations<d>::commit(const double* y, Particles& p) {
  motion(y, u_);
  gather<d>(grid_, u_, [&](int64_t k, const PackSpline<d>& s, const double* tile) {
    Start& own = pack_[size_t(k)];
    const CellPack& pack = grid_.packs()[size_t(k)];
    own.moved = own.after(nodal_gradient<d>(grid_, k, s, tile));
    const Mat3<Eight> trial = own.moved * own.F;
    for (int begin = 0; begin < pack.count; begin += lane_count<WidePack>)
      end_step<d>(laws_, pack, begin, part<WidePack>(trial, begin), p);
    own.F = inverse(own.moved) * matrix_lanes<Eight>(p.F, pack);
  });
  for_each(u_.size(), [&](int64_t k) {
    motion_.data()[k] += u_.data()[k];
    start_.velocity.data()[k] = u_.data()[k] / dt_;
  });
}

template <int d>
void MpmEquations<d>::transfer(Particles& p) const {
  grid_to_particles<d>(grid_, motion_, before_, start_.velocity, scene_.transfer, scene_.dt, p);
}

template class MpmEquations<2>;
template class MpmEquations<3>;

}  // namespace elastogen::mpm
