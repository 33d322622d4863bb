// SPDX-License-Identifier: Apache-2.0
#include "io/plain_gltf.hpp"

#include "core/error.hpp"
#include "io/gltf_draco.hpp"
#include "io/gltf_edit.hpp"
#include "io/gltf_instancing.hpp"
#include "io/gltf_meshopt.hpp"
#include "io/gltf_model.hpp"
#include "io/gltf_morph.hpp"
#include "io/gltf_normals.hpp"
#include "io/gltf_quantized.hpp"
#include "io/gltf_skin.hpp"

#include <algorithm>
#include <cstdint>

namespace elastogen {

namespace {

/// Removes the resolved extensions from the lists of the document.
void drop_extensions(GltfEdit::Json& document) {
  for (const char* list : {"extensionsUsed", "extensionsRequired"}) {
    GltfEdit::Json left = GltfEdit::Json::array();
    for (const auto& name : document.value(list, GltfEdit::Json::array())) {
      if (name != "KHR_draco_mesh_compression" && name != "EXT_meshopt_compression" &&
          name != "KHR_mesh_quantization" && name != "EXT_mesh_gpu_instancing")
        left.push_back(name);
    }
    document.erase(list);
    if (!left.empty()) document[list] = std::move(left);
  }
}

/// Parent of each node, the number of nodes where it has none.
std::vector<size_t> parents(const GltfEdit::Json& nodes) {
  std::vector<size_t> parent(nodes.size(), nodes.size());
  for (size_t n = 0; n < nodes.size(); ++n)
    for (const auto& child : nodes[n].value("children", GltfEdit::Json::array()))
      if (child.is_number_unsigned() && child.get<size_t>() < nodes.size())
        parent[child.get<size_t>()] = n;
  return parent;
}

/// The nodes that a scene names must be roots. One that lies below another named node is dropped
/// from the list; one that lies in a tree that the scene does not show is cut from its parent.
void free_roots(GltfEdit::Json& document, std::vector<Finding>& findings) {
  using Json = GltfEdit::Json;
  const size_t scene = document.value("scene", size_t{0});
  if (!document.contains("nodes") || !document.contains("scenes") ||
      scene >= document["scenes"].size() || !document["scenes"][scene].contains("nodes"))
    return;
  // sort the named nodes: roots stay
  Json& nodes = document["nodes"];
  const std::vector<size_t> parent = parents(nodes);
  const Json named = document["scenes"][scene]["nodes"];
  Json roots = Json::array();
  int64_t freed = 0;
  for (const Json& root : named) {
    const size_t n = root.is_number_unsigned() ? root.get<size_t>() : nodes.size();
    if (n >= nodes.size() || parent[n] == nodes.size()) {
      roots.push_back(root);
      continue;
    }
    // climb; the number of steps is bounded, as parents may form a cycle
    bool below = false;
    size_t above = parent[n];
    for (size_t steps = 0; steps < nodes.size() && above < nodes.size() && !below; ++steps) {
      below = std::find(named.begin(), named.end(), Json(above)) != named.end();
      above = parent[above];
    }
    // below a named node it is shown anyway, else it becomes a root
    ++freed;
    if (below) continue;
    Json& children = nodes[parent[n]]["children"];
    children.erase(std::find(children.begin(), children.end(), root));
    if (children.empty()) nodes[parent[n]].erase("children");
    roots.push_back(root);
  }
  if (freed == 0) return;
  document["scenes"][scene]["nodes"] = std::move(roots);
  findings.push_back(
      {"scene-roots", freed, "nodes that the scene names as its roots have a parent"});
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
    expand_instances(edit, findings);
    free_roots(edit.json, findings);
    bake_morph_weights(edit, findings);
    pose_skins(edit, findings);
    mend_gltf_normals(edit, findings);
    drop_extensions(edit.json);
    return edit.finished();
  } catch (const nlohmann::json::exception& failure) {
    throw Error(path + ": not valid glTF: " + failure.what(), ErrorKind::kAsset);
  }
}

}  // namespace elastogen
