// SPDX-License-Identifier: Apache-2.0
// Options of a scene as they were typed, and what they mean.

#pragma once

#include "cli/options.hpp"

namespace elastogen {

/// Values as they were typed; empty means not given.
struct Typed {
  std::string material = "rubber", law, young, poisson, density;
  std::string yield, hardening, friction_angle, cohesion, keeps_volume, method = "auto";
  std::string shape, friction = "0.5", integrator = "implicit", dt = "auto";
  std::string transfer = "apic", blend_time = "0.01";
  std::string gravity = "auto", velocity, spin, h = "auto", size = "auto", substeps = "auto";
  std::string max_memory = "none", max_time = "none";
  std::vector<std::string> floor;
  bool has_floor = false;
  std::string splat_scales = "auto", grid = "auto", thickness = "auto";
  std::string up = "auto", scheme = "euler", solver = "auto", hourglass = "auto", profile = "modal";
  std::string device = "auto", energy = "auto";
  std::string camera = "three-quarter", image_size = "auto";
  std::string element = "auto", mass = "lumped";  ///< of simulate
  std::vector<std::string> pins, regions, colliders, holds, tractions, moves;
  bool no_skip = false;
};

/// Turns the texts into values and checks all of them.
/// @throws Error (usage) naming the option.
void resolve(const Typed& typed, AnimateOptions& options);

/// No output, the numbered files of animations included, may take the place of another or of the
/// scene file; only an animation that is one file may take that of the input.
/// @throws Error (usage) naming the file.
void check_outputs(const AnimateOptions& options, const std::string& scene_file = "");

/// A scene of a batch, by its file.
struct NamedScene {
  std::string file;
  const AnimateOptions& options;
};

/// No scene may write a file that another one writes or reads.
/// @throws Error (usage) naming the file and both scenes.
void check_outputs(const std::vector<NamedScene>& scenes);

}  // namespace elastogen
