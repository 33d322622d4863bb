// SPDX-License-Identifier: Apache-2.0
#include "io/morph_targets.hpp"

#include "io/normal_deltas.hpp"

#include <Eigen/Dense>

namespace elastogen {

namespace {

using Matrix3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Motion motion_of(const Asset& asset, const Surface& surface, const SurfaceInstance& instance,
                 const FrameStore& frames) {
  Motion motion;
  motion.frames = frames.frames();
  motion.vertices = int64_t(asset.meshes[size_t(instance.mesh)].position.size());
  motion.read = [&frames, start = instance.first_vertex](int64_t t, int64_t first, int64_t count,
                                                         float* d) {
    frames.read(t, 3 * (start + first), 3 * count, d);
  };
  const Matrix4 world = world_matrix(asset, instance.node);
  Matrix3d A;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) A(r, c) = surface.scale * world[size_t(4 * c + r)];
  }
  const Matrix3d inverse = A.completeOrthogonalDecomposition().pseudoInverse();
  Eigen::Map<Matrix3d>(motion.to_metres.data()) = A;
  Eigen::Map<Matrix3d>(motion.to_mesh.data()) = inverse;
  return motion;
}

/// Displacements of a frame in the mesh's numbers, (positions, 3).
Array<double> displacement_of(const Motion& motion, int64_t frame) {
  std::vector<float> d(size_t(3 * motion.vertices));
  motion.read(frame, 0, motion.vertices, d.data());
  Array<double> result(motion.vertices, 3);
  for (int64_t v = 0; v < motion.vertices; ++v) {
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c)
        result(v, r) += motion.to_mesh[size_t(3 * r + c)] * double(d[size_t(3 * v + c)]);
    }
  }
  return result;
}

/// The normals' deltas, combined as the modes are combined from their snapshots.
Array<float> normal_targets(const Mesh& mesh, const Motion& motion, const ModalBasis& basis) {
  const auto drawn = int64_t(mesh.normal.size());
  Array<float> result(basis.modes(), int(3 * drawn)), delta(drawn, 3);
  for (size_t s = 0; s < basis.snapshots.size() && basis.modes() > 0; ++s) {
    normal_deltas(mesh, displacement_of(motion, basis.snapshots[s]), delta);
    for (int k = 0; k < basis.modes(); ++k) {
      const double share = basis.shares.empty() ? double(int(s) == k) : basis.shares(int64_t(s), k);
      if (share == 0) continue;
      float* row = result.row(k);
      for (int64_t i = 0; i < delta.size(); ++i) row[i] += float(share * double(delta.data()[i]));
    }
  }
  return result;
}

/// From positions to drawn vertices.
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

}  // namespace

MorphTargets morph_targets(const Asset& asset, const Surface& surface,
                           const SurfaceInstance& instance, const FrameStore& frames,
                           double tolerance) {
  const Mesh& mesh = asset.meshes[size_t(instance.mesh)];
  const Motion motion = motion_of(asset, surface, instance, frames);
  ModalBasis basis = tolerance > 0 ? modal_basis(motion, tolerance) : keyframe_basis(motion);
  MorphTargets targets;
  targets.position = drawn(mesh, mode_shapes(motion, basis));
  if (!mesh.normal.empty()) targets.normal = normal_targets(mesh, motion, basis);
  targets.max_error = basis.max_error;
  targets.weights = std::move(basis.weights);
  return targets;
}

}  // namespace elastogen
