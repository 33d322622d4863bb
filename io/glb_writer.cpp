// SPDX-License-Identifier: Apache-2.0
#include "io/glb_writer.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/animated_document.hpp"
#include "io/collider_mesh.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

namespace elastogen {

namespace {

using Json = AnimatedDocument::Json;

double determinant(const Matrix4& m) {
  return m[0] * (m[5] * m[10] - m[9] * m[6]) - m[4] * (m[1] * m[10] - m[9] * m[2]) +
         m[8] * (m[1] * m[6] - m[5] * m[2]);
}

class GlbWriter : public AnimationWriter {
 public:
  GlbWriter(const std::string& path, const Asset& asset, const Surface& surface,
            const AnimationOptions& options)
      : path_(path),
        asset_(asset),
        surface_(surface),
        options_(options),
        frames_(path, surface.vertices.size()) {
    ELASTOGEN_CHECK(std::isfinite(determinant(options.root)) && determinant(options.root) != 0,
                    "the root matrix must have an inverse");
  }

  void frame(const AnimationFrame& frame) override {
    const Span<const double>& displacement = frame.displacement;
    ELASTOGEN_CHECK(displacement.is(surface_.vertices.rows(), 3), "displacement must be (",
                    surface_.vertices.rows(), ", 3), got ", displacement);
    const bool finite = std::all_of(displacement.data, displacement.data + displacement.size(),
                                    [](double d) { return std::abs(d) < 1e38; });
    ELASTOGEN_CHECK(finite, "frame ", certificates_.size(),
                    " has a displacement that is not finite in single precision");
    frames_.append(displacement);
    for (int64_t k = 0; k < displacement.size(); ++k)
      motion_ = std::max(motion_, std::abs(displacement.data[k]));
    if (options_.colliders) see(displacement);
    certificates_.push_back(frame.certificate);
  }

  void finish() override {
    ELASTOGEN_CHECK(!certificates_.empty(), path_, ": there is no frame to write");
    const bool is_gltf = asset_.format == "glb" || asset_.format == "gltf";
    GlbDocument base = is_gltf ? gltf_document(asset_) : mesh_document(asset_);
    notes_ = std::move(base.notes);
    AnimatedDocument document(std::move(base), clip_times());
    std::set<size_t> simulated;
    for (const SurfaceInstance& instance : surface_.instances)
      simulated.insert(size_t(instance.node));
    document.keep_meshes_of_others(simulated);
    for (std::vector<size_t>& instances : touching_instances(surface_)) {
      const PieceOptions limits{tolerance(), options_.max_targets};
      add(morph_group(asset_, surface_, std::move(instances), frames_, limits), document);
    }
    if (options_.colliders && options_.scene) add_colliders(document);
    if (options_.root != kIdentity4) document.add_root(options_.root);
    add_extras(document.json()["asset"]);
    document.write(path_);
    say_limits();
  }

  std::vector<std::string> notes() const override { return notes_; }
  std::vector<std::string> warnings() const override { return warnings_; }

 private:
  std::vector<float> clip_times() const {
    std::vector<float> times;
    for (size_t t = 0; t < certificates_.size(); ++t)
      times.push_back(float(double(t) / options_.fps));
    return times;
  }

  /// Longest edge of the asset [m].
  double longest_edge() const {
    return std::max({surface_.box.extent(0), surface_.box.extent(1), surface_.box.extent(2)});
  }

  /// Largest error of the targets to aim at [m]; 0 for keyframes. A small motion that can still be
  /// seen gets a smaller one.
  double tolerance() const {
    const double usual = options_.modal_error * longest_edge();
    if (options_.keyframe) return 0;
    return motion_ < kVisibleMotion * longest_edge() ? usual : std::min(usual, motion_ / 10);
  }

  /// Adds the pieces of a group to the document.
  void add(const MorphGroup& group, AnimatedDocument& document) {
    if (group.pieces.empty()) return;
    std::vector<FrameRange> ranges;
    for (const ClipPiece& piece : group.pieces) ranges.push_back(piece.frames);
    std::vector<std::vector<size_t>> nodes;  // (instances, pieces)
    for (const size_t i : group.instances)
      nodes.push_back(document.stage(size_t(surface_.instances[i].node), ranges));
    pieces_ = std::max(pieces_, int64_t(ranges.size()));
    for (size_t p = 0; p < group.pieces.size(); ++p) {
      const ClipPiece& piece = group.pieces[p];
      targets_ = std::max(targets_, int64_t(piece.weights.cols()));
      max_error_ = std::max(max_error_, piece.basis.max_error);
      normal_error_ = std::max(normal_error_, piece.normal_error);
      if (piece.weights.cols() == 0) continue;
      const size_t weights = document.add_weights(piece.weights);
      for (size_t part = 0; part < group.instances.size(); ++part)
        document.play(nodes[part][p], morph_targets(asset_, surface_, group, part, piece),
                      piece.frames, weights);
    }
  }

