// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_draco.hpp"

#include "core/error.hpp"

#include <draco/compression/decode.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include <cstring>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <tuple>

namespace elastogen {

namespace {

using Json = GltfEdit::Json;

constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";
/// Real streams pack fewer triangles into a byte.
constexpr uint64_t kMaxFacesPerByte = 1024;
/// Memory for attributes of a vertex that no accessor asks for [bytes].
constexpr uint64_t kSpareBytes = 64;

/// Bound of all attributes of a vertex; vertices times this cannot overflow.
constexpr uint64_t kMaxVertexBytes = 1 << 16;

/// What a stream may hold at most, by the accessors of its primitive.
struct Limits {
  uint64_t faces = 0, vertices = 0;
  uint64_t vertex_bytes = 0;  ///< of all attributes of a vertex
};

/// A decoder that stops before it allocates if a stream claims more than its limits.
template <class Decoder>
class LimitedDecoder : public Decoder {
 public:
  explicit LimitedDecoder(const Limits& limits) : limits_(limits) {}
  bool exceeds() const { return exceeds_; }

 private:
  bool DecodeConnectivity() override {
    // both methods begin with their counts here; the kind of traversal has been read before
    draco::DecoderBuffer ahead = *this->buffer();
    uint32_t first = 0, second = 0;
    if (!draco::DecodeVarint(&first, &ahead) || !draco::DecodeVarint(&second, &ahead)) return false;
    const bool edgebreaker = std::is_base_of_v<draco::MeshEdgebreakerDecoder, Decoder>;
    const uint32_t vertices = edgebreaker ? first : second, faces = edgebreaker ? second : first;
    exceeds_ = faces > limits_.faces || vertices > limits_.vertices;
    return !exceeds_ && Decoder::DecodeConnectivity();
  }

  /// Called when the types of the attributes are known, before their values are read.
  bool DecodeAllAttributes() override {
    uint64_t bytes = 0;
    for (int a = 0; a < this->point_cloud()->num_attributes(); ++a) {
      const draco::PointAttribute& attribute = *this->point_cloud()->attribute(a);
      bytes += uint64_t(attribute.num_components()) *
               uint64_t(draco::DataTypeLength(attribute.data_type()));
    }
    exceeds_ =
        this->point_cloud()->num_points() != limits_.vertices || bytes > limits_.vertex_bytes;
    return !exceeds_ && Decoder::DecodeAllAttributes();
  }

  bool exceeds_ = false;
  const Limits limits_;
};

/// Decodes a mesh of either method. @throws std::runtime_error with the reason where it fails.
template <class Decoder>
std::unique_ptr<draco::Mesh> decoded_by(draco::DecoderBuffer& buffer, const Limits& limits) {
  auto mesh = std::make_unique<draco::Mesh>();
  LimitedDecoder<Decoder> decoder(limits);
  const draco::DecoderOptions options;
  const draco::Status status = decoder.Decode(options, &buffer, mesh.get());
  if (decoder.exceeds()) throw std::runtime_error("it does not hold what its accessors state");
  if (!status.ok()) throw std::runtime_error(status.error_msg());
  return mesh;
}

/// Decodes a mesh. @throws Error (asset) on broken data and beyond the limits.
std::unique_ptr<draco::Mesh> decoded(const uint8_t* data, size_t size, const Limits& limits,
                                     const std::string& place) {
  try {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(data), size);
    draco::DecoderBuffer ahead = buffer;
    draco::DracoHeader header = {};
    const draco::Status known = draco::PointCloudDecoder::DecodeHeader(&ahead, &header);
    // the extension requires meshes of bitstream 2.2
    const bool mesh = known.ok() && header.encoder_type == draco::TRIANGULAR_MESH &&
                      header.version_major == 2 && header.version_minor == 2;
    if (!mesh) throw std::runtime_error("it is no mesh of Draco 2.2");
    return header.encoder_method == draco::MESH_EDGEBREAKER_ENCODING
               ? decoded_by<draco::MeshEdgebreakerDecoder>(buffer, limits)
               : decoded_by<draco::MeshSequentialDecoder>(buffer, limits);
  } catch (const std::exception& failure) {
    throw Error(concat(place, ": its ", kDracoExtension, " stream cannot be used: ", failure.what(),
                       "; re-export without compression"),
                ErrorKind::kAsset);
  }
}

/// Values of an attribute as T, each row at a multiple of four bytes; empty if they do not fit T.
template <class T>
Bytes values_as(const draco::PointAttribute& attribute, size_t vertices, size_t width) {
  const size_t stride = (width * sizeof(T) + 3) / 4 * 4;
  Bytes bytes(vertices * stride);
  std::vector<T> row(width);
  for (size_t v = 0; v < vertices; ++v) {
    const draco::AttributeValueIndex at =
        attribute.mapped_index(draco::PointIndex(static_cast<uint32_t>(v)));
    if (at.value() >= attribute.size() || !attribute.ConvertValue<T>(at, int8_t(width), row.data()))
      return {};
    std::memcpy(bytes.data() + v * stride, row.data(), width * sizeof(T));
  }
  return bytes;
}

Bytes values_of(const draco::PointAttribute& attribute, size_t vertices, size_t width, int type) {
  switch (type) {
    case 5120:
      return values_as<int8_t>(attribute, vertices, width);
    case 5121:
      return values_as<uint8_t>(attribute, vertices, width);
    case 5122:
      return values_as<int16_t>(attribute, vertices, width);
    case 5123:
      return values_as<uint16_t>(attribute, vertices, width);
    case 5125:
      return values_as<uint32_t>(attribute, vertices, width);
    case 5126:
      return values_as<float>(attribute, vertices, width);
    default:
      return {};
  }
}

/// Three indices a face.
Bytes indices_of(const draco::Mesh& mesh, const std::string& place) {
  Bytes bytes(size_t(mesh.num_faces()) * 12);
  for (uint32_t f = 0; f < mesh.num_faces(); ++f) {
    for (size_t c = 0; c < 3; ++c) {
      const uint32_t index = mesh.face(draco::FaceIndex(f))[c].value();
      ELASTOGEN_CHECK_ASSET(index < mesh.num_points(), place, ": vertex index ", index,
                            " is out of range; there are ", mesh.num_points(), " vertices");
      std::memcpy(bytes.data() + 12 * f + 4 * c, &index, 4);
    }
  }
  return bytes;
}

size_t components(const Json& accessor, const std::string& place) {
  static const std::map<std::string, size_t> kWidths = {
      {"SCALAR", 1}, {"VEC2", 2}, {"VEC3", 3}, {"VEC4", 4}};
  const auto width = kWidths.find(accessor.value("type", ""));
  ELASTOGEN_CHECK_ASSET(width != kWidths.end(), place,
                        ": its accessors must be scalars or vectors");
  return width->second;
}

/// Decodes the primitives of one document.
class DracoDecoder {
 public:
  explicit DracoDecoder(GltfEdit& edit) : edit_(edit) {}

