// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_colours.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "io/texture.hpp"
#include "io/triangle_corners.hpp"
#include "scene/paint.hpp"
#include "voxelize/labels.hpp"
#include "voxelize/particle_surface.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

using Colours = std::vector<std::array<float, 4>>;

constexpr int kLongestTexture = 2048;  // longest edge of a decoded texture [texels]
constexpr float kSeen = 0.1f;          // least opacity of a splat whose colour is used

/// Materials, textures and colours of vertices of a mesh.
class Paints {
 public:
  Paints(const Asset& asset, const Surface& surface, std::vector<std::string>& notes)
      : asset_(asset), surface_(surface), corners_(triangle_corners(asset, surface)) {
    BaseColours colours = base_colours(asset);
    materials_ = std::move(colours.materials);
    notes.insert(notes.end(), colours.notes.begin(), colours.notes.end());
    for (const EncodedImage& image : colours.images) {
      textures_.emplace_back();
      try {
        textures_.back().emplace(decode_image(image.bytes, kLongestTexture));
      } catch (const Error& error) {
        notes.push_back(
            concat(asset.path, ": ", image.name, ": ", error.what(), "; its base colour is shown"));
      }
    }
  }

  bool empty() const {
    return asset_.materials.empty() &&
           std::ranges::all_of(asset_.meshes, [](const Mesh& mesh) { return mesh.colour.empty(); });
  }

  /// @param width  size of the sample that gets the colour [m].
  Texel at(int64_t t, const Vec3& point, double width) const {
    const std::array<Vec3, 3> corner = {place(t, 0), place(t, 1), place(t, 2)};
    const Vec3 w = nearest_weights(corner.data(), point);
    const TriangleCorners& of = corners_[size_t(t)];
    const int32_t m = surface_.material(t);
    Texel colour = {1, 1, 1, 1};
    if (m >= 0) colour = asset_.materials[size_t(m)].base_colour;
    if (!of.mesh->colour.empty())
      for (size_t k = 0; k < 4; ++k) {
        double mean = 0;
        for (size_t c = 0; c < 3; ++c) mean += w[c] * of.mesh->colour[size_t(of.drawn[c])][k];
        colour[k] *= float(mean);
      }
    if (m < 0 || of.mesh->uv.empty()) return colour;
    const BaseColour& paint = materials_[size_t(m)];
    if (paint.image < 0 || !textures_[size_t(paint.image)]) return colour;
    const double area = norm(cross(minus(corner[1], corner[0]), minus(corner[2], corner[0])));
    const Texel texel =
        sample(*textures_[size_t(paint.image)], paint, of, w, area > 0 ? width * width / area : 0);
    for (size_t k = 0; k < 4; ++k) colour[k] *= texel[k];
    return colour;
  }

 private:
  Vec3 place(int64_t t, int c) const {
    const double* x = surface_.vertices.row(surface_.triangles(t, c));
    return {x[0], x[1], x[2]};
  }

  /// @param share  the area that the sample covers, over twice the triangle's area.
  static Texel sample(const Texture& texture, const BaseColour& paint, const TriangleCorners& of,
                      const Vec3& w, double share) {
    std::array<std::array<float, 2>, 3> uv;
    float at[2] = {};
    const auto& m = paint.transform;
    for (size_t c = 0; c < 3; ++c) {
      const auto& [u, v] = of.mesh->uv[size_t(of.drawn[c])];
      uv[c] = {m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
      for (size_t k = 0; k < 2; ++k) at[k] += float(w[c]) * uv[c][k];
    }
    const double covered = (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) -
                           (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0]);
    const int level = texture.level(std::abs(covered) * share * texture.texels());
    return texture.at(level, at[0], at[1], paint.wrap);
  }

  const Asset& asset_;
  const Surface& surface_;
  std::vector<TriangleCorners> corners_;
  std::vector<BaseColour> materials_;
  std::vector<std::optional<Texture>> textures_;  ///< none if its image cannot be decoded
};

Colours colours_of_mesh(const Asset& asset, const Setup& setup, const ParticleSetup& particles,
                        std::vector<std::string>& notes) {
  const Surface& surface = setup.body.surface;
  const Paints paints(asset, surface, notes);
  if (paints.empty()) return {};
  const Array<int32_t> triangle = nearest_triangles(setup.scene.grid, surface);
  const Array<double>& x = particles.nodes.rest;
  Colours colours(size_t(x.rows()));
  for_each(x.rows(), [&](int64_t k) {
    colours[size_t(k)] =
        paints.at(triangle(particles.voxel(k)), {x(k, 0), x(k, 1), x(k, 2)}, particles.spacing);
  });
  return colours;
}

/// Points or splats as sources of colour: places and colours.
struct Dabs {
  std::vector<int32_t> point;
  Colours colour;
};

Dabs dabs_of(const Asset& asset) {
  Dabs dabs;
  if (asset.points) {
    dabs.colour = asset.points->colour;
    for (size_t k = 0; k < dabs.colour.size(); ++k) dabs.point.push_back(int32_t(k));
    return dabs;
  }
  const SplatCloud& splats = *asset.splats;
  for (size_t k = 0; k < splats.position.size(); ++k) {
    if (splats.opacity[k] < kSeen) continue;
    dabs.point.push_back(int32_t(k));
    dabs.colour.push_back(splat_colour(splats, k));
  }
  return dabs;
}

Colours colours_of_points(const Asset& asset, const ParticleSetup& particles, In<double> carried) {
  const Dabs dabs = dabs_of(asset);
  if (dabs.point.empty()) return {};
  Array<double> places(int64_t(dabs.point.size()), 3);
  for (size_t k = 0; k < dabs.point.size(); ++k)
    std::copy_n(carried.row(dabs.point[k]), 3, places.row(int64_t(k)));
  const Array<double>& x = particles.nodes.rest;
  std::vector<Vec3> wanted;
  for (int64_t k = 0; k < x.rows(); ++k) wanted.push_back({x(k, 0), x(k, 1), x(k, 2)});
  Colours colours;
  for (const int32_t k : nearest_particles(places, particles.spacing, wanted))
    colours.push_back(dabs.colour[size_t(k)]);
  return colours;
}

}  // namespace

std::vector<std::array<float, 4>> particle_colours(const Asset& asset, const Setup& setup,
                                                   const ParticleSetup& particles,
                                                   In<double> carried,
                                                   std::vector<std::string>& notes) {
  if (asset.points || asset.splats) return colours_of_points(asset, particles, carried);
  if (asset.meshes.empty()) return {};
  return colours_of_mesh(asset, setup, particles, notes);
}

}  // namespace elastogen
