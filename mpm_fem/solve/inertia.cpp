// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/inertia.hpp"

#include "core/reduce.hpp"

#include <algorithm>

namespace elastogen::fem {

Inertia::Inertia(MassMatrix mass)
    : mass_(std::move(mass)),
      predictor_(size_t(3 * mass_.nodal().rows())),
      away_(predictor_),
      mass_away_(predictor_) {}

void Inertia::set(double weight, In<double> predictor) {
  weight_ = weight;
  std::copy(predictor.data, predictor.data + predictor.size(), predictor_.begin());
}

void Inertia::find_away(In<double> u) {
  for_each(u.size(), [&](int64_t k) { away_[size_t(k)] = u.data[k] - predictor_[size_t(k)]; });
  mass_.multiply(away_.data(), mass_away_.data());
}

void Inertia::find_accelerations(In<double> u, double* acceleration) const {
  for (int64_t k = 0; k < u.size(); ++k)
    acceleration[k] = weight_ * (u.data[k] - predictor_[size_t(k)]);
}

TermValue Inertia::value(In<double> u) {
  if (weight_ == 0) return {};
  find_away(u);
  const double value = weight_ / 2 * dot(away_.data(), mass_away_.data(), u.size());
  return {value, value, 0};
}

void Inertia::add_gradient(In<double> u, Out<double> g) {
  if (weight_ == 0) return;
  find_away(u);
  add_scaled(weight_, mass_away_.data(), g.data, g.size());
}

void Inertia::add_hessian(In<double>, TangentKind, SparseMatrix& H) {
  if (weight_ != 0) mass_.add_to(weight_, H);
}

}  // namespace elastogen::fem