  void decode(Json& primitive, const Json& extension, const std::string& place) {
    ELASTOGEN_CHECK_ASSET(extension.is_object() && extension.contains("attributes") &&
                              extension["attributes"].is_object(),
                          place, ": ", kDracoExtension, " must have attributes");
    const uint64_t view = count_of(extension, "bufferView", place);
    const Limits limits = limits_of(primitive, extension, place);
    const auto [data, size] = bytes_of(view, place);
    // limits come from accessors, which may state far more than the bytes can hold
    const bool plausible = limits.faces <= size * kMaxFacesPerByte;
    ELASTOGEN_CHECK_ASSET(plausible && limits.vertices <= 3 * limits.faces, place,
                          ": its accessors state more than its ", size, " packed bytes can hold");
    const uint64_t bytes = limits.faces * 12 + limits.vertices * limits.vertex_bytes;
    if (streams_.insert(view).second) {
      edit_.claim(bytes, place);
    } else {
      edit_.claim_copy(bytes, place);
    }
    const std::unique_ptr<draco::Mesh> mesh = decoded(data, size, limits, place);
    place_indices(*mesh, primitive, view, place);
    for (const auto& [name, id] : extension["attributes"].items())
      place_attribute(*mesh, primitive["attributes"][name], id.get<uint64_t>(), view,
                      concat(place, ": ", name));
  }

 private:
  /// What was decoded for an accessor: stream, attribute (kIndices for indices), accessor.
  using Key = std::tuple<uint64_t, uint64_t, size_t>;
  static constexpr uint64_t kIndices = UINT64_MAX;

  Limits limits_of(const Json& primitive, const Json& extension, const std::string& place) {
    const uint64_t mode = count_of(primitive, "mode", place, 4);
    ELASTOGEN_CHECK_ASSET(mode == 4 || mode == 5, place, ": only triangles are packed by ",
                          kDracoExtension);
    const size_t indices = size_t(count_of(primitive, "indices", place));
    const uint64_t corners = count_of(edit_.entry("accessors", indices, place), "count", place);
    Limits limits = {mode == 4 ? corners / 3 : corners, 0, kSpareBytes};
    for (const auto& [name, id] : extension["attributes"].items()) {
      ELASTOGEN_CHECK_ASSET(id.is_number_unsigned(), place, ": ", name,
                            " must name an attribute by a non-negative integer");
      const size_t index = size_t(count_of(primitive["attributes"], name.c_str(), place));
      const Json& accessor = edit_.entry("accessors", index, place);
      const uint64_t count = count_of(accessor, "count", place);
      ELASTOGEN_CHECK_ASSET(limits.vertices == 0 || count == limits.vertices, place,
                            ": its accessors have ", count, " and ", limits.vertices, " vertices");
      limits.vertices = count;
      limits.vertex_bytes += 8 * components(accessor, place);
    }
    ELASTOGEN_CHECK_ASSET(limits.vertex_bytes <= kMaxVertexBytes, place,
                          ": it has more attributes than any real file");
    return limits;
  }

