// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_instancing.hpp"

#include "core/error.hpp"
#include "io/flat_stream.hpp"
#include "io/gltf_accessor.hpp"
#include "io/gltf_model.hpp"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace elastogen {

namespace {

using Json = GltfEdit::Json;

constexpr const char* kInstancing = "EXT_mesh_gpu_instancing";
constexpr size_t kMaxNodes = 1'000'000;

bool has_instances(const Json& node) {
  const auto extensions = node.find("extensions");
  return extensions != node.end() && extensions->is_object() && extensions->contains(kInstancing);
}

/// Transforms of the instances of one node; arrays without rows where the file has none.
struct Instances {
  int64_t count = -1;
  Array<double> translation, rotation, scale;
};

class InstanceExpander {
 public:
  InstanceExpander(GltfEdit& edit, const tinygltf::Model& model) : edit_(edit), model_(model) {
    for (const Json& node : edit.json["nodes"]) names_.insert(node.value("name", ""));
  }

  void expand_all(std::vector<Finding>& findings) {
    for (size_t n = 0; n < model_.nodes.size(); ++n) {
      if (!has_instances(edit_.json["nodes"][n])) continue;
      const std::string place = concat(edit_.path(), ": nodes[", n, ']');
      const Json extension = edit_.json["nodes"][n]["extensions"][kInstancing];
      if (edit_.json["nodes"][n].contains("mesh")) expand(n, read(extension, place), place);
      Json& extensions = edit_.json["nodes"][n]["extensions"];
      extensions.erase(kInstancing);
      if (extensions.empty()) edit_.json["nodes"][n].erase("extensions");
    }
    if (added_ > 0)
      findings.push_back({"instances", added_, "instances of meshes are in the file"});
    if (others_ > 0)
      findings.push_back({"instance-attributes", others_,
                          shown_line("attributes of instances are unknown: " + other_names_)});
  }

 private:
  static void check(bool condition, const std::string& place, const auto&... parts) {
    ELASTOGEN_CHECK_ASSET(condition, place, ": ", parts...);
  }

  /// Values of an attribute: floats; for rotations also normalised integers.
  Array<double> values(int accessor, const char* name, int width, const std::string& place) {
    const auto& from = model_.accessors[size_t(accessor)];
    edit_.claim_copy(uint64_t(from.count) * uint64_t(width) * 8, place);
    Array<double> rows = accessor_values(edit_.source(), model_, accessor);
    check(rows.cols() == width, place, name, " must have ", width, " numbers for each instance");
    check(from.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT || (width == 4 && from.normalized),
          place, name, " must be floats, or normalised integers for rotations");
    for (int64_t k = 0; k < rows.rows(); ++k) {
      double square = 0;
      for (int d = 0; d < width; ++d) square += rows(k, d) * rows(k, d);
      check(std::isfinite(square), place, name, " of instance ", k, " is not finite");
      if (width != 4) continue;
      check(square > 1e-12, place, name, " of instance ", k, " is no rotation");
      for (int d = 0; d < 4; ++d) rows(k, d) /= std::sqrt(square);
    }
    return rows;
  }

  Instances read(const Json& extension, const std::string& node_place) {
    const std::string place = concat(node_place, ".", kInstancing);
    // every attribute has one value for each instance
    check(extension.is_object() && extension.contains("attributes") &&
              extension["attributes"].is_object() && !extension["attributes"].empty(),
          place, "it has no attributes");
    Instances instances;
    for (const auto& [name, value] : extension["attributes"].items()) {
      const uint64_t index = count_of(extension["attributes"], name.c_str(), place);
      check(index < model_.accessors.size(), place, name, ": there is no accessor ", index);
      const auto count = int64_t(model_.accessors[size_t(index)].count);
      check(count > 0, place, name, " has no instance");
      check(instances.count < 0 || instances.count == count, place, name, " has ", count,
            " instances, another attribute ", instances.count);
      instances.count = count;
      // transforms are read, other attributes are named in a finding
      const auto accessor = int(index);
      if (name == "TRANSLATION") {
        instances.translation = values(accessor, "TRANSLATION", 3, place);
      } else if (name == "ROTATION") {
        instances.rotation = values(accessor, "ROTATION", 4, place);
      } else if (name == "SCALE") {
        instances.scale = values(accessor, "SCALE", 3, place);
      } else {
        other_names_ += (others_++ > 0 ? ", " : "") + name;
      }
    }
    return instances;
  }

  std::string free_name(const std::string& wanted) {
    std::string name = wanted;
    for (int k = 2; !names_.insert(name).second; ++k) name = concat(wanted, '_', k);
    return name;
  }

  void expand(size_t index, const Instances& instances, const std::string& place) {
    Json& nodes = edit_.json["nodes"];
    // skins and counts that would fill memory are refused
    check(!nodes[index].contains("skin"), place, "instances of a skinned mesh are not read");
    check(nodes.size() + size_t(instances.count) <= kMaxNodes, place, "it has ", instances.count,
          " instances; at most ", kMaxNodes, " nodes are read");
    const std::string name = nodes[index].value("name", "node");
    edit_.claim_copy(uint64_t(instances.count) * (name.size() + 128), place);
    // the mesh moves from the node to its children
    Json shown = {{"mesh", nodes[index]["mesh"]}};
    if (nodes[index].contains("weights")) shown["weights"] = nodes[index]["weights"];
    nodes[index].erase("mesh");
    nodes[index].erase("weights");
    const auto row = [](const Array<double>& rows, int64_t k) {
      return std::vector<double>(rows.row(k), rows.row(k) + rows.cols());
    };
    // one child for each instance, with its transform
    for (int64_t k = 0; k < instances.count; ++k) {
      Json child = shown;
      child["name"] = free_name(concat(name, "_instance_", k + 1));
      if (!instances.translation.empty()) child["translation"] = row(instances.translation, k);
      if (!instances.rotation.empty()) child["rotation"] = row(instances.rotation, k);
      if (!instances.scale.empty()) child["scale"] = row(instances.scale, k);
      nodes[index]["children"].push_back(nodes.size());
      nodes.push_back(std::move(child));
    }
    added_ += instances.count;
  }

  GltfEdit& edit_;
  const tinygltf::Model& model_;
  std::set<std::string> names_;  // of nodes
  int64_t added_ = 0, others_ = 0;
  std::string other_names_;
};

}  // namespace

void expand_instances(GltfEdit& edit, std::vector<Finding>& findings) {
  if (!edit.json.contains("nodes") || std::ranges::none_of(edit.json["nodes"], has_instances))
    return;
  tinygltf::Model model;
  read_gltf_model(edit.current(), model);
  InstanceExpander(edit, model).expand_all(findings);
}

}  // namespace elastogen
