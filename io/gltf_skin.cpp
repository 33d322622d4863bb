// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_skin.hpp"

#include "core/error.hpp"
#include "io/gltf_accessor.hpp"
#include "io/gltf_animations.hpp"
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
using Matrices = std::vector<Eigen::Matrix4d>;

/// Attributes of a primitive that decide its pose: POSITION, NORMAL, TANGENT (-1 for none), then
/// pairs of JOINTS_n and WEIGHTS_n.
using Parts = std::vector<int>;

/// Poses the skinned meshes of one document.
class SkinPoser {
 public:
  SkinPoser(GltfEdit& edit, const tinygltf::Model& model) : edit_(edit), model_(model) {
    Asset tree;
    tree.path = edit.path();
    tree.nodes = gltf_nodes(edit.path(), model);
    invisible_ = invisible_nodes(edit.path(), edit.json["nodes"]);
    world_ = world_matrices(tree);
  }

  /// Returns how many nodes showed a skinned mesh.
  int64_t pose_all() {
    std::map<int, int> users;
    for (const tinygltf::Node& node : model_.nodes) ++users[node.mesh];
    int64_t count = 0;
    for (const int n : gltf_scene_nodes(edit_.path(), model_)) {
      const tinygltf::Node& node = model_.nodes[size_t(n)];
      if (node.skin < 0 || node.mesh < 0) continue;
      pose(size_t(n), node, users[node.mesh] == 1);
      ++count;
    }
    return count;
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, edit_.path(), ": ", parts...);
  }

  /// W_j B_j of the joints of a skin.
  const Matrices& matrices_of(int skin) {
    const auto [found, is_new] = matrices_.try_emplace(skin);
    Matrices& matrices = found->second;
    if (!is_new) return matrices;
    const std::string place = concat(edit_.path(), ": skins[", skin, ']');
    const Json& entry = edit_.entry("skins", uint64_t(skin), place);
    check(entry.is_object() && entry.contains("joints") && entry["joints"].is_array(), "skins[",
          skin, "] has no list of joints");
    for (const Json& joint : entry["joints"]) {
      check(joint.is_number_unsigned() && joint.get<uint64_t>() < world_.size(), "skins[", skin,
            "]: there is no node for one of its joints");
      matrices.emplace_back(world_[joint.get<size_t>()].data());
    }
    if (!entry.contains("inverseBindMatrices")) return matrices;
    const uint64_t accessor = count_of(entry, "inverseBindMatrices", place);
    check(accessor < model_.accessors.size(), "skins[", skin, "]: there is no accessor ", accessor);
    const Array<double> bind = accessor_matrices(edit_.source(), model_, int(accessor));
    check(bind.rows() >= int64_t(matrices.size()), "skins[", skin,
          "] has more joints than inverse bind matrices");
    for (size_t j = 0; j < matrices.size(); ++j)
      matrices[j] *= Eigen::Map<const Eigen::Matrix4d>(bind.row(int64_t(j)));
    return matrices;
  }

  static bool is_shape(const Array<double>& values, int64_t rows, int cols) {
    return values.rows() == rows && values.cols() == cols;
  }

  static Parts parts_of(const tinygltf::Primitive& primitive) {
    const auto at = [&](const std::string& name) {
      const auto found = primitive.attributes.find(name);
      return found == primitive.attributes.end() ? -1 : found->second;
    };
    Parts parts = {at("POSITION"), at("NORMAL"), at("TANGENT")};
    for (int set = 0; at(concat("JOINTS_", set)) >= 0 || at(concat("WEIGHTS_", set)) >= 0; ++set) {
      parts.push_back(at(concat("JOINTS_", set)));
      parts.push_back(at(concat("WEIGHTS_", set)));
    }
    return parts;
  }

  /// Blended matrix of each vertex.
  Matrices blended(const Parts& parts, int64_t vertices, const Matrices& joints) {
    // sum of matrices and weights of each vertex, and its first joint
    Matrices sum(size_t(vertices), Eigen::Matrix4d::Zero());
    std::vector<double> total(size_t(vertices), 0);
    std::vector<size_t> first(size_t(vertices), 0);
    // each pair of JOINTS_n and WEIGHTS_n has four of them
    for (size_t k = 3; k + 1 < parts.size(); k += 2) {
      edit_.claim_copy(uint64_t(vertices) * 16,
                       concat(edit_.path(), ": accessors[", parts[k], ']'));
      const Array<double> index = accessor_values(edit_.source(), model_, parts[k]);
      const Array<double> weight = accessor_values(edit_.source(), model_, parts[k + 1]);
      check(is_shape(index, vertices, 4) && is_shape(weight, vertices, 4), "accessors[", parts[k],
            "] and [", parts[k + 1], "]: joints and weights must be VEC4 for each of ", vertices,
            " vertices");
      for (int64_t v = 0; v < vertices; ++v) {
        for (int c = 0; c < 4; ++c) {
          const double j = index(v, c), w = weight(v, c);
          check(j >= 0 && j < double(joints.size()) && j == std::floor(j), "accessors[", parts[k],
                "]: joint index ", j, " is out of range; the skin has ", joints.size());
          check(w >= 0 && std::isfinite(w), "accessors[", parts[k + 1], "]: the weight ", w,
                " of vertex ", v, " must be finite and not negative");
          if (k == 3 && c == 0) first[size_t(v)] = size_t(j);
          sum[size_t(v)] += w * joints[size_t(j)];
          total[size_t(v)] += w;
        }
      }
    }
    // weights need not sum to one; a vertex without any follows its first joint
    for (size_t v = 0; v < sum.size(); ++v)
      sum[v] = total[v] > 0 ? sum[v] / total[v] : joints[first[v]];
    return sum;
  }

  /// A copy of an accessor with other values; positions get bounds.
  size_t add_accessor(int like, const std::vector<float>& rows, size_t width, bool bounds) {
    edit_.claim_copy(rows.size() * 4, concat(edit_.path(), ": accessors[", like, ']'));
    Json accessor = edit_.json["accessors"][size_t(like)];
    edit_.set_floats(accessor, rows, width, bounds);
    return edit_.append("accessors", std::move(accessor));
  }

  /// The posed POSITION, NORMAL and TANGENT of a primitive.
  std::vector<size_t> posed(const Parts& parts, const Matrices& joints) {
    const Array<double> position = accessor_values(edit_.source(), model_, parts[0]);
    check(position.cols() == 3, "accessors[", parts[0], "]: POSITION must be VEC3");
    const int64_t vertices = position.rows();
    const Matrices matrix = blended(parts, vertices, joints);
    std::vector<size_t> accessors;
    for (size_t k = 0; k < 3; ++k) {
      if (parts[k] < 0) continue;
      const Array<double> from = accessor_values(edit_.source(), model_, parts[k]);
      const int width = k == 2 ? 4 : 3;
      check(is_shape(from, vertices, width), "accessors[", parts[k], "] must have ", width,
            " numbers for each of ", vertices, " vertices");
      std::vector<float> rows;
      for (int64_t v = 0; v < vertices; ++v) {
        const Eigen::Map<const Eigen::Vector3d> p(from.row(v));
        const Eigen::Vector3d moved =
            k == 0 ? point(matrix[size_t(v)], p) : direction(matrix[size_t(v)], p, k == 1);
        for (int d = 0; d < 3; ++d) rows.push_back(float(moved[d]));
        if (width == 4) rows.push_back(float(from(v, 3)));
      }
      accessors.push_back(add_accessor(parts[k], rows, size_t(width), k == 0));
    }
    return accessors;
  }

  static Eigen::Vector3d point(const Eigen::Matrix4d& m, const Eigen::Vector3d& p) {
    return m.topLeftCorner<3, 3>() * p + m.topRightCorner<3, 1>();
  }

  /// A unit vector under M: tangents by M, normals by M^-T, scaled to length one. It stays as it is
  /// where M maps it to zero.
  static Eigen::Vector3d direction(const Eigen::Matrix4d& m, const Eigen::Vector3d& p,
                                   bool normal) {
    Eigen::Matrix3d turn = m.topLeftCorner<3, 3>();
    if (normal) {
      // det(M) M^-T: its columns are cross products of the columns of M
      const Eigen::Matrix3d a = turn;
      const double sign = a.determinant() < 0 ? -1 : 1;
      for (int c = 0; c < 3; ++c) turn.col(c) = sign * a.col((c + 1) % 3).cross(a.col((c + 2) % 3));
    }
    const Eigen::Vector3d moved = turn * p;
    const double length = moved.norm();
    return length > 0 && std::isfinite(length) ? Eigen::Vector3d(moved / length) : p;
  }

  /// Shows the posed mesh of a node by a new one at the root.
  void pose(size_t index, const tinygltf::Node& node, bool only_user) {
    const Matrices& joints = matrices_of(node.skin);
    // pose each set of attributes once
    Json mesh = edit_.json["meshes"][size_t(node.mesh)];
    edit_.claim_copy(mesh.dump().size(), concat(edit_.path(), ": nodes[", index, ']'));
    std::map<Parts, std::vector<size_t>> done;  // primitives may share their vertices
    const auto& primitives = model_.meshes[size_t(node.mesh)].primitives;
    for (size_t p = 0; p < primitives.size(); ++p) {
      const Parts parts = parts_of(primitives[p]);
      if (parts[0] < 0) continue;
      check(parts.size() > 3, "meshes[", node.mesh, "].primitives[", p,
            "] is shown with a skin but has no JOINTS_0 and WEIGHTS_0");
      const auto [found, is_new] = done.try_emplace(parts);
      if (is_new) found->second = posed(parts, joints);
      Json& attributes = mesh["primitives"][p]["attributes"];
      size_t next = 0;
      for (const char* name : {"POSITION", "NORMAL", "TANGENT"}) {
        if (attributes.contains(name)) attributes[name] = found->second[next++];
      }
    }
    // the posed mesh, in place of the old one unless other nodes show that
    const auto shown = only_user ? size_t(node.mesh) : edit_.append("meshes", Json());
    edit_.json["meshes"][shown] = std::move(mesh);
    // a new node at the root shows it, as the old node's matrix has no part in it
    Json root = {{"mesh", shown}};
    if (!node.name.empty()) root["name"] = node.name;
    if (invisible_[index]) root["extensions"]["KHR_node_visibility"]["visible"] = false;
    edit_.json["nodes"][index].erase("mesh");
    const size_t added = edit_.append("nodes", std::move(root));
    if (model_.scenes.empty()) return;
    edit_.json["scenes"][size_t(std::max(model_.defaultScene, 0))]["nodes"].push_back(added);
  }

  GltfEdit& edit_;
  const tinygltf::Model& model_;
  std::vector<Matrix4> world_;
  std::vector<char> invisible_;
  std::map<int, Matrices> matrices_;
};