  std::pair<const uint8_t*, size_t> bytes_of(uint64_t index, const std::string& place) {
    const Json& view = edit_.entry("bufferViews", index, place);
    const uint64_t buffer = count_of(view, "buffer", place),
                   offset = count_of(view, "byteOffset", place, 0),
                   size = count_of(view, "byteLength", place);
    ELASTOGEN_CHECK_ASSET(buffer < edit_.buffers().size(), place, ": there is no buffer ", buffer);
    const Bytes& bytes = edit_.buffers()[size_t(buffer)];
    ELASTOGEN_CHECK_ASSET(offset <= bytes.size() && size <= bytes.size() - offset, place,
                          ": its packed bytes leave the buffer");
    return {bytes.data() + offset, size_t(size)};
  }

  void place_indices(const draco::Mesh& mesh, Json& primitive, uint64_t view,
                     const std::string& place) {
    const Json plain = {
        {"componentType", 5125}, {"count", mesh.num_faces() * 3}, {"type", "SCALAR"}};
    const Bytes bytes = indices_of(mesh, place);
    ELASTOGEN_CHECK_ASSET(!bytes.empty(), place, ": its ", kDracoExtension,
                          " data hold no triangle");
    const size_t accessor = primitive["indices"].get<size_t>();
    primitive["indices"] = place_values({view, kIndices, accessor}, plain, bytes, 0);
    primitive["mode"] = 4;
  }

  /// @param accessor  accessor of the primitive; becomes the one that has the values.
  void place_attribute(const draco::Mesh& mesh, Json& accessor, uint64_t id, uint64_t view,
                       const std::string& place) {
    const Json& stated = edit_.entry("accessors", accessor.get<uint64_t>(), place);
    const draco::PointAttribute* attribute =
        id <= UINT32_MAX ? mesh.GetAttributeByUniqueId(uint32_t(id)) : nullptr;
    const size_t width = components(stated, place), vertices = mesh.num_points();
    ELASTOGEN_CHECK_ASSET(attribute && attribute->num_components() == int(width), place, ": its ",
                          kDracoExtension, " data hold no attribute ", id, " of ", width,
                          " components");
    const Bytes bytes = values_of(*attribute, vertices, width, stated.value("componentType", 0));
    ELASTOGEN_CHECK_ASSET(!bytes.empty(), place, ": its ", kDracoExtension,
                          " data do not fit the component type of its accessor");
    accessor = place_values({view, id, accessor.get<size_t>()}, {{"count", vertices}}, bytes,
                            bytes.size() / vertices);
  }

  /// Gives an accessor the values; a copy of it if it has values of another stream already.
  size_t place_values(const Key& key, const Json& plain, const Bytes& bytes, size_t stride) {
    const auto found = placed_.find(key);
    if (found != placed_.end()) return found->second;
    const size_t stated = std::get<2>(key);
    Json accessor = edit_.json["accessors"][stated];
    const bool taken = accessor.contains("bufferView");
    for (const char* field : {"byteOffset", "sparse", "min", "max"}) accessor.erase(field);
    accessor.update(plain);
    Json view = edit_.view_of(bytes);
    if (stride > 0) view["byteStride"] = stride;
    accessor["bufferView"] = edit_.append("bufferViews", std::move(view));
    if (!taken) edit_.json["accessors"][stated] = accessor;
    return placed_[key] = taken ? edit_.append("accessors", std::move(accessor)) : stated;
  }

  GltfEdit& edit_;
  std::set<uint64_t> streams_;
  std::map<Key, size_t> placed_;
};

/// Removes the extension from a primitive and returns it, if there is one. Fields that are added
/// later move their neighbours, so no reference to one is kept while a primitive is decoded.
std::optional<Json> taken_extension(Json& primitive) {
  if (!primitive.contains("extensions")) return {};
  Json& extensions = primitive["extensions"];
  std::optional<Json> taken;
  if (extensions.is_object() && extensions.contains(kDracoExtension)) {
    taken = extensions[kDracoExtension];
    extensions.erase(kDracoExtension);
  }
  if (extensions.empty()) primitive.erase("extensions");
  return taken;
}

}  // namespace

void decode_draco(GltfEdit& edit) {
  DracoDecoder decoder(edit);
  if (!edit.json.contains("meshes")) return;
  for (size_t m = 0; m < edit.json["meshes"].size(); ++m) {
    Json& primitives = edit.json["meshes"][m]["primitives"];
    for (size_t p = 0; p < primitives.size(); ++p) {
      Json& primitive = primitives[p];
      const std::optional<Json> extension = taken_extension(primitive);
      if (!extension) continue;
      const Json& mesh = edit.json["meshes"][m];
      const std::string name = mesh.contains("name") ? concat(" (", mesh["name"], ')') : "";
      decoder.decode(primitive, *extension,
                     concat(edit.path(), ": meshes[", m, ']', name, ".primitives[", p, ']'));
    }
  }
}

}  // namespace elastogen
