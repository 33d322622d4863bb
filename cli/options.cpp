// SPDX-License-Identifier: Apache-2.0
#include "cli/options.hpp"

#include "cli/exit_code.hpp"
#include "cli/region_option.hpp"
#include "cli/version.hpp"
#include "core/error.hpp"
#include "io/read_asset.hpp"
#include "io/units.hpp"
#include "voxelize/regions.hpp"

#include <CLI/CLI.hpp>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace elastogen {
namespace {

/// Values as they were typed; empty means not given.
struct Typed {
  std::string material, law, young, poisson, density;
  std::string gravity, velocity, spin, h, size, substeps = "auto", max_memory, max_time;
  std::vector<std::string> floor;
  std::string up = "y", scheme = "euler", solver = "auto", hourglass = "full", profile = "modal";
  std::string device = "cpu";
  bool no_skip = false;
  CLI::Option* floor_option = nullptr;
};

void add_material_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("--material", t.material, "preset: rubber, soft-rubber, jelly, foam, ...")
      ->group("Material");
  app.add_option("--law", t.law, "fixed-corotated, neo-hookean, stable-neo-hookean, stvk or hencky")
      ->group("Material");
  app.add_option("--young", t.young, "Young's modulus, e.g. 1e6 or '1 MPa'")->group("Material");
  app.add_option("--poisson", t.poisson, "Poisson's ratio, 0 <= nu < 0.5")->group("Material");
  app.add_option("--density", t.density, "density, e.g. 1100 or '1.1 g/cm3'")->group("Material");
  app.add_option("--region", o.regions,
                 "another material for a part, 'SELECTION: MATERIAL'; repeatable")
      ->group("Material")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_scene_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("--pin", o.pins,
                 "hold a part: y<5%, z>0.2m, box(x,y,z,x,y,z), sphere(x,y,z,r), all; repeatable")
      ->group("Scene")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--gravity", t.gravity, "x,y,z [m/s^2]; default 9.81 down")->group("Scene");
  app.add_option("--velocity", t.velocity, "start velocity x,y,z [m/s]")->group("Scene");
  app.add_option("--spin", t.spin, "start spin x,y,z [rad/s] about the centre of mass")
      ->group("Scene");
  t.floor_option =
      app.add_option("--floor", t.floor, "floor plane AXIS=PLACE; alone: the asset's lowest point")
          ->group("Scene")
          ->expected(0, 1);
  app.add_option("--collider", o.colliders,
                 "plane(x,y,z, nx,ny,nz), sphere(x,y,z, r) or box(x0,y0,z0, x1,y1,z1), then "
                 "friction F, name NAME, path T:x,y,z; T:x,y,z; repeatable")
      ->group("Scene")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--friction", o.friction, "Coulomb's coefficient with floor and colliders")
      ->group("Scene")
      ->capture_default_str();
  app.add_option("--voxels", o.voxels, "voxels along the longest edge")
      ->group("Scene")
      ->capture_default_str();
  app.add_option("--h", t.h, "voxel edge, e.g. '5 mm', instead of --voxels")->group("Scene");
  app.add_option("--size", t.size, "longest edge of the asset, e.g. '30 cm'")->group("Scene");
  app.add_option("--up", t.up, "axis that points up: y or z")
      ->group("Scene")
      ->capture_default_str();
}

void add_run_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("--frames", o.frames, "frames after the first")->capture_default_str();
  app.add_option("--fps", o.fps, "frames a second")->capture_default_str();
  app.add_option("--substeps", t.substeps, "time steps a frame, or auto")->capture_default_str();
  app.add_option("--time-scheme", t.scheme, "euler or bdf2")->capture_default_str();
  app.add_option("--solver", t.solver, "auto, quasi or newton")->capture_default_str();
  app.add_option("--tolerance", o.solver.tolerance, "of the residual |grad E|/|M g|")
      ->capture_default_str();
  app.add_option("--hourglass", t.hourglass, "full, variance or off")->capture_default_str();
  app.add_option("--device", t.device, "cpu")->capture_default_str();
  app.add_option("--threads", o.threads, "0: all")->capture_default_str();
  app.add_option("--max-memory", t.max_memory, "budget, e.g. '8 GB'");
  app.add_option("--max-voxels", o.max_voxels, "budget")->capture_default_str();
  app.add_option("--max-time", t.max_time, "wall time of the steps, e.g. '10 min'");
  app.add_flag("--no-skip", t.no_skip, "take no shortcut that the scene would allow");
  app.add_flag("--strict", o.strict, "warnings are errors");
  app.add_flag("--quiet", o.quiet, "print errors only");
}

