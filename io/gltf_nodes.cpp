// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_nodes.hpp"

#include "core/error.hpp"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace elastogen {

namespace {

Matrix4 rotation_matrix(const std::vector<double>& q) {
  const double x = q[0], y = q[1], z = q[2], w = q[3], s = 2 / (x * x + y * y + z * z + w * w);
  const Vec3 a = {1 - s * (y * y + z * z), s * (x * y + w * z), s * (x * z - w * y)},
             b = {s * (x * y - w * z), 1 - s * (x * x + z * z), s * (y * z + w * x)},
             c = {s * (x * z + w * y), s * (y * z - w * x), 1 - s * (x * x + y * y)};
  return {a[0], a[1], a[2], 0, b[0], b[1], b[2], 0, c[0], c[1], c[2], 0, 0, 0, 0, 1};
}

/// The matrix of a node to its parent.
Matrix4 composed(const tinygltf::Node& node) {
  Matrix4 matrix = kIdentity4;
  if (!node.matrix.empty()) {
    std::copy(node.matrix.begin(), node.matrix.end(), matrix.begin());
    return matrix;
  }
  if (!node.rotation.empty()) matrix = rotation_matrix(node.rotation);
  for (size_t c = 0; c < 3 && !node.scale.empty(); ++c) {
    for (size_t r = 0; r < 3; ++r) matrix[4 * c + r] *= node.scale[c];
  }
  for (size_t r = 0; r < 3 && !node.translation.empty(); ++r) matrix[12 + r] = node.translation[r];
  return matrix;
}

void check_transform(const tinygltf::Node& node, const std::string& place) {
  const auto is = [](const std::vector<double>& v, size_t n) { return v.empty() || v.size() == n; };
  ELASTOGEN_CHECK_ASSET(
      is(node.matrix, 16) && is(node.rotation, 4) && is(node.scale, 3) && is(node.translation, 3),
      place, ": its transform has the wrong number of entries");
  const std::vector<double>& m = node.matrix;
  ELASTOGEN_CHECK_ASSET(m.empty() || (m[3] == 0 && m[7] == 0 && m[11] == 0 && m[15] == 1), place,
                        ": the last row of its matrix is not 0, 0, 0, 1");
  double norm = 0;
  for (const double q : node.rotation) norm += q * q;
  ELASTOGEN_CHECK_ASSET(node.rotation.empty() || (norm > 1e-12 && std::isfinite(norm)), place,
                        ": its rotation is not a quaternion of length one");
}

/// The nodes at and below some nodes; stops at one more than the model has, for cycles.
std::vector<int> reached_from(const tinygltf::Model& model, std::vector<int> stack) {
  std::vector<int> reached;
  while (!stack.empty() && reached.size() <= model.nodes.size()) {
    reached.push_back(stack.back());
    stack.pop_back();
    const auto& children = model.nodes[size_t(reached.back())].children;
    stack.insert(stack.end(), children.begin(), children.end());
  }
  return reached;
}

}  // namespace

std::vector<AssetNode> gltf_nodes(const std::string& path, const tinygltf::Model& model) {
  const size_t count = model.nodes.size();
  std::vector<AssetNode> nodes(count);
  for (size_t n = 0; n < count; ++n) {
    const tinygltf::Node& node = model.nodes[n];
    const std::string place = concat(path, ": nodes[", n, ']');
    check_transform(node, place);
    nodes[n].name = node.name;
    nodes[n].matrix = composed(node);
    ELASTOGEN_CHECK_ASSET(node.mesh < int64_t(model.meshes.size()), place, ": there is no mesh ",
                          node.mesh);
    for (const int child : node.children) {
      ELASTOGEN_CHECK_ASSET(child >= 0 && size_t(child) < count, place, ": there is no node ",
                            child);
      int& parent = nodes[size_t(child)].parent;
      ELASTOGEN_CHECK_ASSET(parent < 0, path, ": nodes[", child, "] has two parents");
      parent = int(n);
    }
  }
  // each node has at most one parent, so nodes that the roots do not reach form a cycle
  std::vector<int> roots;
  for (size_t n = 0; n < count; ++n) {
    if (nodes[n].parent < 0) roots.push_back(int(n));
  }
  ELASTOGEN_CHECK_ASSET(reached_from(model, roots).size() == count, path,
                        ": the node tree has a cycle");
  return nodes;
}

std::vector<int> gltf_scene_roots(const std::string& path, const tinygltf::Model& model) {
  std::vector<int> roots;
  if (model.scenes.empty()) {
    std::vector<bool> is_child(model.nodes.size(), false);
    for (const tinygltf::Node& node : model.nodes) {
      for (const int child : node.children) is_child[size_t(child)] = true;
    }
    for (size_t n = 0; n < is_child.size(); ++n) {
      if (!is_child[n]) roots.push_back(int(n));
    }
    return roots;
  }
  const int scene = std::max(model.defaultScene, 0);
  ELASTOGEN_CHECK_ASSET(size_t(scene) < model.scenes.size(), path, ": there is no scene ", scene);
  for (const int node : model.scenes[size_t(scene)].nodes) {
    ELASTOGEN_CHECK_ASSET(node >= 0 && size_t(node) < model.nodes.size(), path, ": scenes[", scene,
                          "]: there is no node ", node);
    roots.push_back(node);
  }
  return roots;
}

std::vector<int> gltf_scene_nodes(const std::string& path, const tinygltf::Model& model) {
  const std::vector<int> nodes = reached_from(model, gltf_scene_roots(path, model));
  std::vector<bool> seen(model.nodes.size(), false);
  for (const int n : nodes) {
    ELASTOGEN_CHECK_ASSET(!seen[size_t(n)], path, ": node ", n, " is listed twice in its scene");
    seen[size_t(n)] = true;
  }
  return nodes;
}

}  // namespace elastogen
