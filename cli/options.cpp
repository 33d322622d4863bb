// SPDX-License-Identifier: Apache-2.0
#include "cli/options.hpp"

#include "cli/exit_code.hpp"
#include "cli/materials_options.hpp"
#include "cli/option_groups.hpp"
#include "cli/scene_options.hpp"
#include "cli/study_options.hpp"
#include "core/error.hpp"
#include "io/read_asset.hpp"
#include "io/safe_file.hpp"
#include "io/scene_file.hpp"
#include "scene/tet_asset.hpp"
#include "scene/version.hpp"

#include <CLI/CLI.hpp>

#include <filesystem>
#include <set>

namespace elastogen {
namespace {

std::string joined(int argc, const char* const* argv) {
  std::string text = "elastogen";
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    const bool plain = word.find_first_of(" <>()*'\"") == std::string::npos && !word.empty();
    text += plain ? " " + word : " '" + word + "'";
  }
  return text;
}

bool given(CLI::App& app, const char* name) {
  const CLI::Option* option = app.get_option_no_throw(name);
  return option && option->count() > 0;
}

/// One verb: its CLI11 command, the texts of its options, and the structs that they become.
struct Verb {
  CLI::App* app = nullptr;
  Typed typed;
  AnimateOptions scene;
  std::string scene_file;
};

/// Gives an option the texts of a scene file.
void fill(CLI::Option& option, const SceneOption& scene, const std::string& path) {
  try {
    for (const std::string& text : scene.texts) option.add_result(text);
    option.run_callback();
  } catch (const CLI::Error& error) {
    throw Error(concat(path, ": ", error.what()));
  }
}

/// Gives options that are not on the command line the values of the scene file. A general option on
/// the command line overrides the scene's special ones too.
void fill_from_scene(Verb& verb) {
  CLI::App& app = *verb.app;
  std::set<std::string> taken;
  for (const CLI::Option* option : app.get_options())
    if (option->count() > 0) taken.insert(option->get_name());
  if (taken.contains("--voxels")) taken.insert("--h");
  if (taken.contains("--material"))
    taken.insert({"--law", "--young", "--poisson", "--density", "--damping", "--damping-frequency",
                  "--yield", "--hardening", "--friction-angle", "--cohesion", "--keeps-volume"});
  if (!verb.scene.input.empty()) taken.insert("--shape");
  if (taken.contains("--analytic")) taken.insert("--energy");
  for (const SceneOption& scene : scene_options(read_scene(verb.scene_file))) {
    CLI::Option* option = app.get_option_no_throw(scene.option);
    if (scene.option == "INPUT" && verb.scene.input.empty()) {
      if (!given(app, "--shape")) verb.scene.input = scene.texts[0];
    } else if (option && !taken.contains(option->get_name())) {
      fill(*option, scene, verb.scene_file);
    }
  }
}

/// Resolves the texts from the command line and the scene file into values.
void resolve(Verb& verb) {
  if (!verb.scene_file.empty()) fill_from_scene(verb);
  verb.typed.has_floor = given(*verb.app, "--floor");
  if (verb.scene.fem) {
    verb.scene.fem->any_rounding = !given(*verb.app, "--tolerance");
    verb.scene.fem->resolution = given(*verb.app, "--voxels") || given(*verb.app, "--h");
  }
  resolve(verb.typed, verb.scene);
}

/// @throws Error (usage) naming the first option that studies do not have.
void check_no_boundary(const Typed& typed) {
  for (const auto& [option, texts] : {std::pair("--hold", &typed.holds),
                                      {"--traction", &typed.tractions},
                                      {"--force", &typed.forces},
                                      {"--move", &typed.moves}})
    ELASTOGEN_CHECK(texts->empty(), "study has no ", option, ", got '", texts->front(), "'");
  ELASTOGEN_CHECK(typed.wind.empty(), "study has no --wind, got '", typed.wind, "'");
}

/// Makes the asset's path absolute, so that the printed scene can be read from any folder.
AnimateOptions& finish_resolved(AnimateOptions& o) {
  if (o.print_resolved && !o.input.empty())
    o.input = std::filesystem::absolute(o.input).lexically_normal().string();
  return o;
}

/// @param formats  endings of the files that it reads.
void add_run(CLI::App& app, Verb& verb, const char* name, const char* text,
             const std::string& formats) {
  verb.app = app.add_subcommand(name, text);
  verb.app->add_option("INPUT", verb.scene.input, "asset: " + formats + "; or a scene file");
  verb.app->add_option("--scene", verb.scene_file,
                       "scene file (.toml, .json): what holds for options that are not given");
  verb.app->add_flag("--print-resolved", verb.scene.print_resolved,
                     "print the scene that results as JSON and end");
  add_scene_groups(*verb.app, verb.scene, verb.typed);
}

void add_animate(CLI::App& app, Verb& verb, BatchTask& batch) {
  add_run(app, verb, "animate", "asset, material and pins to an animation", kReadFormats);
  verb.app->add_option("--batch", batch.files, "scene files with outputs of their own, at once");
  verb.app->add_option(
      "--jobs", batch.jobs,
      "with --batch: scenes at a time; 0, the default: 8 on a card, else one a core");
}

/// Options that hold for all scenes of a batch are typed; those of one scene stand in its file.
BatchTask take_batch(const Verb& verb, BatchTask batch, int argc, const char* const* argv) {
  for (const char* name :
       {"--scene", "--print-resolved", "--output", "--state", "--log-json", "--report"})
    ELASTOGEN_CHECK(!given(*verb.app, name), name,
                    " does not go with --batch: each scene file has its own outputs");
  ELASTOGEN_CHECK(batch.jobs >= 0, "--jobs must not be negative, got ", batch.jobs);
  batch.words = words_without_batch(argc, argv, batch.files);
  batch.quiet = verb.scene.quiet;
  return batch;
}

void add_simulate(CLI::App& app, Verb& verb) {
  verb.scene.fem.emplace();
  verb.scene.solver.tolerance = 1e-8;
  add_run(app, verb, "simulate", "the same on finite elements, in float64",
          std::string(kReadFormats) + kTetFormats);
  verb.app->get_option("--tolerance")->default_str("1e-8, or above the rounding of doubles");
  verb.app
      ->add_option(
          "--element", verb.typed.element,
          "voxel (the network's), hex, hex-bbar, tet4, tet10, tet10-bbar or tri3; auto: voxel, "
          "or as a mesh of tetrahedra has it")
      ->capture_default_str();
  verb.app->add_option("--mass", verb.typed.mass, "lumped or consistent")->capture_default_str();
  verb.app->add_flag("--static", verb.scene.fem->statics,
                     "the equilibrium under gravity, tractions and moves instead of time steps");
}

/// Accepts a scene file in place of an asset.
void take_scene_file(Verb& verb) {
  const std::string ending = ending_of(verb.scene.input);
  if (!verb.scene_file.empty() || (ending != "toml" && ending != "json")) return;
  verb.scene_file = std::move(verb.scene.input);
  verb.scene.input.clear();
}

/// @throws Error (usage) naming an option that the way to compute of a run does not have.
void check_mode(const AnimateOptions& o) {
  ELASTOGEN_CHECK(o.wind.keys.empty() || !o.fem || !o.fem->statics,
                  "--static finds no equilibrium in wind, got --wind '", o.wind_text, "'");
  if (o.fem || method_of(o) != Method::kAuto || o.solver.mode != SolverMode::kPaper) return;
  ELASTOGEN_CHECK(o.holds.empty(), "the solver 'paper' knows no holds along single axes: --hold '",
                  o.holds.front().text, "'");
  ELASTOGEN_CHECK(o.wind.keys.empty(), "the solver 'paper' knows no wind: --wind '", o.wind_text,
                  "'");
}

/// Options of the verb animate or simulate.
AnimateOptions take_run(Verb& verb) {
  const std::string name = verb.app->get_name();
  ELASTOGEN_CHECK(!given(*verb.app, "--jobs"), "--jobs goes with --batch only");
  take_scene_file(verb);
  resolve(verb);
  AnimateOptions& o = verb.scene;
  if (o.print_resolved) return finish_resolved(o);
  check_mode(o);
  ELASTOGEN_CHECK(o.method == Method::kAuto || method_of(o) != Method::kAuto, "--method ",
                  verb.typed.method, ": no material of the scene yields");
  const std::string& file = verb.scene_file;
  const std::string scene = file.empty() ? "" : file + ": ";
  ELASTOGEN_CHECK(has_body(o), scene, name,
                  " needs an INPUT, a --shape, or a --scene with asset.file or shape");
  ELASTOGEN_CHECK(!o.outputs.empty(), scene, name,
                  " needs an --output, or a --scene with output.files");
  check_outputs(o, verb.scene_file);
  return o;
}

void add_voxelize(CLI::App& app, Verb& verb, VoxelizeTask& task) {
  verb.app = app.add_subcommand("voxelize", "asset to a voxel file");
  verb.app->add_option("INPUT", verb.scene.input, "asset")->required();
  verb.app->add_option("-o,--output", task.output, "OpenVDB file (.vdb)")->required();
  verb.app->add_option("--report", verb.scene.report, "what was found (JSON)");
  verb.app->add_flag("--quiet", verb.scene.quiet, "print errors only");
  add_resolution_options(*verb.app, verb.scene, verb.typed);
}

VoxelizeTask take_voxelize(Verb& verb, VoxelizeTask task) {
  resolve(verb);
  ELASTOGEN_CHECK(ending_of(task.output) == "vdb", task.output, ": the output must end in .vdb");
  AnimateOptions names = verb.scene;
  names.state = task.output;  // so that check_outputs compares it with the input
  check_outputs(names);
  task.scene = verb.scene;
  return task;
}

void add_inspect(CLI::App& app, Verb& verb, InspectTask& task) {
  verb.app = app.add_subcommand("inspect", "what an asset or a scene holds and what it costs");
  verb.app->add_option("FILE", verb.scene_file, "asset, or scene file (.toml, .json)");
  verb.app->add_flag("--json", task.json, "print JSON");
  verb.app->add_flag("--schema", task.schema, "print the JSON schema of scene files and end");
  verb.app->add_flag("--print-resolved", verb.scene.print_resolved,
                     "print the scene that results as JSON and end");
  add_scene_groups(*verb.app, verb.scene, verb.typed);
}

InspectTask take_inspect(Verb& verb, InspectTask task) {
  if (task.schema) return task;
  const std::string file = verb.scene_file;
  ELASTOGEN_CHECK(!file.empty(), "inspect needs a FILE");
  task.is_scene = ending_of(file) == "toml" || ending_of(file) == "json";
  if (!task.is_scene) verb.scene.input = file, verb.scene_file.clear();
  resolve(verb);
  const bool named = has_body(verb.scene) || verb.scene.print_resolved;
  ELASTOGEN_CHECK(named, file, ": names no asset (asset.file) and no shape");
  task.scene = finish_resolved(verb.scene);
  return task;
}

void add_doctor(CLI::App& app, Verb& verb, DoctorTask& task) {
  verb.app = app.add_subcommand("doctor", "what is odd about an asset and what is done about it");
  verb.app->add_option("FILE", verb.scene.input, "asset")->required();
  verb.app->add_flag("--json", task.json, "print JSON");
  add_resolution_options(*verb.app, verb.scene, verb.typed);
}

void add_study(CLI::App& app, Verb& verb, StudyTask& task, StudyNames& names) {
  verb.app = app.add_subcommand("study", "network against finite elements, error against time");
  verb.app->add_option("INPUT", verb.scene.input, "asset, or scene file (.toml, .json)");
  verb.app->add_option("--scene", verb.scene_file, "scene file (.toml, .json)");
  add_study_options(*verb.app, task, names);
  add_scene_groups(*verb.app, verb.scene, verb.typed);
}

StudyTask take_study(Verb& verb, StudyTask task, const StudyNames& names) {
  take_scene_file(verb);
  if (verb.typed.scheme.empty()) verb.typed.scheme = "euler";  // of equal steps, on both sides
  resolve(verb);
  check_no_boundary(verb.typed);
  ELASTOGEN_CHECK(
      method_of(verb.scene) != Method::kFem,
      "study: the network steps no material that yields; --method mpm compares particles");
  if (verb.scene.energy == EnergySource::kAuto) verb.scene.energy = EnergySource::kAnalytic;
  ELASTOGEN_CHECK(has_body(verb.scene),
                  "study needs an INPUT, a --shape, or a --scene with asset.file or shape");
  resolve_study(names, task);
  task.scene = verb.scene;
  return task;
}

CLI::App* add_demo(CLI::App& app, DemoOptions& demo) {
  CLI::App* verb = app.add_subcommand("demo", "builds a character and animates it");
  verb->add_option("-o,--output", demo.folder, "folder for demo.glb and demo.png")
      ->capture_default_str();
  verb->add_option("--threads", demo.threads, "0: all")->capture_default_str();
  verb->add_flag("--quiet", demo.quiet, "print errors only");
  return verb;
}

/// All verbs, while they are parsed.
struct Verbs {
  Verb animate, simulate, study, voxelize, inspect, doctor;
  VoxelizeTask voxelize_task;
  InspectTask inspect_task;
  StudyTask study_task;
  StudyNames study_names;
  DoctorTask doctor_task;
  MaterialsTask materials_task;
  BatchTask batch;
  DemoOptions demo;
  TrainOptions train;
  BenchOptions bench;
  const CLI::App* materials = nullptr;
};

void add_verbs(CLI::App& app, Verbs& verbs, const std::string& command) {
  for (Verb* verb : {&verbs.animate, &verbs.simulate, &verbs.study, &verbs.voxelize, &verbs.inspect,
                     &verbs.doctor})
    verb->scene.command = command;
  verbs.demo.command = command;
  add_animate(app, verbs.animate, verbs.batch);
  add_simulate(app, verbs.simulate);
  add_study(app, verbs.study, verbs.study_task, verbs.study_names);
  add_voxelize(app, verbs.voxelize, verbs.voxelize_task);
  add_inspect(app, verbs.inspect, verbs.inspect_task);
  add_doctor(app, verbs.doctor, verbs.doctor_task);
  verbs.materials_task.command = command;
  verbs.materials = add_materials(app, verbs.materials_task);
  add_demo(app, verbs.demo);
  verbs.train.add(app);
  verbs.bench.add(app, command);
}

/// The task of the verb that was parsed.
CommandLine taken(Verbs& verbs, int argc, const char* const* argv) {
  // animate, one scene or many, and simulate
  CommandLine result;
  if (!verbs.batch.files.empty()) {
    result.batch = take_batch(verbs.animate, verbs.batch, argc, argv);
  } else if (verbs.animate.app->parsed()) {
    result.animate = take_run(verbs.animate);
  } else if (verbs.simulate.app->parsed()) {
    result.animate = take_run(verbs.simulate);
    // verbs about an asset or a scene
  } else if (verbs.study.app->parsed()) {
    result.study = take_study(verbs.study, verbs.study_task, verbs.study_names);
  } else if (verbs.voxelize.app->parsed()) {
    result.voxelize = take_voxelize(verbs.voxelize, verbs.voxelize_task);
  } else if (verbs.inspect.app->parsed()) {
    result.inspect = take_inspect(verbs.inspect, verbs.inspect_task);
  } else if (verbs.doctor.app->parsed()) {
    resolve(verbs.doctor);
    verbs.doctor_task.scene = verbs.doctor.scene;
    result.doctor = verbs.doctor_task;
    // verbs about nets, solvers and materials
  } else if (verbs.train.parsed()) {
    result.train = verbs.train.take();
  } else if (verbs.bench.parsed()) {
    result.bench = verbs.bench.take();
  } else if (verbs.materials->parsed()) {
    result.materials = verbs.materials_task;
  } else {
    result.demo = verbs.demo;
  }
  return result;
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Any 3D asset in, physically accurate animation out.", "elastogen");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  Verbs verbs;
  add_verbs(app, verbs, joined(argc, argv));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    CommandLine result;
    result.code = app.exit(error) == 0 ? kExitDone : kExitUsage;
    return result;
  }
  return taken(verbs, argc, argv);
}

}  // namespace elastogen
