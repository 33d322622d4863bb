// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/mpm_potential.hpp"

#include "core/reduce.hpp"
#include "core/rigid_motion.hpp"

#include <cmath>
#include <limits>

namespace elastogen::mpm {
namespace {

constexpr double kEps = std::numeric_limits<double>::epsilon();

}  // namespace

template <int d>
void MpmPotential<d>::freeze(const double* y, bool drag) {
  is_frozen_ = true;
  drags_ = drag;
  frozen_.resize(size_t(this->particles_->count()));
  F0_.resize(this->pack_.size());
  energy_.assign(F0_.size(), 0), size_.assign(F0_.size(), 0);
  this->motion(y, this->u_);
  gather<d>(this->grid_, this->u_, [&](int64_t k, const PackSpline<d>& s, const double* tile) {
    Mat3<Eight>& F = F0_[size_t(k)];
    const auto& own = this->pack_[size_t(k)];
    F = own.after(nodal_gradient<d>(this->grid_, k, s, tile)) * own.F;
    mpm::freeze<d>(this->laws_, *this->particles_, this->grid_.packs()[size_t(k)],
                   decompose_lanes<d>(F).sigma, frozen_);
  });
  freeze_obstacles(y);
}

/// Freezes where colliders leave nodes, which directions stay free, and the force in these.
template <int d>
void MpmPotential<d>::freeze_obstacles(const double* y) {
  held_.resize(size_t(this->obstacles_.count()));
  for_each(int64_t(held_.size()), [&](int64_t k) {
    Held& held = held_[size_t(k)];
    const Vec3 free = this->free_motion(k, y);
    held.motion = this->obstacles_.allowed(k, free, nullptr);
    held.free = this->obstacles_.free_part(k, free);
    held.load = times(held.free, minus(held.motion, free));
    const double scale = this->root_mass_[size_t(this->obstacles_.node(k))];
    for (double& l : held.load) l *= scale / (this->dt_ * this->dt_);
  });
}

template <int d>
void MpmPotential<d>::meet_obstacles(double* y) {
  std::vector<double> met(y, y + this->unknowns());
  for_each(int64_t(held_.size()), [&](int64_t k) {
    const int64_t i = this->obstacles_.node(k);
    const double scale = this->root_mass_[size_t(i)];
    Vec3 off;
    for (size_t a = 0; a < 3; ++a)
      off[a] = scale * held_[size_t(k)].motion[a] - y[3 * i + int64_t(a)];
    const Vec3 along = times(held_[size_t(k)].free, off);
    for (size_t a = 0; a < 3; ++a) met[size_t(3 * i) + a] += off[a] - along[a];
  });
  const double share = this->longest_step(y, met.data());
  for_each(this->unknowns(), [&](int64_t k) { y[k] += share * (met[size_t(k)] - y[k]); });
}

/// mu of the regulariser for a pack's particles [Pa].
template <int d>
Eight MpmPotential<d>::drag_of(int64_t k) const {
  const CellPack& pack = this->grid_.packs()[size_t(k)];
  Eight mu = {};
  for (int lane = 0; lane < pack.count; ++lane) {
    const Solid& solid = this->scene_.solids[size_t(this->particles_->solid(pack.particle[lane]))];
    mu[lane] = solid.is_plastic() ? solid.elastic.mu() : 0;
  }
  return mu;
}

/// The stress; stores the energy too.
template <int d>
Mat3<Eight> MpmPotential<d>::piola(int64_t k, const Mat3<Eight>& F) {
  if (!is_frozen_) return Base::piola(k, F);
  const Svd3<Eight> svd = decompose_lanes<d>(F);
  Eight t[3];
  Eight psi = respond<false, d>(this->laws_, *this->particles_, frozen_,
                                this->grid_.packs()[size_t(k)], svd.sigma, t, nullptr);
  Mat3<Eight> P = first_piola(svd, t);
  Eight size = 32 * absolute(psi);
  for (int i = 0; i < 3; ++i) size += 8 * absolute(t[i] * svd.sigma[i]);
  if (drags_) {
    const Eight mu = drag_of(k);
    for (int e = 0; e < 9; ++e) {
      const Eight off = F.m[e] - F0_[size_t(k)].m[e];
      P.m[e] += mu * off;
      psi += mu / 2 * off * off;
    }
  }
  double sums[kFour] = {};
  const Eight& volume = this->pack_[size_t(k)].volume;
  add_sums(volume * psi, volume * size, Eight{}, Eight{}, sums);
  energy_[size_t(k)] = sums[0], size_[size_t(k)] = sums[1];
  return P;
}

template <int d>
PrincipalHessian<Eight, Mat3<Eight>> MpmPotential<d>::piola_derivative(int64_t k,
                                                                       const Svd3<Eight>& F,
                                                                       Eight t[3]) {
  if (!is_frozen_) return Base::piola_derivative(k, F, t);
  Mat3<Eight> D;
  respond<true, d>(this->laws_, *this->particles_, frozen_, this->grid_.packs()[size_t(k)], F.sigma,
                   t, &D);
  PrincipalHessian<Eight, Mat3<Eight>> h = hessian_lanes(F.sigma, t, D);
  if (drags_) {
    const Eight mu = drag_of(k);
    for (int i = 0; i < 3; ++i) h.A(i, i) += mu, h.twist[i] += mu, h.flip[i] += mu;
  }
  if (kind_ == TangentKind::kTrue) return h;
  const PrincipalHessian<Eight> positive = positive_part(h);
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3;
    h.A(i, i) = positive.A.m[i];
    h.A(i, j) = h.A(j, i) = positive.A.m[3 + i];
    h.twist[i] = positive.twist[i], h.flip[i] = positive.flip[i];
  }
  return h;
}

