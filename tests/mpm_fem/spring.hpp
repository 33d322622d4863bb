// SPDX-License-Identifier: Apache-2.0
// A term of two nodes, which may come and go: a spring of rest length 0.

#pragma once

#include "mpm_fem/solve/term.hpp"

namespace elastogen::test {

/// k/2 |x_b - x_a|^2 of the places x = X + u of nodes a and b, while it is attached.
class Spring final : public fem::Term {
 public:
  Spring(In<double> rest, int32_t a, int32_t b, double k) : rest_(rest), a_(a), b_(b), k_(k) {}

  void attach() {
    const int32_t ends[2] = {a_, b_};
    stencils_.add(ends, 2);
  }

  const fem::Stencils& stencils() const override { return stencils_; }
  fem::TermValue value(In<double> u) override {
    double energy = 0;
    for (int i = 0; i < 3; ++i) energy += stiffness() / 2 * stretch(u, i) * stretch(u, i);
    return {energy, energy, 0};
  }
  void add_gradient(In<double> u, Out<double> g) override {
    for (int i = 0; i < 3; ++i) {
      g(b_, i) += stiffness() * stretch(u, i);
      g(a_, i) -= stiffness() * stretch(u, i);
    }
  }
  void add_hessian(In<double>, TangentKind, fem::SparseMatrix& H) override {
    if (stiffness() == 0) return;
    for (const int32_t row : {a_, b_})
      for (const int32_t column : {a_, b_}) {
        double block[9] = {};
        for (int i = 0; i < 3; ++i) block[4 * i] = row == column ? k_ : -k_;
        H.add_block(row, column, block);
      }
  }

 private:
  double stiffness() const { return stencils_.count() > 0 ? k_ : 0; }
  double stretch(In<double> u, int i) const {
    return rest_(b_, i) + u(b_, i) - rest_(a_, i) - u(a_, i);
  }

  Span<const double> rest_;
  int32_t a_, b_;
  double k_;
  fem::Stencils stencils_;
};

}  // namespace elastogen::test
