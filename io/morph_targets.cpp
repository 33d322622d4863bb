// SPDX-License-Identifier: Apache-2.0
#include "io/morph_targets.hpp"

#include "io/normal_deltas.hpp"
#include "io/weld.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {

namespace {

using Matrix3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

/// Vertices whose normals decide which frames become keys.
constexpr int64_t kNormalSample = 4096;

const Mesh& mesh_of(const Asset& asset, const Surface& surface, size_t instance) {
  return asset.meshes[size_t(surface.instances[instance].mesh)];
}

MotionPart part_of(const Asset& asset, const Surface& surface, size_t index) {
  const SurfaceInstance& instance = surface.instances[index];
  MotionPart part;
  part.first = instance.first_vertex;
  part.vertices = int64_t(mesh_of(asset, surface, index).position.size());
  const Matrix4 world = world_matrix(asset, instance.node);
  Matrix3d A;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) A(r, c) = surface.scale * world[size_t(4 * c + r)];
  }
  const Matrix3d inverse = A.completeOrthogonalDecomposition().pseudoInverse();
  Eigen::Map<Matrix3d>(part.to_metres.data()) = A;
  Eigen::Map<Matrix3d>(part.to_mesh.data()) = inverse;
  return part;
}

/// Displacements of a frame in the mesh's numbers, (positions, 3).
Array<double> displacement_of(const Motion& motion, const MotionPart& part, int64_t frame) {
  std::vector<float> d(size_t(3 * part.vertices));
  motion.read(frame, part.first, part.vertices, d.data());
  Array<double> result(part.vertices, 3);
  for (int64_t v = 0; v < part.vertices; ++v) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        result(v, r) += part.to_mesh[size_t(3 * r + c)] * double(d[size_t(3 * v + c)]);
    }
  }
  return result;
}

/// Rows of normal deltas of some frames, (frames, 3 drawn vertices).
Array<float> normal_rows(const Mesh& mesh, const Motion& motion, const MotionPart& part,
                         const std::vector<int64_t>& frames) {
  const auto drawn = int64_t(mesh.normal.size());
  Array<float> rows(int64_t(frames.size()), int(3 * drawn)), delta(drawn, 3);
  for (size_t k = 0; k < frames.size(); ++k) {
    normal_deltas(mesh, displacement_of(motion, part, frames[k]), delta);
    std::copy_n(delta.data(), delta.size(), rows.row(int64_t(k)));
  }
  return rows;
}

/// Copies values of positions to drawn vertices.
Array<float> drawn(const Mesh& mesh, Array<float> shapes) {
  if (mesh.position_of.size() == mesh.position.size()) return shapes;
  const size_t count = mesh.position_of.size();
  Array<float> result(shapes.rows(), int(3 * count));
  for (int64_t k = 0; k < shapes.rows(); ++k) {
    for (size_t v = 0; v < count; ++v)
      std::copy_n(shapes.row(k) + 3 * mesh.position_of[v], 3, result.row(k) + 3 * v);
  }
  return result;
}

/// A drawn vertex with a normal.
struct Sampled {
  size_t part, vertex;
};

/// At most kNormalSample vertices of a group, evenly spaced.
std::vector<Sampled> sampled_vertices(const Asset& asset, const Surface& surface,
                                      const MorphGroup& group) {
  std::vector<Sampled> all;
  for (size_t p = 0; p < group.instances.size(); ++p) {
    const Mesh& mesh = mesh_of(asset, surface, group.instances[p]);
    for (size_t v = 0; v < mesh.normal.size(); ++v) {
      const auto& n = mesh.normal[v];
      if (n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > 0) all.push_back({p, v});
    }
  }
  const size_t stride = (all.size() + kNormalSample - 1) / kNormalSample;
  std::vector<Sampled> chosen;
  for (size_t k = 0; k < all.size(); k += stride) chosen.push_back(all[k]);
  return chosen;
}

