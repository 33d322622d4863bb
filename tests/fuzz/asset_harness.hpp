// SPDX-License-Identifier: Apache-2.0
// Properties of every asset that a reader returns, and of every reader: equal bytes give equal
// assets or equal sentences, and an asset that passes the check can be posed and made a body, or is
// refused as an asset.

#pragma once

#include "io/asset_check.hpp"
#include "io/asset_pose.hpp"
#include "io/asset_stream.hpp"
#include "io/ply_mesh.hpp"
#include "io/ply_reader.hpp"
#include "tests/fuzz/harness.hpp"
#include "voxelize/body.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

namespace elastogen::fuzz {

/// The bytes of a list of plain values.
template <class T>
std::string_view bytes_of(const std::vector<T>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T)};
}

/// All data that a reader returns, to the bit.
inline std::string fingerprint(const Asset& asset) {
  std::string all = encode_asset(asset);
  for (const Mesh& mesh : asset.meshes) {
    all += bytes_of(mesh.file_position);
    for (const TriangleGroup& group : mesh.groups) all += group.has_uv ? 'u' : '-';
    for (const OwnColumn& own : mesh.own)
      all += concat(own.name, int(own.type), bytes_of(own.value));
  }
  if (asset.points)
    all += concat(bytes_of(asset.points->position), '|', bytes_of(asset.points->normal), '|',
                  bytes_of(asset.points->colour));
  if (asset.splats) {
    const SplatCloud& s = *asset.splats;
    all += concat(bytes_of(s.position), '|', bytes_of(s.scale), '|', bytes_of(s.rotation), '|',
                  bytes_of(s.opacity), '|', bytes_of(s.harmonics), '|', s.degree);
  }
  return all;
}

inline void require_finite(In<double> values, std::string_view what) {
  for (int64_t k = 0; k < values.size(); ++k) require(std::isfinite(values.data[k]), what);
}

inline void check_body(const Body& body) {
  const Surface& s = body.surface;
  require_finite(s.vertices, "vertices are finite");
  require_finite(body.carried, "carried points are finite");
  require(s.triangles.rows() > 0 && s.material.rows() == s.triangles.rows(), "there are triangles");
  for (int64_t k = 0; k < s.triangles.size(); ++k)
    require(s.triangles.data()[k] >= 0 && s.triangles.data()[k] < s.vertices.rows(),
            "triangles have vertices that are there");
}

/// @param size  longest edge [m], 0 as the file has it.
inline void check_sized(const Asset& asset, double size) {
  try {
    const Body body = make_body(asset, size);
    check_body(body);
    const Box& box = body.surface.box;
    const double longest = std::max({box.extent(0), box.extent(1), box.extent(2)});
    require(longest > 0 && std::isfinite(longest), "a body has an extent");
    choose_size(asset, longest, size > 0);
  } catch (const Error& error) {
    require_kind(error, ErrorKind::kAsset);
  }
}

/// Whether to make a body of the asset. OpenVDB needs a second for a shell of points or splats
/// under the sanitizers, a reader a millisecond: one asset in 64 is enough, chosen by its content,
/// so that an input that fails fails again.
inline bool is_worth_a_body(const Asset& asset) {
  return !(asset.points || asset.splats) || std::hash<std::string>{}(fingerprint(asset)) % 64 == 0;
}

/// The rest frame of a PLY sequence can be read and has the asset's vertices and triangles.
inline void check_ply_frame(const Asset& asset) {
  const Surface surface = pose_surface(asset);
  const FileOrder order = file_order(asset, surface);
  PlyMesh ply("fuzz.ply", asset, surface, order);
  const std::string header = ply.header();
  if (header.size() > 60000) return;  // the reader accepts 64 KiB
  const Array<double> still(surface.vertices.rows(), 3);
  const Asset back = parse_ply(
      concat("ply\nformat binary_little_endian 1.0\n", header, "end_header\n", ply.body(still)),
      path_of("fuzz.ply"));
  require(back.meshes.size() == 1 && back.meshes[0].position.size() == order.rest.size(),
          "a frame has the vertices of the asset");
  size_t corners = 0;
  for (const TriangleGroup& group : back.meshes[0].groups) corners += group.corner.size();
  require(corners == size_t(surface.triangles.size()), "a frame has the triangles of the asset");
}

/// The steps that follow a reader in the command.
inline void check_read(Asset asset) {
  try {
    check_asset(asset);
  } catch (const Error& error) {
    return require_kind(error, ErrorKind::kAsset);
  }
  choose_up(asset, {});
  if (!asset.points && !asset.splats) check_ply_frame(asset);
  if (!is_worth_a_body(asset)) return;
  check_sized(asset, 0);
  check_sized(asset, 0.3);
}

/// @param read  gives an asset or throws.
/// @return the asset or the message, as one text.
template <class Read>
std::string answer(const Read& read) {
  try {
    return fingerprint(read());
  } catch (const Error& error) {
    require_kind(error, ErrorKind::kAsset);
    return error.what();
  }
}

template <class Read>
void check_reader(const Read& read) {
  try {
    Asset asset = read();
    require(answer(read) == fingerprint(asset), "a reader gives the same asset twice");
    check_read(std::move(asset));
  } catch (const Error& error) {
    require_kind(error, ErrorKind::kAsset);
    require(answer(read) == error.what(), "a reader gives the same reason twice");
  }
}

}  // namespace elastogen::fuzz
