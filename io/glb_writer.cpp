// SPDX-License-Identifier: Apache-2.0
#include "io/glb_writer.hpp"

#include "core/error.hpp"
#include "io/glb_document.hpp"
#include "io/morph_targets.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace elastogen {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kVertices = 34962;

/// A document that is being given an animation.
class AnimatedDocument {
 public:
  explicit AnimatedDocument(GlbDocument base)
      : bin_(std::move(base.bin)), json_(Json::parse(base.json)) {}

  Json& json() { return json_; }

  size_t add_scalars(const std::vector<float>& values) {
    const uint64_t offset = append_bytes(bin_, values.data(), values.size() * sizeof(float));
    const size_t view = add_view(offset, values.size() * sizeof(float));
    const auto [least, largest] = std::minmax_element(values.begin(), values.end());
    return add_accessor({{"bufferView", view},
                         {"componentType", kFloat},
                         {"count", values.size()},
                         {"type", "SCALAR"},
                         {"min", Json::array({*least})},
                         {"max", Json::array({*largest})}});
  }

  /// Gives the mesh of a node morph targets; the mesh is copied if another node has it animated.
  /// Returns the node that shows the mesh now: a child where the node has a matrix, which glTF
  /// forbids in nodes that an animation targets.
  size_t add_targets(int asset_node, const MorphTargets& targets) {
    auto node = size_t(asset_node);
    auto mesh = json_["nodes"][node]["mesh"].get<size_t>();
    if (!animated_.insert(mesh).second) {
      json_["meshes"].push_back(Json(json_["meshes"][mesh]));
      mesh = json_["meshes"].size() - 1;
    }
    if (json_["nodes"][node].contains("matrix")) node = add_child(node);
    set_targets(json_["meshes"][mesh], targets);
    const std::vector<int> zeros(size_t(targets.weights.cols()), 0);
    json_["meshes"][mesh]["weights"] = zeros;
    json_["nodes"][node]["mesh"] = mesh;
    json_["nodes"][node]["weights"] = zeros;
    return node;
  }