template <int d>
void MpmPotential<d>::linearise_obstacles(const double* y) {
  if (!is_frozen_) return Base::linearise_obstacles(y);
  for (size_t k = 0; k < held_.size(); ++k) this->obstacle_tangent_[k] = held_[k].free;
}

template <int d>
void MpmPotential<d>::linearise(const double* y, TangentKind kind) {
  kind_ = kind;
  Base::linearise(y);
}

template <int d>
fem::NewtonValue MpmPotential<d>::evaluate(const double* y, double* gradient) {
  this->equilibrium(y, gradient);
  // at colliders: the work of lambda, and the gradient in free directions
  double work = 0;
  for (size_t k = 0; k < held_.size(); ++k) {
    const int64_t i = this->obstacles_.node(int64_t(k));
    Vec3 g;
    for (size_t a = 0; a < 3; ++a) {
      work += held_[k].load[a] * y[3 * i + int64_t(a)];
      g[a] = gradient[3 * i + int64_t(a)] - held_[k].load[a];
    }
    g = times(held_[k].free, g);
    for (size_t a = 0; a < 3; ++a) gradient[3 * i + int64_t(a)] = g[a];
  }
  // inertia
  const double inertia =
      ordered_sum(this->grid_.nodes(),
                  [&](int64_t begin, int64_t end) {
                    double sum = 0;
                    for (int64_t i = begin; i < end; ++i)
                      for (int a = 0; a < d; ++a)
                        sum += std::pow(
                            y[3 * i + a] - this->root_mass_[size_t(i)] * this->predicted(i, a), 2);
                    return sum;
                  }) /
      (2 * this->dt_ * this->dt_);
  // elastic energy and its rounding error, from the packs
  const auto sum = [](const std::vector<double>& of) {
    return ordered_sum(int64_t(of.size()), [&](int64_t begin, int64_t end) {
      double total = 0;
      for (int64_t k = begin; k < end; ++k) total += of[size_t(k)];
      return total;
    });
  };
  return {inertia + sum(energy_) - work, kEps * (sum(size_) + 32 * (inertia + std::abs(work)))};
}

template class MpmPotential<2>;
template class MpmPotential<3>;

}  // namespace elastogen::mpm
