// SPDX-License-Identifier: Apache-2.0
#include "cli/scene_options.hpp"

#include "io/scene_keys.hpp"
#include "mpm_fem/materials/solid_presets.hpp"
#include "scene/tet_asset.hpp"

#include <fmt/format.h>

#include <cmath>

namespace elastogen {
namespace {

using Kind = SceneValue::Kind;

/// Shortest text that reads back as the same number; whole numbers without exponent.
std::string number_text(double number) {
  if (number == std::floor(number) && std::abs(number) < 1e15)
    return fmt::format("{}", int64_t(number));
  return fmt::format("{}", number);
}

/// Numbers between commas, or a single text.
std::string value_text(const SceneValue& value) {
  if (value.kind == Kind::kText) return value.text;
  if (value.kind == Kind::kFlag) return value.flag ? "true" : "false";
  if (value.kind == Kind::kNumber) return number_text(value.number);
  std::string text;
  for (const SceneValue& item : value.items)
    text += fmt::format("{}{}", text.empty() ? "" : ",", value_text(item));
  return text;
}

std::string text_of(const SceneValue& table, const char* key, const std::string& fallback) {
  const SceneValue* value = table.find(key);
  return value ? value_text(*value) : fallback;
}

/// The selection of a table as the options write it.
std::string selection_text(const SceneValue& table) {
  if (table.find("node")) return fmt::format("node:{}", text_of(table, "node", ""));
  if (table.find("gltf_material"))
    return fmt::format("material:{}", text_of(table, "gltf_material", ""));
  return text_of(table, "select", "");
}

std::string region_text(const SceneValue& region, const std::string& preset) {
  std::string text =
      fmt::format("{}: {}", selection_text(region), text_of(region, "preset", preset));
  for (const auto& [key, word] : {std::pair("law", "law"),
                                  {"young", "young"},
                                  {"poisson", "poisson"},
                                  {"density", "density"},
                                  {"damping", "damping"},
                                  {"damping_frequency", "damping-frequency"},
                                  {"yield", "yield"},
                                  {"hardening", "hardening"},
                                  {"cohesion", "cohesion"},
                                  {"friction_angle", "friction-angle"},
                                  {"keeps_volume", "keeps-volume"}})
    if (region.find(key)) text += fmt::format(",{}={}", word, text_of(region, key, ""));
  return text;
}

/// " T:x,y,z; T:x,y,z" from lists of a time and values at that time.
std::string path_text(const SceneValue& path) {
  std::string text;
  for (const SceneValue& key : path.items) {
    SceneValue place = key;
    place.items.erase(place.items.begin());
    text += fmt::format("{} {}:{}", text.empty() ? "" : ";", value_text(key.items[0]),
                        value_text(place));
  }
  return text;
}

std::string collider_text(const SceneValue& c) {
  const std::string shape = text_of(c, "shape", "");
  const bool box = shape == "box";
  std::string text = fmt::format("{}({}, {})", shape, text_of(c, box ? "lower" : "centre", ""),
                                 text_of(c,
                                         box                ? "upper"
                                         : shape == "plane" ? "normal"
                                                            : "radius",
                                         ""));
  for (const char* key : {"friction", "name"})
    if (c.find(key)) text += fmt::format(" {} {}", key, text_of(c, key, ""));
  const SceneValue* path = c.find("path");
  if (path && !path->items.empty()) text += " path" + path_text(*path);
  return text;
}

std::string shape_text(const SceneValue& shape) {
  const bool round = shape.find("radius") != nullptr;
  return fmt::format("{}({}, {})", text_of(shape, "kind", ""),
                     text_of(shape, round ? "centre" : "lower", ""),
                     text_of(shape, round ? "radius" : "upper", ""));
}

std::string hold_text(const SceneValue& hold) {
  return fmt::format("{}: {}", selection_text(hold), text_of(hold, "axes", ""));
}

std::string traction_text(const SceneValue& traction) {
  return fmt::format("{}: {}", selection_text(traction),
                     text_of(traction, traction.find("force") ? "force" : "pressure", ""));
}

std::string move_text(const SceneValue& move) {
  const std::string select = selection_text(move);
  std::string words;
  for (const char* word : {"ease", "loop"})
    if (const SceneValue* flag = move.find(word); flag && flag->flag)
      words += std::string(" ") + word;
  if (const SceneValue* path = move.find("path"))
    return fmt::format("{}: shift{}{}", select, words, path_text(*path));
  return fmt::format("{}: turn({}, {}){}{}", select, text_of(move, "turn_centre", ""),
                     text_of(move, "turn_axis", ""), words, path_text(*move.find("turn")));
}

std::string floor_text(const SceneValue& floor) {
  const SceneValue* on = floor.find("on");
  if (on && !on->flag) return "off";
  return fmt::format("{}={}", text_of(floor, "axis", "auto"), text_of(floor, "place", "auto"));
}

/// The texts of a key's value; none if it has none.
std::vector<std::string> key_texts(const SceneKey& key, const SceneValue& value) {
  std::vector<std::string> texts;
  if (key.type == SceneType::kTexts)
    for (const SceneValue& item : value.items) texts.push_back(item.text);
  else if (key.type == SceneType::kFlag)
    texts.push_back((key.name == "skip") != value.flag ? "true" : "false");
  else if (const std::string text = value_text(value); !text.empty())
    texts.push_back(text);
  return texts;
}

/// Adds the tables that may occur many times, after the list of texts of that option.
void add_tables(const SceneValue& scene, std::vector<SceneOption>& options) {
  const auto add = [&](const char* table, const char* option, const auto& text) {
    const SceneValue* items = scene.find(table);
    if (!items || items->items.empty()) return;
    auto at = options.begin();
    while (at != options.end() && at->option != option) ++at;
    if (at == options.end()) at = options.insert(at, {option, {}});
    for (const SceneValue& item : items->items) at->texts.push_back(text(item));
  };
  const SceneValue* material = scene.find("material");
  const std::string preset = material ? text_of(*material, "preset", "rubber") : "rubber";
  add("pin", "--pin", selection_text);
  add("region", "--region", [&](const SceneValue& r) { return region_text(r, preset); });
  add("collider", "--collider", collider_text);
  add("hold", "--hold", hold_text);
  add("traction", "--traction", traction_text);
  add("move", "--move", move_text);
}

SceneValue quantity(double value, const char* word) {
  return value > 0 ? scene_number(value) : scene_text(word);
}

SceneValue vector(const double* x) {
  SceneValue list;
  list.kind = Kind::kList;
  for (int d = 0; d < 3; ++d) list.items.push_back(scene_number(x[d]));
  return list;
}

/// Values as they were typed.
template <class Values>
SceneValue texts_of(const Values& values) {
  std::vector<std::string> texts;
  for (const auto& value : values) texts.push_back(value.text);
  return scene_texts(texts);
}

SceneValue asset_table(const AnimateOptions& o) {
  SceneValue t;
  t.set("file", scene_text(o.input));
  t.set("size", quantity(o.size, "auto"));
  t.set("up", scene_text(o.up ? up_name(*o.up) : "auto"));
  t.set("splat_scales", scene_text(splat_scales_name(o.read.splat_scales)));
  t.set("grid", scene_text(o.read.grid.empty() ? "auto" : o.read.grid));
  if (o.fem && is_tet_file(o.input)) return t;  // meshes of tetrahedra have no voxels
  t.set("voxels", scene_number(o.voxels));
  t.set("h", quantity(o.h, "auto"));
  t.set("part_pieces", scene_flag(o.part_pieces));
  t.set("thickness", quantity(o.thickness, "auto"));
  return t;
}

/// A preset that yields as a changed material does; all its numbers are overridden.
const char* preset_like(const Yield& yield) {
  constexpr const char* kNames[] = {"rubber", "steel", "sand", "snow"};
  return kNames[yield.index()];
}

void set_yield(const Yield& yield, SceneValue& t) {
  if (const auto* metal = std::get_if<MetalYield>(&yield)) {
    t.set("yield", scene_number(metal->stress));
    t.set("hardening", scene_number(metal->hardening));
  } else if (const auto* sand = std::get_if<SandYield>(&yield)) {
    t.set("friction_angle", scene_number(sand->friction));
    t.set("cohesion", scene_number(sand->cohesion));
    t.set("keeps_volume", scene_flag(sand->keeps_volume));
  } else if (const auto* snow = std::get_if<SnowYield>(&yield)) {
    t.set("yield", scene_number(snow->pressure));
    t.set("hardening", scene_number(snow->hardening));
    t.set("friction_angle", scene_number(critical_angle(snow->slope)));
    t.set("cohesion", scene_number(snow->cohesion));
  }
}

/// @param scheme  with stages the preset's damping holds where none was chosen (scene/set_up.cpp)
SceneValue material_table(const Material& m, const Yield& yield, TimeScheme scheme) {
  SceneValue t;
  t.set("preset", scene_text(m.name == "custom" ? preset_like(yield) : m.name));
  t.set("law", scene_text(law_name(m.law)));
  t.set("young", scene_number(m.young));
  t.set("poisson", scene_number(m.poisson));
  t.set("density", scene_number(m.density));
  const double usual = has_stages(scheme) && yield.index() == 0 ? m.usual_loss : 0;
  t.set("damping", scene_number(m.loss_factor.value_or(usual)));
  t.set("damping_frequency", scene_number(m.loss_frequency));
  set_yield(yield, t);
  return t;
}

SceneValue motion_table(const StartMotion& motion) {
  SceneValue t;
  t.set("velocity", vector(motion.velocity));
  t.set("spin", vector(motion.spin));
  return t;
}

SceneValue floor_table(const AnimateOptions& o) {
  const FloorPlane floor = o.floor.value_or(FloorPlane{});
  SceneValue t;
  t.set("on", scene_flag(o.floor.has_value()));
  t.set("axis", scene_text(floor.axis < 0 ? "auto" : std::string(1, char('x' + floor.axis))));
  t.set("place", floor.place ? scene_number(*floor.place) : scene_text("auto"));
  t.set("friction", o.friction == kSticks ? scene_text("sticky") : scene_number(o.friction));
  return t;
}

SceneValue time_table(const AnimateOptions& o) {
  SceneValue t;
  t.set("frames", scene_number(double(o.frames)));
  t.set("fps", scene_number(o.fps));
  t.set("substeps", quantity(o.substeps, "auto"));
  t.set("scheme", scene_text(find_scene_key("time", "scheme")->words[size_t(o.scheme)]));
  t.set("error", scene_number(o.solver.time_error));
  return t;
}

SceneValue solver_table(const AnimateOptions& o) {
  SceneValue t;
  t.set("mode", scene_text(std::string(solver_name(o.solver.mode))));
  if (!o.fem || !o.fem->any_rounding) t.set("tolerance", scene_number(o.solver.tolerance));
  t.set("hourglass", scene_text(find_scene_key("solver", "hourglass")->words[size_t(o.hourglass)]));
  t.set("energy", scene_text(find_scene_key("solver", "energy")->words[size_t(o.energy)]));
  t.set("method", scene_text(find_scene_key("solver", "method")->words[size_t(o.method)]));
  t.set("outer", scene_number(o.solver.paper.outer));
  t.set("inner", scene_number(o.solver.paper.inner));
  t.set("modes", scene_number(o.solver.paper.modes));
  t.set("mesh_error", scene_text(o.mesh_error ? "on" : "off"));
  t.set("skip", scene_flag(o.solver.skip));
  t.set("threads", scene_number(o.threads));
  t.set("device", scene_text(find_scene_key("solver", "device")->words[size_t(o.solver.device)]));
  return t;
}

SceneValue shape_table(const BodyShape& shape) {
  SceneValue t;
  t.set("kind", scene_text(kind_name(shape.kind)));
  if (shape.is_round()) {
    t.set("centre", vector(shape.centre.data()));
    t.set("radius", scene_number(shape.radius));
  } else {
    t.set("lower", vector(shape.lower.data()));
    t.set("upper", vector(shape.upper.data()));
  }
  return t;
}

SceneValue particles_table(const ParticleOptions& p) {
  const auto word = [](const char* key, auto value) {
    return scene_text(find_scene_key("particles", key)->words[size_t(value)]);
  };
  SceneValue t;
  t.set("integrator", word("integrator", p.integrator));
  t.set("dt", quantity(p.dt, "auto"));
  t.set("substeps", scene_number(p.substeps));
  t.set("passes", scene_number(p.passes));
  t.set("per_edge", scene_number(p.per_edge));
  t.set("jitter", scene_number(p.jitter));
  t.set("transfer", word("transfer", p.transfer.kind));
  t.set("blend_time", scene_number(p.transfer.blend_time));
  t.set("flip", scene_number(p.transfer.flip));
  return t;
}

SceneValue limits_table(const AnimateOptions& o) {
  SceneValue t;
  t.set("max_voxels", scene_number(double(o.max_voxels)));
  t.set("max_memory", quantity(double(o.max_memory), "none"));
  t.set("max_time", quantity(o.max_time, "none"));
  t.set("strict", scene_flag(o.strict));
  t.set("strict_time", scene_flag(o.strict_time));
  return t;
}

SceneValue output_table(const AnimateOptions& o) {
  SceneValue t;
  t.set("files", scene_texts(o.outputs));
  t.set("glb_profile", scene_text(o.keyframe ? "keyframe" : "modal"));
  t.set("glb_targets", scene_number(o.glb_targets));
  t.set("glb_colliders", scene_flag(o.glb_colliders));
  t.set("camera", scene_text(std::string(view_names()[size_t(o.picture.view)])));
  t.set("image_size",
        scene_text(o.picture.width > 0 ? fmt::format("{}x{}", o.picture.width, o.picture.height)
                                       : "auto"));
  t.set("state", scene_text(o.state));
  t.set("log", scene_text(o.log));
  t.set("report", scene_text(o.report));
  t.set("quiet", scene_flag(o.quiet));
  return t;
}

}  // namespace

std::vector<SceneOption> scene_options(const SceneValue& scene) {
  std::vector<SceneOption> options;
  for (const SceneKey& key : scene_keys()) {
    const SceneValue* table = key.table.empty() ? &scene : scene.find(key.table);
    const SceneValue* value = table && *key.option ? table->find(key.name) : nullptr;
    if (!value) continue;
    std::vector<std::string> texts = key_texts(key, *value);
    if (!texts.empty()) options.push_back({key.option, std::move(texts)});
  }
  if (const SceneValue* floor = scene.find("floor"))
    options.push_back({"--floor", {floor_text(*floor)}});
  if (const SceneValue* shape = scene.find("shape"))
    options.push_back({"--shape", {shape_text(*shape)}});
  add_tables(scene, options);
  return options;
}

SceneValue resolved_scene(const AnimateOptions& o) {
  SceneValue scene;
  scene.set("pins", texts_of(o.pins));
  scene.set("regions", texts_of(o.regions));
  scene.set("colliders", texts_of(o.colliders));
  scene.set("holds", texts_of(o.holds));
  scene.set("tractions", texts_of(o.tractions));
  scene.set("forces", texts_of(o.forces));
  scene.set("moves", texts_of(o.moves));
  scene.set("wind", scene_text(o.wind_text));
  scene.set("gravity", o.gravity ? vector(o.gravity->data()) : scene_text("auto"));
  scene.set("asset", asset_table(o));
  if (o.shape) scene.set("shape", shape_table(*o.shape));
  scene.set("material", material_table(o.material, o.yield, o.scheme));
  scene.set("motion", motion_table(o.motion));
  scene.set("floor", floor_table(o));
  scene.set("time", time_table(o));
  scene.set("solver", solver_table(o));
  scene.set("particles", particles_table(o.particles));
  scene.set("limits", limits_table(o));
  scene.set("output", output_table(o));
  return scene;
}

}  // namespace elastogen
