// SPDX-License-Identifier: Apache-2.0
// Clips of small assets as GLB files, and the motion that these show.

#pragma once

#include "io/animation_writer.hpp"
#include "io/gltf_reader.hpp"
#include "tests/io/glb_files.hpp"

#include <cmath>

namespace elastogen::test {

inline constexpr int kFrames = 9;

/// A smooth motion that is zero at frame 0: waves whose amplitude grows with the frame [m].
inline Array<double> wave(const Surface& surface, int frame) {
  Array<double> d(surface.vertices.rows(), 3);
  const double size = surface.box.extent(0) + surface.box.extent(1) + surface.box.extent(2);
  for (int64_t v = 0; v < d.rows(); ++v) {
    for (int c = 0; c < 3; ++c) {
      const double x = surface.vertices(v, (c + 1) % 3) / size;
      d(v, c) = 0.02 * size * frame / kFrames * std::sin(5 * x + 0.7 * frame + c);
    }
  }
  return d;
}

class GlbClip : public ::testing::Test {
 protected:
  /// Writes the waves of an asset and reads the file back.
  GlbFile animate(const Asset& asset, const Surface& surface, const AnimationOptions& options) {
    const auto writer = AnimationWriter::create(out, asset, surface, options);
    for (int t = 0; t < kFrames; ++t)
      writer->frame(
          {.displacement = wave(surface, t), .certificate = {t != 3, 1e-4 * t, 1 - 0.01 * t}});
    writer->finish();
    return GlbFile(out);
  }
  Asset read(const Builder& builder) { return read_gltf(folder.write("a.glb", builder.file())); }

  /// Largest distance between the waves and the motion in the file, in the world [m].
  double shown_error(const GlbFile& file, const Asset& asset, const Surface& surface);

  test::TempFolder folder;
  std::string out = folder.path("out.glb");
};

/// The node that shows the mesh of an asset's node: itself or the child that took it over.
inline size_t shown_by(const GlbFile& file, int node) {
  const Json& n = file.document["nodes"][size_t(node)];
  return n.contains("mesh") ? size_t(node) : n["children"].back().get<size_t>();
}

inline double GlbClip::shown_error(const GlbFile& file, const Asset& asset,
                                   const Surface& surface) {
  double worst = 0;
  for (const SurfaceInstance& instance : surface.instances) {
    const Matrix4 world = world_matrix(asset, instance.node);
    const size_t node = shown_by(file, instance.node);
    const Rows weights = file.weights(node);
    EXPECT_EQ(weights.size(), size_t(kFrames));
    // the motion of each frame, against the targets with their weights
    for (int t = 0; t < kFrames; ++t) {
      const Array<double> expected = wave(surface, t);
      std::map<size_t, int64_t> first;  // of each POSITION accessor
      int64_t next = instance.first_vertex;
      // primitives may share the vertices of one accessor
      for (const Json& primitive : file.mesh_of(node)["primitives"]) {
        const size_t accessor = primitive["attributes"]["POSITION"];
        const Rows d = file.moved(primitive, "POSITION", weights[size_t(t)]);
        const bool is_new = first.try_emplace(accessor, next).second;
        if (is_new) next += int64_t(d.size());
        for (size_t v = 0; v < d.size(); ++v) {
          double square = 0;
          for (size_t r = 0; r < 3; ++r) {
            double e = -expected(first[accessor] + int64_t(v), int(r));
            for (size_t c = 0; c < 3; ++c) e += surface.scale * world[4 * c + r] * d[v][c];
            square += e * e;
          }
          worst = std::max(worst, std::sqrt(square));
        }
      }
    }
  }
  return worst;
}

/// A mirrored, a sheared and a plain instance of one mesh of two primitives, below a scaled node.
inline Builder instances() {
  Builder builder = triangle();
  const int other = builder.add_vectors({5, 0, 0, 6, 0, 1, 5, 1, 0, 9, 9, 9});
  builder.add_primitive({{"attributes", {{"POSITION", other}}}, {"indices", 3}});
  builder.document["nodes"] = {{{"name", "top"}, {"scale", {2, 2, 2}}, {"children", {1, 2, 3}}},
                               {{"name", "plain"}, {"mesh", 0}, {"translation", {0, 4, 0}}},
                               {{"name", "mirrored"}, {"mesh", 0}, {"scale", {-1, 1, 3}}},
                               {{"name", "sheared"},
                                {"mesh", 0},
                                {"matrix", {1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0.25, 1, 0, 0, 0, 9, 1}}}};
  return builder;
}

}  // namespace elastogen::test