  /// Plays the weights of a node.
  void add_channel(size_t node, size_t times, const Array<float>& weights) {
    const std::vector<float> values(weights.data(), weights.data() + weights.size());
    const size_t output = add_scalars(values);
    channels_.push_back(
        {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", "weights"}}}});
    samplers_.push_back({{"input", times}, {"interpolation", "LINEAR"}, {"output", output}});
  }

  /// Puts a node with a matrix above the roots of the default scene.
  void add_root(const Matrix4& matrix) {
    if (!json_.contains("scenes")) json_["scenes"] = Json::array({{{"nodes", roots()}}});
    if (!json_.contains("scene")) json_["scene"] = 0;
    Json& scene = json_["scenes"][json_["scene"].get<size_t>()];
    Json& nodes = json_["nodes"];
    nodes.push_back({{"name", "elastogen_root"}, {"matrix", matrix}, {"children", scene["nodes"]}});
    scene["nodes"] = Json::array({nodes.size() - 1});
  }

  void write(const std::string& path) {
    if (!channels_.empty()) {
      json_["animations"] =
          Json::array({{{"name", "elastogen"}, {"channels", channels_}, {"samplers", samplers_}}});
    }
    json_["buffers"] = Json::array({{{"byteLength", bin_.size()}}});
    write_glb(path, json_.dump(-1, ' ', false, Json::error_handler_t::replace), bin_);
  }

 private:
  /// Vertices that primitives share by one POSITION accessor, and their targets.
  struct Range {
    int64_t first = 0, count = 0;
    std::vector<Json> targets;  // without and with NORMAL
  };

  /// Nodes that are nobody's child.
  Json roots() const {
    std::set<size_t> children;
    for (const Json& node : json_["nodes"]) {
      for (const Json& child : node.value("children", Json::array()))
        children.insert(child.get<size_t>());
    }
    Json result = Json::array();
    for (size_t n = 0; n < json_["nodes"].size(); ++n) {
      if (!children.contains(n)) result.push_back(n);
    }
    return result;
  }

  /// A child without transform that takes over the mesh of a node.
  size_t add_child(size_t node) {
    Json& nodes = json_["nodes"];
    const size_t child = nodes.size();
    nodes.push_back(Json::object());
    if (nodes[node].contains("name")) nodes[child]["name"] = nodes[node]["name"];
    nodes[node].erase("mesh");
    nodes[node]["children"].push_back(child);
    return child;
  }

  size_t add_view(uint64_t offset, size_t size) {
    json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
    return json_["bufferViews"].size() - 1;
  }

  size_t add_accessor(Json accessor) {
    json_["accessors"].push_back(std::move(accessor));
    return json_["accessors"].size() - 1;
  }

  /// An accessor of three floats a vertex with its bounds, at an offset of a view.
  size_t add_vectors(size_t view, uint64_t offset, const float* values, int64_t count) {
    std::array<float, 3> lower, upper;
    for (size_t d = 0; d < 3; ++d) {
      lower[d] = upper[d] = values[d];
      for (int64_t v = 1; v < count; ++v) {
        lower[d] = std::min(lower[d], values[size_t(3 * v) + d]);
        upper[d] = std::max(upper[d], values[size_t(3 * v) + d]);
      }
    }
    return add_accessor({{"bufferView", view},
                         {"byteOffset", offset},
                         {"componentType", kFloat},
                         {"count", count},
                         {"type", "VEC3"},
                         {"min", lower},
                         {"max", upper}});
  }

  /// One view with rows of vectors, and an accessor for each row.
  std::vector<size_t> add_rows(const Array<float>& rows, const Range& range) {
    std::vector<size_t> accessors;
    const size_t size = size_t(range.count) * 12;
    const size_t view = json_["bufferViews"].size();
    for (int64_t k = 0; k < rows.rows(); ++k) {
      const float* values = rows.row(k) + 3 * range.first;
      const uint64_t at = append_bytes(bin_, values, size);
      if (k == 0) add_view(at, size * size_t(rows.rows()));
      accessors.push_back(add_vectors(view, uint64_t(k) * size, values, range.count));
    }
    json_["bufferViews"][view]["byteStride"] = 12;
    json_["bufferViews"][view]["target"] = kVertices;
    return accessors;
  }

  void fill_range(const MorphTargets& targets, Range& range) {
    range.targets = {Json::array(), Json::array()};
    if (targets.position.rows() == 0) return;
    const std::vector<size_t> position = add_rows(targets.position, range);
    const std::vector<size_t> normal =
        targets.normal.empty() ? position : add_rows(targets.normal, range);
    for (size_t k = 0; k < position.size(); ++k) {
      range.targets[0].push_back({{"POSITION", position[k]}});
      range.targets[1].push_back({{"POSITION", position[k]}, {"NORMAL", normal[k]}});
    }
  }

  /// The distinct POSITION accessors of a mesh's triangles in order of first use, as the reader
  /// (io/gltf_reader.hpp) puts them one after the other.
  std::map<size_t, Range> ranges_of(const Json& mesh, const MorphTargets& targets) {
    std::map<size_t, Range> ranges;
    int64_t first = 0;
    for (const Json& primitive : mesh["primitives"]) {
      const int mode = primitive.value("mode", 4);
      if (mode < 4 || mode > 6 || !primitive["attributes"].contains("POSITION")) continue;
      const auto accessor = primitive["attributes"]["POSITION"].get<size_t>();
      const auto [range, is_new] = ranges.try_emplace(accessor);
      if (!is_new) continue;
      range->second.first = first;
      range->second.count = json_["accessors"][accessor]["count"].get<int64_t>();
      first += range->second.count;
    }
    const int64_t expected = targets.position.rows() > 0 ? targets.position.cols() / 3 : first;
    ELASTOGEN_CHECK_ASSET(first == expected, "the asset file changed while it was animated");
    for (auto& [accessor, range] : ranges) fill_range(targets, range);
    return ranges;
  }

  /// Targets that move nothing, for lines and points beside the triangles.
  Json still_targets(const Json& attributes, int64_t count) {
    Json targets = Json::array();
    if (!attributes.contains("POSITION") || count == 0) return targets;
    const auto accessor = attributes["POSITION"].get<size_t>();
    const std::array<int, 3> zero = {};
    const size_t still = add_accessor({{"componentType", kFloat},
                                       {"count", json_["accessors"][accessor]["count"]},
                                       {"type", "VEC3"},
                                       {"min", zero},
                                       {"max", zero}});
    for (int64_t k = 0; k < count; ++k) targets.push_back({{"POSITION", still}});
    return targets;
  }

  void set_targets(Json& mesh, const MorphTargets& targets) {
    const std::map<size_t, Range> ranges = ranges_of(mesh, targets);
    for (Json& primitive : mesh["primitives"]) {
      const Json& attributes = primitive["attributes"];
      const auto found = attributes.contains("POSITION")
                             ? ranges.find(attributes["POSITION"].get<size_t>())
                             : ranges.end();
      const bool normals = attributes.contains("NORMAL") && !targets.normal.empty();
      Json list = found == ranges.end() ? still_targets(attributes, targets.position.rows())
                                        : found->second.targets[normals ? 1 : 0];
      if (!list.empty()) primitive["targets"] = std::move(list);
    }
    if (mesh.contains("extras") && !mesh["extras"].is_object()) return;
    for (int64_t k = 0; k < targets.position.rows(); ++k)
      mesh["extras"]["targetNames"].push_back(concat("elastogen_", k));
  }

  Bytes bin_;
  Json json_, channels_ = Json::array(), samplers_ = Json::array();
  std::set<size_t> animated_;  // meshes that have their targets
};

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
    certificates_.push_back(frame.certificate);
  }

