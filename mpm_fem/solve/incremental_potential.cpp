// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/incremental_potential.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kFirstOrder = 1e-4;  // how far the system of move_fixed is solved

std::vector<uint8_t> fixed_unknowns(const FemScene& scene) {
  const int64_t nodes = scene.mesh.rest.rows();
  const Array<uint8_t>& fixed = scene.fixed;
  if (fixed.empty()) return std::vector<uint8_t>(size_t(3 * nodes));
  ELASTOGEN_CHECK(fixed.rows() == nodes && fixed.cols() == 3, "fixed must be (nodes, 3) with ",
                  nodes, " nodes, got (", fixed.rows(), ", ", fixed.cols(), ")");
  return {fixed.data(), fixed.data() + fixed.size()};
}

}  // namespace

IncrementalPotential::IncrementalPotential(const FemScene& scene, const LinearOptions& options)
    : scene_(scene),
      body_(scene.mesh, scene.materials),
      assembly_(scene.mesh.elements, scene.mesh.rest.rows()),
      mass_(scene, body_, assembly_),
      contact_(scene.contact, scene.colliders, scene.mesh.rest.rows()),
      fixed_(fixed_unknowns(scene)),
      force_(fixed_.size()),
      predictor_(force_),
      away_(force_),
      mass_away_(force_),
      right_(force_),
      hessian_(assembly_.pattern()),
      solver_(hessian_, scene.mesh.rest, fixed_.data(), options) {
  const Array<double> volume = body_.volume();
  double total = 0;
  for (int64_t e = 0; e < volume.rows(); ++e) {
    const Material& m = scene.materials[size_t(scene.mesh.material(e))];
    stiffness_ += volume(e) * (2 * m.mu() + m.lambda());
    total += volume(e);
  }
  edge_ = std::cbrt(total / double(std::max<int64_t>(1, volume.rows())));
}

void IncrementalPotential::set_force(In<double> force) {
  std::copy(force.data, force.data + unknowns(), force_.begin());
}

void IncrementalPotential::set_inertia(double weight, In<double> predictor) {
  weight_ = weight;
  std::copy(predictor.data, predictor.data + unknowns(), predictor_.begin());
}

void IncrementalPotential::full_gradient(const double* u, double* gradient) {
  const int64_t size = unknowns();
  for_each(size, [&](int64_t k) { gradient[k] = -force_[size_t(k)]; });
  body_.add_gradient({u, size / 3, 3}, {gradient, size / 3, 3});
  if (contact_.exists()) contact_.add_gradient({u, size / 3, 3}, {gradient, size / 3, 3});
  if (weight_ == 0) return;
  for_each(size, [&](int64_t k) { away_[size_t(k)] = u[k] - predictor_[size_t(k)]; });
  mass_.multiply(away_.data(), mass_away_.data());
  add_scaled(weight_, mass_away_.data(), gradient, size);
}

NewtonValue IncrementalPotential::evaluate(const double* u, double* gradient) {
  const int64_t size = unknowns();
  full_gradient(u, gradient);
  for_each(size, [&](int64_t k) { gradient[k] = fixed_[size_t(k)] ? 0 : gradient[k]; });
  const EnergyParts energy = body_.energy({u, size / 3, 3});
  const double elastic = energy.elastic + energy.hourglass;
  const double touch = contact_.exists() ? contact_.energy({u, size / 3, 3}) : 0;
  const double work = dot(force_.data(), u, size);
  const double inertia =
      weight_ == 0 ? 0 : weight_ / 2 * dot(away_.data(), mass_away_.data(), size);
  double farthest = 0;
  for (int64_t k = 0; k < size; ++k) farthest = std::max(farthest, std::abs(u[k]));
  const double parts = elastic + touch + inertia + std::abs(work);
  const double rounding =
      4 * std::sqrt(2 * stiffness_ * std::max(elastic, 0.0)) * (1 + farthest / edge_);
  return {elastic + touch - work + inertia, kEpsilon * (32 * parts + rounding)};
}

