// SPDX-License-Identifier: Apache-2.0
#include "network/step/host_stages.hpp"

#include "core/reduce.hpp"

#include <algorithm>

namespace elastogen {

HostStages::HostStages(IncrementalPotential& potential)
    : scene_(potential.scene()), potential_(potential), pieces_(scene_) {
  motion_.resize(3 * size_t(scene_.grid.node_count()));
  moving_colliders_ = std::any_of(scene_.colliders.begin(), scene_.colliders.end(),
                                  [](const Collider& c) { return c.path.size() > 1; });
  forget();
}

void HostStages::forget() {
  at_start_ = at_before_ = {};
  speed_.assign(pieces_.count(), 0);
  closing_.assign(pieces_.count(), 0);
  turn_.assign(pieces_.count(), {});
  turn_last_ = turn_;
  gain_.assign(pieces_.count(), 0);
  h_last_ = 0;
}

Vec3 HostStages::d_b(int64_t n) const {
  const Vec3 x = vector(scheme_.stage.t_b > 0 ? x_a_ : state_->x_before, n);
  return minus(minus(x, x0(n)), reference_motion(other_[piece(n)], x0(n)));
}

Vec3 HostStages::e_b(int64_t n) const {
  if (scheme_.stage.t_b > 0) return scaled(d_b(n), 1 / scheme_.stage.t_b);  // k of the first stage
  return minus(vector(state_->v_before, n), reference_velocity(other_[piece(n)], x0(n)));
}

void HostStages::set_poses(double t, std::vector<RigidPose>& poses) const {
  poses.resize(pieces_.count());
  for (size_t p = 0; p < pieces_.count(); ++p)
    poses[p] = pieces_.is_free(p) ? pose_at(motions_[p], t)
                                  : turned_about(pieces_.pins(p), turn_[p], gain_[p], t);
}

/// The turn of a piece about its pins, which goes on as it changed in the last step.
void HostStages::turn_about_pins(size_t p) {
  turn_[p] = spin_about(now_[p], pieces_.mass(p), pieces_.pins(p));
  const double rate = safe_norm(turn_[p]);
  gain_[p] = 0;
  if (h_last_ > 0 && rate > 0)
    gain_[p] = dot(minus(turn_[p], turn_last_[p]), turn_[p]) / (rate * h_last_);
}

/// xhat - x0.
Vec3 HostStages::predicted(int64_t n) const {
  const TimeStage& s = scheme_.stage;
  const RigidPose& pose = end_[piece(n)];
  Vec3 motion = plus(reference_motion(pose, x0(n)), scaled(e0(n), s.w_0));
  const Vec3 pull = minus(scene_.gravity, reference_acceleration(pose, x0(n)));
  motion = plus(motion, scaled(pull, s.k * s.k));
  if (s.w_d != 0) motion = plus(motion, scaled(d_b(n), s.w_d));
  if (s.w_e != 0) motion = plus(motion, scaled(e_b(n), s.w_e));
  return motion;
}

void HostStages::begin(const State& state, const StepScheme& scheme) {
  const double t_b = scheme.stage.t_b;
  scheme_ = scheme;
  if (t_b > 0) {  // the second stage: the first one is the other point
    other_.swap(end_);
  } else {
    state_ = &state;
    at_stage_ = {};
    now_.resize(pieces_.count());
    before_.resize(pieces_.count());
    motions_.assign(pieces_.count(), {});
    for (size_t p = 0; p < pieces_.count(); ++p) {
      now_[p] = pieces_.state(
          p, [&](int64_t n) { return x0(n); }, [&](int64_t n) { return v0(n); });
      if (!pieces_.is_free(p)) {
        turn_about_pins(p);
        continue;
      }
      motions_[p] = rigid_motion(now_[p]);
      if (t_b < 0)
        before_[p] = pieces_.state(
            p, [&](int64_t n) { return vector(state_->x_before, n); },
            [&](int64_t n) { return vector(state_->v_before, n); });
    }
    set_poses(0, start_);
    if (t_b < 0) set_poses(t_b, other_);
  }
  // the reference at the stage, and the predictor
  set_poses(scheme.stage.t, end_);
  for_each(scene_.grid.node_count(), [&](int64_t n) {
    const Vec3 motion = predicted(n);
    for (size_t d = 0; d < 3; ++d) motion_[3 * size_t(n) + d] = motion[d];
  });
}

void HostStages::start(int order, double* u) const {
  const TimeStage& s = scheme_.stage;
  const Array<double>& X = scene_.grid.rest;
  for_each(X.rows(), [&](int64_t n) {
    Vec3 motion = {};
    if (!scene_.pinned(n) && order == 0) {
      for (size_t d = 0; d < 3; ++d) motion[d] = motion_[3 * size_t(n) + d];
      const Vec3 turning = reference_acceleration(end_[piece(n)], x0(n));
      motion = plus(motion, scaled(turning, s.k * s.k));
    } else if (!scene_.pinned(n)) {
      motion = plus(reference_motion(end_[piece(n)], x0(n)), scaled(e0(n), s.t));
      if (order == 2) {
        const Vec3 bend = s.t_b > 0
                              ? scaled(minus(d_b(n), scaled(e0(n), s.t_b)), 1 / (s.t_b * s.t_b))
                              : scaled(minus(e0(n), e_b(n)), -0.5 / s.t_b);
        motion = plus(motion, scaled(bend, s.t * s.t));
      }
    }
    for (int d = 0; d < 3; ++d) u[3 * n + d] = state_->x(n, d) - X(n, d) + motion[size_t(d)];
  });
}

/// Contact at u, with torques about the centres of the pieces.
HostStages::Forces HostStages::forces(const double* u, const std::vector<PieceState>& pieces) {
  Forces f;
  f.known = true;
  f.pieces.resize(pieces.size());
  if (!potential_.contact().exists()) return f;
  std::vector<Vec3> centres(pieces.size());
  for (size_t p = 0; p < pieces.size(); ++p) centres[p] = pieces[p].centre;
  f.energy = potential_.contact().act(u, state_->v.data(), centres, f.pieces);
  return f;
}

void HostStages::keep_stage(const double* u) {
  const Array<double>& X = scene_.grid.rest;
  if (x_a_.empty()) x_a_ = X;
  for_each(X.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) x_a_(n, d) = X(n, d) + u[3 * n + d];
  });
  if (!potential_.contact().exists()) {
    at_stage_ = forces(u, now_);
    return;
  }
  std::vector<PieceState> at(pieces_.count());
  for (size_t p = 0; p < at.size(); ++p)
    at[p] = pieces_.state(
        p, [&](int64_t n) { return vector(x_a_, n); }, [](int64_t) { return Vec3{}; });
  at_stage_ = forces(u, at);
}

