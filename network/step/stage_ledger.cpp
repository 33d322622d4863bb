// SPDX-License-Identifier: Apache-2.0
// The ledger of a step of stages (core/ledger.hpp). Forces of voxels, elastic and viscous, are inner ones
// and add up to nothing: pins hold what the inertia of a piece asks for beyond its weight and contact.
#include "network/step/stages.hpp"

namespace elastogen {

/// Momentum and energy of motion; the rest of the energies is not filled.
BodyAccount Stages::account_of(const double* x, const double* v) {
  BodyAccount body;
  for (const PieceSums& of : machine_.sum(WholeMotion{at_, ledger_before_.about, x, v})) {
    body.momentum.add({{of[0], of[1], of[2]}, {of[3], of[4], of[5]}}, 1);
    body.energy.kinetic += of[6];
    body.energy.gravity += of[7];
  }
  return body;
}

void Stages::open_ledger(const double* u, double energy) {
  // angular momenta are about the centre of mass
  StepLedger& opened = ledger_before_;
  opened = {};
  opened.known = opened.opens = true;
  std::vector<Vec3> centres;
  double mass = 0;
  for (size_t p = 0; p < pieces_.count(); ++p) mass += pieces_.mass(p);
  for (const PieceMotion& piece : means(at_.state.x, nullptr)) {
    const double share = pieces_.mass(centres.size()) / mass;
    opened.about = plus(opened.about, scaled(piece.centre, share));
    centres.push_back(piece.centre);
  }
  // the energies at the start
  opened.end = account_of(at_.state.x, at_.state.v);
  opened.end.energy.elastic = energy;
  if (!machine_.has_contact()) return;
  const ActionSums contact = machine_.act(u, at_.state.v, at_.state.v, centres);
  opened.end.energy.contact = contact.energy;
  opened.end.energy.bonds = contact.bonds;
}

/// What acts on the body at the end of a stage, and the power of it.
BodyActions Stages::actions(const double* x, const Forces& contact,
                            const StageCertificate& certificate) {
  BodyActions all;
  all.damped = certificate.damping;
  all.moved = certificate.moved;
  booking_.kinetic = 0;
  const Vec3& about = ledger_before_.about;
  const std::vector<PieceSums> sums =
      machine_.sum(StageForces{at_, about, certificate.gradient, x});
  // weight and contact of each piece, then what its pins hold beside them
  for (size_t p = 0; p < sums.size(); ++p) {
    const PieceSums& of = sums[p];
    const ContactAction& push = contact.pieces[p];
    const Vec3 arm = minus(contact.centres[p], about),
               weight = scaled(scene_.gravity, pieces_.mass(p));
    const TwoMomenta gravity = {weight, cross(arm, weight)},
                     touch = {push.force, plus(push.torque, cross(arm, push.force))};
    const TwoMomenta load = load_on(contact, p, about);
    all.gravity.add(gravity, 1);
    all.contact.add(touch, 1);
    all.loads.add(load, 1);
    if (!contact.loads.empty()) all.loaded += contact.loads[p][6];
    all.colliders += push.driven;
    all.rubbed += push.rubbed;
    all.residual += of[6];
    booking_.kinetic += of[7];
    if (pieces_.is_free(p)) continue;
    all.pins.add({{of[0], of[1], of[2]}, {of[3], of[4], of[5]}}, 1);
    all.pins.add(gravity, -1);
    all.pins.add(touch, -1);
    all.pins.add(load, -1);
  }
  return all;
}

/// Velocities of pieces with pins follow their references exactly, and the rest of their motion by the
/// weights of stages: what pins add to their momentum beyond the latter.
TwoMomenta Stages::gain_of_references() {
  TwoMomenta gain;
  bool any = false;
  for (size_t p = 0; p < pieces_.count(); ++p) any |= !pieces_.is_loose(p);
  if (!any) return gain;
  for (const PieceSums& of : machine_.sum(ReferenceGain{at_, ledger_before_.about}))
    gain.add({{of[0], of[1], of[2]}, {of[3], of[4], of[5]}}, 1);
  return gain;
}

}  // namespace elastogen
