// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_morph.hpp"

#include "core/error.hpp"
#include "io/gltf_accessor.hpp"
#include "io/gltf_hidden.hpp"
#include "io/gltf_model.hpp"
#include "io/gltf_nodes.hpp"

#include <Eigen/Dense>
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace elastogen {

namespace {

using Json = GltfEdit::Json;
using Weights = std::vector<double>;

bool has_targets(const Json& mesh) {
  return std::ranges::any_of(mesh["primitives"], [](const Json& primitive) {
    return primitive.contains("targets") && !primitive["targets"].empty();
  });
}

/// Bakes the morph weights of one document into its meshes.
class MorphBaker {
 public:
  MorphBaker(GltfEdit& edit, const tinygltf::Model& model) : edit_(edit), model_(model) {}

  void bake_all(std::vector<Finding>& findings) {
    const std::vector<char> hidden = hidden_nodes(edit_.path(), edit_.json["nodes"], model_);
    std::map<int, int64_t> users;
    for (const tinygltf::Node& node : model_.nodes) ++users[node.mesh];
    std::map<int, std::map<Weights, std::vector<int>>> shapes;
    std::vector<int> moved;
    for (const int n : gltf_scene_nodes(edit_.path(), model_)) {
      const int mesh = model_.nodes[size_t(n)].mesh;
      if (mesh < 0 || hidden[size_t(n)] || !has_targets(edit_.json["meshes"][size_t(mesh)]))
        continue;
      const Weights weights = weights_of(size_t(n), size_t(mesh));
      shapes[mesh][weights].push_back(n);
      if (std::ranges::any_of(weights, [](double w) { return w != 0; })) moved.push_back(n);
    }
    for (const auto& [mesh, by_weights] : shapes)
      for (const auto& [weights, nodes] : by_weights)
        if (std::ranges::any_of(weights, [](double w) { return w != 0; }))
          bake(size_t(mesh), weights, nodes, int64_t(nodes.size()) == users[mesh]);
    say(shapes.size(), moved, findings);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, edit_.path(), ": ", parts...);
  }

  void say(size_t meshes, std::vector<int> moved, std::vector<Finding>& findings) const {
    if (!moved.empty()) {
      std::ranges::sort(moved);
      const std::string names = node_names(gltf_nodes(edit_.path(), model_), moved);
      findings.push_back({"morph-weights", int64_t(moved.size()),
                          "nodes are shown with weights of morph targets: " + names});
    }
    if (meshes > 0)
      findings.push_back(
          {"morph-targets", int64_t(meshes), "meshes have morph targets of their own"});
  }

  /// Weights of the node, else those of its mesh, else zeros; one for each target.
  Weights weights_of(size_t node, size_t mesh) const {
    const Json& at_mesh = edit_.json["meshes"][mesh];
    const Json& at_node = edit_.json["nodes"][node];
    const bool own = at_node.contains("weights");
    const std::string place = own ? concat("nodes[", node, ']') : concat("meshes[", mesh, ']');
    const Json list = (own ? at_node : at_mesh).value("weights", Json::array());
    check(list.is_array(), place, ": its weights are no list");
    Weights weights;
    for (const Json& weight : list) {
      check(weight.is_number() && std::isfinite(weight.get<double>()), place,
            ": its weights must be finite numbers");
      weights.push_back(weight.get<double>());
    }
    for (const Json& primitive : at_mesh["primitives"]) {
      const Json targets = primitive.value("targets", Json::array());
      check(targets.is_array(), "meshes[", mesh, "]: its targets are no list");
      check(weights.empty() || targets.size() == weights.size(), place, " has ", weights.size(),
            " weights, a primitive of its mesh has ", targets.size(), " targets");
    }
    return weights;
  }

  /// An attribute of a primitive in double precision; counts towards what may be copied.
  Array<double> values(const Json& attributes, const std::string& name, const std::string& place) {
    const uint64_t index = count_of(attributes, name.c_str(), place);
    check(index < model_.accessors.size(), place, ": there is no accessor ", index);
    edit_.claim_copy(uint64_t(model_.accessors[size_t(index)].count) * 12, place);
    return accessor_values(edit_.source(), model_, int(index));
  }

  /// X + sum_k w_k d_k of an attribute; no rows if no target with a weight has it.
  Array<double> morphed(const Json& primitive, const std::string& name, const Weights& weights,
                        const std::string& place) {
    Array<double> sum;
    for (size_t k = 0; k < weights.size(); ++k) {
      const Json& target = primitive["targets"][k];
      check(target.is_object(), place, ": a target is no object");
      if (weights[k] == 0 || !target.contains(name)) continue;
      if (sum.empty()) sum = values(primitive["attributes"], name, place);
      const std::string here = concat(place, ".targets[", k, "].", name);
      const Array<double> delta = values(target, name, here);
      const int width = name == "TANGENT" ? 3 : sum.cols();
      check(delta.rows() == sum.rows() && delta.cols() >= width, here, " has ", delta.rows(), " x ",
            delta.cols(), " numbers, its attribute ", sum.rows(), " x ", sum.cols());
      for (int64_t v = 0; v < sum.rows(); ++v)
        for (int d = 0; d < width; ++d) sum(v, d) += weights[k] * delta(v, d);
    }
    return sum;
  }

  size_t add_accessor(const Array<double>& sum, bool bounds, const std::string& place) {
    edit_.claim_copy(uint64_t(sum.size()) * 4, place);
    const std::vector<float> rows(sum.data(), sum.data() + sum.size());
    Json accessor = Json::object();
    edit_.set_floats(accessor, rows, size_t(sum.cols()), bounds);
    return edit_.append("accessors", std::move(accessor));
  }

  /// Scales rows of vectors to length one; a row of length zero becomes that of the base.
  static void set_unit(Array<double>& vectors, const Array<double>& base) {
    for (int64_t v = 0; v < vectors.rows(); ++v) {
      Eigen::Map<Eigen::Vector3d> n(vectors.row(v));
      const double length = n.norm();
      n = length > 1e-12 ? Eigen::Vector3d(n / length) : Eigen::Vector3d(base.row(v));
    }
  }

  /// Removes the part along the normals from tangents.
  static void set_orthogonal(Array<double>& tangents, const Array<double>& normals) {
    for (int64_t v = 0; v < std::min(tangents.rows(), normals.rows()); ++v) {
      Eigen::Map<Eigen::Vector3d> t(tangents.row(v));
      const Eigen::Vector3d n(normals.row(v));
      t -= n.dot(t) / std::max(n.squaredNorm(), 1e-24) * n;
    }
  }

  /// Normals or tangents after morphing, of length one; no rows if they do not change.
  Array<double> unit_vectors(const Json& primitive, const char* name, const Weights& weights,
                             const Array<double>& normals, const std::string& place) {
    if (!primitive["attributes"].contains(name)) return {};
    Array<double> sum = morphed(primitive, name, weights, place);
    if (sum.empty() && normals.empty()) return {};
    const Array<double> base = values(primitive["attributes"], name, place);
    if (sum.empty()) sum = base;
    check(sum.cols() >= 3 && (normals.empty() || normals.rows() == sum.rows()), place, ": ", name,
          " must have three numbers for each vertex");
    set_orthogonal(sum, normals);
    set_unit(sum, base);
    return sum;
  }

  /// Bakes the weights into the attributes of one primitive and removes its targets.
  void bake_primitive(Json& primitive, const Weights& weights, const std::string& place) {
    const Json before = primitive;
    Json& attributes = primitive["attributes"];
    const Array<double> normals = unit_vectors(before, "NORMAL", weights, {}, place),
                        tangents = unit_vectors(before, "TANGENT", weights, normals, place);
    if (!normals.empty()) attributes["NORMAL"] = add_accessor(normals, false, place);
    if (!tangents.empty()) attributes["TANGENT"] = add_accessor(tangents, false, place);
    for (const auto& [name, index] : before["attributes"].items()) {
      if (name == "NORMAL" || name == "TANGENT") continue;
      Array<double> sum = morphed(before, name, weights, place);
      if (sum.empty()) continue;
      if (name.starts_with("COLOR_"))
        for (int64_t i = 0; i < sum.size(); ++i)
          sum.data()[i] = std::clamp(sum.data()[i], 0.0, 1.0);
      attributes[name] = add_accessor(sum, name == "POSITION", place);
    }
    primitive.erase("targets");
  }

  /// Bakes weights into the mesh that some nodes show, or into a copy if other nodes show it too.
  void bake(size_t index, const Weights& weights, const std::vector<int>& nodes, bool all_users) {
    // each set of attributes is baked once
    Json mesh = edit_.json["meshes"][index];
    if (!all_users)
      edit_.claim_copy(mesh.dump().size(), concat(edit_.path(), ": meshes[", index, ']'));
    std::map<std::string, Json> done;  // primitives may share their vertices
    for (size_t p = 0; p < mesh["primitives"].size(); ++p) {
      Json& primitive = mesh["primitives"][p];
      const Json key = {primitive["attributes"], primitive.value("targets", Json())};
      const auto [shape, is_new] = done.try_emplace(key.dump());
      if (is_new)
        bake_primitive(primitive, weights,
                       concat(edit_.path(), ": meshes[", index, "].primitives[", p, ']'));
      if (is_new) shape->second = primitive["attributes"];
      primitive["attributes"] = shape->second;
      primitive.erase("targets");
    }
    // nothing of the targets remains
    mesh.erase("weights");
    if (mesh.contains("extras") && mesh["extras"].is_object()) mesh["extras"].erase("targetNames");
    // the nodes show the result
    const size_t shown = all_users ? index : edit_.append("meshes", Json());
    edit_.json["meshes"][shown] = std::move(mesh);
    for (const int n : nodes) {
      edit_.json["nodes"][size_t(n)]["mesh"] = shown;
      edit_.json["nodes"][size_t(n)].erase("weights");
    }
  }

  GltfEdit& edit_;
  const tinygltf::Model& model_;
};

}  // namespace

void bake_morph_weights(GltfEdit& edit, std::vector<Finding>& findings) {
  if (!edit.json.contains("nodes") || !edit.json.contains("meshes")) return;
  if (std::ranges::none_of(edit.json["meshes"], has_targets)) return;
  tinygltf::Model model;
  read_gltf_model(edit.current(), model);
  MorphBaker(edit, model).bake_all(findings);
}

}  // namespace elastogen
