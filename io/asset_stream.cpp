// SPDX-License-Identifier: Apache-2.0
#include "io/asset_stream.hpp"

#include "core/error.hpp"
#include "io/asset_check.hpp"
#include "io/flat_stream.hpp"
#include "io/safe_file.hpp"

#include <cmath>
#include <utility>

namespace elastogen {
namespace {

/// Points, where an asset has them; columns of their own are not sent.
template <class Stream, class AssetOfStream>
void transfer_points(Stream& s, AssetOfStream& asset) {
  auto count = uint8_t(asset.points.has_value());
  s.value(count);
  if (count == 0) return;
  PointCloud points = asset.points.value_or(PointCloud());
  s.array(points.position);
  s.array(points.normal);
  s.array(points.colour);
  if constexpr (!std::is_const_v<AssetOfStream>) asset.points = std::move(points);
}

/// Every member that is sent, in the order that writer and reader share.
template <class Stream, class AssetOfStream>
void transfer(Stream& s, AssetOfStream& asset) {
  // axes and unit, then geometry
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
  // how it is shown
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
  transfer_points(s, asset);
  // points, and what the reader noticed
  s.list(asset.findings, [&](auto& finding) {
    s.array(finding.what);
    s.value(finding.count);
    s.array(finding.text);
  });
}

void resolve_textures(Asset& asset) {
  for (AssetMaterial& material : asset.materials) {
    if (material.texture.empty()) continue;
    const std::string name = std::exchange(material.texture, "");
    material.texture = resolve_beside(asset.path, name);
    if (material.texture.empty())
      add_finding(asset, "missing-texture", 1,
                  "the texture " + shown_line(name) + " is not beside the asset");
  }
}

}  // namespace

std::string encode_asset(const Asset& asset) {
  StreamWriter stream;
  stream.value(uint8_t(0));
  transfer(stream, asset);
  return stream.take();
}

Asset decode_asset(std::string_view bytes, const std::string& path) try {
  StreamReader stream(bytes);
  begin_answer(stream);
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
