// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/material_nets.hpp"
#include "cli/verbs.hpp"
#include "mpm_fem/materials/solid_presets.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers derived from those of a material.
struct Derived {
  double mu, lambda, bulk;           ///< [Pa]
  double pressure_wave, shear_wave;  ///< speeds [m/s]
};

/// K = lambda + 2 mu / 3, c_p = sqrt((lambda + 2 mu)/rho), c_s = sqrt(mu/rho).
Derived derived(const Material& m) {
  const double mu = m.mu(), lambda = m.lambda();
  return {mu, lambda, lambda + 2 * mu / 3, std::sqrt((lambda + 2 * mu) / m.density),
          std::sqrt(mu / m.density)};
}

/// Parameters of yielding; empty for an elastic material.
Json yield_json(const Yield& yield) {
  if (const auto* metal = std::get_if<MetalYield>(&yield))
    return {{"yield", metal->stress}, {"hardening", metal->hardening}};
  if (const auto* sand = std::get_if<SandYield>(&yield))
    return {{"friction_angle", sand->friction}, {"cohesion", sand->cohesion}};
  if (const auto* snow = std::get_if<SnowYield>(&yield))
    return {{"yield", snow->pressure},
            {"hardening", snow->hardening},
            {"friction_angle", critical_angle(snow->slope)},
            {"cohesion", snow->cohesion}};
  return Json::object();
}

Json to_json(const SolidPreset& preset) {
  const Material& m = preset.solid.elastic;
  const Derived d = derived(m);
  Json json = {{"name", m.name},
               {"law", law_name(m.law)},
               {"young", m.young},
               {"poisson", m.poisson},
               {"density", m.density},
               {"mu", d.mu},
               {"lambda", d.lambda},
               {"bulk", d.bulk},
               {"pressure_wave", d.pressure_wave},
               {"shear_wave", d.shear_wave},
               {"kind", preset.kind},
               {"source", preset.source}};
  if (m.usual_loss > 0)
    json.update({{"loss_factor", m.usual_loss},
                 {"loss_frequency", m.loss_frequency},
                 {"loss_source", preset.loss_source}});
  if (!preset.solid.is_plastic()) return json;
  json["yields_as"] = yield_name(preset.solid.yield);
  json.update(yield_json(preset.solid.yield));
  return json;
}

void print_line(const SolidPreset& preset) {
  const Material& m = preset.solid.elastic;
  const std::string how =
      preset.solid.is_plastic() ? yield_name(preset.solid.yield) : law_name(m.law);
  fmt::print("{:<12} {:<19} E {:>8.3g} Pa  nu {:<5.3g} rho {:>5.4g} kg/m3  {}\n", m.name, how,
             m.young, m.poisson, m.density, preset.kind);
}

void print_all(const SolidPreset& preset) {
  const Derived d = derived(preset.solid.elastic);
  print_line(preset);
  fmt::print("  mu {:.4g} Pa, lambda {:.4g} Pa, K {:.4g} Pa\n", d.mu, d.lambda, d.bulk);
  fmt::print("  waves: {:.4g} m/s in pressure, {:.4g} m/s in shear\n", d.pressure_wave,
             d.shear_wave);
  const Material& m = preset.solid.elastic;
  if (m.usual_loss > 0)
    fmt::print("  loss factor {:.3g} at {:.3g} Hz: {}\n", m.usual_loss, m.loss_frequency,
               preset.loss_source);
  const Json yield = yield_json(preset.solid.yield);
  for (const auto& [key, value] : yield.items())
    fmt::print("  {} {:.4g}\n", key, value.get<double>());
  fmt::print("  {}: {}\n", preset.kind, preset.source);
}

int list_presets(const MaterialsTask& task) {
  Json list = Json::array();
  for (const auto& presets : {material_presets(), yielding_presets()})
    for (const MaterialPreset& named : presets) {
      const SolidPreset preset = solid_preset(named.material.name);
      if (task.json)
        list.push_back(to_json(preset));
      else
        print_line(preset);
    }
  if (task.json) fmt::print("{}\n", list.dump(2));
  return kExitDone;
}

int show_preset(const MaterialsTask& task) {
  const SolidPreset preset = solid_preset(task.name);
  if (task.json)
    fmt::print("{}\n", to_json(preset).dump(2));
  else
    print_all(preset);
  return kExitDone;
}

}  // namespace

int materials(const MaterialsTask& task) {
  using Action = MaterialsTask::Action;
  switch (task.action) {
    case Action::kList:
      return list_presets(task);
    case Action::kShow:
      return show_preset(task);
    case Action::kReport:
      return report_material(task);
    case Action::kGenerate:
      return generate_material(task);
    case Action::kFit:
      break;
  }
  return fit_material_test(task);
}

}  // namespace elastogen
