// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_hidden.hpp"

#include "core/error.hpp"
#include "core/svd3.hpp"
#include "io/flat_stream.hpp"
#include "io/gltf_nodes.hpp"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>

namespace elastogen {

namespace {

constexpr const char* kVisibility = "KHR_node_visibility";
constexpr size_t kNames = 8;

bool is_visible(const nlohmann::ordered_json& node, const std::string& place) {
  const auto extensions = node.find("extensions");
  if (extensions == node.end() || !extensions->is_object() || !extensions->contains(kVisibility))
    return true;
  const auto& extension = (*extensions)[kVisibility];
  ELASTOGEN_CHECK_ASSET(extension.is_object(), place, ": ", kVisibility, " must be an object");
  const auto visible = extension.find("visible");
  if (visible == extension.end()) return true;
  ELASTOGEN_CHECK_ASSET(visible->is_boolean(), place, ": \"visible\" must be true or false");
  return visible->get<bool>();
}

}  // namespace

std::vector<char> invisible_nodes(const std::string& path, const nlohmann::ordered_json& nodes) {
  std::vector<char> hidden(nodes.size(), 0);
  std::vector<size_t> stack;
  for (size_t n = 0; n < nodes.size(); ++n)
    if (!is_visible(nodes[n], concat(path, ": nodes[", n, ']'))) stack.push_back(n);
  while (!stack.empty()) {
    const size_t n = stack.back();
    stack.pop_back();
    if (n >= nodes.size() || hidden[n]) continue;
    hidden[n] = 1;
    if (!nodes[n].contains("children")) continue;
    for (const auto& child : nodes[n]["children"]) stack.push_back(child.get<size_t>());
  }
  return hidden;
}

std::vector<char> hidden_nodes(const std::string& path, const nlohmann::ordered_json& nodes,
                               const tinygltf::Model& model) {
  std::vector<char> hidden = invisible_nodes(path, nodes);
  Asset tree;
  tree.path = path;
  tree.nodes = gltf_nodes(path, model);
  const std::vector<Matrix4> world = world_matrices(tree);
  for (size_t n = 0; n < world.size(); ++n) {
    const tinygltf::Node& node = model.nodes[n];
    if (node.mesh >= 0 && node.skin < 0 && is_singular(world[n])) hidden[n] = 1;
  }
  return hidden;
}

bool is_singular(const Matrix4& matrix) {
  constexpr double kRounding = 1e-7;
  if (!std::ranges::all_of(matrix, [](double m) { return std::isfinite(m); })) return false;
  Mat3<double> linear;
  double largest = 0;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) {
      linear(row, column) = matrix[size_t(4 * column + row)];
      largest = std::max(largest, std::abs(linear(row, column)));
    }
  if (largest == 0) return true;
  for (double& a : linear.m) a /= largest;
  const Svd3<double> svd = svd3(linear);
  return std::abs(svd.sigma[2]) <= kRounding * svd.sigma[0];
}

std::string node_names(const std::vector<AssetNode>& nodes, const std::vector<int>& some) {
  std::string text;
  for (size_t k = 0; k < std::min(some.size(), kNames); ++k) {
    const std::string& name = nodes[size_t(some[k])].name;
    text += concat(k == 0 ? "" : ", ", name.empty() ? concat("nodes[", some[k], ']') : name);
  }
  if (some.size() > kNames) text += concat(" and ", some.size() - kNames, " more");
  return shown_line(text);
}

}  // namespace elastogen
