// SPDX-License-Identifier: Apache-2.0
// A glTF document to which an animation of morph target weights is added, written so that clients
// with different habits play it: docs/formats.md, "What clients need".

#pragma once

#include "io/glb_document.hpp"
#include "io/morph_targets.hpp"

#include <nlohmann/json.hpp>

#include <map>
#include <optional>
#include <set>

namespace elastogen {

class AnimatedDocument {
 public:
  using Json = nlohmann::ordered_json;

  /// @param clip_times  times of the frames of the whole clip [s].
  AnimatedDocument(GlbDocument base, std::vector<float> clip_times);

  Json& json() { return json_; }

  /// Nodes other than `staged` keep their meshes as they are. Staged nodes that show such a mesh
  /// too get a copy.
  void keep_meshes_of_others(const std::set<size_t>& staged);

  /// The nodes that show the mesh of a node, one for each of several pieces of the clip.
  ///
  /// It is the node itself, unless that has a matrix (which glTF forbids in nodes that an animation
  /// targets) or shows meshes below it (some clients pass weights down), or the clip has several
  /// pieces: then each piece has a child without transform, and a scale of 0 or 1 hides all but one
  /// of them. Each has its own mesh; copies share their vertices.
  std::vector<size_t> stage(size_t node, const std::vector<FrameRange>& pieces);

  /// An accessor of the weights of a piece, (frames, targets).
  size_t add_weights(const Array<float>& weights);

  /// Gives the mesh of a staged node its targets and animates their weights.
  void play(size_t node, const MorphTargets& targets, const FrameRange& frames, size_t weights);

  /// A grey body in the default scene: its surface about `place`, (vertices, 3), in the numbers of
  /// the asset and, if it moves, its offsets in each frame of the clip.
  struct Obstacle {
    std::string name;
    Vec3 place = {};
    std::vector<float> positions, normals;
    std::vector<uint32_t> corners;
    std::vector<Vec3> offsets = {};  ///< empty: it does not move
  };
  void add_obstacle(const Obstacle& obstacle);

  /// Puts a node with a matrix above the roots of the default scene.
  void add_root(const Matrix4& matrix);

  /// Writes the GLB. @throws Error (resources) as write_glb.
  void write(const std::string& path);

 private:
  /// Vertices that primitives share through one POSITION accessor, and their targets.
  struct Range {
    int64_t first = 0, count = 0;
    std::vector<Json> targets;  // without and with NORMAL
  };

  static constexpr int kFloat = 5126, kUnsignedInt = 5125;   // types of components
  static constexpr int kVertices = 34962, kIndices = 34963;  // targets of views

  bool shows_below(size_t node) const;
  std::string free_name(const std::string& wanted);
  size_t add_child(size_t node, const std::string& ending);
  void own_mesh(size_t node, size_t mesh);
  size_t default_material();
  size_t obstacle_material();
  void show_in_turn(const std::vector<size_t>& nodes, const std::vector<FrameRange>& pieces);
  void add_channel(size_t node, const char* path, const char* interpolation, size_t input,
                   size_t output);

  Json& scene();
  size_t add_scalars(const std::vector<float>& values);
  size_t times_of(const FrameRange& frames);
  size_t add_view(uint64_t offset, size_t size);
  size_t add_accessor(Json accessor);
  size_t add_vectors(size_t view, uint64_t offset, const float* values, int64_t count);
  size_t zeros(int64_t count);
  std::vector<size_t> add_rows(const Array<float>& rows, const Range& range);
  void fill_range(const MorphTargets& targets, Range& range);
  std::map<size_t, Range> ranges_of(const Json& mesh, const MorphTargets& targets);
  void set_targets(Json& mesh, const MorphTargets& targets);

  Bytes bin_;
  Json json_, channels_ = Json::array(), samplers_ = Json::array();
  std::vector<float> clip_times_;
  std::map<std::pair<int64_t, int64_t>, size_t> times_;  // accessor of times by range of frames
  std::map<int64_t, size_t> zeros_;                      // accessor of zero vectors by count
  std::optional<size_t> material_, grey_;                // default_material(), of obstacles
  std::map<std::string, int> names_;  // names of nodes, with the number to try next
  std::set<size_t> taken_;            // meshes that a node owns already
};

}  // namespace elastogen
