// SPDX-License-Identifier: Apache-2.0
// An animation as a file: the asset unchanged except for its vertices, which move frame by frame.

#pragma once

#include "core/mesh_error.hpp"
#include "core/scene.hpp"
#include "core/state.hpp"
#include "io/asset.hpp"
#include "io/particle_frame.hpp"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// What the solver certifies about one frame; the rest pose is converged with residual 0.
struct FrameCertificate {
  bool converged = false;  ///< all of its steps are (core/step_verdict.hpp)
  double residual = 0;     ///< |grad E| / |M g_ref| of the true equations [-]
  double min_j = 1;        ///< smallest det F [-]
  double time_error = 0;   ///< estimate of what its steps add to the time error [m]; 0: none made
  double time_ratio = 0;   ///< largest of its steps' estimates over what was accepted [-]
  std::optional<MeshError> mesh_error = {};  ///< none where it was not estimated
};

/// One frame as writers see it. The carried points are the vertices of the surface, or the asset's
/// points or splats.
struct AnimationFrame {
  Span<const double> displacement;   ///< of the carried points [m], (points, 3), finite
  Span<const double> gradient = {};  ///< F at the carried points, row-major, (points, 9); filled
                                     ///< where a writer needs it
  const State* state = nullptr;      ///< of the scene; filled where a writer needs velocities
  Span<const double> residual = {};  ///< gradient of the incremental potential [N], (nodes, 3);
                                     ///< filled where a writer needs it
  const ParticleStrain* particles = nullptr;  ///< of runs with particles; comes with the state
  FrameCertificate certificate = {};
};

/// Least motion that can be seen, as a share of the longest edge: a tenth of a pixel if the asset
/// is a thousand pixels long.
inline constexpr double kVisibleMotion = 1e-4;

struct AnimationOptions {
  double fps = 30;             ///< [1/s]
  bool keyframe = false;       ///< one morph target a frame; else displacement modes
  double modal_error = 1e-3;   ///< largest vertex error of the modes / longest edge [-]; a tenth of
                               ///< the motion where that is less
  int max_targets = 64;        ///< of a mesh of a GLB, 4 at least; longer clips are in pieces
  bool colliders = false;      ///< a GLB shows scene->colliders too
  std::string generator = "";  ///< program and version
  std::string command = "";    ///< the command line
  std::string commit = "";     ///< of the program
  Matrix4 root = kIdentity4;   ///< scale of --size and turn of --up, applied above all scene roots
  const Scene* scene = nullptr;  ///< for the writers of voxel data; outlives the writer
  /// Nodes of tetrahedra in place of the scene's voxels, (tetrahedra, 4 or 10), the material of
  /// each in scene->material; outlives the writer.
  const Array<int32_t>* tets = nullptr;
  std::optional<ParticleSet> particles = {};  ///< the nodes are particles
};

/// Writes an animation frame by frame; the first frame is the start. Frames wait in an unnamed file
/// beside the output, so that memory does not grow with their number. Without finish() nothing
/// remains except the finished files of a sequence.
class AnimationWriter {
 public:
  virtual ~AnimationWriter() = default;

  /// A writer by the ending of `path`: .glb (meshes), .ply (one file a frame), .pc2, .pvd (voxels
  /// or particles). Pictures (.png) and surfaces of particles (.obj, .vdb, .mesh.ply) have writers
  /// of their own (cli/picture/picture_writer.hpp, scene/particle_surface_writer.hpp).
  /// @param asset, surface  what was read and posed; both must outlive the writer.
  /// @throws Error (usage) for another ending, a .glb of points or splats, fps <= 0 or a root
  ///         matrix without inverse; (resources) if the folder cannot be written.
  static std::unique_ptr<AnimationWriter> create(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const AnimationOptions& options = {});

  /// Whether frames must come with the deformation gradient.
  virtual bool needs_gradient() const { return false; }

  /// Whether frames must come with velocities and residual.
  virtual bool needs_motion() const { return false; }

  /// Adds a frame.
  virtual void frame(const AnimationFrame& frame) = 0;

  /// Writes the file under a temporary name and renames it.
  /// @throws Error (usage) without a frame; (resources) if disk or format cannot hold it.
  virtual void finish() = 0;

  /// Sentences for the user after finish(): choices, and what the file could not hold.
  virtual std::vector<std::string> notes() const { return {}; }
  virtual std::vector<std::string> warnings() const { return {}; }
};

}  // namespace elastogen
