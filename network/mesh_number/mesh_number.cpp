// SPDX-License-Identifier: Apache-2.0
#include "network/mesh_number/mesh_number.hpp"

#include "core/polar.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr double kLinearTolerance = 0.02;
constexpr int kLinearIterations = 3;
constexpr int64_t kDenseNodes = 200;  // of the coarsest level: little memory

/// The constraints of a scene.
Array<uint8_t> pins_of(const Scene& scene) {
  Array<uint8_t> fixed(scene.grid.node_count(), 3);
  for (int64_t n = 0; n < fixed.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      fixed(n, d) =
          scene.pinned(n) != kFreeNode || (!scene.fixed.empty() && scene.fixed(n, d) >= 0);
  return fixed;
}

/// Time step beside which the inertia of a body counts for nothing [s].
double endless(const Scene& scene) {
  double slowest = 0;  // s / m
  for (const Material& m : scene.materials)
    slowest = std::max(slowest, std::sqrt(m.density / m.young));
  const Array<double>& X = scene.grid.rest;
  double reach = 0;
  for (int64_t k = 0; k < X.size(); ++k)
    reach = std::max(reach, std::abs(X.data()[k] - X.data()[k % 3]));
  return 1e4 * reach * slowest;
}

StepScheme still_scheme() {
  return {TimeScheme::kEuler, std::numeric_limits<double>::infinity(), 1};
}

}  // namespace

MeshNumber::MeshNumber(const Scene& scene, double interval, const Array<uint8_t>& fixed)
    : scene_(scene),
      fixed_(fixed),
      coarse_(coarse_scene(scene, fixed, interval > 0 ? interval : endless(scene))),
      pieces_(coarse_.scene),
      potential_(scene),
      coarse_potential_(PotentialTerms(
          coarse_.scene, {}, {TimeScheme::kBdf2, coarse_.scene.dt, interval > 0 ? 2.25 : 1})),
      preconditioner_(coarse_potential_, {true, 5}, kDenseNodes),
      pcg_(3 * coarse_.scene.grid.node_count()),
      moves_(interval > 0),
      u_(size_t(3 * scene.grid.node_count())),
      forces_(u_.size()),
      uc_(size_t(3 * coarse_.scene.grid.node_count())),
      before_(uc_.size()),
      defect_(uc_.size()),
      d_(uc_.size()),
      v_(uc_.size()),
      d_before_(uc_.size()),
      v_before_(uc_.size()),
      start_(uc_.size()),
      xc_(coarse_.scene.grid.node_count(), 3),
      right_(uc_.size()),
      step_(uc_.size()) {}

MeshNumber::MeshNumber(const Scene& scene, double interval)
    : MeshNumber(scene, interval, pins_of(scene)) {}

void MeshNumber::begin(In<double> x) {
  for (Zeroed<double>* values : {&d_, &v_, &d_before_, &v_before_})
    std::fill(values->begin(), values->end(), 0);
  last_interval_ = 0;
  for_each(x.size(), [&](int64_t k) { u_[size_t(k)] = x.data[k] - scene_.grid.rest.data()[k]; });
  coarse_.fit.apply(u_.data(), uc_.data());
}

MeshError MeshNumber::estimate(In<double> x, double interval, const Embedding& points) {
  before_.swap(uc_);
  find_defect(x);
  take_rigid(defect_, Rigid::kForces);
  if (moves_) turn();
  solve(interval);
  if (moves_) {
    take_rigid(d_, Rigid::kMotion);
    take_rigid(v_, Rigid::kMotion);
  }
  return judge(points);
}

/// t, and the positions of 2h.
void MeshNumber::find_defect(In<double> x) {
  // the forces of h
  for_each(x.size(), [&](int64_t k) { u_[size_t(k)] = x.data[k] - scene_.grid.rest.data()[k]; });
  potential_.begin_still(x, still_scheme());
  least_j_ = potential_.voxel_forces(u_.data(), forces_.data()).min_j;
  for_each(x.size(), [&](int64_t k) {
    if (fixed_.data()[k]) forces_[size_t(k)] = 0;
  });
  restrict_sum(coarse_.transfer, 3, forces_.data(), defect_.data());
  // those of 2h
  coarse_.fit.apply(u_.data(), uc_.data());
  const Array<double>& X = coarse_.scene.grid.rest;
  for_each(X.size(), [&](int64_t k) { xc_.data()[k] = X.data()[k] + uc_[size_t(k)]; });
  coarse_potential_.begin_still(xc_, still_scheme());
  coarse_potential_.voxel_forces(uc_.data(), start_.data());
  for_each(X.size(), [&](int64_t k) {
    double& t = defect_[size_t(k)];
    t = coarse_.fixed.data()[k] ? 0 : t - start_[size_t(k)];
  });
}

