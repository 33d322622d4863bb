// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_model.hpp"

#include "core/error.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <fstream>
#include <set>

#define TINYGLTF_IMPLEMENTATION
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_INCLUDE_JSON
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

namespace elastogen {

namespace {

using nlohmann::json;

constexpr size_t kMaxItems = 1'000'000;

/// Checks one value of a document and everything below it. `place` is for messages.
class Checker {
 public:
  explicit Checker(const std::string& path) : path_(path) {}

  /// Removes extras and extensions of an object or a list, and checks everything else.
  void clean(json& value, const std::string& place) const {
    if (value.is_array()) {
      for (size_t i = 0; i < value.size(); ++i) clean(value[i], concat(place, '[', i, ']'));
    }
    if (!value.is_object()) return;
    value.erase("extras");
    value.erase("extensions");
    for (auto& [key, member] : value.items()) {
      const std::string here = place + '.' + key;
      check(key, member, here);
      clean(member, here);
    }
  }

 private:
  void check(const std::string& key, const json& member, const std::string& place) const {
    // what the standard says of a key tells its type
    static const std::set<std::string> kIndices = {
        "buffer", "bufferView", "byteStride", "camera",   "componentType",
        "count",  "index",      "indices",    "material", "mesh",
        "mode",   "scene",      "skin",       "target",   "texCoord"};
    static const std::set<std::string> kObjects = {"attributes", "sparse"};
    static const std::set<std::string> kNumbers = {"matrix", "rotation", "scale", "translation"};
    const bool sparse_part = place.find(".sparse.") != std::string::npos;
    // parts of sparse accessors are objects where others have an index
    if (sparse_part && (key == "indices" || key == "values")) {
      fail_unless(member.is_object(), place, "an object");
    } else if (key == "byteOffset" || key == "byteLength") {
      // byte counts may be larger than indices
      check_count(member, place, sparse_part ? uint64_t(1) << 31 : uint64_t(1) << 53);
    } else if (kIndices.contains(key) && !member.is_object()) {
      check_count(member, place, uint64_t(1) << 31);
    } else if (key == "children" || key == "nodes") {
      // lists of indices, and objects of them
      fail_unless(member.is_array(), place, "a list");
      for (const json& entry : member) check_count(entry, place, uint64_t(1) << 31);
    } else if (kObjects.contains(key)) {
      fail_unless(member.is_object(), place, "an object");
      if (key == "attributes") {
        for (const json& entry : member) check_count(entry, place, uint64_t(1) << 31);
      }
    } else if (kNumbers.contains(key)) {
      check_numbers(member, place);
    } else if (key == "name") {
      fail_unless(member.is_string(), place, "a string");
    }
  }

  void check_count(const json& value, const std::string& place, uint64_t limit) const {
    fail_unless(value.is_number_unsigned() && value.get<uint64_t>() < limit, place,
                "a non-negative integer within range");
  }

  void check_numbers(const json& value, const std::string& place) const {
    fail_unless(value.is_array(), place, "a list of numbers");
    for (const json& entry : value) {
      fail_unless(entry.is_number() && std::isfinite(entry.get<double>()), place,
                  "a list of finite numbers");
    }
  }

  void fail_unless(bool condition, const std::string& place, const char* expected) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ": ", place, " must be ", expected);
  }

  const std::string& path_;
};

/// Checks that a value is a list of objects.
void check_list(const json& list, const std::string& name, const std::string& path) {
  ELASTOGEN_CHECK_ASSET(list.is_array(), path, ": ", name, " must be a list");
  ELASTOGEN_CHECK_ASSET(list.size() <= kMaxItems, path, ": ", name, " has ", list.size(),
                        " entries; at most ", kMaxItems, " are read");
  for (const json& entry : list) {
    ELASTOGEN_CHECK_ASSET(entry.is_object(), path, ": ", name, " must hold objects only");
  }
}

/// The parts of a document that carry geometry, checked.
json geometry_part(const json& document, const std::string& path) {
  const Checker checker(path);
  json part = {{"asset", {{"version", "2.0"}}}};
  // the lists that geometry needs; morph targets are handled elsewhere
  for (const char* name : {"accessors", "bufferViews", "materials", "meshes", "nodes", "scenes"}) {
    if (!document.contains(name)) continue;
    json& list = part[name] = document[name];
    check_list(list, name, path);
    if (name == std::string("meshes")) {
      for (size_t m = 0; m < list.size(); ++m) {
        const std::string primitives = concat("meshes[", m, "].primitives");
        check_list(list[m].value("primitives", json()), primitives, path);
        for (json& primitive : list[m]["primitives"]) {
          ELASTOGEN_CHECK_ASSET(primitive.contains("attributes"), path, ": ", primitives,
                                " must have attributes");
          primitive.erase("targets");
        }
      }
    }
    checker.clean(list, name);
  }
  // the default scene
  if (document.contains("scene")) {
    json scene = {{"scene", document["scene"]}};
    checker.clean(scene, "document");
    part.update(scene);
  }
  return part;
}

json checked_geometry(const GltfSource& source) {
  const json document = json::parse(source.json);
  const json asset = document.value("asset", json::object());
  const json version = asset.is_object() ? asset.value("version", json()) : json();
  ELASTOGEN_CHECK_ASSET(version.is_string() && version.get<std::string>().starts_with("2."),
                        source.path, ": asset.version must be 2.x; other versions are not read");
  return geometry_part(document, source.path);
}

}  // namespace

void check_gltf_types(const GltfSource& source) {
  checked_geometry(source);
}

void read_gltf_model(const GltfSource& source, tinygltf::Model& model) {
  const std::string text = checked_geometry(source).dump();
  tinygltf::TinyGLTF reader;
  std::string error, warning;
  const bool ok =
      reader.LoadASCIIFromString(&model, &error, &warning, text.data(), unsigned(text.size()), "");
  ELASTOGEN_CHECK_ASSET(ok, source.path, ": not valid glTF: ", error);
}

}  // namespace elastogen
