// SPDX-License-Identifier: Apache-2.0
#include "io/ledger_json.hpp"

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

/// Momentum and impulses, linear or angular.
Json balance(const StepLedger& l, Vec3 TwoMomenta::*kind) {
  return {{"start", l.start.momentum.*kind}, {"end", l.end.momentum.*kind},
          {"gravity", l.done.gravity.*kind}, {"contact", l.done.contact.*kind},
          {"pins", l.done.pins.*kind},       {"loads", l.done.loads.*kind},
          {"guard", l.guarded.*kind},        {"unaccounted", l.gap().*kind}};
}

Json energies_of(const BodyEnergies& e) {
  return {{"kinetic", e.kinetic}, {"elastic", e.elastic}, {"gravity", e.gravity},
          {"contact", e.contact}, {"bonds", e.bonds},     {"total", e.total()}};
}

}  // namespace

Json ledger_json(const StepLedger& l) {
  return {{"about", l.about},
          {"momentum", balance(l, &TwoMomenta::linear)},
          {"angular_momentum", balance(l, &TwoMomenta::angular)},
          {"energy",
           {{"start", energies_of(l.start.energy)},
            {"end", energies_of(l.end.energy)},
            {"colliders", l.done.colliders},
            {"pins", l.done.moved},
            {"loads", l.done.loaded},
            {"damped", l.done.damped},
            {"friction", l.friction()},
            {"guard", l.guard},
            {"numerical", l.numerical()},
            {"of_residual", l.done.residual},
            {"of_correction", l.correction}}}};
}

Json ledger_json(const Ledger& l) {
  Json json = ledger_json(l.sum);
  json["steps"] = l.steps;
  json["momentum"]["largest"] = l.linear;
  json["momentum"]["largest_unaccounted"] = l.linear_gap;
  json["angular_momentum"]["largest"] = l.angular;
  json["angular_momentum"]["largest_unaccounted"] = l.angular_gap;
  json["energy"]["largest_kinetic"] = l.kinetic;
  json["energy"]["largest_rise"] = l.rise;
  return json;
}

Json reactions_json(const std::vector<Reaction>& reactions, const std::vector<std::string>& names) {
  auto list = Json::array();
  for (size_t h = 0; h < reactions.size(); ++h) {
    Json one;
    if (!names.empty()) one["holder"] = names[h];
    one["force"] = reactions[h].force;
    one["moment"] = reactions[h].moment;
    one["about"] = reactions[h].about;
    list.push_back(std::move(one));
  }
  return list;
}

}  // namespace elastogen
