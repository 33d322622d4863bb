// SPDX-License-Identifier: Apache-2.0
#include "io/ply_writer.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"
#include "io/byte_reader.hpp"
#include "io/frame_files.hpp"
#include "io/ply_mesh.hpp"
#include "io/safe_file.hpp"
#include "io/splat_motion.hpp"
#include "io/splat_ply.hpp"
#include "io/turned_normal.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <optional>

namespace elastogen {
namespace {

std::string properties(std::initializer_list<const char*> names, const char* type = "float") {
  std::string text;
  for (const char* name : names) text += concat("property ", type, ' ', name, '\n');
  return text;
}

std::string numbered(const char* name, size_t count) {
  std::string text;
  for (size_t k = 0; k < count; ++k) text += concat("property float ", name, k, '\n');
  return text;
}

constexpr const char* kWrittenTypes[] = {"char", "uchar", "short", "ushort",
                                         "int",  "uint",  "float", "double"};

class PlyWriter : public AnimationWriter {
 public:
  PlyWriter(const std::string& path, const Asset& asset, const Surface& surface,
            const std::optional<ParticleSet>& particles)
      : path_(path),
        asset_(asset),
        surface_(surface),
        order_(file_order(asset, surface)),
        particles_(particles) {
    if (asset.splats) motion_.emplace(*asset.splats);
    if (!asset.splats && !asset.points) mesh_.emplace(path, asset, surface, order_);
    SafeFile probe(frame_path(path, 0, ".ply"));  // throws here if the folder cannot be written
  }

  bool needs_gradient() const override {
    return motion_ || (asset_.points && !asset_.points->normal.empty());
  }

  bool needs_motion() const override { return particles_.has_value(); }

  void frame(const AnimationFrame& frame) override {
    check_frame(frame, frames_, int64_t(order_.vertex.size()), needs_gradient());
    ELASTOGEN_CHECK(!particles_ || (frame.state && frame.particles), path_,
                    ": a frame of particles must come with their state and strain");
    const std::string path = frame_path(path_, frames_, ".ply");
    ELASTOGEN_CHECK(std::filesystem::path(path).lexically_normal() !=
                        std::filesystem::path(asset_.path).lexically_normal(),
                    path, ": a frame would take the place of the input; name the output otherwise");
    if (motion_) motion_->turn(frame.gradient);
    std::string bytes = header();
    if (mesh_) bytes += mesh_->body(frame.displacement);
    for (size_t p = 0; p < order_.rest.size() && !mesh_; ++p) append_point(frame, p, bytes);
    write_file(path, bytes);
    ++frames_;
  }

  void finish() override { ELASTOGEN_CHECK(frames_ > 0, path_, ": there is no frame to write"); }

 private:
  std::string header() const {
    std::string text =
        concat("ply\nformat binary_little_endian 1.0\ncomment elastogen frame ", frames_, '\n');
    if (motion_ && motion_->clamped > 0)
      text += concat("comment stretches of ", motion_->clamped, " splats held within 1/3 ... 3\n");
    if (mesh_) return text + mesh_->header() + "end_header\n";
    text += concat("element vertex ", order_.rest.size(), '\n');
    text += properties({"x", "y", "z"}, is_double_ ? "double" : "float");
    if (motion_) {
      text += properties({"nx", "ny", "nz"});
      text += numbered("f_dc_", 3) + numbered("f_rest_", 3 * (harmonics() - 1));
      text += properties({"opacity"}) + numbered("scale_", 3) + numbered("rot_", 4);
    } else {
      if (!asset_.points->normal.empty()) text += properties({"nx", "ny", "nz"});
      if (!asset_.points->colour.empty())
        text += properties({"red", "green", "blue", "alpha"}, "uchar");
    }
    if (particles_)
      text += properties({"vx", "vy", "vz", "J", "memory"}) + properties({"material"}, "int");
    return text + own_properties(text) + "end_header\n";
  }

  const OwnColumns* own() const {
    return asset_.splats ? &asset_.splats->own : asset_.points ? &asset_.points->own : nullptr;
  }

  /// Properties for own columns; "own_" is put before names that another property has already.
  std::string own_properties(const std::string& before) const {
    std::string text;
    if (!own()) return text;
    for (const OwnColumns::Column& column : own()->columns) {
      std::string name = column.name;
      while ((before + text).find(concat(' ', name, '\n')) != text.npos) name = "own_" + name;
      text += concat("property ", kWrittenTypes[int(column.type)], ' ', name, '\n');
    }
    return text;
  }

  size_t harmonics() const { return size_t(harmonic_count(asset_.splats->degree)); }

  void append_point(const AnimationFrame& frame, size_t p, std::string& bytes) const {
    for (size_t d = 0; d < 3; ++d) {
      const double x =
          order_.rest[p][d] + frame.displacement(order_.point[p], int(d)) / surface_.scale;
      if (is_double_)
        append(bytes, x);
      else
        append(bytes, float(x));
    }
    if (motion_) append_splat(p, bytes);
    if (asset_.points) append_attributes(frame, p, bytes);
    if (particles_) append_particle(frame, int64_t(p), bytes);
    if (!own()) return;
    const size_t width = own()->row_bytes();
    bytes.append(own()->rows, p * width, width);
  }

  void append_attributes(const AnimationFrame& frame, size_t p, std::string& bytes) const {
    if (!asset_.points->normal.empty())
      append(bytes, turned_normal(frame.gradient.row(int64_t(p)), asset_.points->normal[p]));
    if (!asset_.points->colour.empty())
      for (size_t c = 0; c < 4; ++c) {
        const float share = std::clamp(asset_.points->colour[p][c], 0.0f, 1.0f);
        append(bytes, uint8_t(std::lround(255 * (c < 3 ? srgb_from_linear(share) : share))));
      }
  }

  void append_particle(const AnimationFrame& frame, int64_t p, std::string& bytes) const {
    for (int d = 0; d < 3; ++d) append(bytes, float(frame.state->v(p, d) / surface_.scale));
    append(bytes, float(determinant(load_matrix(frame.particles->F.row(p)))));
    append(bytes, float(frame.particles->memory(p)));
    append(bytes, particles_->material(p));
  }

  void append_splat(size_t p, std::string& bytes) const {
    const size_t count = harmonics();
    append(bytes, std::array<float, 3>{});
    const float* colour = motion_->harmonics.data() + p * count * 3;
    for (size_t c = 0; c < 3; ++c) append(bytes, colour[c]);
    for (size_t c = 0; c < 3; ++c)
      for (size_t m = 1; m < count; ++m) append(bytes, colour[3 * m + c]);
    append(bytes, logit_opacity(asset_.splats->opacity[p]));
    for (const float s : motion_->scale[p]) append(bytes, log_scale(s));
    append(bytes, motion_->rotation[p]);
  }

  std::string path_;
  const Asset& asset_;
  const Surface& surface_;
  FileOrder order_;
  std::optional<SplatMotion> motion_;
  std::optional<PlyMesh> mesh_;
  std::optional<ParticleSet> particles_;
  bool is_double_ = is_float32_coarse(order_.rest);
  int64_t frames_ = 0;
};

}  // namespace

std::unique_ptr<AnimationWriter> make_ply_writer(const std::string& path, const Asset& asset,
                                                 const Surface& surface,
                                                 const std::optional<ParticleSet>& particles) {
  return std::make_unique<PlyWriter>(path, asset, surface, particles);
}

}  // namespace elastogen
