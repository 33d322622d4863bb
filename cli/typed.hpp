// SPDX-License-Identifier: Apache-2.0
// Options of a scene as they were typed, and their values.

#pragma once

#include "cli/options.hpp"

namespace elastogen {

/// Values as they were typed; empty means not given.
struct Typed {
  std::string material = "rubber", law, young, poisson, density, damping, damping_frequency;
  std::string yield, hardening, friction_angle, cohesion, keeps_volume, method = "auto";
  std::string shape, friction = "0.5", integrator = "implicit", dt = "auto";
  std::string transfer = "apic", blend_time = "0.01";
  std::string gravity = "auto", velocity, spin, h = "auto", size = "auto", substeps = "auto";
  std::string max_memory = "none", max_time = "none";
  std::vector<std::string> floor;
  bool has_floor = false;
  std::string splat_scales = "auto", grid = "auto", thickness = "auto";
  std::string up = "auto", scheme, time_error = "0.5%", solver = "auto", hourglass = "auto",
              profile = "modal";
  std::string device = "auto", energy = "auto", mesh_error = "on";
  std::string camera = "three-quarter", image_size = "auto";
  std::string element = "auto", mass = "lumped";  ///< only for simulate
  std::vector<std::string> pins, regions, colliders, holds, tractions, forces, moves;
  std::string wind;
  bool no_skip = false;
};

/// Turns the texts into values and checks all of them.
/// @throws Error (usage) naming the option.
void resolve(const Typed& typed, AnimateOptions& options);

/// No output (numbered files of animations included) may replace another one or the scene file.
/// Only an animation in a single file may replace the input.
/// @throws Error (usage) naming the file.
void check_outputs(const AnimateOptions& options, const std::string& scene_file = "");

/// A scene of a batch and its file.
struct NamedScene {
  std::string file;
  const AnimateOptions& options;
};

/// No scene may write a file that another scene writes or reads.
/// @throws Error (usage) naming the file and both scenes.
void check_outputs(const std::vector<NamedScene>& scenes);

}  // namespace elastogen
