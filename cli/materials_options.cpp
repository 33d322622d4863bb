// SPDX-License-Identifier: Apache-2.0
#include "cli/materials_options.hpp"

#include <CLI/CLI.hpp>

namespace elastogen {

CLI::App* add_materials(CLI::App& app, MaterialsTask& task) {
  using Action = MaterialsTask::Action;
  // `materials` alone lists
  CLI::App* verb = app.add_subcommand("materials", "presets, nets of laws, and laws of tests");
  verb->fallthrough()->require_subcommand(0, 1);
  verb->add_flag("--json", task.json, "print JSON");
  // each action is a subcommand
  const auto add = [&](Action action, const char* name, const char* text) {
    CLI::App* sub = verb->add_subcommand(name, text);
    sub->callback([&task, action] { task.action = action; });
    return sub;
  };
  const auto add_poisson = [&](CLI::App& sub, const char* text) {
    return sub.add_option("--poisson", task.poisson, text);
  };
  // presets
  add(Action::kList, "list", "all presets, with the origin of their numbers");
  CLI::App* show = add(Action::kShow, "show", "one of them");
  show->add_option("NAME", task.name, "of a preset")->required();
  // nets of laws
  CLI::App* report =
      add(Action::kReport, "report", "page of a net beside its law")->fallthrough(false);
  report->add_option("LAW", task.name, "a law, a sum of laws, or a preset")->required();
  add_poisson(*report, "Poisson's ratio, 0 to 0.499; else the preset's, of a law 0.45");
  report->add_option("-o,--output", task.output, "page (.html)")->required();
  CLI::App* generate = add(Action::kGenerate, "generate", "weight file of a law");
  generate->add_option("LAW", task.name, "a law, or a sum like 0.3*ogden=4+0.7*stvk")->required();
  add_poisson(*generate, "Poisson's ratio, 0 to 0.499")->required();
  generate->add_option("-o,--output", task.output, "weight file (.weights)")->required();
  // laws of tests
  CLI::App* fit = add(Action::kFit, "fit", "a material from a test of it");
  fit->add_option("TEST", task.name, "table (CSV) with stretch and stress")->required();
  add_poisson(*fit, "Poisson's ratio, 0 to 0.499; else 0.48, for a test hardly tells it");
  fit->add_option("--law", task.laws, "to fit, ogden or ogden=4, again for more; else all of them")
      ->allow_extra_args(false);
  fit->add_option("-o,--output", task.output, "scene file (.toml) with the material");
  return verb;
}

}  // namespace elastogen
