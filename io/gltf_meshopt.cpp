// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_meshopt.hpp"

#include "core/error.hpp"

#include <meshoptimizer.h>

namespace elastogen {

namespace {

using Json = GltfEdit::Json;

constexpr const char* kMeshoptExtension = "EXT_meshopt_compression";

/// A packed buffer view, checked.
struct Packed {
  const uint8_t* data = nullptr;
  size_t size = 0, stride = 0, count = 0;
  std::string mode, filter;
};

std::string text_of(const Json& object, const char* key, const std::string& place) {
  const Json value = object.value(key, Json(""));
  ELASTOGEN_CHECK_ASSET(value.is_string(), place, ": \"", key, "\" must be a string");
  return value.get<std::string>();
}

/// @throws Error unless mode, filter, stride and count fit together.
void check_rules(const Packed& packed, const std::string& place) {
  const auto check = [&](bool condition, const char* message) {
    ELASTOGEN_CHECK_ASSET(condition, place, ": ", message);
  };
  const size_t stride = packed.stride;
  const std::string& filter = packed.filter;
  if (packed.mode == "ATTRIBUTES") {
    check(stride >= 4 && stride <= 256 && stride % 4 == 0,
          "byteStride of attributes must be a multiple of 4 up to 256");
    check(filter.empty() || filter == "NONE" || filter == "EXPONENTIAL" ||
              (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
              (filter == "QUATERNION" && stride == 8),
          "its filter is not known or does not go with its byteStride");
    check(packed.count <= packed.size * 64 / stride, "count is more than its bytes can hold");
    return;
  }
  check(packed.mode == "TRIANGLES" || packed.mode == "INDICES",
        "mode must be ATTRIBUTES, TRIANGLES or INDICES");
  check(stride == 2 || stride == 4, "byteStride of indices must be 2 or 4");
  check(filter.empty() || filter == "NONE", "indices have no filter");
  const bool triangles = packed.mode == "TRIANGLES";
  check(!triangles || packed.count % 3 == 0, "count of triangles must be a multiple of 3");
  check(packed.count <= packed.size * (triangles ? 3 : 1), "count is more than its bytes can hold");
}

Packed checked(const GltfEdit& edit, const Json& view, const Json& extension,
               const std::string& place) {
  ELASTOGEN_CHECK_ASSET(extension.is_object(), place, ": ", kMeshoptExtension,
                        " must be an object");
  const uint64_t index = count_of(extension, "buffer", place);
  ELASTOGEN_CHECK_ASSET(index < edit.file_buffers(), place, ": there is no buffer ", index);
  const Bytes& buffer = edit.buffers()[size_t(index)];
  const uint64_t offset = count_of(extension, "byteOffset", place, 0),
                 size = count_of(extension, "byteLength", place);
  ELASTOGEN_CHECK_ASSET(offset <= buffer.size() && size <= buffer.size() - offset, place,
                        ": its packed bytes leave the buffer");
  const Packed packed = {buffer.data() + offset,
                         size_t(size),
                         size_t(count_of(extension, "byteStride", place)),
                         size_t(count_of(extension, "count", place)),
                         text_of(extension, "mode", place),
                         text_of(extension, "filter", place)};
  check_rules(packed, place);
  ELASTOGEN_CHECK_ASSET(packed.count * packed.stride == count_of(view, "byteLength", place), place,
                        ": byteLength is not count times byteStride");
  return packed;
}

Bytes decoded(const Packed& packed, const std::string& place) {
  Bytes bytes(packed.count * packed.stride);
  int failure = 0;
  if (packed.mode == "ATTRIBUTES") {
    failure = meshopt_decodeVertexBuffer(bytes.data(), packed.count, packed.stride, packed.data,
                                         packed.size);
  } else if (packed.mode == "TRIANGLES") {
    failure = meshopt_decodeIndexBuffer(bytes.data(), packed.count, packed.stride, packed.data,
                                        packed.size);
  } else {
    failure = meshopt_decodeIndexSequence(bytes.data(), packed.count, packed.stride, packed.data,
                                          packed.size);
  }
  ELASTOGEN_CHECK_ASSET(failure == 0, place, ": its ", kMeshoptExtension,
                        " data are broken; re-export without compression");
  if (packed.filter == "OCTAHEDRAL") {
    meshopt_decodeFilterOct(bytes.data(), packed.count, packed.stride);
  } else if (packed.filter == "QUATERNION") {
    meshopt_decodeFilterQuat(bytes.data(), packed.count, packed.stride);
  } else if (packed.filter == "EXPONENTIAL") {
    meshopt_decodeFilterExp(bytes.data(), packed.count, packed.stride);
  }
  return bytes;
}

}  // namespace

void decode_meshopt(GltfEdit& edit) {
  if (!edit.json.contains("bufferViews")) return;
  for (size_t v = 0; v < edit.json["bufferViews"].size(); ++v) {
    Json& view = edit.json["bufferViews"][v];
    const Json extensions = view.value("extensions", Json());
    if (!extensions.is_object() || !extensions.contains(kMeshoptExtension)) continue;
    const std::string place = concat(edit.path(), ": bufferViews[", v, ']');
    const Packed packed = checked(edit, view, extensions[kMeshoptExtension], place);
    edit.claim(packed.count * packed.stride, place);
    view.update(edit.view_of(decoded(packed, place)));
    view["extensions"].erase(kMeshoptExtension);
    if (view["extensions"].empty()) view.erase("extensions");
  }
}

}  // namespace elastogen
