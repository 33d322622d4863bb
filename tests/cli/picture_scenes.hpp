// SPDX-License-Identifier: Apache-2.0
// Small scenes whose pictures follow from geometry.

#pragma once

#include "cli/picture/scene_picture.hpp"
#include "io/asset.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <vector>

namespace elastogen::test {

using Rgb = std::array<int, 3>;

inline Rgb at(const Pixels& picture, int x, int y) {
  const uint8_t* p = picture.rgb.data() + 3 * (size_t(y) * size_t(picture.width) + size_t(x));
  return {p[0], p[1], p[2]};
}

/// Pixels that satisfy a condition.
template <class Condition>
int count(const Pixels& picture, const Condition& condition) {
  int pixels = 0;
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) pixels += condition(at(picture, x, y));
  return pixels;
}

inline bool is_red(const Rgb& c) {
  return c[0] > 60 && c[1] < 20 && c[2] < 20;
}
inline bool is_green(const Rgb& c) {
  return c[1] > 60 && c[0] < 20 && c[2] < 20;
}
inline bool is_sky(const Rgb& c) {
  return c[0] > 240 && c[1] > 240 && c[2] > 240;
}

/// Decodes what encode_png writes, chunk by chunk, each checksum compared.
inline Pixels decoded(const std::string& png) {
  const auto word = [&](size_t at) {
    uint32_t value = 0;
    for (size_t k = 0; k < 4; ++k) value = value << 8 | uint8_t(png[at + k]);
    return value;
  };
  // the signature, then chunks with their checksums
  EXPECT_EQ(png.substr(0, 8), "\x89PNG\r\n\x1a\n");
  Pixels picture(0, 0);
  for (size_t at = 8; at < png.size(); at += word(at) + 12) {
    const size_t size = word(at);
    const std::string type = png.substr(at + 4, 4);
    const auto* body = reinterpret_cast<const Bytef*>(png.data()) + at + 4;
    EXPECT_EQ(word(at + 8 + size), crc32(0, body, uInt(size + 4))) << type;
    if (type == "IHDR") picture = Pixels(int(word(at + 8)), int(word(at + 12)));
    // rows of the only data chunk, without their filter bytes
    if (type != "IDAT") continue;
    const size_t row = 3 * size_t(picture.width);
    std::string rows(size_t(picture.height) * (row + 1), '\0');
    uLongf raw = uLongf(rows.size());
    EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(rows.data()), &raw, body + 4, uLong(size)), Z_OK);
    for (size_t y = 0; y < size_t(picture.height); ++y)
      std::copy_n(rows.begin() + int64_t(y * (row + 1) + 1), row,
                  picture.rgb.begin() + int64_t(y * row));
  }
  return picture;
}

/// A mesh with colours of its vertices, linear, and its frames.
struct MeshScene {
  /// @param colours  of each vertex; none: one grey.
  MeshScene(const std::vector<Vec3>& positions, const std::vector<int32_t>& triangles,
            const std::vector<std::array<float, 4>>& colours = {}) {
    Mesh& mesh = asset.meshes.emplace_back();
    mesh.position = positions;
    mesh.position_of.resize(positions.size());
    std::iota(mesh.position_of.begin(), mesh.position_of.end(), 0);
    mesh.colour = colours;
    mesh.groups.push_back({-1, triangles});
    asset.nodes.push_back({"", -1, kIdentity4, 0});
    asset.format = "ply";
    pose();
  }

  void pose() {
    surface = pose_surface(asset);
    frames = {surface.vertices};
    framed.resize(size_t(surface.vertices.rows()));
    std::iota(framed.begin(), framed.end(), 0);
  }

  /// Adds the last frame again, moved.
  Array<double>& add_frame(const Vec3& shift = {}) {
    frames.push_back(frames.back());
    for (int64_t n = 0; n < frames.back().rows(); ++n)
      for (int d = 0; d < 3; ++d) frames.back()(n, d) += shift[size_t(d)];
    return frames.back();
  }

  /// Calls back with the pictures of the frames so far.
  template <class Use>
  auto use(const Use& use, const PictureOptions& options) {
    const std::unique_ptr<Subject> subject = make_mesh_subject(asset, surface, 64, notes);
    const FrameSource source = {int64_t(frames.size()),
                                surface.vertices.rows(),
                                30,
                                [&](int64_t f, Out<double> x) {
                                  std::copy_n(frames[size_t(f)].data(), frames[size_t(f)].size(),
                                              x.data);
                                },
                                {}};
    ScenePicture picture({*subject, framed, colliders, up}, source, options);
    return use(picture);
  }

  Pixels drawn(int64_t frame = 0, const PictureOptions& options = {View::kThreeQuarter, 64, 64}) {
    return use([&](ScenePicture& picture) { return picture.draw(frame); }, options);
  }

  Asset asset;
  Surface surface;
  std::vector<Array<double>> frames;
  std::vector<int32_t> framed;
  std::vector<Collider> colliders;
  UpAxis up;
  std::vector<std::string> notes;
};

inline const std::array<float, 4> kRed = {1, 0, 0, 1}, kGreen = {0, 1, 0, 1};

/// Two squares of edge 1 in planes z = 0 (red) and z = -1 (green), the green one moved by `shift`.
inline MeshScene squares(double shift = 0) {
  std::vector<Vec3> positions;
  std::vector<std::array<float, 4>> colours;
  for (int n = 0; n < 8; ++n) {
    positions.push_back({(n & 1) + (n < 4 ? 0 : shift), double(n >> 1 & 1), n < 4 ? 0. : -1.});
    colours.push_back(n < 4 ? kRed : kGreen);
  }
  return {positions, {0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6}, colours};
}

}  // namespace elastogen::test
