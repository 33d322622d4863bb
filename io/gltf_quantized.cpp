// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_quantized.hpp"

#include "core/error.hpp"
#include "io/gltf_accessor.hpp"
#include "io/gltf_model.hpp"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <set>

namespace elastogen {

namespace {

/// Whether an attribute must be widened to floats.
bool is_quantized(const std::string& name, const tinygltf::Accessor& accessor) {
  if (accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT) return false;
  if (name == "POSITION" || name == "NORMAL" || name == "TANGENT") return true;
  const bool is_unsigned = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                           accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
  return name.starts_with("TEXCOORD_") && !(accessor.normalized && is_unsigned);
}

/// Whether positions were decoded, so that their bounds are not those that the file states.
bool lacks_bounds(const GltfEdit& edit, const tinygltf::Model& model, const std::string& name,
                  const tinygltf::Accessor& accessor) {
  return name == "POSITION" && accessor.minValues.empty() && accessor.bufferView >= 0 &&
         size_t(accessor.bufferView) < model.bufferViews.size() &&
         size_t(model.bufferViews[size_t(accessor.bufferView)].buffer) == edit.file_buffers();
}

}  // namespace

void widen_quantized(GltfEdit& edit) {
  tinygltf::Model model;
  read_gltf_model(edit.current(), model);
  std::set<int> done;
  for (const tinygltf::Mesh& mesh : model.meshes) {
    for (const tinygltf::Primitive& primitive : mesh.primitives) {
      for (const auto& [name, index] : primitive.attributes) {
        if (index < 0 || size_t(index) >= model.accessors.size()) continue;
        const tinygltf::Accessor& accessor = model.accessors[size_t(index)];
        const bool decoded = lacks_bounds(edit, model, name, accessor);
        if (!decoded && !is_quantized(name, accessor)) continue;
        if (!done.insert(index).second) continue;
        const Array<double> values = accessor_values(edit.source(), model, index);
        edit.claim_copy(uint64_t(values.size()) * 4,
                        concat(edit.path(), ": accessors[", index, ']'));
        const std::vector<float> rows(values.data(), values.data() + values.size());
        edit.set_floats(edit.json["accessors"][size_t(index)], rows, size_t(values.cols()),
                        name == "POSITION");
      }
    }
  }
}

}  // namespace elastogen
