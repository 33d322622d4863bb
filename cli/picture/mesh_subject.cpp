// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/smooth_corners.hpp"
#include "cli/picture/subject.hpp"
#include "core/error.hpp"
#include "io/texture.hpp"
#include "io/triangle_corners.hpp"

#include <numeric>

namespace elastogen {
namespace {

constexpr float kSolid = 0.95f;  // alpha from which on a blended surface is opaque
constexpr float kGrey = 0.6f;    // colour of triangles without material and colours

/// Colour that all triangles of a material share.
struct Paint {
  Texel factor = {kGrey, kGrey, kGrey, 1};
  BaseColour colour;
  const Texture* texture = nullptr;
};

/// Normals of the file. In OBJ a normal that all corners of a triangle share is ignored: many
/// programs write such normals for scans.
std::vector<std::array<float, 3>> corner_normals(const Asset& asset,
                                                 const std::vector<TriangleCorners>& sources) {
  std::vector<std::array<float, 3>> normals;
  for (const TriangleCorners& source : sources) {
    std::array<std::array<float, 3>, 3> of = {};
    for (size_t c = 0; c < 3 && !source.mesh->normal.empty(); ++c)
      of[c] = source.mesh->normal[size_t(source.drawn[c])];
    if (asset.format == "obj" && of[0] == of[1] && of[1] == of[2]) of = {};
    normals.insert(normals.end(), of.begin(), of.end());
  }
  return normals;
}

/// A triangle on the canvas, with the corner values that its samples mix.
struct Patch {
  /// Product of factor, colours of vertices and texture.
  Texel colour(const std::array<float, 3>& w) const {
    Texel colour = paint.factor;
    const auto& of_vertex = source.mesh->colour;
    for (size_t k = 0; k < 4 && !of_vertex.empty(); ++k) {
      float mean = 0;
      for (size_t c = 0; c < 3; ++c) mean += w[c] * of_vertex[size_t(source.drawn[c])][k];
      colour[k] *= mean;
    }
    if (!texture) return colour;
    const Texel texel =
        texture->at(level, w[0] * uv[0][0] + w[1] * uv[1][0] + w[2] * uv[2][0],
                    w[0] * uv[0][1] + w[1] * uv[1][1] + w[2] * uv[2][1], paint.colour.wrap);
    for (size_t k = 0; k < 4; ++k) colour[k] *= texel[k];
    return colour;
  }

  const Paint& paint;
  const TriangleCorners& source;
  float light[3];
  std::array<std::array<float, 2>, 3> uv;
  const Texture* texture;
  int level;
};

class MeshSubject : public Subject {
 public:
  MeshSubject(const Asset& asset, const Surface& surface, int max_edge,
              std::vector<std::string>& notes)
      : surface_(surface),
        sources_(triangle_corners(asset, surface)),
        corners_(smooth_corners(surface, corner_normals(asset, sources_))),
        projected_(surface.vertices.rows(), 3),
        lit_{std::vector<float>(size_t(corners_.normals)),
             std::vector<float>(size_t(corners_.normals))},
        rows_(size_t(surface.triangles.rows())) {
    add_paints(asset, max_edge, notes);
    for (int64_t t = 0; t < surface.triangles.rows(); ++t)
      if (paint_of(t).colour.alpha == AlphaMode::kBlend) blended_.push_back(int32_t(t));
  }

  void pose(In<double> positions, In<double>) override { positions_ = positions; }
  void see(const Camera& camera) override;
  void draw(Canvas& canvas) const override;

 private:
  void add_paints(const Asset& asset, int max_edge, std::vector<std::string>& notes);
  void light(const Camera& camera);
  const Paint& paint_of(int64_t t) const { return paints_[size_t(surface_.material(t) + 1)]; }
  Vec3 corner(int64_t t, int c) const {
    const double* x = projected_.row(surface_.triangles(t, c));
    return {x[0], x[1], x[2]};
  }
  /// @param twice_area  signed area times two on the canvas [samples^2].
  Patch patch_of(int64_t t, double twice_area) const;
  template <bool solid>
  void draw_triangle(int64_t t, Canvas& canvas) const;

