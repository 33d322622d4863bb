// SPDX-License-Identifier: Apache-2.0
#include "cli/exit_code.hpp"
#include "cli/material_nets.hpp"
#include "cli/verbs.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

/// Numbers that follow from those of a material.
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

Json to_json(const MaterialPreset& preset) {
  const Material& m = preset.material;
  const Derived d = derived(m);
  return {{"name", m.name},
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
}

void print_line(const MaterialPreset& preset) {
  const Material& m = preset.material;
  fmt::print("{:<12} {:<19} E {:>8.3g} Pa  nu {:<5.3g} rho {:>5.4g} kg/m3  {}\n", m.name,
             law_name(m.law), m.young, m.poisson, m.density, preset.kind);
}

void print_all(const MaterialPreset& preset) {
  const Derived d = derived(preset.material);
  print_line(preset);
  fmt::print("  mu {:.4g} Pa, lambda {:.4g} Pa, K {:.4g} Pa\n", d.mu, d.lambda, d.bulk);
  fmt::print("  waves: {:.4g} m/s in pressure, {:.4g} m/s in shear\n", d.pressure_wave,
             d.shear_wave);
  fmt::print("  {}: {}\n", preset.kind, preset.source);
}

int list_presets(const MaterialsTask& task) {
  Json list = Json::array();
  for (const MaterialPreset& preset : material_presets()) {
    if (task.json)
      list.push_back(to_json(preset));
    else
      print_line(preset);
  }
  if (task.json) fmt::print("{}\n", list.dump(2));
  return kExitDone;
}

int show_preset(const MaterialsTask& task) {
  const MaterialPreset& preset = material_preset(task.name);
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
