// SPDX-License-Identifier: Apache-2.0
#include "cli/ledger_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// What is far below a scale is 0.
double figure(double value, double scale) {
  return std::abs(value) < 1e-6 * scale ? 0 : value;
}

/// A line for what took energy, or brought it. Nothing where that is 0.
std::string energy_line(const char* what, double value, double scale) {
  if (std::abs(value) < 1e-6 * scale) return {};
  return fmt::format("  {:<34}{:>10.4g}\n", what, value);
}

/// A vector and its name. Nothing where it is 0.
std::string impulse(const char* name, const Vec3& value, double scale) {
  if (safe_norm(value) < 1e-6 * scale) return {};
  return fmt::format("  {:<10}{:>10.4g}{:>10.4g}{:>10.4g}\n", name, figure(value[0], scale),
                     figure(value[1], scale), figure(value[2], scale));
}

/// Shares of what is large: slow work of moves and loads has hardly any kinetic energy.
std::string share_line(const Ledger& ledger) {
  const StepLedger& sum = ledger.sum;
  const double work = std::abs(sum.work()), whole = std::max(ledger.kinetic, work);
  if (!(whole > 0)) return {};
  return fmt::format(
      "  of {}, {:.4g} J: the scheme {:.2g} %, the solver's residual {:.1g} %, the correction of "
      "momentum {:.1g} %\n",
      work > ledger.kinetic ? "the work from outside" : "the largest kinetic energy", whole,
      100 * sum.numerical() / whole, 100 * sum.done.residual / whole, 100 * sum.correction / whole);
}

}  // namespace

std::string ledger_lines(const Ledger& ledger) {
  if (ledger.steps == 0) return {};
  const StepLedger& sum = ledger.sum;
  const BodyEnergies &start = sum.start.energy, &end = sum.end.energy;
  // energy, without what is nothing beside its largest changes
  const double scale = std::max({ledger.kinetic, std::abs(end.total() - start.total()), 1e-300});
  std::string text = fmt::format(
      "energy [J]: {:.4g} at the start, {:.4g} at the end (kinetic {:.4g}, elastic {:.4g}, gravity "
      "{:.4g}, contact {:.4g})\n",
      figure(start.total(), scale), figure(end.total(), scale), figure(end.kinetic, scale),
      figure(end.elastic, scale), figure(end.gravity, scale),
      figure(end.contact + end.bonds, scale));
  text += energy_line("brought by colliders that move", sum.done.colliders, scale);
  text += energy_line("brought by pins that move", sum.done.moved, scale);
  text += energy_line("brought by loads", sum.done.loaded, scale);
  text += energy_line("taken by damping", sum.done.damped, scale);
  text += energy_line("taken by friction", sum.friction(), scale);
  text += energy_line("taken by the guard of contact", sum.guard, scale);
  text += energy_line("lost by the time scheme", sum.numerical(), scale);
  text += share_line(ledger);
  // momentum; a body that it moves at a million metres a second has none
  const double largest = std::max(ledger.linear, 1e-6 * ledger.kinetic);
  text += "momentum [N s]:\n";
  text += impulse("start", sum.start.momentum.linear, largest);
  text += impulse("gravity", sum.done.gravity.linear, largest);
  text += impulse("contact", sum.done.contact.linear, largest);
  text += impulse("pins", sum.done.pins.linear, largest);
  text += impulse("loads", sum.done.loads.linear, largest);
  text += impulse("guard", sum.guarded.linear, largest);
  text += impulse("end", sum.end.momentum.linear, largest);
  text += fmt::format("  not accounted for: {:.1e} in a step at most\n", ledger.linear_gap);
  return text;
}

}  // namespace elastogen
