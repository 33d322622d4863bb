// SPDX-License-Identifier: Apache-2.0
// The deformation gradients at which an element evaluates its law: Fbar_q if it has mean
// dilatation, else F_q. Also the forces and the stiffness of the element from the response of the
// law there.

#pragma once

#include "mpm_fem/fem/mean_dilatation.hpp"

namespace elastogen::fem {

class PointGradients {
 public:
  /// @param share  as in mean_dilatation
  PointGradients(Element element, const ElementState& e, double share = 1);

  const Mat3<double>& F(int q) const { return mean_.Fbar[q]; }
  /// Whether they are Fbar_q, which depend on all points of the element.
  bool shares_dilatation() const { return shares_dilatation_; }

  /// Adds sum_q w_q P_q : dF_q/du [N] to f, (nodes, 3).
  /// @param P  first Piola stress at F_q [Pa], (points); scaled to forces
  void add_force(const ElementState& e, Mat3<double>* P, double* f) const;
  /// The derivative of this force [N/m], row-major (3 nodes, 3 nodes).
  /// @param A          dP/dF at F_q [Pa], (points, 9, 9); scaled
  /// @param symmetric  whether all A are
  void stiffness(const ElementState& e, const Mat3<double>* P, double* A, bool symmetric,
                 double* K) const;

 private:
  bool shares_dilatation_;
  MeanDilatation mean_;  // of other elements only Fbar, which is F
};

/// Whether an element has mean dilatation.
bool has_mean_dilatation(Element element);

}  // namespace elastogen::fem