/// Normals of the sampled vertices in every frame, of length one, (frames, 3 vertices).
Array<float> sampled_normals(const Asset& asset, const Surface& surface, const MorphGroup& group,
                             int64_t frames) {
  const std::vector<Sampled> sample = sampled_vertices(asset, surface, group);
  Array<float> normals(frames, int(3 * sample.size()));
  if (sample.empty()) return normals;
  // samples begin ... end - 1 belong to part p
  size_t begin = 0, end = 0;  // range of the samples of a part
  for (size_t p = 0; p < group.instances.size(); ++p) {
    const Mesh& mesh = mesh_of(asset, surface, group.instances[p]);
    Array<float> delta(int64_t(mesh.normal.size()), 3);
    for (begin = end; end < sample.size() && sample[end].part == p;) ++end;
    if (begin == end) continue;
    // normals at rest plus their change in each frame
    for (int64_t t = 0; t < frames; ++t) {
      normal_deltas(mesh, displacement_of(group.motion, group.motion.parts[p], t), delta);
      for (size_t s = begin; s < end; ++s) {
        const size_t v = sample[s].vertex;
        const float* d = delta.row(int64_t(v));
        const float n[3] = {mesh.normal[v][0] + d[0], mesh.normal[v][1] + d[1],
                            mesh.normal[v][2] + d[2]};
        const float length = std::hypot(n[0], n[1], n[2]);
        for (size_t k = 0; k < 3; ++k) normals(t, int(3 * s + k)) = n[k] / length;
      }
    }
  }
  return normals;
}

/// `before` times -1, then 0, 1, ..., count - 1, then `after` times -1.
std::vector<int> row_numbers(int before, int count, int after) {
  std::vector<int> rows(size_t(before + count + after), -1);
  std::iota(rows.begin() + before, rows.begin() + before + count, 0);
  return rows;
}

}  // namespace

std::vector<std::vector<size_t>> touching_instances(const Surface& surface) {
  const size_t count = surface.instances.size();
  std::vector<size_t> group(count);
  std::iota(group.begin(), group.end(), size_t{0});
  // union-find over instances
  const auto root = [&](size_t i) {
    while (group[i] != i) i = group[i] = group[group[i]];
    return i;
  };
  // instances of which a vertex was welded to one of another touch
  if (count > 1) {
    const WeldedMesh welded = weld(surface);
    std::vector<int64_t> first(size_t(welded.vertices.rows()), -1);
    for (size_t i = 0; i < count; ++i) {
      const SurfaceInstance& instance = surface.instances[i];
      for (int64_t v = instance.first_vertex; v < surface.vertices.rows(); ++v) {
        if (i + 1 < count && v == surface.instances[i + 1].first_vertex) break;
        const int32_t w = welded.welded_of[size_t(v)];
        if (w < 0) continue;
        int64_t& seen = first[size_t(w)];
        if (seen < 0) seen = int64_t(i);
        group[root(i)] = root(size_t(seen));
      }
    }
  }
  // groups in the order of their first instance
  std::vector<std::vector<size_t>> result;
  std::vector<int64_t> place(count, -1);
  for (size_t i = 0; i < count; ++i) {
    if (surface.instances[i].triangles == 0) continue;
    int64_t& at = place[root(i)];
    if (at < 0) {
      at = int64_t(result.size());
      result.emplace_back();
    }
    result[size_t(at)].push_back(i);
  }
  return result;
}

MorphGroup morph_group(const Asset& asset, const Surface& surface, std::vector<size_t> instances,
                       const FrameStore& frames, const PieceOptions& options) {
  MorphGroup group;
  group.instances = std::move(instances);
  for (const size_t i : group.instances) group.motion.parts.push_back(part_of(asset, surface, i));
  group.motion.read = [&frames](int64_t t, int64_t first, int64_t count, float* d) {
    frames.read(t, 3 * first, 3 * count, d);
  };
  const Array<float> normals = sampled_normals(asset, surface, group, frames.frames());
  group.pieces = clip_pieces(group.motion, frames.frames(), normals, options);
  return group;
}

MorphTargets morph_targets(const Asset& asset, const Surface& surface, const MorphGroup& group,
                           size_t part, const ClipPiece& piece) {
  const Mesh& mesh = mesh_of(asset, surface, group.instances[part]);
  const MotionPart& where = group.motion.parts[part];
  MorphTargets targets;
  const int modes = piece.basis.targets(), keys = int(piece.normal_keys.size());
  targets.position = drawn(mesh, target_shapes(group.motion, where, piece.basis));
  targets.position_row = row_numbers(0, modes, keys);
  if (mesh.normal.empty()) return targets;
  const bool frames = piece.is_keyframe();
  targets.normal =
      normal_rows(mesh, group.motion, where, frames ? piece.basis.snapshots : piece.normal_keys);
  targets.normal_row = frames ? row_numbers(0, modes, 0) : row_numbers(modes, keys, 0);
  return targets;
}

}  // namespace elastogen
