// SPDX-License-Identifier: Apache-2.0
#include "io/plain_gltf.hpp"

#include "core/error.hpp"
#include "io/gltf_draco.hpp"
#include "io/gltf_edit.hpp"
#include "io/gltf_meshopt.hpp"
#include "io/gltf_model.hpp"
#include "io/gltf_quantized.hpp"
#include "io/gltf_skin.hpp"

namespace elastogen {

namespace {

/// Takes the extensions that are resolved off the lists of the document.
void drop_extensions(GltfEdit::Json& document) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    GltfEdit::Json left = GltfEdit::Json::array();
    for (const auto& name : document.value(list, GltfEdit::Json::array())) {
      if (name != "KHR_draco_mesh_compression" && name != "EXT_meshopt_compression" &&
          name != "KHR_mesh_quantization")
        left.push_back(name);
    }
    document.erase(list);
    if (!left.empty()) document[list] = std::move(left);
  }
}

}  // namespace

GltfSource plain_gltf(GltfSource source, std::vector<Finding>& findings) {
  const std::string path = source.path;
  check_gltf_types(source);
  GltfEdit edit(std::move(source));
  try {
    decode_meshopt(edit);
    decode_draco(edit);
    widen_quantized(edit);
    pose_skins(edit, findings);
    drop_extensions(edit.json);
    return edit.finished();
  } catch (const nlohmann::json::exception& failure) {
    throw Error(path + ": not valid glTF: " + failure.what(), ErrorKind::kAsset);
  }
}

}  // namespace elastogen