/// The motion that a rigid body of a piece's masses has of the forces f at its nodes.
template <class Force>
MeshNumber::RigidPart MeshNumber::rigid_part(size_t piece, const Force& f) const {
  const auto at = [&](int64_t n) -> Vec3 { return {xc_(n, 0), xc_(n, 1), xc_(n, 2)}; };
  const auto mass = [&](int64_t n) { return coarse_.scene.mass(n); };
  // mass, centre and resultant
  const auto first = pieces_.sum<7>(piece, [&](int64_t n, auto& sum) {
    sum[0] += mass(n);
    for (size_t d = 0; d < 3; ++d) {
      sum[1 + d] += mass(n) * at(n)[d];
      sum[4 + d] += f(n)[d];
    }
  });
  RigidPart part;
  part.centre = scaled({first[1], first[2], first[3]}, 1 / first[0]);
  part.push = scaled({first[4], first[5], first[6]}, 1 / first[0]);
  // moments of inertia and torque
  const auto second = pieces_.sum<12>(piece, [&](int64_t n, auto& sum) {
    const Vec3 r = minus(at(n), part.centre), torque = cross(r, f(n));
    for (size_t i = 0; i < 3; ++i) {
      for (size_t j = 0; j < 3; ++j)
        sum[3 * i + j] += mass(n) * ((i == j ? dot(r, r) : 0) - r[i] * r[j]);
      sum[9 + i] += torque[i];
    }
  });
  Mat3<double> inertia;
  std::copy_n(second.begin(), 9, inertia.m);
  part.twist = times(inverse(inertia), {second[9], second[10], second[11]});
  return part;
}

/// Takes the rigid part from a field of each free piece: from forces their resultant and torque, from
/// motions those of their momenta. Elasticity has neither on either grid; the linearisation of t and
/// the loose solve for d bring some.
void MeshNumber::take_rigid(Zeroed<double>& field, Rigid kind) {
  if (coarse_.has_rails) return;
  const auto weight = [&](int64_t n) { return kind == Rigid::kForces ? 1 : coarse_.scene.mass(n); };
  for (size_t p = 0; p < pieces_.count(); ++p) {
    if (!pieces_.is_free(p)) continue;
    const RigidPart part = rigid_part(p, [&](int64_t n) -> Vec3 {
      const double* f = &field[size_t(3 * n)];
      return scaled({f[0], f[1], f[2]}, weight(n));
    });
    if (!finite(part.twist)) continue;
    for (const int32_t n : pieces_.nodes()[p]) {
      const Vec3 r = minus({xc_(n, 0), xc_(n, 1), xc_(n, 2)}, part.centre);
      const Vec3 rigid =
          scaled(plus(part.push, cross(part.twist, r)), coarse_.scene.mass(n) / weight(n));
      for (size_t d = 0; d < 3; ++d)
        if (!coarse_.fixed(n, int(d))) field[size_t(3 * n) + d] -= rigid[d];
    }
  }
}

/// Turns d and its velocities by the rotation of each piece since the last estimate.
void MeshNumber::turn() {
  const Array<double>& X = coarse_.scene.grid.rest;
  for (size_t p = 0; p < pieces_.count(); ++p) {
    const auto mass = [&](int64_t n) { return coarse_.scene.mass(n); };
    const auto now = [&](int64_t n, int d) { return X(n, d) + uc_[size_t(3 * n + d)]; };
    const auto then = [&](int64_t n, int d) { return X(n, d) + before_[size_t(3 * n + d)]; };
    // centres of mass
    const auto centre = pieces_.sum<7>(p, [&](int64_t n, auto& sum) {
      sum[6] += mass(n);
      for (int d = 0; d < 3; ++d) {
        sum[size_t(d)] += mass(n) * now(n, d);
        sum[size_t(3 + d)] += mass(n) * then(n, d);
      }
    });
    // the rotation nearest to the moments of the two
    const auto moments = pieces_.sum<9>(p, [&](int64_t n, auto& sum) {
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          sum[size_t(3 * i + j)] += mass(n) * (now(n, i) - centre[size_t(i)] / centre[6]) *
                                    (then(n, j) - centre[size_t(3 + j)] / centre[6]);
    });
    Mat3<double> spread;
    const double size = std::abs(moments[0]) + std::abs(moments[4]) + std::abs(moments[8]);
    if (!(size > 0)) continue;
    for (size_t k = 0; k < 9; ++k) spread.m[k] = moments[k] / size;
    const Mat3<double> R = polar_rotation(spread);
    for (const int32_t n : pieces_.nodes()[p])
      for (Zeroed<double>* values : {&d_, &v_, &d_before_, &v_before_}) {
        double* value = values->data() + 3 * int64_t(n);
        const Vec3 turned = times(R, {value[0], value[1], value[2]});
        std::copy_n(turned.begin(), 3, value);
      }
  }
}

/// Zero where a component is fixed.
void MeshNumber::mask(float* values) const {
  if (!coarse_.has_rails) return;
  for_each(coarse_.fixed.size(), [&](int64_t k) {
    if (coarse_.fixed.data()[k]) values[k] = 0;
  });
}

