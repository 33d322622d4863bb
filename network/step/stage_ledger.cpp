// SPDX-License-Identifier: Apache-2.0
// The ledger of a step of stages (core/ledger.hpp). Forces of voxels, elastic and viscous, are inner ones
// and add up to nothing: pins hold what the inertia of a piece asks for beyond its weight and contact.
#include "network/step/stages.hpp"

namespace elastogen {

/// Momentum and energy of motion; the rest of the energies is not filled.
BodyAccount Stages::account_of(const double* x, const double* v) {
  BodyAccount body;
  for (const PieceSums& of : machine_.sum(WholeMotion{at_, about_, x, v})) {
    body.momentum.add({{of[0], of[1], of[2]}, {of[3], of[4], of[5]}}, 1);
    body.energy.kinetic += of[6];
    body.energy.gravity += of[7];
  }
  return body;
}

void Stages::open_account(const double* u, double energy) {
  // angular momenta are about the centre of mass
  const std::vector<PieceMotion> pieces = means(at_.state.x, at_.state.v);
  double mass = 0;
  for (size_t p = 0; p < pieces.size(); ++p) mass += pieces_.mass(p);
  about_ = {};
  std::vector<Vec3> centres;
  for (size_t p = 0; p < pieces.size(); ++p) {
    about_ = plus(about_, scaled(pieces[p].centre, pieces_.mass(p) / mass));
    centres.push_back(pieces[p].centre);
  }
  account_ = {};
  account_.known = true;
  account_.body = account_of(at_.state.x, at_.state.v);
  const Forces contact = forces(u, at_.state.v, std::move(centres));
  account_.body.energy.elastic = energy;
  account_.body.energy.contact = contact.energy;
  account_.body.energy.bonds = contact.bonds;
}

/// What acts on the body at the end of a stage, and the power of it.
BodyActions Stages::actions(const double* x, const double* v, const Forces& contact,
                            const StageCertificate& certificate) {
  BodyActions all;
  all.damped = certificate.damping;
  kinetic_ = 0;
  const std::vector<PieceSums> sums =
      machine_.sum(StageForces{at_, about_, certificate.gradient, x, v});
  for (size_t p = 0; p < sums.size(); ++p) {
    const PieceSums& of = sums[p];
    const ContactAction& push = contact.pieces[p];
    const Vec3 arm = minus(contact.centres[p], about_),
               weight = scaled(scene_.gravity, pieces_.mass(p));
    const TwoMomenta gravity = {weight, cross(arm, weight)},
                     touch = {push.force, plus(push.torque, cross(arm, push.force))};
    all.gravity.add(gravity, 1);
    all.contact.add(touch, 1);
    all.colliders += push.driven;
    all.rubbed += push.rubbed;
    all.residual += of[6];
    kinetic_ += of[7];
    if (pieces_.is_free(p)) continue;
    all.pins.add({{of[0], of[1], of[2]}, {of[3], of[4], of[5]}}, 1);
    all.pins.add(gravity, -1);
    all.pins.add(touch, -1);
  }
  return all;
}

/// @param corrected  before the guard.
void Stages::write_ledger(const BodyActions& at_end, const BodyAccount& corrected, const double* x,
                          const double* v) {
  const TimeStage& s = at_.stage;
  ledger_ = {};
  ledger_.known = account_.known;
  ledger_.about = about_;
  ledger_.start = account_.body;
  // what was done; in a step before that is not known forces were those of this one
  BodyActions before = account_.done;
  if (s.t_b < 0 && !account_.has_step) before.add(at_end, -s.t_b);
  ledger_.done = done_in_step(s, actions_first_, at_end, before);
  // what the guard changed; BDF2 goes on with a share of what it changed in the step before
  if (s.t_b < 0) ledger_.guarded.add(account_.guarded, -s.w_d);
  ledger_.end = corrected;
  if (guarded_) {
    ledger_.end = account_of(x, v);
    ledger_.guarded.add(ledger_.end.momentum, 1);
    ledger_.guarded.add(corrected.momentum, -1);
    ledger_.guard = corrected.energy.kinetic - ledger_.end.energy.kinetic;
  }
  ledger_.correction = corrected.energy.kinetic - kinetic_;
  ledger_.end.energy.elastic = voxels_end_;
  ledger_.end.energy.contact = at_end_.energy;
  ledger_.end.energy.bonds = at_end_.bonds;
  account_next_ = {true, true, ledger_.end, ledger_.done, ledger_.guarded};
}

}  // namespace elastogen
