// SPDX-License-Identifier: Apache-2.0
// The published algorithm (ElastoGen, AAAI 2026), for the study of its accuracy: RNN-1 freezes the
// lagged quadratic of every voxel R1 times a step, RNN-2 relaxes
//
//     A x = b,   A = a0 M/dt^2 + sum_v omega W_v G^T (N N^T (x) I) G + variance term,
//
// by an encoder of cosine modes and R2 Jacobi sweeps. A is one operator for x, y and z. With the
// variance term the sweeps take the majorised diagonal
//
//     D_c = a0 m_c/dt^2 + sum_v phi omega h [3/16 nmax^2 + 7/48 max(kappa, nmax^2)],
//     kappa = c_h/omega,
//
// (border voxels: absolute row sums), which converges for every N; without it (the printed
// operator) the true diagonal, which diverges above an elastic Courant number of 1.

#pragma once

#include "network/potential/incremental_potential.hpp"
#include "network/solver.hpp"
#include "network/step/iteration.hpp"

namespace elastogen {

/// @throws Error (usage) for loops below 1, modes that are no multiple of 3 or beyond 192, the
///         torsion correction (it couples the components) and colliders.
void check_paper_scene(const PotentialTerms& terms, const PaperLoops& loops);

/// The encoder's cosines over the box of the whole grid, times d/(d + L/8), d the distance to the
/// nearest pin and L the longest side; (waves, nodes).
std::vector<double> paper_modes(const Scene& scene, int waves);

/// y of A_r y = right (A_r (waves, waves), right (waves, 3), both row-major), into right.
void solve_reduced(int waves, const double* A_r, double* right);

class PaperSolver {
 public:
  /// @throws Error as check_paper_scene.
  PaperSolver(IncrementalPotential& potential, const PaperLoops& loops);

  /// paper_loop on u.
  IterationResult solve(double* u, const Interrupted& interrupted);

  /// f = A p for three independent columns, (nodes, 3), 0 on pinned nodes; after freeze().
  void product(const double* p, double* f);
  /// Takes N and R of every voxel at u, and the diagonal.
  void freeze(const double* u);
  /// Diagonal D [N/m] of a node.
  double diagonal(int64_t node) const { return diagonal_[size_t(node)]; }

 private:
  struct Work;

  template <bool kAffine>
  void apply(const double* p, double* f);
  void set_diagonal();
  void corner_diagonal(int64_t row, int lane, double share[8]) const;
  void project(double* u);
  void sweep(double* u);

  IncrementalPotential& potential_;
  PaperLoops loops_;
  int waves_ = 0;               // cosines
  std::vector<double> lagged_;  // NN and rest, [row][15][lane]
  std::vector<double> slope_;   // max n^2, [row][lane]
  std::vector<double> corner_;  // share of each corner in D, (voxels, 8)
  std::vector<double> diagonal_, force_, column_;
  std::vector<double> modes_;  // (cosines, nodes)
  BrickScratch<double> scratch_;
  std::vector<NoSums> sums_;
};

}  // namespace elastogen
