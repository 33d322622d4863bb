// SPDX-License-Identifier: Apache-2.0
// `--state`: an HDF5 file from which others can recompute every step of a run (docs/formats.md,
// state file).

#pragma once

#include "core/report.hpp"
#include "core/state.hpp"
#include "io/particle_frame.hpp"
#include "io/safe_file.hpp"

#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace elastogen {

/// Nodes and elements of a run that does not compute on the voxels themselves.
struct StateMesh {
  Scene nodes;               ///< all nodes at rest, and what holds them, as HeldNodes reads them
  Array<int32_t> corners;    ///< nodes of each element, (elements, 4 or 10)
  Array<double> mass;        ///< [kg], (nodes, 1)
  Array<double> fill, part;  ///< of elements that pins cut (fem::ElementMesh), else empty
  Array<int32_t> material;   ///< (elements, 1)
  Array<int32_t> contact_nodes;   ///< nodes that carry each surface point, (points, 4 or 10)
  Array<double> contact_weights;  ///< weights of these nodes, (points, 4 or 10)
};

/// The net of a material, which gives its energy in place of the law.
struct StateNet {
  std::string hash;            ///< SHA-256 of its file
  std::vector<float> weights;  ///< 17153
  int cells = 0;               ///< table cells in a unit of log stretch; 0: no table
  std::vector<float> table;    ///< coefficients of the table, a cube
};

/// State of a body that yields at the end of a run. For particles only the yields: their steps have
/// the rest.
struct StatePlastic {
  Array<double> yields;      ///< of each material: kind 0 ... 3 and four numbers, (materials, 5)
  Array<double> Fp_inverse;  ///< of the points of elements that yield, in order, (points, 9)
  Array<double> memory;      ///< the law's internal variable at each point, (points, 1)
};

/// Facts of the run beside its scene.
struct StateHeader {
  double fps = 60;
  std::string solver;               ///< "quasi", "newton", "paper", "fem" or "mpm"
  std::string element = "voxel";    ///< "voxel", a finite element, or "particle"
  std::string scheme = {};          ///< "newmark", "static"; empty: the scene's scheme
  double tolerance = 1e-3;          ///< of the residual [-]
  std::string energy = "analytic";  ///< source of the stress
  std::vector<StateNet> nets =
      {};              ///< of each material, without weights where its law holds; empty: analytic
  std::string commit;  ///< of the build
  /// parameters of the contact model, e.g. {"distance", 0.001}: attributes of /contact
  std::vector<std::pair<std::string, double>> contact;
  std::optional<StateMesh> mesh = {};         ///< in place of the grid
  std::optional<ParticleSet> particles = {};  ///< in place of the grid
  Array<uint8_t> fixed = {};    ///< 1: the component's displacement is prescribed, (nodes, 3)
  Array<double> traction = {};  ///< dead load on each node [N], (nodes, 3); both empty: none
  std::vector<TimedForce> forces = {};
  bool moved = false;    ///< prescribed displacements may change
  double path_time = 1;  ///< of paths in a unit of time: in statics that is the load factor
};

/// What the file has of a report: long clips keep many of them.
struct ReportFields {
  TimeScheme scheme;
  bool converged, guarded;
  int32_t outer, inner, fallbacks;
  double residual, ms, min_j, length, tolerance, time_error, time_ratio;
  EnergyParts energy;
  std::optional<MeshError> mesh_error;
};

/// Keeps every step in a raw file in the target's folder and packs all of them into the target at
/// the end. The raw file has no name, so the system frees it however the process ends.
class StateWriter {
 public:
  /// @param scene    finished; must outlive the writer.
  /// @param initial  the start, entry 0 of /steps/x, v and time.
  /// @param strain   strain at the start, for particles.
  /// @throws Error (resources) if the raw file cannot be written; (usage) on wrong shapes.
  StateWriter(const std::string& path, const Scene& scene, const StateHeader& header,
              const State& initial, const ParticleStrain* strain = nullptr);

  /// Adds the state after a time step and its report. Call once a step, substeps included.
  /// @param data  of steps of stages, for scenes whose scheme makes them.
  /// @throws Error (resources) if the disk is full; (usage) on wrong shapes.
  void step(const State& state, const StepReport& report, const ParticleStrain* strain = nullptr,
            const StageData& data = {});

  /// Sets the plastic state of the body after the last step.
  void set_plastic(StatePlastic plastic) { plastic_ = std::move(plastic); }

  /// Writes the file under a temporary name and renames it. Also valid for a run that ended early.
  /// @throws Error (resources)
  void finish();

 private:
  void keep(const State& state, const ParticleStrain* strain, const StepReport* report,
            const StageData& data);

  const Scene& scene_;
  StateHeader header_;
  std::optional<StatePlastic> plastic_;
  std::string path_;
  SafeFile spill_file_;                                    ///< never committed
  std::unique_ptr<std::FILE, int (*)(std::FILE*)> spill_;  ///< numbers of each entry, raw float64
  std::vector<double> time_;                               ///< of each entry [s]
  std::vector<ReportFields> reports_;                      ///< one fewer than entries
  std::vector<Reaction> reactions_;                        ///< of each step, by holders
};

}  // namespace elastogen
