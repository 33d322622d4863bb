// SPDX-License-Identifier: Apache-2.0
// The ledger of a step of stages (core/ledger.hpp). What the gradient of Phi has at prescribed components
// are the forces that hold or move them, what it has at the others was left by the solver. Forces on
// dependent nodes are with the former, as the opposite of their part is with their parent nodes.
#include "core/reduce.hpp"
#include "mpm_fem/integrators/stage_fem.hpp"

namespace elastogen::fem {
namespace {

constexpr double kNoTime = 1e-9;  // of dt: a step that stands for none

}  // namespace

/// Momentum, kinetic energy and that of gravity.
BodyAccount StageFem::account_of(const Array<double>& u, const Array<double>& v) const {
  BodyAccount body;
  Array<double> Mv(v.rows(), 3);
  potential_.mass().multiply(v.data(), Mv.data());
  for (int64_t n = 0; n < v.rows(); ++n) {
    const Vec3 place = plus(row_of(scene_.mesh.rest, n), row_of(u, n)), momentum = row_of(Mv, n);
    body.momentum.add({momentum, cross(minus(place, ledger_before_.about), momentum)}, 1);
    body.energy.kinetic += elastogen::dot(momentum, row_of(v, n)) / 2;
    body.energy.gravity -= elastogen::dot(row_of(solve_.weight(), n), place);
  }
  return body;
}

/// Takes the ledger of the step before, or opens one with the energies at the start of this.
void StageFem::open_ledger() {
  ledger_before_ = now_->stages.ledger;
  if (ledger_before_.known) return;
  ledger_before_.known = ledger_before_.opens = true;
  // angular momenta are about the centre of mass
  double mass = 0;
  for (size_t p = 0; p < pieces_.count(); ++p) mass += pieces_.mass(p);
  for (size_t p = 0; p < pieces_.count(); ++p)
    ledger_before_.about =
        plus(ledger_before_.about, scaled(motion_.now()[p].centre, pieces_.mass(p) / mass));
  // the energies
  BodyAccount& at = ledger_before_.end;
  at = account_of(now_->u, now_->v);
  const EnergyParts energy = terms_.energy(now_->u);
  at.energy.elastic = energy.elastic + energy.hourglass;
  if (!terms_.contact.exists()) return;
  terms_.contact.begin_stage(now_->u, now_->time, kNoTime * scene_.dt, now_->u, now_->time,
                             now_->stages.bonds);
  for (const PointForce& f : terms_.contact.forces(now_->u, now_->v, now_->v)) {
    at.energy.contact += f.energy;
    at.energy.bonds += f.bond;
  }
}

/// What acts on the body at the end of a stage, u_, and the power of it at velocities v.
BodyActions StageFem::actions(const Array<double>& v, const Loads& loads) {
  BodyActions all;
  Array<double> g(u_.rows(), 3);
  potential_.full_gradient(u_.data(), g.data());
  Array<double> rest = g;
  potential_.restrict(rest.data());
  const auto with_moment = [&](const Vec3& force, const Vec3& place) -> TwoMomenta {
    return {force, cross(minus(place, ledger_before_.about), force)};
  };
  // what acts on nodes
  for (int64_t n = 0; n < u_.rows(); ++n) {
    const Vec3 place = plus(row_of(scene_.mesh.rest, n), row_of(u_, n)), speed = row_of(v, n);
    const Vec3 left = row_of(rest, n), pin = minus(row_of(g, n), left);
    all.gravity.add(with_moment(row_of(solve_.weight(), n), place), 1);
    all.loads.add(with_moment(row_of(applied_.force(), n), place), 1);
    all.pins.add(with_moment(pin, place), 1);
    all.moved += elastogen::dot(pin, speed);
    all.loaded += elastogen::dot(row_of(applied_.force(), n), speed);
    all.residual += elastogen::dot(left, speed);
  }
  // contact, and what damping takes
  for (size_t p = 0; p < pieces_.count(); ++p) {
    const Load& contact = loads.pieces[p].contact;
    all.contact.add(with_moment(contact.force, loads.centres[p]), 1);
    all.contact.angular = plus(all.contact.angular, contact.torque);
  }
  all.colliders = loads.driven;
  all.rubbed = loads.rubbed;
  all.damped = terms_.damping_power(u_);
  return all;
}

/// Ends the ledger of the step.
void StageFem::write_ledger(FemStepReport& report) {
  Array<double> ones(u_.rows(), 3), M1(u_.rows(), 3), mass(u_.rows());
  ones.fill(1);
  potential_.mass().multiply(ones.data(), M1.data());
  for (int64_t n = 0; n < mass.rows(); ++n) mass(n) = M1(n, 0);
  booking_.of_reference = motion_.gain_of_references(ledger_before_.about, mass);
  booking_.end = guarded_ ? account_of(u_, v_) : booking_.corrected;
  booking_.end.energy.elastic = report.energy.elastic + report.energy.hourglass;
  booking_.end.energy.contact = at_end_.contact_energy;
  booking_.end.energy.bonds = at_end_.bond_energy;
  report.ledger = step_ledger(ledger_before_, motion_.stage(), booking_);
  report.damped = report.ledger.done.damped;
}

}  // namespace elastogen::fem
