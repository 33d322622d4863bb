// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_surface_writer.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/byte_reader.hpp"
#include "io/frame_files.hpp"
#include "io/safe_file.hpp"
#include "voxelize/particle_surface.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <iterator>

namespace elastogen {
namespace {

using Srgb = std::array<float, 3>;

/// A surface in the asset's numbers.
struct ColouredSurface {
  ParticleSurface surface;
  std::vector<Srgb> colour;  ///< of each vertex, 0 ... 1; empty if there are none
};

std::string obj_text(const ColouredSurface& of) {
  std::string text = "# elastogen: surface of particles\n";
  const auto out = std::back_inserter(text);
  for (size_t k = 0; k < of.surface.position.size(); ++k) {
    const Vec3& x = of.surface.position[k];
    fmt::format_to(out, "v {:.9g} {:.9g} {:.9g}", x[0], x[1], x[2]);
    if (!of.colour.empty())
      fmt::format_to(out, " {:.4f} {:.4f} {:.4f}", of.colour[k][0], of.colour[k][1],
                     of.colour[k][2]);
    text += '\n';
  }
  for (const auto& t : of.surface.triangle)
    fmt::format_to(out, "f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

/// @param type  type of the positions, float or double.
template <class T>
std::string ply_bytes(const ColouredSurface& of, const char* type) {
  std::string bytes = concat(
      "ply\nformat binary_little_endian 1.0\ncomment elastogen surface of particles\n"
      "element vertex ",
      of.surface.position.size(), '\n');
  for (const char* axis : {"x", "y", "z"}) bytes += concat("property ", type, ' ', axis, '\n');
  if (!of.colour.empty())
    bytes += "property uchar red\nproperty uchar green\nproperty uchar blue\n";
  bytes += concat("element face ", of.surface.triangle.size(),
                  "\nproperty list uchar int vertex_indices\nend_header\n");
  for (size_t k = 0; k < of.surface.position.size(); ++k) {
    for (const double x : of.surface.position[k]) append(bytes, T(x));
    if (of.colour.empty()) continue;
    for (const float share : of.colour[k]) append(bytes, uint8_t(std::lround(255 * share)));
  }
  for (const auto& t : of.surface.triangle) {
    append(bytes, uint8_t(3));
    append(bytes, t);
  }
  return bytes;
}

class ParticleSurfaceWriter : public AnimationWriter {
 public:
  ParticleSurfaceWriter(const std::string& path, const Asset& shown, const Setup& setup)
      : path_(path),
        ending_(ending_of(path)),
        shown_(shown),
        setup_(setup),
        is_double_(is_float32_coarse(shown.points->position)) {
    SafeFile probe(frame_file(path, 0));  // throws now if it cannot be written
  }

  bool needs_motion() const override { return ending_ == "vdb"; }

  void frame(const AnimationFrame& frame) override {
    const Array<double>& rest = setup_.particles->nodes.rest;
    check_frame(frame, frames_, rest.rows(), false);
    const std::string path = frame_file(path_, frames_);
    ELASTOGEN_CHECK(std::filesystem::path(path).lexically_normal() !=
                        std::filesystem::path(shown_.path).lexically_normal(),
                    path, ": a frame would take the place of the input; name the output otherwise");
    Array<double> x = rest;
    for (int64_t k = 0; k < x.size(); ++k) x.data()[k] += frame.displacement.data[k];
    const ParticleCloud cloud = {x, setup_.particles->particles.volume, setup_.particles->spacing};
    if (ending_ == "vdb") {
      ELASTOGEN_CHECK(frame.state, path_, ": a frame must come with the state of the particles");
      write_particle_vdb(path, cloud, frame.state->v, setup_.scene.place);
    } else {
      write_mesh(path, cloud);
    }
    ++frames_;
  }

  void finish() override { ELASTOGEN_CHECK(frames_ > 0, path_, ": there is no frame to write"); }

 private:
  void write_mesh(const std::string& path, const ParticleCloud& cloud) const {
    ColouredSurface of{particle_surface(cloud), {}};
    const auto& colour = shown_.points->colour;
    if (!colour.empty())
      for (const int32_t k : nearest_particles(cloud.x, cloud.spacing, of.surface.position)) {
        Srgb& srgb = of.colour.emplace_back();
        for (size_t c = 0; c < 3; ++c)
          srgb[c] = srgb_from_linear(std::clamp(colour[size_t(k)][c], 0.0f, 1.0f));
      }
    for (Vec3& p : of.surface.position)
      p = scaled(plus(p, setup_.scene.place), 1 / setup_.body.surface.scale);
    if (ending_ == "obj")
      write_file(path, obj_text(of));
    else
      write_file(path,
                 is_double_ ? ply_bytes<double>(of, "double") : ply_bytes<float>(of, "float"));
  }

  std::string path_, ending_;
  const Asset& shown_;
  const Setup& setup_;
  bool is_double_;
  int64_t frames_ = 0;
};

}  // namespace

bool shows_surface(const std::string& path) {
  const std::string ending = ending_of(path);
  const std::string before = ending_of(std::filesystem::path(path).stem().string());
  return ending == "obj" || ending == "vdb" || (ending == "ply" && before == "mesh");
}

std::unique_ptr<AnimationWriter> make_particle_surface_writer(const std::string& path,
                                                              const Asset& shown,
                                                              const Setup& setup) {
  if (!shows_surface(path)) return nullptr;
  return std::make_unique<ParticleSurfaceWriter>(path, shown, setup);
}

}  // namespace elastogen
