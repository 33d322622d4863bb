// SPDX-License-Identifier: Apache-2.0
// Momentum and energy of the pieces at the end of a step of stages.
#include "mpm_fem/integrators/stage_fem.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr double kMayRise = 1e-4;  // energy, of the weight times the size

void add_force(const Vec3& force, const Vec3& arm, Load& load) {
  load.force = plus(load.force, force);
  load.torque = plus(load.torque, cross(arm, force));
}

}  // namespace

/// What colliders and loads do to the pieces at the end of a stage, u.
Loads StageFem::actions_at(const Array<double>& u) {
  const std::vector<PieceMotion> at = pieces_.motions(u, u);  // for their centres
  Loads result;
  result.pieces.resize(pieces_.count());
  for (const PieceMotion& piece : at) result.centres.push_back(piece.centre);
  // colliders
  if (terms_.contact.exists())
    for (const PointForce& f : terms_.contact.forces(u, now_->v, motion_.velocities(u))) {
      const size_t p = pieces_.of(f.node);
      PieceLoad& load = result.pieces[p];
      add_force(f.force, minus(f.place, at[p].centre), load.contact);
      load.push += f.push;
      load.closing += f.push * f.closing;
      result.contact_energy += f.energy;
      result.bond_energy += f.bond;
      result.rubbed += f.rubbed;
      result.driven += f.driven;
    }
  for (PieceLoad& load : result.pieces)
    if (load.push > 0) load.closing = std::abs(load.closing) / load.push;
  // loads
  for (int64_t n = 0; n < u.rows(); ++n) {
    const Vec3 place = plus(row_of(scene_.mesh.rest, n), row_of(u, n));
    const size_t p = pieces_.of(n);
    add_force(row_of(applied_.force(), n), minus(place, at[p].centre), result.pieces[p].applied);
  }
  return result;
}

/// The piece at the end of the step with the velocity and the angular momentum that the scheme gives
/// it.
PieceMotion StageFem::aim(size_t p, const PieceMotion& end) const {
  const TimeStage& s = motion_.stage();
  const PieceMotion& now = motion_.now()[p];
  const double m = pieces_.mass(p);
  PieceMotion result = end;
  result.velocity = now.velocity;
  result.spin = now.spin;
  const auto add = [&](const Loads& loads, double time) {
    const PieceLoad& load = loads.pieces[p];
    const Vec3 force = plus(load.contact.force, load.applied.force),
               torque = plus(load.contact.torque, load.applied.torque);
    result.velocity = plus(result.velocity, scaled(force, time / m));
    result.spin = plus(result.spin, scaled(torque, time));
  };
  // the step before of BDF2, then the impulses
  if (s.t_b < 0) {
    const PieceMotion& before = motion_.before()[p];
    const Vec3 dv = minus(before.velocity, now.velocity), dL = minus(before.spin, now.spin);
    result.velocity = plus(result.velocity, scaled(dv, s.w_d));
    result.spin = plus(result.spin, scaled(dL, s.w_d));
  }
  if (s.t_b > 0) add(at_stage_, s.t - s.k);
  add(at_end_, s.k);
  result.velocity = plus(result.velocity, scaled(scene_.gravity, s.t_b < 0 ? s.k : s.t));
  return result;
}

/// Adds to the velocities of each loose piece the rigid motion that it lacks.
void StageFem::correct_momentum() {
  for (int pass = 0; pass < 2; ++pass) {  // the second one takes what the first one rounded
    std::vector<PieceMotion> lack = pieces_.motions(u_, v_);
    for (size_t p = 0; p < pieces_.count(); ++p) {
      const PieceMotion wanted = aim(p, lack[p]);
      lack[p].velocity = minus(wanted.velocity, lack[p].velocity);
      lack[p].spin = minus(wanted.spin, lack[p].spin);
    }
    const Array<double> change = pieces_.rigid_part(u_, lack);
    for (int64_t k = 0; k < v_.size(); ++k) v_.data()[k] += change.data()[k];
  }
}

bool StageFem::touched(size_t piece) const {
  const StageHistory& history = now_->stages;
  for (const Loads* loads : {&history.before, &history.now, &at_stage_, &at_end_})
    if (!loads->pieces.empty() && loads->pieces[piece].push > 0) return true;
  return false;
}

bool StageFem::touched() const {
  for (size_t p = 0; p < pieces_.count(); ++p)
    if (touched(p)) return true;
  return false;
}

/// Takes q D from the velocities, q of [0, 1] the least share that takes the energy `rise` from
/// them. @return what is left of it
double StageFem::take_energy(const Array<double>& D, double rise) {
  // the energy taken is q b - q^2 a
  const double a = pieces_.product(D, D) / 2, b = pieces_.product(D, v_);
  if (!(a > 0 && b > 0)) return rise;
  const double best = std::min(b / (2 * a), 1.0), most = best * (b - best * a);
  const bool enough = most > rise;
  const double q = enough ? (b - std::sqrt(std::max(0.0, b * b - 4 * a * rise))) / (2 * a) : best;
  for (int64_t k = 0; k < v_.size(); ++k) v_.data()[k] -= q * D.data()[k];
  return enough ? 0 : rise - most;
}

/// Where contact lets the energy of the body rise, it is taken from the velocities relative to the
/// references: from their rigid part, the change that contact brought, and where that does not
/// suffice from the rest. False where both do not.
bool StageFem::guard(double elastic_energy) {
  guarded_ = false;
  const StageHistory& history = now_->stages;
  if (history.now.pieces.empty() || is_driven_ || !touched()) return true;
  // the rise of kinetic, elastic, contact energy and that of gravity
  double allowed = 0;
  for (size_t p = 0; p < pieces_.count(); ++p)
    allowed += kMayRise * pieces_.mass(p) * safe_norm(scene_.gravity) * pieces_.size(p);
  double rise = (pieces_.product(v_, v_) - pieces_.product(now_->v, now_->v)) / 2 + elastic_energy -
                history.elastic_energy + at_end_.contact_energy - history.now.contact_energy;
  for (int64_t k = 0; k < u_.size(); ++k)
    rise -= solve_.weight().data()[k] * (u_.data()[k] - now_->u.data()[k]);
  guarded_ = rise > allowed;
  if (!guarded_) return true;
  // the rigid part, then what else loose pieces have
  const Array<double> e = motion_.relative(v_);
  const Array<double> rigid = pieces_.rigid_part(u_, pieces_.motions(u_, e));
  double left = take_energy(rigid, rise);
  if (left <= allowed) return true;
  const Array<double> now = motion_.relative(v_);
  Array<double> rest = pieces_.rigid_part(u_, pieces_.motions(u_, now));
  for (int64_t n = 0; n < rest.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      rest(n, d) = pieces_.is_loose(pieces_.of(n)) ? now(n, d) - rest(n, d) : 0;
  left = take_energy(rest, left);
  return left <= allowed;
}

}  // namespace elastogen::fem
