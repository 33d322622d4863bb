// SPDX-License-Identifier: Apache-2.0
#include "cli/typed.hpp"

#include "core/error.hpp"
#include "io/units.hpp"
#include "mpm_fem/materials/solid_presets.hpp"
#include "scene/solid_text.hpp"
#include "voxelize/regions.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace elastogen {
namespace {

/// The index of a name in a list. @throws Error naming the choices.
int choice(const char* option, const std::string& value, const std::vector<std::string>& names) {
  std::string known;
  for (size_t k = 0; k < names.size(); ++k) {
    if (names[k] == value) return int(k);
    known += (known.empty() ? "" : ", ") + names[k];
  }
  throw Error(concat(option, " '", value, "': known are ", known));
}

void resolve_material(const Typed& t, AnimateOptions& o) {
  // the preset, changed by what was typed
  Solid solid = solid_preset(t.material).solid;
  const Material preset = solid.elastic;
  const Yield yield = solid.yield;
  for (const auto& [key, text] : {std::pair("law", &t.law),
                                  {"young", &t.young},
                                  {"poisson", &t.poisson},
                                  {"density", &t.density},
                                  {"damping", &t.damping},
                                  {"damping-frequency", &t.damping_frequency},
                                  {"yield", &t.yield},
                                  {"hardening", &t.hardening},
                                  {"friction-angle", &t.friction_angle},
                                  {"cohesion", &t.cohesion},
                                  {"keeps-volume", &t.keeps_volume}}) {
    if (!text->empty()) change_solid(key, *text, solid);
  }
  check_solid(solid);
  // what it is called
  const Material& m = solid.elastic;
  const bool same = m.law == preset.law && m.young == preset.young && m.poisson == preset.poisson &&
                    m.density == preset.density && solid.yield == yield;
  o.material = m;
  o.yield = solid.yield;
  if (!same) o.material.name = "custom";
}

/// Bodies that yield are stepped by elements or particles, not by the network.
void resolve_method(const Typed& t, AnimateOptions& o) {
  o.method = Method(choice("--method", t.method, {"auto", "mpm", "fem"}));
  const Method method = method_of(o);
  ELASTOGEN_CHECK(method != Method::kMpm || !o.fem || !o.fem->statics,
                  "--static: particles take time steps; --method fem has an equilibrium");
  if (method == Method::kFem && !o.fem) o.fem.emplace();
}

/// "": automatic axis and place; AXIS=PLACE; off.
std::optional<FloorPlane> resolve_floor(const std::vector<std::string>& typed) {
  FloorPlane floor;
  if (typed.empty() || typed[0].empty()) return floor;
  const std::string& text = typed[0];
  if (text == "off") return std::nullopt;
  const size_t equals = std::min(text.find('='), text.size());
  const std::string axis = text.substr(0, equals);
  const bool named = axis.size() == 1 && axis[0] >= 'x' && axis[0] <= 'z';
  ELASTOGEN_CHECK(equals + 1 < text.size() && (named || axis == "auto"), "--floor '", text,
                  "': expected x=PLACE, y=PLACE, z=PLACE, auto=PLACE or off (an input file goes ",
                  "before --floor)");
  if (named) floor.axis = axis[0] - 'x';
  const std::string place = text.substr(equals + 1);
  if (place != "auto") floor.place = parse_length(place);
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

/// A share, as a number or in per cent.
double resolve_share(const char* option, const std::string& text) {
  const bool percent = !text.empty() && text.back() == '%';
  const double share = parse_number(text.substr(0, text.size() - percent)) / (percent ? 100 : 1);
  ELASTOGEN_CHECK(share > 0 && share < 1, option, " '", text, "': expected more than 0 and less ",
                  "than 100 %");
  return share;
}

/// The scheme where none is typed: steps by their time error, SDIRK2 where the steps a frame are
/// typed, and implicit Euler for what has neither of them.
std::string default_scheme(const Typed& t, const AnimateOptions& o) {
  const bool yields = o.yield.index() > 0 ||
                      std::any_of(o.regions.begin(), o.regions.end(),
                                  [](const MaterialRegion& r) { return r.yield.index() > 0; });
  const bool has_stages = !yields && method_of(o) != Method::kMpm &&
                          o.solver.mode != SolverMode::kPaper && !(o.fem && o.fem->statics);
  return !has_stages ? "euler" : t.substeps == "auto" ? "auto" : "sdirk2";
}

/// Finite elements have one scheme more than the network.
void resolve_scheme(const Typed& t, AnimateOptions& o) {
  std::vector<std::string> names = {"euler", "bdf2", "sdirk2", "auto"};
  if (o.fem) names.push_back("newmark");
  const int scheme =
      choice("--time-scheme", t.scheme.empty() ? default_scheme(t, o) : t.scheme, names);
  const bool newmark = scheme == 4;
  o.scheme = newmark ? TimeScheme::kEuler : TimeScheme(scheme);
  ELASTOGEN_CHECK(o.scheme != TimeScheme::kAuto || t.substeps == "auto",
                  "--time-scheme auto finds its own steps: leave out --substeps");
  if (!o.fem) return;
  o.fem->newmark = newmark;
  o.fem->named = t.element != "auto";
  if (o.fem->named) o.fem->element = fem::element_from_name(t.element);
  o.fem->mass = fem::Mass(choice("--mass", t.mass, {"lumped", "consistent"}));
}

/// Options that may be given many times.
void convert_lists(const Typed& t, AnimateOptions& o) {
  for (const std::string& pin : t.pins) o.pins.push_back(parse_pin(pin));
  for (const std::string& region : t.regions) o.regions.push_back(parse_region(region));
  for (const std::string& hold : t.holds) o.holds.push_back(parse_hold(hold));
  for (const std::string& traction : t.tractions) o.tractions.push_back(parse_traction(traction));
  for (const std::string& force : t.forces) o.forces.push_back(parse_force(force));
  if (!t.wind.empty()) o.wind = parse_wind(t.wind);
  o.wind_text = t.wind;
  for (const std::string& move : t.moves) o.moves.push_back(parse_move(move));
  for (const std::string& text : t.colliders) o.colliders.push_back(parse_obstacle(text));
}

/// Bodies without a file, and particles.
void resolve_particles(const Typed& t, AnimateOptions& o) {
  if (!t.shape.empty()) o.shape = parse_shape(t.shape);
  ParticleOptions& p = o.particles;
  p.integrator =
      Integrator(choice("--integrator", t.integrator,
                        {"implicit", "explicit", "frozen-fixed-point", "pn-fixed-point"}));
  p.transfer.kind =
      mpm::Transfer(choice("--transfer", t.transfer, {"apic", "apic-blend", "rpic", "flip"}));
  p.transfer.blend_time = parse_time(t.blend_time);
  if (t.dt != "auto") p.dt = parse_time(t.dt);
  ELASTOGEN_CHECK(t.dt == "auto" || p.dt > 0, "--dt must be positive, got '", t.dt, "'");
  ELASTOGEN_CHECK(p.transfer.blend_time > 0, "--blend-time must be positive, got '", t.blend_time,
                  "'");
  ELASTOGEN_CHECK(p.transfer.flip >= 0 && p.transfer.flip <= 1,
                  "--flip must lie between 0 and 1, got ", p.transfer.flip);
  ELASTOGEN_CHECK(p.jitter >= 0 && p.jitter <= 1, "--jitter must lie between 0 and 1, got ",
                  p.jitter);
  ELASTOGEN_CHECK(p.per_edge >= 1 && p.per_edge <= 8, "--per-edge must lie in 1 ... 8, got ",
                  p.per_edge);
  ELASTOGEN_CHECK(p.substeps >= 1 && p.substeps <= 1'000'000,
                  "--particle-substeps must lie in 1 ... 1000000, got ", p.substeps);
  ELASTOGEN_CHECK(p.passes >= 1 && p.passes <= 1000, "--passes must lie in 1 ... 1000, got ",
                  p.passes);
}

/// Solver, its hourglass term and the source of its energy.
void resolve_solver(const Typed& t, AnimateOptions& o) {
  o.solver.mode = solver_from_name(t.solver);
  o.solver.skip = !t.no_skip;
  const bool paper = o.solver.mode == SolverMode::kPaper;
  const int hourglass = choice("--hourglass", t.hourglass, {"full", "variance", "off", "auto"});
  o.hourglass = hourglass < 3 ? Hourglass(hourglass)
                : paper       ? Hourglass::kVariance
                              : Hourglass::kFull;
  o.energy = EnergySource(choice("--energy", t.energy, {"auto", "analytic", "neural"}));
  ELASTOGEN_CHECK(o.energy != EnergySource::kNeural || !o.fem,
                  "simulate has the laws themselves: leave out --energy neural");
}

void convert(const Typed& t, AnimateOptions& o) {
  resolve_material(t, o);
  convert_lists(t, o);
  resolve_particles(t, o);
  o.friction = parse_friction(t.friction);
  resolve_method(t, o);
  if (t.gravity != "auto") o.gravity = parse_vec3(t.gravity, Quantity::kAcceleration);
  if (!t.velocity.empty()) copy(parse_vec3(t.velocity, Quantity::kSpeed), o.motion.velocity);
  if (!t.spin.empty()) copy(parse_vec3(t.spin, Quantity::kSpin), o.motion.spin);
  if (t.has_floor) o.floor = resolve_floor(t.floor);
  // sizes and budgets
  if (t.h != "auto") o.h = parse_length(t.h);
  if (t.size != "auto") o.size = parse_length(t.size);
  if (t.thickness != "auto") o.thickness = parse_length(t.thickness);
  if (t.max_memory != "none") o.max_memory = parse_memory(t.max_memory);
  if (t.max_time != "none") o.max_time = parse_time(t.max_time);
  o.up = up_from_name(t.up);
  o.read.splat_scales = splat_scales_from_name(t.splat_scales);
  o.read.grid = t.grid == "auto" ? "" : t.grid;
  o.substeps = resolve_substeps(t.substeps);
  o.solver.time_error = resolve_share("--time-error", t.time_error);
  o.solver.follows_time_error = o.solver.tolerance == SolverOptions{}.tolerance;
  o.mesh_error = choice("--mesh-error", t.mesh_error, {"off", "on"}) == 1;
  resolve_solver(t, o);
  resolve_scheme(t, o);
  // outputs
  o.keyframe = choice("--glb-profile", t.profile, {"modal", "keyframe"}) == 1;
  ELASTOGEN_CHECK(o.glb_targets >= 4 && o.glb_targets <= 65536,
                  "--glb-targets must lie in 4 ... 65536, got ", o.glb_targets);
  o.picture.view = view_from_name(t.camera);
  set_image_size(t.image_size, o.picture);
  o.solver.device = Device(choice("--device", t.device, {"auto", "cpu", "cuda"}));
  ELASTOGEN_CHECK(o.solver.device != Device::kCuda || !o.fem,
                  "simulate runs on the CPU: leave out --device cuda");
}

/// A static run is one step of one second, from rest.
void resolve_statics(AnimateOptions& o) {
  ELASTOGEN_CHECK(!o.floor && o.colliders.empty(),
                  "--static does not see colliders: leave out --floor and --collider");
  const bool held = !o.pins.empty() || !o.holds.empty() || !o.moves.empty();
  ELASTOGEN_CHECK(held, "--static: nothing holds the asset; give --pin, --hold or --move");
  for (const double* start : {o.motion.velocity, o.motion.spin})
    ELASTOGEN_CHECK(start[0] == 0 && start[1] == 0 && start[2] == 0,
                    "--static has no start motion: leave out --velocity and --spin");
  o.frames = 1;
  o.fps = 1;
  o.substeps = 1;
}

void check_paper(const SolverOptions& s) {
  for (const auto& [name, value] :
       {std::pair{"--outer", s.paper.outer}, {"--inner", s.paper.inner}})
    ELASTOGEN_CHECK(value >= 1 && value <= 10000, name, " must lie in 1 ... 10000, got ", value);
  const int modes = s.paper.modes;
  ELASTOGEN_CHECK(modes >= 0 && modes <= 192 && modes % 3 == 0,
                  "--modes must be a multiple of 3 from 0 to 192, got ", modes);
}

void check_ranges(const Typed& t, const AnimateOptions& o) {
  ELASTOGEN_CHECK(t.h == "auto" || o.h > 0, "--h must be positive, got '", t.h, "'");
  ELASTOGEN_CHECK(t.size == "auto" || o.size > 0, "--size must be positive, got '", t.size, "'");
  ELASTOGEN_CHECK(t.thickness == "auto" || o.thickness > 0, "--thickness must be positive, got '",
                  t.thickness, "'");
  ELASTOGEN_CHECK(o.voxels >= 1, "--voxels must be 1 or more, got ", o.voxels);
  ELASTOGEN_CHECK(o.frames >= 0 && o.frames <= 1'000'000,
                  "--frames must lie in 0 ... 1000000, got ", o.frames);
  ELASTOGEN_CHECK(o.fps > 0 && std::isfinite(o.fps), "--fps must be positive, got ", o.fps);
  ELASTOGEN_CHECK(o.friction >= 0, "--friction must not be negative, got ", o.friction);
  ELASTOGEN_CHECK(!o.shape || o.input.empty(), "--shape stands in place of a file, and there is '",
                  o.input, "'");
  ELASTOGEN_CHECK(!o.shape || t.size == "auto", "--size: a shape has the size of its numbers");
  ELASTOGEN_CHECK(o.solver.tolerance > 0 && o.solver.tolerance < 1, "--tolerance must lie between ",
                  "0 and 1, got ", o.solver.tolerance);
  ELASTOGEN_CHECK(o.threads >= 0, "--threads must not be negative, got ", o.threads);
  ELASTOGEN_CHECK(o.max_voxels >= 1, "--max-voxels must be positive, got ", o.max_voxels);
  ELASTOGEN_CHECK(t.max_memory == "none" || o.max_memory > 0,
                  "--max-memory must be positive, got '", t.max_memory, "'");
  ELASTOGEN_CHECK(t.max_time == "none" || o.max_time > 0, "--max-time must be positive, got '",
                  t.max_time, "'");
}

}  // namespace

void resolve(const Typed& typed, AnimateOptions& options) {
  convert(typed, options);
  if (options.fem && options.fem->statics) resolve_statics(options);
  check_ranges(typed, options);
  check_paper(options.solver);
}

}  // namespace elastogen