/// Velocity and angular momentum that the scheme gives a free piece at the end of the step.
PieceState HostStages::aim(size_t p, const PieceState& end) const {
  const TimeStage& s = scheme_.stage;
  const ContactAction& f = at_end_.pieces[p];
  const double per_mass = 1 / pieces_.mass(p);
  PieceState result = end;
  for (size_t i = 0; i < 3; ++i) {
    double velocity = now_[p].velocity[i], spin = now_[p].spin[i], gravity = s.t;
    if (s.t_b < 0) {
      velocity += s.w_d * (before_[p].velocity[i] - velocity);
      spin += s.w_d * (before_[p].spin[i] - spin);
      gravity = s.k;
    }
    velocity += s.k * f.force[i] * per_mass + gravity * scene_.gravity[i];
    spin += s.k * f.torque[i];
    if (s.t_b > 0) {
      const ContactAction& a = at_stage_.pieces[p];
      velocity += (s.t - s.k) * a.force[i] * per_mass;
      spin += (s.t - s.k) * a.torque[i];
    }
    result.velocity[i] = velocity;
    result.spin[i] = spin;
  }
  return result;
}

void HostStages::correct_momentum(const Array<double>& x, Array<double>& v) {
  for (size_t p = 0; p < pieces_.count(); ++p) {
    if (!pieces_.is_free(p)) continue;
    for (int pass = 0; pass < 2; ++pass) {  // the second one takes what the first one rounded
      const PieceState end = pieces_.state(
          p, [&](int64_t n) { return vector(x, n); }, [&](int64_t n) { return vector(v, n); });
      const PieceState wanted = aim(p, end);
      const Vec3 shift = minus(wanted.velocity, end.velocity);
      const Vec3 turn = times(rigid_motion(end).per_inertia, minus(wanted.spin, end.spin));
      pieces_.for_each(p, [&](int64_t n) {
        const Vec3 change = plus(shift, cross(turn, minus(vector(x, n), end.centre)));
        for (int d = 0; d < 3; ++d) v(n, d) += change[size_t(d)];
      });
    }
  }
}

/// Kinetic energy and that of gravity [J].
double HostStages::mechanical_energy(const Array<double>& x, const Array<double>& v) const {
  return ordered_sum(x.rows(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t n = begin; n < end; ++n) {
      const Vec3 speed = vector(v, n);
      sum += scene_.mass(n) * (dot(speed, speed) / 2 - dot(scene_.gravity, vector(x, n)));
    }
    return sum;
  });
}