  /// Grows seen_ by a frame.
  void see(const Span<const double>& displacement) {
    for (int64_t k = 0; k < surface_.triangles.size(); ++k) {
      const int32_t v = surface_.triangles.data()[k];
      seen_.add({surface_.vertices(v, 0) + displacement(v, 0),
                 surface_.vertices(v, 1) + displacement(v, 1),
                 surface_.vertices(v, 2) + displacement(v, 2)});
    }
  }

  /// Adds floor and colliders as bodies of the scene, in the numbers of the asset.
  void add_colliders(AnimatedDocument& document) const {
    const double scale = surface_.scale;
    Vec3 place;
    for (size_t d = 0; d < 3; ++d) place[d] = (seen_.lower[d] + seen_.upper[d]) / 2;
    for (const Collider& collider : options_.scene->colliders) {
      const ColliderMesh mesh = collider_mesh(collider, seen_);
      AnimatedDocument::Obstacle obstacle{
          .name = collider.name,
          .place = scaled(plus(place, surface_.box.origin), 1 / scale),
          .positions = {},
          .normals = {},
          .corners = {}};
      for (int64_t v = 0; v < mesh.position.rows(); ++v)
        for (int d = 0; d < 3; ++d) {
          obstacle.positions.push_back(float((mesh.position(v, d) - place[size_t(d)]) / scale));
          obstacle.normals.push_back(float(mesh.normal(v, d)));
        }
      obstacle.corners.assign(mesh.triangles.data(), mesh.triangles.data() + mesh.triangles.size());
      for (size_t t = 0; t < certificates_.size() && !collider.path.keys.empty(); ++t)
        obstacle.offsets.push_back(
            scaled(offset_at(collider, double(t) / options_.fps), 1 / scale));
      document.add_obstacle(obstacle);
    }
  }

  void add_extras(Json& asset) const {
    // the certificates of the frames
    Json frames = Json::array();
    for (const FrameCertificate& certificate : certificates_) {
      frames.push_back({{"converged", certificate.converged},
                        {"residual", certificate.residual},
                        {"min_j", certificate.min_j}});
      if (certificate.time_error > 0) {
        frames.back()["time_error"] = certificate.time_error;
        frames.back()["time_ratio"] = certificate.time_ratio;
      }
      // one number: clips have many frames
      if (const auto& mesh = certificate.mesh_error) {
        frames.back()["mesh_error"] = mesh->rms;
        if (!mesh->trusted) frames.back()["mesh_error_trusted"] = false;
      }
    }
    // origin, form and quality of the file
    Json record = {{"generator", options_.generator},
                   {"commit", options_.commit},
                   {"command", options_.command},
                   {"fps", options_.fps},
                   {"profile", options_.keyframe ? "keyframe" : "modal"},
                   {"targets", targets_},
                   {"pieces", pieces_},
                   {"max_error_m", max_error_},
                   {"normal_error_deg", normal_error_ * 180 / std::numbers::pi}};
    if (!options_.keyframe) record["tolerance_m"] = tolerance();
    if (!notes_.empty()) record["notes"] = notes_;
    record["frames"] = std::move(frames);
    if (asset.contains("generator")) record["source_generator"] = asset["generator"];
    if (asset.contains("extras") && !asset["extras"].is_object()) asset.erase("extras");
    asset["extras"]["elastogen"] = std::move(record);
    if (!options_.generator.empty()) asset["generator"] = options_.generator;
  }

  /// Notes for the user about what the limits of the format changed.
  void say_limits() {
    if (targets_ == 0 && certificates_.size() > 1)
      warnings_.push_back(concat(path_, " has no animation: nothing in it moves"));
    if (pieces_ > 1)
      notes_.push_back(concat(path_, ": the clip is shown in ", pieces_,
                              " pieces, nodes that are visible in turn, because ",
                              options_.max_targets,
                              " morph targets (--glb-targets) do not hold all of it"));
    const double promised = options_.keyframe ? options_.modal_error * longest_edge() : tolerance();
    if (max_error_ > promised)
      warnings_.push_back(concat(path_, ": vertices are up to ", max_error_,
                                 " m from where they should be, ", promised,
                                 " m were aimed at: a node of the asset is scaled to zero"));
  }

  std::string path_;
  const Asset& asset_;
  const Surface& surface_;
  AnimationOptions options_;
  FrameStore frames_;
  std::vector<FrameCertificate> certificates_;
  std::vector<std::string> notes_, warnings_;
  double motion_ = 0;                 ///< largest component of a displacement [m]
  Box seen_;                          ///< of the triangles in all frames, filled for colliders [m]
  int64_t targets_ = 0, pieces_ = 0;  ///< largest numbers of a mesh
  double max_error_ = 0;              ///< [m]
  double normal_error_ = 0;           ///< root mean square of the worst frame [rad]
};

}  // namespace

std::unique_ptr<AnimationWriter> make_glb_writer(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const AnimationOptions& options) {
  return std::make_unique<GlbWriter>(path, asset, surface, options);
}

}  // namespace elastogen