/// The scheme of the step to the next d.
StepScheme MeshNumber::scheme_of(double interval) const {
  if (!moves_) return {TimeScheme::kEuler, coarse_.scene.dt, 1};
  if (interval == last_interval_) return {TimeScheme::kBdf2, interval, 2.25};
  return {TimeScheme::kEuler, interval, 1};
}

void MeshNumber::product(const float* p, float* Ap) {
  coarse_potential_.hessian_product(p, Ap);
  mask(Ap);
}

/// The right side for d - start of
///
///     (a0 M/dt^2 + (1 + beta) K) d = t + a0 M/dt^2 dhat + beta K start,
///
/// start being where the rate of damping is measured from; in place of t. @return its largest entry.
double MeshNumber::find_right_side(const StepScheme& scheme) {
  const auto size = int64_t(d_.size());
  const double stiffer = 1 + coarse_potential_.beta(rate_of(scheme));
  for_each(size, [&](int64_t k) {
    const auto i = size_t(k);
    start_[i] = !moves_                              ? 0
                : scheme.scheme == TimeScheme::kBdf2 ? (4 * d_[i] - d_before_[i]) / 3
                                                     : d_[i];
    step_[i] = float(start_[i]);
  });
  product(step_.data(), right_.data());
  for_each(size, [&](int64_t k) {
    const auto i = size_t(k);
    const double inertia = moves_ ? coarse_potential_.inertia(k / 3) : 0;
    const double motion = predicted_motion(scheme, d_[i], v_[i], d_before_[i], v_before_[i], 0);
    const double stiff = (double(right_[i]) - inertia * start_[i]) / stiffer;
    const double sum = defect_[i] + inertia * (d_[i] + motion - start_[i]) - stiff;
    defect_[i] = coarse_.fixed.data()[k] ? 0 : sum;
  });
  const double most = largest(size, [&](int64_t k) { return std::abs(defect_[size_t(k)]); });
  return most > 0 ? most : 1;
}

/// The next d.
void MeshNumber::solve(double interval) {
  const auto size = int64_t(d_.size());
  const StepScheme scheme = scheme_of(interval);
  coarse_potential_.begin_still(xc_, scheme);
  coarse_potential_.linearise(uc_.data());
  coarse_potential_.set_nodal_rotations(uc_.data());
  if (moves_) preconditioner_.update_inertia();
  // d - start, scaled so that float holds it
  const double most = find_right_side(scheme);
  for_each(size, [&](int64_t k) { right_[size_t(k)] = float(defect_[size_t(k)] / most); });
  pcg(
      right_.data(), step_.data(), size, kLinearTolerance, kLinearIterations, pcg_,
      [&](const float* p, float* Ap) { product(p, Ap); },
      [&](const float* r, float* z) {
        preconditioner_.apply(r, z);
        mask(z);
      });
  for_each(size, [&](int64_t k) {
    const auto i = size_t(k);
    const double next = start_[i] + most * double(step_[i]);
    const double velocity = velocity_after(scheme, next, d_[i], d_before_[i]);
    d_before_[i] = d_[i], v_before_[i] = v_[i];
    d_[i] = next, v_[i] = velocity;
  });
  last_interval_ = interval;
}

/// |d| at the points, and whether 2h may be believed.
MeshError MeshNumber::judge(const Embedding& points) {
  // d on the nodes of h, where nothing fixed moves
  prolong(coarse_.transfer, d_.data(), u_.data());
  for_each(int64_t(u_.size()), [&](int64_t k) {
    if (fixed_.data()[k]) u_[size_t(k)] = 0;
  });
  const auto square = [&](int64_t p) {
    Vec3 sum = {};
    for (int c = 0; c < 8; ++c) {
      const double* d = &u_[size_t(3 * scene_.grid.corners(points.voxel(p), c))];
      sum = plus(sum, scaled({d[0], d[1], d[2]}, points.weights(p, c)));
    }
    return dot(sum, sum);
  };
  const int64_t count = points.voxel.rows();
  MeshError error;
  error.largest = std::sqrt(largest(count, square));
  const double sum = ordered_sum(count, [&](int64_t begin, int64_t end) {
    double part = 0;
    for (int64_t p = begin; p < end; ++p) part += square(p);
    return part;
  });
  if (count > 0) error.rms = std::sqrt(sum / double(count));
  // the body of 2h
  for_each(int64_t(uc_.size()),
           [&](int64_t k) { start_[size_t(k)] = uc_[size_t(k)] + d_[size_t(k)]; });
  const double coarse_j = coarse_potential_.voxel_forces(start_.data(), defect_.data()).min_j;
  error.trusted = coarse_j >= kTrustedJ * std::min(1.0, least_j_) && std::isfinite(error.rms);
  return error;
}

}  // namespace elastogen
