// SPDX-License-Identifier: Apache-2.0
// Constant-coefficient multigrid, the encoder of many levels: three scalar hierarchies, one for
// each displacement component d, built once for a scene,
//
//     A_d = a0 M / dt^2 + sum_v phi_v h^3 sum_e k_de (dN/dX_e)(dN/dX_e)^T + variance term,
//     k_dd = 2 mu + lambda,  k_de = mu (e != d),
//
// with the border voxels' own mean gradients on the finest level, and with averaged moduli, centre
// gradients and twice the edge on each coarser one. One V-cycle with Chebyshev smoothing is a fixed
// symmetric positive definite map: a preconditioner, never an iteration of its own.

#pragma once

#include "network/potential/brick_rows.hpp"

#include <memory>
#include <optional>
#include <vector>

namespace elastogen {

/// The data of a level that the cycle reads, for tests. It refers to the hierarchy, which must
/// outlive it and keep its nodal stiffness.
template <class T>
struct MultigridLevel {
  const BrickRows& rows;
  const Zeroed<T>& moduli;            ///< h / unit times those of LevelGrid, [row][6][lane]
  const Zeroed<T>& added;             ///< inertia and nodal stiffness over unit, (nodes, 3)
  const Zeroed<T>& inverse_diagonal;  ///< times unit, (nodes, 3); 0 on pinned nodes
  const Zeroed<uint8_t>& pinned;      ///< (nodes)
  const Array<int32_t>& node_coord;   ///< lattice coordinates of this level, (nodes, 3)
  double lambda_max, unit;            ///< bound of the smoother; divisor of the operator [N/m]
  int64_t nodes;
};

/// @tparam T  float, or double where the condition number asks for it (Courant number above 1e3).
template <class T>
class Multigrid {
 public:
  /// @param a0    mass factor of the time scheme.
  /// @param rows   rows of the scene; made if not given.
  /// @param dense  most nodes of a level that is solved; dense_nodes of the scene if not given.
  Multigrid(const Scene& scene, double a0, std::shared_ptr<const BrickRows> rows = {},
            std::optional<int64_t> dense = {});
  ~Multigrid();

  /// z = B r, one V-cycle from z = 0; r and z are (nodes, 3), r is 0 on pinned nodes.
  void apply(const T* r, T* z);

  /// product = A p on the finest level (the three scalar operators, not the elastic one).
  void operator_product(const T* p, T* product);

  int level_count() const { return int(levels_.size()); }
  /// Level l, 0 the finest.
  MultigridLevel<T> level(int l) const;

  /// Adds a diagonal stiffness [N/m], (3 nodes), to the operator, in place of the one added before;
  /// coarser levels get P^T of it, lumped like the mass. An empty vector removes it.
  void set_nodal_stiffness(const std::vector<double>& stiffness);

  /// Multiplies the inertia that the hierarchy was built with, for steps of another length; removes
  /// a nodal stiffness.
  void scale_inertia(double factor);

 private:
  struct Level;
  void smooth_from_zero(Level& level);
  void smooth(Level& level);
  void cycle(size_t l);
  std::vector<std::unique_ptr<Level>> levels_;
  std::vector<double> folded_;  // of dependent nodes (held_diagonal.hpp); empty: there is none
};

}  // namespace elastogen