/// Hessian with the rows of what is fixed still in it.
void IncrementalPotential::assemble(const double* u, bool projected) {
  std::fill(hessian_.value.begin(), hessian_.value.end(), 0.0);
  assembly_.add(
      [&](int64_t element, double* K) {
        body_.element_hessian(element, {u, unknowns() / 3, 3}, projected, K);
      },
      hessian_);
  if (weight_ != 0) mass_.add_to(weight_, hessian_);
  if (!contact_.exists()) return;
  contact_.add_hessian({u, unknowns() / 3, 3}, [&](int32_t a, int32_t b, const double block[9]) {
    for (int k = 0; k < 9; ++k)
      hessian_.at(3 * int64_t(a) + k / 3, 3 * int64_t(b) + k % 3) += block[k];
  });
}

/// Adds growing shares of the diagonal until the matrix can be factored.
bool IncrementalPotential::factor_shifted() {
  const std::vector<double> start = diagonal(hessian_);
  const double largest = *std::max_element(start.begin(), start.end());
  for (double share = 1e-12; share < 1; share *= 100) {
    for (int64_t r = 0; r < hessian_.rows(); ++r)
      hessian_.at(r, r) = start[size_t(r)] + share * std::max(start[size_t(r)], 1e-3 * largest);
    if (solver_.factor(hessian_)) return true;
  }
  return false;
}

bool IncrementalPotential::newton_step(const double* u, const double* gradient, bool projected,
                                       double tolerance, const double* moved, double* step) {
  assemble(u, projected);
  for_each(unknowns(), [&](int64_t k) {
    const double given = moved ? moved[k] : 0;
    right_[size_t(k)] = fixed_[size_t(k)] ? given : -gradient[k];
  });
  fix_unknowns(fixed_.data(), hessian_, right_.data());
  if (!solver_.factor(hessian_) && !(projected && factor_shifted())) return false;
  return solver_.solve(right_.data(), step, tolerance) || projected;
}

double IncrementalPotential::gradient_noise(const double* u) const {
  const double square = ordered_sum(unknowns(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t r = begin; r < end; ++r) {
      if (fixed_[size_t(r)]) continue;
      double row = 0;
      for (int32_t k = hessian_.start[size_t(r)]; k < hessian_.start[size_t(r) + 1]; ++k)
        row +=
            std::abs(hessian_.value[size_t(k)]) * (std::abs(u[hessian_.column[size_t(k)]]) + edge_);
      sum += row * row;
    }
    return sum;
  });
  return kEpsilon * std::sqrt(square);
}

NewtonResult IncrementalPotential::minimise(const NewtonOptions& options, double* u) {
  NewtonFunction function;
  function.unknowns = unknowns();
  function.evaluate = [&](const double* x, double* gradient) { return evaluate(x, gradient); };
  function.step = [&](const double* x, const double* gradient, bool projected, double tolerance,
                      double* step) {
    return newton_step(x, gradient, projected, tolerance, nullptr, step);
  };
  if (contact_.exists())
    function.longest_step = [&](const double* x, const double* end) {
      return contact_.longest_step({x, unknowns() / 3, 3}, {end, unknowns() / 3, 3});
    };
  function.gradient_noise = [&](const double* x) { return gradient_noise(x); };
  return fem::minimise(function, options, u);
}

void IncrementalPotential::move_fixed(In<double> target, double* u) {
  std::vector<double> gradient(force_.size()), moved(gradient), step(gradient);
  for (size_t k = 0; k < moved.size(); ++k)
    if (fixed_[k]) moved[k] = target.data[k] - u[k];
  if (std::all_of(moved.begin(), moved.end(), [](double m) { return m == 0; })) return;
  evaluate(u, gradient.data());
  bool found = false;
  for (const bool projected : {false, true})
    if (!found)
      found = newton_step(u, gradient.data(), projected, kFirstOrder, moved.data(), step.data());
  for (size_t k = 0; k < step.size(); ++k) {
    if (fixed_[k]) u[k] = target.data[k];
    if (!fixed_[k] && found) u[k] += step[k];
  }
}

}  // namespace elastogen::fem