bool HostStages::touched() const {
  for (const Forces* f : {&at_start_, &at_before_, &at_stage_, &at_end_})
    for (const ContactAction& piece : f->pieces)
      if (piece.normal > 0) return true;
  return false;
}

/// The rigid part of the velocities of free pieces relative to their references, or what is left of
/// them without it, by node; 0 for the others.
Array<double> HostStages::relative_velocities(const Array<double>& x, const Array<double>& v,
                                              bool rigid) const {
  Array<double> D(x.rows(), 3);
  for (size_t p = 0; p < pieces_.count(); ++p) {
    if (!pieces_.is_free(p)) continue;
    const PieceState relative = pieces_.state(
        p, [&](int64_t n) { return vector(x, n); }, [&](int64_t n) { return e1(n, v); });
    const Vec3 w = times(rigid_motion(relative).per_inertia, relative.spin);
    pieces_.for_each(p, [&](int64_t n) {
      Vec3 part = plus(relative.velocity, cross(w, minus(vector(x, n), relative.centre)));
      if (!rigid) part = minus(e1(n, v), part);
      for (int d = 0; d < 3; ++d) D(n, d) = part[size_t(d)];
    });
  }
  return D;
}

/// Takes q D from the velocities, q of [0, 1] the least share that takes the energy `rise` from
/// them. @return what is left of it.
double HostStages::take_energy(const Array<double>& D, double rise, Array<double>& v) const {
  // the energy taken is q b - q^2 a
  double a = 0, b = 0;
  for (int64_t n = 0; n < v.rows(); ++n) {
    const Vec3 part = vector(D, n);
    a += scene_.mass(n) / 2 * dot(part, part);
    b += scene_.mass(n) * dot(part, vector(v, n));
  }
  if (!(a > 0 && b > 0)) return rise;
  const double best = std::min(b / (2 * a), 1.0), most = best * (b - best * a);
  const double q =
      most > rise ? (b - std::sqrt(std::max(0.0, b * b - 4 * a * rise))) / (2 * a) : best;
  add_scaled(-q, D.data(), v.data(), v.size());
  return most > rise ? 0 : rise - most;
}

/// Where contact lets the energy of the body rise, it is taken from the rigid part of the velocities
/// relative to the references, the change that contact brought; where that does not suffice (it
/// slows the body down) from the rest, the vibrations, which leaves momentum as it is.
bool HostStages::guard(const Array<double>& x, double energy, Array<double>& v) {
  voxels_end_ = energy;
  guarded_ = false;
  if (!at_start_.known || moving_colliders_ || !touched()) return true;
  double allowed = 0;
  for (size_t p = 0; p < pieces_.count(); ++p)
    allowed += 1e-4 * pieces_.mass(p) * safe_norm(scene_.gravity) * pieces_.size(p);
  const double end = mechanical_energy(x, v) + voxels_end_ + at_end_.energy;
  const double rise =
      end - mechanical_energy(state_->x, state_->v) - voxels_start_ - at_start_.energy;
  guarded_ = rise > allowed;
  if (!guarded_) return true;
  double left = take_energy(relative_velocities(x, v, true), rise, v);
  if (left > allowed) left = take_energy(relative_velocities(x, v, false), left, v);
  return left <= allowed;
}

bool HostStages::end_step(const Array<double>& x, const double* u, double energy,
                          Array<double>& v) {
  const TimeStage& s = scheme_.stage;
  v = Array<double>(x.rows(), 3);
  for_each(x.rows(), [&](int64_t n) {
    Vec3 speed = {};
    if (!scene_.pinned(n)) {
      const RigidPose& pose = end_[piece(n)];
      Vec3 d = minus(minus(vector(x, n), x0(n)), reference_motion(pose, x0(n)));
      if (s.w_v != 0) d = minus(d, scaled(d_b(n), s.w_v));
      speed = plus(reference_velocity(pose, x0(n)), scaled(d, 1 / s.k));
    }
    for (int d = 0; d < 3; ++d) v(n, d) = speed[size_t(d)];
  });
  last_.resize(pieces_.count());
  for (size_t p = 0; p < pieces_.count(); ++p)
    last_[p] = pieces_.state(
        p, [&](int64_t n) { return vector(x, n); }, [&](int64_t n) { return vector(v, n); });
  at_end_ = forces(u, last_);
  correct_momentum(x, v);
  return guard(x, energy, v);
}

void HostStages::accept() {
  at_before_ = std::move(at_start_);
  at_start_ = std::move(at_end_);
  voxels_start_ = voxels_end_;
  turn_last_ = turn_;
  h_last_ = scheme_.end();
  speed_ = speed_next_;
  closing_ = closing_next_;
}

}  // namespace elastogen
