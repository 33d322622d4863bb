// SPDX-License-Identifier: Apache-2.0
#include "io/asset_stream.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/child_reader.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <type_traits>

namespace elastogen {
namespace {

constexpr std::string_view kMagic = "elastogen-asset1";
constexpr size_t kMaxMessage = 300;  ///< of a message that is shown [bytes]

/// Appends what it is given.
class StreamWriter {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof(T));
  }
  template <class Items>
  void array(const Items& items) {
    value(uint64_t(items.size()));
    bytes_.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(items[0]));
  }
  template <class T, class Fields>
  void list(const std::vector<T>& items, const Fields& fields) {
    value(uint64_t(items.size()));
    for (const T& item : items) fields(item);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_{kMagic};
};

/// Fills what it is given from bytes that may be anything.
class StreamReader {
 public:
  explicit StreamReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&v, take(1, sizeof(T)).data(), sizeof(T));
  }
  template <class Items>
  void array(Items& items) {
    uint64_t count = 0;
    value(count);
    const std::string_view from = take(count, sizeof(items[0]));
    items.resize(size_t(count));
    if (count > 0) std::memcpy(items.data(), from.data(), from.size());
  }
  /// The list grows with the bytes that its items take, whatever count is claimed.
  template <class T, class Fields>
  void list(std::vector<T>& items, const Fields& fields) {
    uint64_t count = 0;
    value(count);
    for (uint64_t k = 0; k < count; ++k) fields(items.emplace_back());
  }
  std::string_view take(uint64_t count, size_t size) {
    ELASTOGEN_CHECK_ASSET(count <= bytes_.size() / size, "its answer is cut off");
    const std::string_view taken = bytes_.substr(0, size_t(count) * size);
    bytes_.remove_prefix(taken.size());
    return taken;
  }
  size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

/// Every member that is sent, in order; the same for both directions.
template <class Stream, class AssetOfStream>
void transfer(Stream& s, AssetOfStream& asset) {
  s.value(asset.up);
  s.value(asset.unit);
  s.list(asset.meshes, [&](auto& mesh) {
    s.array(mesh.name);
    s.array(mesh.position);
    s.array(mesh.position_of);
    s.array(mesh.uv);
    s.array(mesh.normal);
    s.array(mesh.colour);
    s.list(mesh.groups, [&](auto& group) {
      s.value(group.material);
      s.array(group.corner);
    });
  });
  s.list(asset.nodes, [&](auto& node) {
    s.array(node.name);
    s.value(node.parent);
    s.value(node.matrix);
    s.value(node.mesh);
  });
  s.list(asset.materials, [&](auto& material) {
    s.array(material.name);
    s.value(material.base_colour);
    s.array(material.texture);
  });
  s.list(asset.findings, [&](auto& finding) {
    s.array(finding.what);
    s.value(finding.count);
    s.array(finding.text);
  });
}

/// One line of printable text, shortened.
std::string shown(std::string_view message) {
  std::string text(message.substr(0, kMaxMessage));
  std::ranges::replace_if(
      text, [](char c) { return uint8_t(c) < 0x20 || c == 0x7f; }, ' ');
  return message.size() > kMaxMessage ? text + "..." : text;
}

void throw_failure(StreamReader& stream, ReaderFailure failure) {
  std::string message;
  stream.array(message);
  if (failure == ReaderFailure::kMemory)
    message = concat("reading it needed more than ", kReaderMemory >> 30,
                     " GiB; simplify it, or convert it to GLB");
  throw Error(shown(message), ErrorKind::kAsset);
}

void resolve_textures(Asset& asset) {
  for (AssetMaterial& material : asset.materials) {
    if (material.texture.empty()) continue;
    const std::string name = std::exchange(material.texture, "");
    material.texture = resolve_beside(asset.path, name);
    if (material.texture.empty())
      add_finding(asset, "missing-texture", 1,
                  "the texture " + shown(name) + " is not beside the asset");
  }
}

}  // namespace

std::string encode_asset(const Asset& asset) {
  StreamWriter stream;
  stream.value(uint8_t(0));
  transfer(stream, asset);
  return stream.take();
}

std::string encode_failure(ReaderFailure failure, std::string_view message) {
  StreamWriter stream;
  stream.value(uint8_t(failure));
  stream.array(message);
  return stream.take();
}

Asset decode_asset(std::string_view bytes, const std::string& path) try {
  StreamReader stream(bytes);
  ELASTOGEN_CHECK_ASSET(stream.take(kMagic.size(), 1) == kMagic, "its answer is no asset");
  uint8_t failure = 0;
  stream.value(failure);
  if (failure != 0) throw_failure(stream, ReaderFailure(failure));
  Asset asset;
  asset.path = path;
  transfer(stream, asset);
  ELASTOGEN_CHECK_ASSET(stream.left() == 0, "its answer has ", stream.left(), " bytes too many");
  ELASTOGEN_CHECK_ASSET(asset.up >= -3 && asset.up <= 3, "its answer has the axis ", asset.up);
  ELASTOGEN_CHECK_ASSET(asset.unit >= 0 && std::isfinite(asset.unit), "its unit of ", asset.unit,
                        " m is out of range");
  resolve_textures(asset);
  return asset;
} catch (const Error& error) {
  throw Error(path + ": " + error.what(), error.kind());
}

}  // namespace elastogen