  const Surface& surface_;
  std::vector<TriangleCorners> sources_;
  SmoothCorners corners_;
  std::vector<Texture> textures_;
  std::vector<Paint> paints_;     ///< for no material, then for each
  std::vector<int32_t> blended_;  ///< blended triangles, from back to front
  In<double> positions_ = {};
  Array<double> projected_;
  std::vector<float> lit_[2];  ///< light of each normal, seen from outside and inside
  std::vector<std::array<int32_t, 2>> rows_;  ///< rows of samples that each triangle may cover
};

void MeshSubject::add_paints(const Asset& asset, int max_edge, std::vector<std::string>& notes) {
  // textures; one that cannot be decoded leaves the base colour
  BaseColours colours = base_colours(asset);
  notes.insert(notes.end(), colours.notes.begin(), colours.notes.end());
  std::vector<int> texture_of;
  for (const EncodedImage& image : colours.images) {
    texture_of.push_back(int(textures_.size()));
    try {
      textures_.emplace_back(decode_image(image.bytes, max_edge));
    } catch (const Error& error) {
      texture_of.back() = -1;
      notes.push_back(
          concat(asset.path, ": ", image.name, ": ", error.what(), "; its base colour is shown"));
    }
  }
  // paint of triangles without material: white under colours of vertices
  const auto coloured = [](const Mesh& mesh) { return !mesh.colour.empty(); };
  paints_.emplace_back();
  if (std::any_of(asset.meshes.begin(), asset.meshes.end(), coloured))
    paints_[0].factor = {1, 1, 1, 1};
  // paint of each material
  for (size_t m = 0; m < asset.materials.size(); ++m) {
    const BaseColour& colour = colours.materials[m];
    const int texture = colour.image >= 0 ? texture_of[size_t(colour.image)] : -1;
    paints_.push_back({asset.materials[m].base_colour, colour,
                       texture >= 0 ? &textures_[size_t(texture)] : nullptr});
  }
}

void MeshSubject::see(const Camera& camera) {
  for_each(positions_.rows, [&](int64_t n) {
    const double* x = positions_.row(n);
    const Vec3 p = camera.project({x[0], x[1], x[2]});
    std::copy(p.begin(), p.end(), projected_.row(n));
  });
  for_each(surface_.triangles.rows(), [&](int64_t t) {
    const double y[3] = {corner(t, 0)[1], corner(t, 1)[1], corner(t, 2)[1]};
    const SampleRange rows(std::min({y[0], y[1], y[2]}), std::max({y[0], y[1], y[2]}), -1, 1 << 20);
    rows_[size_t(t)] = {rows.begin, rows.end};
  });
  light(camera);
  const auto depth = [&](int32_t t) { return corner(t, 0)[2] + corner(t, 1)[2] + corner(t, 2)[2]; };
  std::sort(blended_.begin(), blended_.end(), [&](int32_t a, int32_t b) {
    const double x = depth(a), y = depth(b);
    return x != y ? x < y : a < b;
  });
}

/// Computes the normals of the moved triangles and their light.
void MeshSubject::light(const Camera& camera) {
  std::vector<Vec3> normal(size_t(corners_.normals), Vec3{});
  for (int64_t t = 0; t < surface_.triangles.rows(); ++t) {
    Vec3 x[3];
    for (int c = 0; c < 3; ++c)
      std::copy_n(positions_.row(surface_.triangles(t, c)), 3, x[c].begin());
    const Vec3 area = cross(minus(x[1], x[0]), minus(x[2], x[0]));
    for (int c = 0; c < 3; ++c) {
      Vec3& sum = normal[size_t(corners_.normal_of(t, c))];
      sum = plus(sum, area);
    }
  }
  for_each(corners_.normals, [&](int64_t k) {
    const Vec3& sum = normal[size_t(k)];
    const Vec3 n = scaled(sum, 1 / std::max(norm(sum), 1e-290));
    const Vec3 seen = {dot(camera.right, n), dot(camera.up, n), dot(camera.back, n)};
    lit_[0][size_t(k)] = light_on(seen);
    lit_[1][size_t(k)] = light_on(scaled(seen, -1));
  });
}

Patch MeshSubject::patch_of(int64_t t, double twice_area) const {
  const Paint& paint = paint_of(t);
  Patch patch{paint, sources_[size_t(t)], {}, {}, paint.texture, 0};
  // rows run down, so seen from outside the corners run clockwise on the canvas
  const std::vector<float>& lit = lit_[twice_area < 0 ? 0 : 1];
  for (int c = 0; c < 3; ++c) patch.light[c] = lit[size_t(corners_.normal_of(t, c))];
  const Mesh& mesh = *patch.source.mesh;
  if (mesh.uv.empty()) patch.texture = nullptr;
  if (!patch.texture) return patch;
  const auto& m = paint.colour.transform;
  for (size_t c = 0; c < 3; ++c) {
    const auto& [u, v] = mesh.uv[size_t(patch.source.drawn[c])];
    patch.uv[c] = {m[0] * u + m[1] * v + m[2], m[3] * u + m[4] * v + m[5]};
  }
  const auto& uv = patch.uv;
  const double covered =
      (uv[1][0] - uv[0][0]) * (uv[2][1] - uv[0][1]) - (uv[1][1] - uv[0][1]) * (uv[2][0] - uv[0][0]);
  patch.level = patch.texture->level(std::abs(covered / twice_area) * patch.texture->texels());
  return patch;
}

/// @tparam solid  draws opaque samples; else those that are blended with the samples behind them.
template <bool solid>
void MeshSubject::draw_triangle(int64_t t, Canvas& canvas) const {
  const Vec3 p = corner(t, 0), q = corner(t, 1), r = corner(t, 2);
  const Patch patch = patch_of(t, (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]));
  const BaseColour& kind = patch.paint.colour;
  fill_triangle(canvas, p, q, r, [&](size_t sample, const Vec3& weights, double z) {
    if (float(z) <= canvas.depth[sample]) return;
    const std::array<float, 3> w = {float(weights[0]), float(weights[1]), float(weights[2])};
    const Texel colour = patch.colour(w);
    if (kind.alpha == AlphaMode::kMask && colour[3] < kind.cutoff) return;
    const float alpha = kind.alpha == AlphaMode::kBlend ? std::clamp(colour[3], 0.0f, 1.0f) : 1;
    if (solid != (alpha >= kSolid)) return;
    const float shade = w[0] * patch.light[0] + w[1] * patch.light[1] + w[2] * patch.light[2];
    Light& to = canvas.light[sample];
    for (size_t k = 0; k < 3; ++k)
      to[k] = solid ? shade * colour[k] : alpha * shade * colour[k] + (1 - alpha) * to[k];
    if (solid) canvas.depth[sample] = float(z);
  });
}

void MeshSubject::draw(Canvas& canvas) const {
  const auto is_here = [&](int64_t t) {
    const auto& [begin, end] = rows_[size_t(t)];
    return begin < canvas.first + canvas.rows && end > canvas.first;
  };
  for (int64_t t = 0; t < surface_.triangles.rows(); ++t)
    if (is_here(t)) draw_triangle<true>(t, canvas);
  for (const int32_t t : blended_)
    if (is_here(t)) draw_triangle<false>(t, canvas);
}

}  // namespace

float light_on(const Vec3& normal) {
  constexpr double kAmbient = 0.15, kKey = 0.79, kFill = 0.08;
  static const Vec3 key = scaled({-0.5, 0.8, 0.9}, 1 / norm({-0.5, 0.8, 0.9}));
  static const Vec3 fill = scaled({0.9, 0.1, 0.5}, 1 / norm({0.9, 0.1, 0.5}));
  return float(std::min(1.0, kAmbient + kKey * std::max(0.0, dot(normal, key)) +
                                 kFill * std::max(0.0, dot(normal, fill))));
}

std::unique_ptr<Subject> make_mesh_subject(const Asset& asset, const Surface& surface, int max_edge,
                                           std::vector<std::string>& notes) {
  return std::make_unique<MeshSubject>(asset, surface, max_edge, notes);
}

}  // namespace elastogen
