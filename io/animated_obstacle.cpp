// SPDX-License-Identifier: Apache-2.0
// Obstacles (floor and colliders) that an AnimatedDocument shows beside its meshes.

#include "io/animated_document.hpp"

namespace elastogen {

/// Grey, rough, seen from both sides.
size_t AnimatedDocument::obstacle_material() {
  if (!grey_) {
    json_["materials"].push_back(
        {{"name", "elastogen_collider"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.5, 0.5, 0.5, 1}}, {"metallicFactor", 0}, {"roughnessFactor", 1}}},
         {"doubleSided", true}});
    grey_ = json_["materials"].size() - 1;
  }
  return *grey_;
}

void AnimatedDocument::add_obstacle(const Obstacle& obstacle) {
  // positions, normals and corners get a buffer view each
  const auto vectors = [this](const std::vector<float>& values) {
    const size_t size = values.size() * sizeof(float);
    const size_t view = add_view(append_bytes(bin_, values.data(), size), size);
    json_["bufferViews"][view]["target"] = kVertices;
    return add_vectors(view, 0, values.data(), int64_t(values.size() / 3));
  };
  const size_t position = vectors(obstacle.positions), normal = vectors(obstacle.normals);
  const size_t size = obstacle.corners.size() * sizeof(uint32_t);
  const size_t view = add_view(append_bytes(bin_, obstacle.corners.data(), size), size);
  json_["bufferViews"][view]["target"] = kIndices;
  const size_t index = add_accessor({{"bufferView", view},
                                     {"componentType", kUnsignedInt},
                                     {"count", obstacle.corners.size()},
                                     {"type", "SCALAR"}});
  // a mesh, and a node for it at a root of the scene
  const Json primitive = {{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
                          {"indices", index},
                          {"material", obstacle_material()}};
  json_["meshes"].push_back({{"name", obstacle.name}, {"primitives", Json::array({primitive})}});
  Json& roots = scene()["nodes"];
  const size_t node = json_["nodes"].size();
  json_["nodes"].push_back({{"name", free_name(obstacle.name)},
                            {"mesh", json_["meshes"].size() - 1},
                            {"translation", obstacle.place}});
  roots.push_back(node);
  if (obstacle.offsets.empty()) return;
  // an obstacle that moves gets a translation for each frame
  std::vector<float> places;
  for (const Vec3& offset : obstacle.offsets)
    for (size_t d = 0; d < 3; ++d) places.push_back(float(obstacle.place[d] + offset[d]));
  const size_t bytes = places.size() * sizeof(float);
  const size_t output = add_view(append_bytes(bin_, places.data(), bytes), bytes);
  const auto frames = int64_t(obstacle.offsets.size());
  add_channel(node, "translation", "LINEAR", times_of({0, frames - 1}),
              add_vectors(output, 0, places.data(), frames));
}

}  // namespace elastogen
