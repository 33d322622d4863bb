// SPDX-License-Identifier: Apache-2.0
// Reads a GLB by two foreign libraries and compares what they read:
//
//     round_trip FILE.glb...
//
// Counts of meshes, triangles, morph targets and animated nodes, and the box of the vertices must
// agree. Ends with 1 at the first file that one of them does not read or that they see differently.

#include <assimp/Importer.hpp>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#define TINYGLTF_NO_FS
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>

namespace {

constexpr int kTriangles[] = {TINYGLTF_MODE_TRIANGLES, TINYGLTF_MODE_TRIANGLE_STRIP,
                              TINYGLTF_MODE_TRIANGLE_FAN};

/// Contents of a file as a program reads them.
struct Seen {
  size_t primitives = 0, triangles = 0, targets = 0, moved = 0;
  std::array<double, 3> lower = {1e300, 1e300, 1e300}, upper = {-1e300, -1e300, -1e300};

  void add(double x, int d) {
    lower[size_t(d)] = std::min(lower[size_t(d)], x);
    upper[size_t(d)] = std::max(upper[size_t(d)], x);
  }
};

bool is_triangles(const tinygltf::Primitive& primitive) {
  return std::ranges::find(kTriangles, primitive.mode) != std::end(kTriangles);
}

/// Leaves images undecoded.
bool leave_image(tinygltf::Image*, int, std::string*, std::string*, int, int, const unsigned char*,
                 int, void*) {
  return true;
}

Seen by_tinygltf(const std::string& path) {
  tinygltf::TinyGLTF loader;
  loader.SetImageLoader(leave_image, nullptr);
  tinygltf::Model model;
  std::string error, warning;
  std::ifstream file(path, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  if (!loader.LoadBinaryFromMemory(&model, &error, &warning, data, unsigned(bytes.size())) ||
      !warning.empty())
    throw std::runtime_error("tinygltf: " + error + warning);
  Seen seen;
  // triangles, targets and bounds of all meshes that a node shows
  std::set<int> shown;  // assimp leaves out what no node shows
  for (const tinygltf::Node& node : model.nodes)
    if (node.mesh >= 0) shown.insert(node.mesh);
  for (const int m : shown)
    for (const tinygltf::Primitive& primitive : model.meshes.at(size_t(m)).primitives) {
      if (!is_triangles(primitive)) continue;
      const tinygltf::Accessor& position =
          model.accessors.at(size_t(primitive.attributes.at("POSITION")));
      const size_t corners = primitive.indices < 0
                                 ? position.count
                                 : model.accessors.at(size_t(primitive.indices)).count;
      seen.triangles += primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners - 2;
      ++seen.primitives;
      seen.targets += primitive.targets.size();
      for (int d = 0; d < 3; ++d) {
        seen.add(position.minValues.at(size_t(d)), d);
        seen.add(position.maxValues.at(size_t(d)), d);
      }
    }
  std::set<int> moved;
  for (const tinygltf::Animation& animation : model.animations)
    for (const tinygltf::AnimationChannel& channel : animation.channels)
      if (channel.target_path == "weights") moved.insert(channel.target_node);
  seen.moved = moved.size();
  return seen;
}

Seen by_assimp(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, aiProcess_ValidateDataStructure);
  if (scene == nullptr)
    throw std::runtime_error(std::string("assimp: ") + importer.GetErrorString());
  Seen seen;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    if (mesh.mPrimitiveTypes != aiPrimitiveType_TRIANGLE) continue;
    ++seen.primitives;
    seen.triangles += mesh.mNumFaces;
    seen.targets += mesh.mNumAnimMeshes;
    for (unsigned v = 0; v < mesh.mNumVertices; ++v)
      for (int d = 0; d < 3; ++d) seen.add(mesh.mVertices[v][unsigned(d)], d);
    for (unsigned t = 0; t < mesh.mNumAnimMeshes; ++t)
      if (mesh.mAnimMeshes[t]->mNumVertices != mesh.mNumVertices)
        throw std::runtime_error("assimp: a target has other vertices than its mesh");
  }
  for (unsigned a = 0; a < scene->mNumAnimations; ++a)
    seen.moved += scene->mAnimations[a]->mNumMorphMeshChannels;
  return seen;
}

void compare(const std::string& path) {
  const Seen a = by_tinygltf(path), b = by_assimp(path);
  const auto same = [&](const char* what, size_t x, size_t y) {
    if (x != y)
      throw std::runtime_error(std::to_string(x) + ' ' + what + ", assimp sees " +
                               std::to_string(y));
  };
  same("primitives", a.primitives, b.primitives);
  same("triangles", a.triangles, b.triangles);
  same("targets", a.targets, b.targets);
  same("animated nodes", a.moved, b.moved);
  double size = 0;
  for (size_t d = 0; d < 3; ++d) size = std::max(size, a.upper[d] - a.lower[d]);
  for (size_t d = 0; d < 3; ++d)
    if (std::abs(a.lower[d] - b.lower[d]) > 1e-5 * size ||
        std::abs(a.upper[d] - b.upper[d]) > 1e-5 * size)
      throw std::runtime_error("the vertices lie in different boxes");
}

}  // namespace

int main(int count, char** words) {
  for (int k = 1; k < count; ++k) {
    try {
      compare(words[k]);
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s: %s\n", words[k], error.what());
      return 1;
    }
  }
  return 0;
}
