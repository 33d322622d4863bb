// SPDX-License-Identifier: Apache-2.0
// One level of the multigrid hierarchy: its voxels, moduli and masses, and the transfers between a
// level and the next coarser one (edge doubled, nodes of even index kept, trilinear).

#pragma once

#include "core/bricks/index.hpp"
#include "network/potential/brick_rows.hpp"

#include <memory>
#include <vector>

namespace elastogen {

struct LevelGrid {
  std::shared_ptr<const BrickRows> rows;
  int64_t nodes = 0;
  double h = 0;               ///< edge [m]
  double unit = 1;            ///< [N/m]; the cycle runs on the operator divided by it
  Zeroed<double> moduli;      ///< phi times mu, lambda, c_xy, c_yz, c_zx, c_xyz [Pa], (voxels, 6)
  Zeroed<double> inertia;     ///< a0 m / dt^2 [N/m], (nodes)
  Zeroed<uint8_t> pinned;     ///< (nodes)
  Array<int32_t> node_coord;  ///< lattice coordinates of this level, (nodes, 3)
  BrickIndex voxel_index, node_index;

  // to the next coarser level; filled by coarser_level
  Zeroed<int32_t> parents;  ///< coarse nodes whose mean a node interpolates, (nodes, 8), with
                            ///< repetitions; -1 for a pinned one
  // from the next finer level; filled by coarser_level
  Zeroed<int32_t> children;  ///< fine nodes at offset -1, 0, 1 per axis, (nodes, 27), -1 if none
};

/// Most nodes of a coarsest level that is solved by a dense inverse. With colliders the level
/// changes and the inverse is computed anew every step.
inline int64_t dense_nodes(const Scene& scene) {
  return scene.colliders.empty() ? 400 : 100;
}

inline constexpr int kMostLevels = 12;

/// Whether a level of that many nodes helps a finer one; isolated voxels do not become fewer.
inline bool is_worthwhile(int64_t nodes, int64_t finer) {
  return double(nodes) <= 0.7 * double(finer);
}

/// Moduli of a voxel of the scene, as in LevelGrid.
void moduli_of_voxel(const Scene& scene, int64_t v, double k[6]);

/// @param rows  rows of the scene.
LevelGrid finest_level(const Scene& scene, double a0, std::shared_ptr<const BrickRows> rows);

/// The next level; fills `parents` of the fine one.
LevelGrid coarser_level(LevelGrid& fine);

/// Frees what only the construction of the hierarchy needs: moduli and indices.
void release_setup(LevelGrid& level);

/// coarse = P^T fine, gathered, 0 on pinned coarse nodes; (nodes, 3).
template <class T>
void restrict_residual(const LevelGrid& coarse_level, const T* fine, T* coarse);

/// fine += P coarse on the free nodes.
template <class T>
void prolong_correction(const LevelGrid& fine_level, const T* coarse, T* fine);

}  // namespace elastogen