  void finish() override {
    ELASTOGEN_CHECK(!certificates_.empty(), path_, ": there is no frame to write");
    const bool is_gltf = asset_.format == "glb" || asset_.format == "gltf";
    GlbDocument base = is_gltf ? gltf_document(asset_) : mesh_document(asset_);
    const std::vector<std::string> notes = base.notes;
    AnimatedDocument document(std::move(base));
    std::vector<float> times;
    for (size_t t = 0; t < certificates_.size(); ++t)
      times.push_back(float(double(t) / options_.fps));
    const size_t time_accessor = document.add_scalars(times);

    int modes = 0;
    double max_error = 0;
    for (const SurfaceInstance& instance : surface_.instances) {
      if (instance.triangles == 0) continue;
      const MorphTargets targets = morph_targets(asset_, surface_, instance, frames_, tolerance());
      max_error = std::max(max_error, targets.max_error);
      modes = std::max(modes, targets.weights.cols());
      if (targets.weights.cols() == 0) continue;
      const size_t node = document.add_targets(instance.node, targets);
      document.add_channel(node, time_accessor, targets.weights);
    }
    if (options_.root != kIdentity4) document.add_root(options_.root);
    add_extras(document.json()["asset"], modes, max_error, notes);
    document.write(path_);
  }

 private:
  /// Largest error of the modes [m]; 0 for keyframes.
  double tolerance() const {
    double longest = 0;
    for (int d = 0; d < 3; ++d) longest = std::max(longest, surface_.box.extent(d));
    return options_.keyframe ? 0 : options_.modal_error * longest;
  }

  void add_extras(Json& asset, int modes, double max_error,
                  const std::vector<std::string>& notes) const {
    Json frames = Json::array();
    for (const FrameCertificate& certificate : certificates_) {
      frames.push_back({{"converged", certificate.converged},
                        {"residual", certificate.residual},
                        {"min_j", certificate.min_j}});
    }
    Json record = {{"generator", options_.generator},
                   {"commit", options_.commit},
                   {"command", options_.command},
                   {"fps", options_.fps},
                   {"profile", options_.keyframe ? "keyframe" : "modal"},
                   {"modes", modes},
                   {"max_error_m", max_error}};
    if (!options_.keyframe) record["tolerance_m"] = tolerance();
    if (!notes.empty()) record["notes"] = notes;
    record["frames"] = std::move(frames);
    if (asset.contains("generator")) record["source_generator"] = asset["generator"];
    if (asset.contains("extras") && !asset["extras"].is_object()) asset.erase("extras");
    asset["extras"]["elastogen"] = std::move(record);
    if (!options_.generator.empty()) asset["generator"] = options_.generator;
  }

  std::string path_;
  const Asset& asset_;
  const Surface& surface_;
  AnimationOptions options_;
  FrameStore frames_;
  std::vector<FrameCertificate> certificates_;
};

}  // namespace

std::unique_ptr<AnimationWriter> make_glb_writer(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const AnimationOptions& options) {
  return std::make_unique<GlbWriter>(path, asset, surface, options);
}

}  // namespace elastogen