void add_output_options(CLI::App& app, AnimateOptions& o, Typed& t) {
  app.add_option("-o,--output", o.outputs,
                 "animation to write: .glb, .ply (a file a frame), .pc2, .pvd; repeatable")
      ->group("Output")
      ->required()
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--glb-profile", t.profile, "modal or keyframe")
      ->group("Output")
      ->capture_default_str();
  app.add_option("--state", o.state, "state file (HDF5)")->group("Output");
  app.add_option("--log-json", o.log, "one JSON object a time step")->group("Output");
  app.add_option("--report", o.report, "summary of the run (JSON)")->group("Output");
}

/// The index of a name in a list. @throws Error naming the choices.
int choice(const char* option, const std::string& value, const std::vector<std::string>& names) {
  std::string known;
  for (size_t k = 0; k < names.size(); ++k) {
    if (names[k] == value) return int(k);
    known += (known.empty() ? "" : ", ") + names[k];
  }
  throw Error(concat(option, " '", value, "': known are ", known));
}

Material resolve_material(const Typed& t) {
  Material m = material_preset(t.material.empty() ? "rubber" : t.material).material;
  const bool changed =
      !t.law.empty() || !t.young.empty() || !t.poisson.empty() || !t.density.empty();
  if (t.material.empty() && changed) m.name = "custom";
  if (!t.law.empty()) m.law = law_from_name(t.law);
  if (!t.young.empty()) m.young = parse_pressure(t.young);
  if (!t.poisson.empty()) m.poisson = parse_number(t.poisson);
  if (!t.density.empty()) m.density = parse_density(t.density);
  check_material(m);
  return m;
}

FloorOption resolve_floor(const std::vector<std::string>& typed) {
  FloorOption floor;
  if (typed.empty() || typed[0].empty()) return floor;
  const std::string& text = typed[0];
  const bool has_axis = text.size() > 2 && text[0] >= 'x' && text[0] <= 'z' && text[1] == '=';
  ELASTOGEN_CHECK(has_axis, "--floor '", text,
                  "': expected x=PLACE, y=PLACE or z=PLACE (an input file goes before --floor)");
  floor.axis = text[0] - 'x';
  floor.place = parse_length(std::string_view(text).substr(2));
  return floor;
}

int resolve_substeps(const std::string& text) {
  if (text == "auto") return 0;
  const double n = parse_number(text);
  ELASTOGEN_CHECK(n >= 1 && n <= 10000 && n == std::floor(n), "--substeps '", text,
                  "': expected auto or a whole number from 1 to 10000");
  return int(n);
}

void copy(const Vec3& from, double to[3]) {
  std::copy(from.begin(), from.end(), to);
}

void resolve(const Typed& t, AnimateOptions& o) {
  o.material = resolve_material(t);
  for (const std::string& pin : o.pins) parse_selection(pin);
  for (const std::string& region : o.regions) parse_region(region);
  if (!t.gravity.empty()) o.gravity = parse_vec3(t.gravity, Quantity::kAcceleration);
  if (!t.velocity.empty()) copy(parse_vec3(t.velocity, Quantity::kSpeed), o.motion.velocity);
  if (!t.spin.empty()) copy(parse_vec3(t.spin, Quantity::kSpin), o.motion.spin);
  if (t.floor_option->count() > 0) o.floor = resolve_floor(t.floor);
  if (!t.h.empty()) o.h = parse_length(t.h);
  if (!t.size.empty()) o.size = parse_length(t.size);
  if (!t.max_memory.empty()) o.max_memory = parse_memory(t.max_memory);
  if (!t.max_time.empty()) o.max_time = parse_time(t.max_time);
  o.up = 1 + choice("--up", t.up, {"y", "z"});
  o.substeps = resolve_substeps(t.substeps);
  o.scheme = TimeScheme(choice("--time-scheme", t.scheme, {"euler", "bdf2"}));
  o.solver.mode = solver_from_name(t.solver);
  o.solver.skip = !t.no_skip;
  o.hourglass = Hourglass(choice("--hourglass", t.hourglass, {"full", "variance", "off"}));
  o.keyframe = choice("--glb-profile", t.profile, {"modal", "keyframe"}) == 1;
  choice("--device", t.device, {"cpu"});
}

