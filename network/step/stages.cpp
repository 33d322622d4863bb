// SPDX-License-Identifier: Apache-2.0
#include "network/step/stages.hpp"

#include <algorithm>

namespace elastogen {
namespace {

template <class Piece>
std::vector<Vec3> centres_of(const std::vector<Piece>& pieces) {
  std::vector<Vec3> centres;
  for (const Piece& piece : pieces) centres.push_back(piece.centre);
  return centres;
}

}  // namespace

Stages::Stages(StageMachine& machine)
    : machine_(machine), scene_(machine.scene()), pieces_(machine.pieces()), at_(machine.nodes()) {
  holders_move_ = std::ranges::any_of(scene_.holders, [](auto& h) { return h.moves(); });
  is_driven_ = has_loads(scene_) ||
               std::ranges::any_of(scene_.colliders, [](auto& c) { return c.path.moves(); }) ||
               holders_move_;
  poses_.resize(pieces_.count());
  for (size_t p = 0; p < pieces_.count(); ++p) poses_[p].is_loose = pieces_.is_loose(p);
  forget();
}

void Stages::forget() {
  at_start_ = at_before_ = {};
  speed_.assign(pieces_.count(), 0);
  spin_.assign(pieces_.count(), 0);
  closing_.assign(pieces_.count(), 0);
  struck_.assign(pieces_.count(), {});
  turn_.assign(pieces_.count(), {});
  turn_last_ = turn_;
  gain_.assign(pieces_.count(), 0);
  h_last_ = 0;
  known_time_ = -1e300;
  ledger_before_ = {};
}

/// Centres of mass at positions x, and their velocities; null: at rest.
std::vector<PieceMotion> Stages::means(const double* x, const double* v) {
  const std::vector<PieceSums> first = machine_.sum(FirstMoments{at_, x, v});
  std::vector<PieceMotion> about(pieces_.count());
  for (size_t p = 0; p < about.size(); ++p)
    for (size_t i = 0; i < 3; ++i) {
      about[p].centre[i] = first[p][6 + i] + first[p][i] / pieces_.mass(p);
      about[p].velocity[i] = first[p][3 + i] / pieces_.mass(p);
    }
  return about;
}

/// The pieces at positions x with velocities v; null: at rest.
std::vector<PieceState> Stages::states(const double* x, const double* v) {
  const std::vector<PieceMotion> about = means(x, v);
  std::vector<PieceState> result(pieces_.count());
  for (size_t p = 0; p < result.size(); ++p) {
    result[p].centre = about[p].centre;
    result[p].velocity = about[p].velocity;
  }
  // what is about the centres
  const PieceMotion* centres = machine_.put(about);
  const std::vector<PieceSums> second = machine_.sum(SecondMoments{at_, centres, x, v});
  for (size_t p = 0; p < result.size(); ++p)
    for (size_t i = 0; i < 3; ++i) {
      result[p].spin[i] = second[p][i];
      const auto a = int(i), b = int((i + 1) % 3);
      Mat3<double>& I = result[p].inertia;
      I(a, a) = second[p][3 + (i + 1) % 3] + second[p][3 + (i + 2) % 3];
      I(a, b) = I(b, a) = -second[p][6 + i];
    }
  return result;
}

RigidPose Stages::pose(size_t p, double t) const {
  return pieces_.is_loose(p) ? pose_at(motions_[p], t)
                             : turned_about(pieces_.pins(p), turn_[p], gain_[p], t);
}

/// The turn of a piece about its pins, which goes on as it changed in the last step; none where
/// something that is held moves.
void Stages::turn_about_pins(size_t p) {
  if (holders_move_) return;
  turn_[p] = pieces_.turn_about_pins(p, now_[p]);
  const double rate = safe_norm(turn_[p]);
  gain_[p] = 0;
  if (h_last_ > 0 && rate > kStill)
    gain_[p] = dot(minus(turn_[p], turn_last_[p]), turn_[p]) / (rate * h_last_);
}

/// The pieces and their references at the start of the step and at the step before.
void Stages::take_poses() {
  const double t_b = at_.stage.t_b;
  now_ = states(at_.state.x, at_.state.v);
  if (t_b < 0) before_ = states(at_.state.x_before, at_.state.v_before);
  motions_.assign(pieces_.count(), {});
  for (size_t p = 0; p < pieces_.count(); ++p) {
    if (pieces_.is_loose(p))
      motions_[p] = pieces_.rigid_motion(p, now_[p]);
    else
      turn_about_pins(p);
    poses_[p].start = pose(p, 0);
    if (t_b < 0) poses_[p].other = pose(p, t_b);
  }
}

const double* Stages::begin(const StateArrays& state, const StepScheme& scheme) {
  at_.stage = scheme.stage;
  if (scheme.stage.t_b > 0) {  // the second stage: the first one is the other point
    for (PiecePoses& of : poses_) of.other = of.end;
  } else {
    at_.state = state;
    at_stage_ = {};
    take_poses();
  }
  // the reference at the stage, and the predictor
  for (size_t p = 0; p < poses_.size(); ++p) poses_[p].end = pose(p, scheme.stage.t);
  at_.poses = machine_.put(poses_);
  machine_.run(PredictMotion{at_, machine_.field()});
  return machine_.field();
}

void Stages::start(int order, double* u) {
  machine_.run(StartDisplacement{at_, order, machine_.field(), u});
}

/// Contact at u, where positions are x, and torques about the centres of the pieces. The field of the
/// machine gets velocities.
Stages::Forces Stages::forces(const double* u, const double* x, std::vector<Vec3> centres) {
  Forces f;
  f.known = true;
  f.centres = std::move(centres);
  f.pieces.resize(f.centres.size());
  if (at_.load) f.loads = machine_.sum(LoadForces{at_, ledger_before_.about, x});
  if (!machine_.has_contact()) return f;
  machine_.run(TakeVelocities{at_, x, machine_.field()});
  static_cast<ActionSums&>(f) = machine_.act(u, at_.state.v, machine_.field(), f.centres);
  return f;
}

/// The load on a piece, with its torque about a point.
TwoMomenta Stages::load_on(const Forces& f, size_t p, const Vec3& about) const {
  if (f.loads.empty()) return {};
  const PieceSums& of = f.loads[p];
  const Vec3 force = {of[0], of[1], of[2]}, torque = {of[3], of[4], of[5]};
  return {force, minus(torque, cross(minus(about, ledger_before_.about), force))};
}

void Stages::keep_stage(const double* u, const StageCertificate& certificate) {
  double* const x = machine_.first_stage();
  machine_.run(PlaceNodes{at_, u, x});
  at_stage_ = forces(u, x, centres_of(means(x, nullptr)));
  booking_.at_first = actions(x, at_stage_, certificate);
}

/// Velocity and angular momentum that the scheme gives a loose piece at the end of the step.
PieceState Stages::aim(size_t p, const PieceState& end) const {
  const TimeStage& s = at_.stage;
  // contact and load
  TwoMomenta f = load_on(at_end_, p, at_end_.centres[p]), first;
  f.add({at_end_.pieces[p].force, at_end_.pieces[p].torque}, 1);
  if (s.t_b > 0) {
    first = load_on(at_stage_, p, at_stage_.centres[p]);
    first.add({at_stage_.pieces[p].force, at_stage_.pieces[p].torque}, 1);
  }
  const double per_mass = 1 / pieces_.mass(p);
  PieceState result = end;
  for (size_t i = 0; i < 3; ++i) {
    double velocity = now_[p].velocity[i], spin = now_[p].spin[i], gravity = s.t;
    if (s.t_b < 0) {
      velocity += s.w_d * (before_[p].velocity[i] - velocity);
      spin += s.w_d * (before_[p].spin[i] - spin);
      gravity = s.k;
    }
    velocity += s.k * f.linear[i] * per_mass + gravity * scene_.gravity[i];
    spin += s.k * f.angular[i];
    if (s.t_b > 0) {
      velocity += (s.t - s.k) * first.linear[i] * per_mass;
      spin += (s.t - s.k) * first.angular[i];
    }
    result.velocity[i] = velocity;
    result.spin[i] = spin;
  }
  return result;
}

void Stages::correct_momentum(const double* x, double* v) {
  for (int pass = 0; pass < 2; ++pass) {  // the second one takes what the first one rounded
    const std::vector<PieceState> end = pass == 0 ? last_ : states(x, v);
    std::vector<PieceMotion> change(pieces_.count());
    for (size_t p = 0; p < pieces_.count(); ++p) {
      if (!pieces_.is_loose(p)) continue;
      const PieceState wanted = aim(p, end[p]);
      change[p].centre = end[p].centre;
      change[p].velocity = pieces_.slide(p, minus(wanted.velocity, end[p].velocity));
      change[p].turn =
          times(pieces_.rigid_motion(p, end[p]).per_inertia, minus(wanted.spin, end[p].spin));
    }
    machine_.run(AddRigidMotion{at_, machine_.put(change), 1, 1, x, v});
  }
}

bool Stages::flies_fast() const {
  for (const ContactAction& piece : at_start_.pieces)
    if (piece.normal > 0) return false;
  bool fast = false;
  for (size_t p = 0; p < pieces_.count(); ++p)
    fast |=
        pieces_.is_loose(p) && bounce_counts(safe_norm(now_[p].velocity), safe_norm(scene_.gravity),
                                             scene_.dt, pieces_.size(p));
  return fast;
}

bool Stages::touched(size_t p) const {
  for (const Forces* f : {&at_start_, &at_before_, &at_stage_, &at_end_})
    if (!f->pieces.empty() && f->pieces[p].normal > 0) return true;
  return false;
}

bool Stages::touched() const {
  for (size_t p = 0; p < pieces_.count(); ++p)
    if (touched(p)) return true;
  return false;
}

/// The rigid part of the velocities of loose pieces relative to their references, or what is left of
/// them without it, by node; 0 for the others. It is in the field of the machine.
void Stages::relative_velocities(const double* x, const double* v, bool rigid) {
  double* const D = machine_.field();
  machine_.run(RelativeVelocities{at_, v, D});
  const std::vector<PieceState> relative = states(x, D);
  std::vector<PieceMotion> part(pieces_.count());
  for (size_t p = 0; p < pieces_.count(); ++p)
    if (pieces_.is_loose(p))
      part[p] = {relative[p].centre, pieces_.slide(p, relative[p].velocity),
                 times(pieces_.rigid_motion(p, relative[p]).per_inertia, relative[p].spin)};
  const double before = rigid ? 0 : 1, share = rigid ? 1 : -1;
  machine_.run(AddRigidMotion{at_, machine_.put(part), before, share, x, D});
}

/// Takes q D from the velocities, D the field, q of [0, 1] the least share that takes the energy
/// `rise` from them. @return what is left of it.
double Stages::take_energy(double rise, double* v) {
  // the energy taken is q b - q^2 a
  double a = 0, b = 0;
  for (const PieceSums& of : machine_.sum(Products{at_, machine_.field(), v}))
    a += of[0] / 2, b += of[1];
  if (!(a > 0 && b > 0)) return rise;
  const double best = std::min(b / (2 * a), 1.0), most = best * (b - best * a);
  const double q =
      most > rise ? (b - std::sqrt(std::max(0.0, b * b - 4 * a * rise))) / (2 * a) : best;
  machine_.run(AddPart{machine_.field(), -q, v});
  return most > rise ? 0 : rise - most;
}

/// Where contact lets the energy of the body rise, it is taken from the rigid part of the velocities
/// relative to the references, the change that contact brought; where that does not suffice (it
/// slows the body down) from the rest, the vibrations, which leaves momentum as it is.
bool Stages::guard(const double* x, double energy, double* v) {
  voxels_end_ = energy;
  guarded_ = false;
  if (!at_start_.known || is_driven_ || !touched()) return true;
  double allowed = 0, rise = voxels_end_ + at_end_.energy - voxels_start_ - at_start_.energy;
  for (size_t p = 0; p < pieces_.count(); ++p)
    allowed += 1e-4 * pieces_.mass(p) * safe_norm(scene_.gravity) * pieces_.size(p);
  const std::vector<PieceSums> end = machine_.sum(MotionEnergies{at_, x, v}),
                               start = machine_.sum(MotionEnergies{at_, at_.state.x, at_.state.v});
  for (size_t p = 0; p < pieces_.count(); ++p) rise += end[p][0] - start[p][0];
  guarded_ = rise > allowed;
  if (!guarded_) return true;
  // from the rigid part, then from the rest
  double left = rise;
  for (const bool rigid : {true, false}) {
    if (!(left > allowed)) break;
    relative_velocities(x, v, rigid);
    left = take_energy(left, v);
  }
  return left <= allowed;
}

bool Stages::end_step(const double* x, const double* u, const StageCertificate& certificate,
                      double* v) {
  machine_.run(TakeVelocities{at_, x, v});
  last_ = states(x, v);
  at_end_ = forces(u, x, centres_of(last_));
  booking_.at_end = actions(x, at_end_, certificate);
  booking_.of_reference = gain_of_references();
  correct_momentum(x, v);
  booking_.corrected = account_of(x, v);
  const bool keeps_energy = guard(x, certificate.energy, v);
  // the ledger
  booking_.end = guarded_ ? account_of(x, v) : booking_.corrected;
  booking_.end.energy.elastic = certificate.energy;
  booking_.end.energy.contact = at_end_.energy;
  booking_.end.energy.bonds = at_end_.bonds;
  ledger_ = step_ledger(ledger_before_, at_.stage, booking_);
  return keeps_energy;
}

void Stages::accept(double time) {
  known_time_ = time;
  at_before_ = std::move(at_start_);
  at_start_ = std::move(at_end_);
  voxels_start_ = voxels_end_;
  turn_last_ = turn_;
  h_last_ = at_.stage.t;
  speed_ = speed_next_;
  spin_ = spin_next_;
  closing_ = closing_next_;
  struck_ = struck_next_;
  ledger_before_ = ledger_;
}

}  // namespace elastogen
