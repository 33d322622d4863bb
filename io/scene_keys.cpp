// SPDX-License-Identifier: Apache-2.0
#include "io/scene_keys.hpp"

#include "io/scene_load_keys.hpp"
#include "io/scene_material_keys.hpp"
#include "io/scene_particle_keys.hpp"

#include <algorithm>

namespace elastogen {
namespace {

using T = SceneType;
using Q = Quantity;
using Keys = std::vector<SceneKey>;

constexpr double kMost = 9007199254740992;  // 2^53: float64 skips whole numbers above it
const SceneRange kPositive = {.least = 0, .above = true};
const SceneRange kNotNegative = {.least = 0};
const SceneRange kCount = {.least = 1, .most = kMost};

SceneRange whole(double least, double most) {
  return {.least = least, .most = most};
}

Keys asset_keys() {
  // members in the order of SceneKey
  return {
      {"asset", "file", T::kText, "", "INPUT", "the asset, from the folder of the scene file"},
      {"asset",
       "size",
       T::kNumber,
       "auto",
       "--size",
       "longest edge of the asset's box; auto: the file's numbers in its unit, else in metres",
       Q::kLength,
       kPositive,
       {"auto"}},
      {"asset",
       "up",
       T::kText,
       "auto",
       "--up",
       "direction that points up; auto: what the file says, else z for STL and LAS, y for others",
       Q::kNumber,
       {},
       {"auto", "x", "y", "z", "-x", "-y", "-z"}},
      {"asset",
       "splat_scales",
       T::kText,
       "auto",
       "--splat-scales",
       "scales and opacities of splats in a PLY: log and logit, linear, or auto: found out",
       Q::kNumber,
       {},
       {"auto", "log", "linear"}},
      {"asset", "grid", T::kText, "auto", "--grid",
       "grid of a .vdb by its name; auto: the first that has something"},
      {"asset", "voxels", T::kWhole, "48", "--voxels", "voxels along the longest edge", Q::kNumber,
       whole(1, 1 << 20)},
      {"asset",
       "h",
       T::kNumber,
       "auto",
       "--h",
       "voxel edge; auto: from voxels",
       Q::kLength,
       kPositive,
       {"auto"}},
      {"asset", "part_pieces", T::kFlag, "false", "--part-pieces",
       "true: pieces that do not touch are not joined, however near they are"},
      {"asset",
       "thickness",
       T::kNumber,
       "auto",
       "--thickness",
       "of what bounds no solid: sheets, and shells of points; auto: that of a voxel",
       Q::kLength,
       kPositive,
       {"auto"}},
  };
}

Keys floor_keys() {
  return {
      // where its plane lies
      {"floor", "on", T::kFlag, "true", "", "false: no floor, as without the table"},
      {"floor",
       "axis",
       T::kText,
       "auto",
       "",
       "axis across the floor; auto: that of up",
       Q::kNumber,
       {},
       {"auto", "x", "y", "z"}},
      {"floor",
       "place",
       T::kNumber,
       "auto",
       "",
       "coordinate of the floor along its axis; auto: where the asset begins",
       Q::kLength,
       {},
       {"auto"}},
      // contact with the floor
      {"floor",
       "friction",
       T::kNumber,
       "0.5",
       "--friction",
       "Coulomb's coefficient; sticky: particles that touch it move with it",
       Q::kNumber,
       kNotNegative,
       {"sticky"}},
  };
}

Keys collider_keys() {
  return {
      // one text for each, or tables whose shape tells the other keys
      {"", "colliders", T::kTexts, "[]", "--collider", "colliders as the option writes them"},
      {"collider",
       "shape",
       T::kText,
       "",
       "",
       "needed; says which of the other keys it has",
       Q::kNumber,
       {},
       {"plane", "sphere", "box"}},
      {"collider", "name", T::kText, "", "", "for messages: letters, digits, - and _"},
      // keys of the three shapes
      {"collider", "centre", T::kVector, "", "", "plane: a point of it; sphere: its centre",
       Q::kLength},
      {"collider", "normal", T::kVector, "", "", "plane: the direction of its free side",
       Q::kNumber},
      {"collider", "radius", T::kNumber, "", "", "sphere", Q::kLength, kPositive},
      {"collider", "lower", T::kVector, "", "", "box: its lower corner", Q::kLength},
      {"collider", "upper", T::kVector, "", "", "box: its upper corner", Q::kLength},
      // keys of every shape
      {"collider",
       "friction",
       T::kNumber,
       "that of the floor",
       "",
       "as that of the floor",
       Q::kNumber,
       kNotNegative,
       {"sticky"}},
      {"collider", "path", T::kPath, "at rest", "",
       "[t, x, y, z] in s and m: how far it is from its place at a time, straight between them"},
  };
}

Keys time_keys() {
  return {
      // length and rate of the clip
      {"time", "frames", T::kWhole, "120", "--frames", "frames after the rest frame", Q::kNumber,
       whole(0, 1e6)},
      {"time", "fps", T::kNumber, "30", "--fps", "frames a second", Q::kNumber, kPositive},
      // steps between its frames
      {"time",
       "substeps",
       T::kWhole,
       "auto",
       "--substeps",
       "time steps a frame",
       Q::kNumber,
       whole(1, 1e4),
       {"auto"}},
      {"time",
       "scheme",
       T::kText,
       "auto; with substeps sdirk2; euler for particles, materials that yield, the solver paper",
       "--time-scheme",
       "implicit Euler, BDF2 or SDIRK2 of fixed steps, or steps by their time error",
       Q::kNumber,
       {},
       {"euler", "bdf2", "sdirk2", "auto"}},
      {"time",
       "error",
       T::kNumber,
       "0.005",
       "--time-error",
       "scheme auto: error of a frame's steps in time, as a share of the motion in it",
       Q::kNumber,
       {.least = 0, .most = 1, .above = true, .below = true}},
  };
}

Keys solver_keys() {
  // method, tolerance, strain-variance term and source of the stress
  return {
      {"solver",
       "mode",
       T::kText,
       "auto",
       "--solver",
       "L-BFGS, Newton, the better of them, or the published algorithm",
       Q::kNumber,
       {},
       {"auto", "quasi", "newton", "paper"}},
      {"solver",
       "tolerance",
       T::kNumber,
       "0.001",
       "--tolerance",
       "residual, in units of the weight, below which a step is converged",
       Q::kNumber,
       {.least = 0, .most = 1, .above = true, .below = true}},
      {"solver",
       "hourglass",
       T::kText,
       "auto",
       "--hourglass",
       "strain-variance term; auto: variance for mode paper, else full",
       Q::kNumber,
       {},
       {"full", "variance", "off", "auto"}},
      {"solver",
       "energy",
       T::kText,
       "auto",
       "--energy",
       "what gives the stress: the law, or the net that was fitted to it; auto: the net where one "
       "keeps its limits",
       Q::kNumber,
       {},
       {"auto", "analytic", "neural"}},
  };
}

/// A key of the solver that is one of a few words.
SceneKey solver_word(const char* name, const char* usual, const char* option, const char* text,
                     std::vector<std::string> words) {
  return {"solver", name, T::kText, usual, option, text, Q::kNumber, {}, std::move(words)};
}

Keys effort_keys() {
  return {
      // bodies that yield
      solver_word(
          "method", "auto", "--method",
          "what steps a body that yields: particles (mpm) or elements (fem); auto: particles "
          "where a material falls apart into grains",
          {"auto", "mpm", "fem"}),
      // the mesh number
      solver_word("mesh_error", "on", "--mesh-error",
                  "estimate by how much frames are wrong because of the voxels' size",
                  {"off", "on"}),
      // speed and hardware
      {"solver", "skip", T::kFlag, "true", "--no-skip", "false: take no shortcut"},
      {"solver", "threads", T::kWhole, "0", "--threads", "0: all cores", Q::kNumber,
       whole(0, 1 << 20)},
      solver_word("device", "auto", "--device", "what the iterations run on",
                  {"auto", "cpu", "cuda"}),
  };
}

Keys paper_keys() {
  return {
      {"solver", "outer", T::kWhole, "10", "--outer", "mode paper: outer loops", Q::kNumber,
       whole(1, 1e4)},
      {"solver", "inner", T::kWhole, "20", "--inner", "mode paper: sweeps of each loop", Q::kNumber,
       whole(1, 1e4)},
      {"solver", "modes", T::kWhole, "54", "--modes",
       "mode paper: latent size, three times the cosines", Q::kNumber, whole(0, 192)},
  };
}

Keys limit_keys() {
  return {
      // size and cost of a run
      {"limits", "max_voxels", T::kWhole, "64000000", "--max-voxels", "refused above", Q::kNumber,
       kCount},
      {"limits",
       "max_memory",
       T::kNumber,
       "none",
       "--max-memory",
       "refused above",
       Q::kMemory,
       kCount,
       {"none"}},
      {"limits",
       "max_time",
       T::kNumber,
       "none",
       "--max-time",
       "wall time of the steps",
       Q::kTime,
       kPositive,
       {"none"}},
      // what a warning is
      {"limits", "strict", T::kFlag, "false", "--strict", "true: warnings are errors"},
      {"limits", "strict_time", T::kFlag, "false", "--strict-time",
       "true: a run with frames above the time error ends with exit code 4"},
  };
}

Keys output_keys() {
  return {
      // animations
      {"output", "files", T::kTexts, "[]", "-o", "animations, each by its ending"},
      {"output",
       "glb_profile",
       T::kText,
       "modal",
       "--glb-profile",
       "displacement modes or frames",
       Q::kNumber,
       {},
       {"modal", "keyframe"}},
      {"output", "glb_targets", T::kWhole, "64", "--glb-targets",
       "most morph targets of a mesh; longer clips are shown in pieces", Q::kNumber,
       whole(4, 65536)},
      {"output", "glb_colliders", T::kFlag, "false", "--glb-colliders",
       "true: floor and colliders in the GLB too"},
      // pictures
      {"output",
       "camera",
       T::kText,
       "three-quarter",
       "--camera",
       "where pictures are taken from; turntable: once around",
       Q::kNumber,
       {},
       {"three-quarter", "front", "back", "left", "right", "top", "turntable"}},
      {"output", "image_size", T::kText, "auto", "--image-size",
       "WIDTHxHEIGHT of a picture [pixels]; auto: 320x320 on a sheet, else 960x540"},
      // files about the run
      {"output", "state", T::kText, "", "--state", "state file (HDF5)"},
      {"output", "log", T::kText, "", "--log-json", "one JSON object a time step"},
      {"output", "report", T::kText, "", "--report", "summary of the run (JSON)"},
      {"output", "quiet", T::kFlag, "false", "--quiet", "true: print errors only"},
  };
}

}  // namespace

std::span<const SceneTable> scene_tables() {
  static const std::vector<SceneTable> tables = {
      {"asset", false, "What is animated, how large, and how finely."},
      {"shape", false,
       "A body without a file, in place of asset.file; its size is that of its numbers."},
      {"material", false, "The material of what no region takes."},
      {"region", true, "A part of another material."},
      {"pin", true, "A part that is held, as in `pins`."},
      {"hold", true, "A part that is held along some axes."},
      {"traction", true, "A force or a pressure on a part of the surface."},
      {"move", true, "A part that is shifted along a path, or turned."},
      {"motion", false, "Motion at the start."},
      {"floor", false, "A floor; it is there when the table is."},
      {"collider", true, "An obstacle, at rest or on a path."},
      {"time", false, "Frames and time steps."},
      {"solver", false, "How a time step is solved."},
      {"particles", false, "Particles, of what falls apart into grains."},
      {"limits", false, "Budgets."},
      {"output", false, "What is written, from the folder the command runs in."},
  };
  return tables;
}

std::span<const SceneKey> scene_keys() {
  static const Keys keys = [] {
    Keys all;
    for (const Keys& part :
         {asset_keys(), shape_keys(), particle_keys(), main_material_keys(), region_keys(),
          load_keys(), floor_keys(), collider_keys(), time_keys(), solver_keys(), effort_keys(),
          paper_keys(), limit_keys(), output_keys()})
      all.insert(all.end(), part.begin(), part.end());
    const auto order = [](const SceneKey& key) {
      return key.table.empty() ? 0 : 1 + (find_scene_table(key.table) - scene_tables().data());
    };
    std::stable_sort(all.begin(), all.end(),
                     [&](const SceneKey& a, const SceneKey& b) { return order(a) < order(b); });
    return all;
  }();
  return keys;
}

const SceneKey* find_scene_key(std::string_view table, std::string_view name) {
  for (const SceneKey& key : scene_keys())
    if (key.table == table && key.name == name) return &key;
  return nullptr;
}

const SceneTable* find_scene_table(std::string_view name) {
  for (const SceneTable& table : scene_tables())
    if (table.name == name) return &table;
  return nullptr;
}

}  // namespace elastogen