void check_ranges(const Typed& t, const AnimateOptions& o) {
  ELASTOGEN_CHECK(t.h.empty() || o.h > 0, "--h must be positive, got '", t.h, "'");
  ELASTOGEN_CHECK(t.size.empty() || o.size > 0, "--size must be positive, got '", t.size, "'");
  ELASTOGEN_CHECK(o.voxels >= 1, "--voxels must be 1 or more, got ", o.voxels);
  ELASTOGEN_CHECK(o.frames >= 0 && o.frames <= 1'000'000,
                  "--frames must lie in 0 ... 1000000, got ", o.frames);
  ELASTOGEN_CHECK(o.fps > 0 && std::isfinite(o.fps), "--fps must be positive, got ", o.fps);
  ELASTOGEN_CHECK(o.friction >= 0 && std::isfinite(o.friction), "--friction must not be negative, ",
                  "got ", o.friction);
  ELASTOGEN_CHECK(o.solver.tolerance > 0 && o.solver.tolerance < 1, "--tolerance must lie between ",
                  "0 and 1, got ", o.solver.tolerance);
  ELASTOGEN_CHECK(o.threads >= 0, "--threads must not be negative, got ", o.threads);
  ELASTOGEN_CHECK(o.max_voxels >= 1, "--max-voxels must be positive, got ", o.max_voxels);
  ELASTOGEN_CHECK(t.max_memory.empty() || o.max_memory > 0, "--max-memory must be positive, got '",
                  t.max_memory, "'");
  ELASTOGEN_CHECK(t.max_time.empty() || o.max_time > 0, "--max-time must be positive, got '",
                  t.max_time, "'");
}

/// No output may take the place of another; only the animation may take that of the input.
void check_outputs(const AnimateOptions& o) {
  std::vector<std::filesystem::path> taken = {std::filesystem::path(o.input).lexically_normal()};
  const auto take = [&](const std::string& name, bool may_be_input) {
    if (name.empty()) return;
    const auto path = std::filesystem::path(name).lexically_normal();
    const auto first = taken.begin() + (may_be_input ? 1 : 0);
    ELASTOGEN_CHECK(std::find(first, taken.end(), path) == taken.end(), name,
                    ": two files of one name: the input and each output need their own");
    taken.push_back(path);
  };
  for (const std::string* name : {&o.log, &o.state, &o.report}) take(*name, false);
  for (const std::string& name : o.outputs) take(name, true);
}

std::string joined(int argc, const char* const* argv) {
  std::string text = "elastogen";
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    const bool plain = word.find_first_of(" <>()*'\"") == std::string::npos && !word.empty();
    text += plain ? " " + word : " '" + word + "'";
  }
  return text;
}

}  // namespace

CommandLine parse_command_line(int argc, const char* const* argv) {
  CLI::App app("Any 3D asset in, physically accurate animation out.", "elastogen");
  app.set_version_flag("--version", version_text());
  app.require_subcommand(1);
  AnimateOptions animate;
  Typed typed;
  CLI::App& a = *app.add_subcommand("animate", "asset, material and pins to an animation");
  a.add_option("INPUT", animate.input, std::string("asset: ") + kReadFormats)->required();
  add_output_options(a, animate, typed);
  add_material_options(a, animate, typed);
  add_scene_options(a, animate, typed);
  add_run_options(a, animate, typed);

  DemoOptions demo;
  CLI::App& d = *app.add_subcommand("demo", "builds a character and animates it");
  d.add_option("-o,--output", demo.folder, "folder for demo.glb and demo.png")
      ->capture_default_str();
  d.add_option("--threads", demo.threads, "0: all")->capture_default_str();
  d.add_flag("--quiet", demo.quiet, "print errors only");

  CommandLine result;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    result.code = app.exit(error) == 0 ? kExitDone : kExitUsage;
    return result;
  }
  if (a.parsed()) {
    resolve(typed, animate);
    check_ranges(typed, animate);
    check_outputs(animate);
    animate.command = joined(argc, argv);
    result.animate = animate;
  } else {
    demo.command = joined(argc, argv);
    result.demo = demo;
  }
  return result;
}

}  // namespace elastogen
