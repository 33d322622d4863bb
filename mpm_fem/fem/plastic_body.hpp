// SPDX-License-Identifier: Apache-2.0
// Finite elements that yield, in float64. Each quadrature point stores Fp^-1 and one number of the
// law. During a step both keep their values from its start; from these the forces are
//
//     f(u) = sum_e sum_q w_q P(F_q Fp_q^-1) Fp_q^-T : dF_q/du,
//
// For laws with a potential this is the gradient of E(u) = sum w_q psi. For the others, sand and
// snow, a potential can be frozen at a state (materials/frozen_potential.hpp), with the same forces
// there. Triangles flow in their plane (materials with d = 2). With bbar F_q has a share of the
// mean dilatation (fem/mean_dilatation.hpp).

#pragma once

#include "mpm_fem/fem/element_tables.hpp"
#include "mpm_fem/fem/plastic_point.hpp"
#include "mpm_fem/fem/point_gradients.hpp"
#include "mpm_fem/materials/frozen_law.hpp"

namespace elastogen::fem {

/// The history of all points of a body, point q of element e in row e points + q.
struct PlasticHistory {
  Array<double> Fp_inverse;  ///< (points, 9)
  Array<double> memory;      ///< the number of the law, 0 at the start, (points, 1)
};

class PlasticBody {
 public:
  /// @throws Error as check_mesh and point_law, on an index without solid, and on voxel elements:
  ///         with one point their flow is left to the elastic strain-variance term.
  PlasticBody(const ElementMesh& mesh, const std::vector<Solid>& solids);

  const ElementMesh& mesh() const { return tables_.mesh(); }
  /// Whether all laws have a potential.
  bool has_energy() const;

  /// The history before any flow.
  PlasticHistory rest_history() const;
  /// Sets the history that steps start from. @throws Error unless the arrays fit.
  void set_history(const PlasticHistory& history);
  /// The history after a step that ends at u.
  PlasticHistory history_after(In<double> u) const;

  /// Until thaw(), potentials frozen at u replace the laws without one.
  void freeze(In<double> u);
  void thaw() { frozen_.clear(); }

  /// E(u) [J]; laws without potential, unless frozen, have their elastic energy.
  double energy(In<double> u) const;
  /// Adds f(u) [N] to g, (nodes, 3).
  void add_gradient(In<double> u, Out<double> g) const;
  /// add_gradient, which also sets the history after a step that ends at u.
  void add_gradient_and_commit(In<double> u, Out<double> g);
  /// df/du of an element [N/m], row-major (3 n, 3 n), symmetric where the law has a potential.
  void element_hessian(int64_t element, In<double> u, TangentKind kind, double* K) const;

  /// Elastic energy at the end of a step that ends at u, and plastic work in it [J].
  StepWork work(In<double> u) const;
  /// Smallest det F of a quadrature point (with bbar of F, not Fbar).
  double min_j(In<double> u) const;
  /// Largest share, at most 1, of the path from u to end on which no det F falls below a tenth of
  /// its value at u.
  double longest_step(In<double> u, In<double> end) const;
  /// Rest volume and constrained modulus of an element [m^3], [Pa].
  double volume(int64_t element) const { return tables_.volume(element); }
  double stiffness(int64_t element) const;

 private:
  using Frozen =
      std::variant<std::monostate, FrozenDruckerPrager<double, 3>::History,
                   FrozenCamClay<double, 3>::History, FrozenDruckerPrager<double, 2>::History,
                   FrozenCamClay<double, 2>::History>;

  template <class Visit>
  void for_points(int64_t element, const Visit& visit) const;
  template <class Visit>
  void for_laws(int64_t element, const Visit& visit) const;

  ElementTables tables_;
  std::vector<Solid> solids_;
  double share(int64_t element) const { return shares_[size_t(mesh().material(element))]; }

  std::vector<AnyLaw> laws_;    // of each solid
  std::vector<double> shares_;  // of the mean in the dilatation, of each solid
  PlasticHistory history_;
  std::vector<Frozen> frozen_;  // of each point; empty: thawed
};

}  // namespace elastogen::fem