/// Removes everything that belongs to skins from the document.
void remove_skins(Json& document) {
  document.erase("skins");
  for (Json& node : document["nodes"]) node.erase("skin");
  for (Json& mesh : document["meshes"]) {
    for (Json& primitive : mesh["primitives"]) {
      Json& attributes = primitive["attributes"];
      for (auto entry = attributes.begin(); entry != attributes.end();) {
        const bool of_skin =
            entry.key().starts_with("JOINTS_") || entry.key().starts_with("WEIGHTS_");
        entry = of_skin ? attributes.erase(entry) : std::next(entry);
      }
    }
  }
}

}  // namespace

void pose_skins(GltfEdit& edit, std::vector<Finding>& findings) {
  if (!edit.json.contains("nodes")) return;
  const Json& nodes = edit.json["nodes"];
  const bool any = std::any_of(nodes.begin(), nodes.end(),
                               [](const Json& node) { return node.contains("skin"); });
  if (!any) return;
  tinygltf::Model model;
  read_gltf_model(edit.current(), model);
  const int64_t count = SkinPoser(edit, model).pose_all();
  if (count == 0) return;
  remove_joint_channels(edit.json);
  remove_skins(edit.json);
  findings.push_back({"skins", count, "skinned meshes are taken in the pose that the file shows"});
}

}  // namespace elastogen
