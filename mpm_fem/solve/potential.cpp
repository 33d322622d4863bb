// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/potential.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
constexpr double kFirstOrder = 1e-4;  // tolerance of the linear system of move_fixed

std::vector<uint8_t> fixed_unknowns(In<uint8_t> fixed, int64_t nodes) {
  if (fixed.size() == 0) return std::vector<uint8_t>(size_t(3 * nodes));
  ELASTOGEN_CHECK(fixed.is(nodes, 3), "fixed must be (nodes, 3) with ", nodes, " nodes, got ",
                  fixed);
  return {fixed.data, fixed.data + fixed.size()};
}

}  // namespace

Potential::Potential(In<double> rest, In<uint8_t> fixed, MassMatrix mass, std::vector<Term*> terms,
                     const LinearOptions& options, Constraint constraint)
    : rest_(rest),
      constraint_(std::move(constraint)),
      fixed_(fixed_unknowns(fixed, rest.rows)),
      bound_(fixed_),
      terms_(std::move(terms)),
      inertia_(std::move(mass)),
      hessian_order_(terms_),
      force_(fixed_.size()),
      right_(force_),
      solver_(options),
      options_(options) {
  ELASTOGEN_CHECK(rest.cols == 3, "positions must be (nodes, 3), got ", rest);
  ELASTOGEN_CHECK(inertia_.mass().nodal().rows() == rest.rows, "mass must be (nodes, 1) with ",
                  rest.rows, " nodes, got ", inertia_.mass().nodal().rows());
  ELASTOGEN_CHECK(constraint_.dependent().last_node() < rest.rows,
                  "dependent nodes must be among the ", rest.rows, " nodes");
  constraint_.mark(bound_);
  for (int64_t i = 0; i < constraint_.dependent().count(); ++i)
    for (int64_t k = 3 * int64_t(constraint_.dependent().node(i)), d = 0; d < 3; ++d)
      ELASTOGEN_CHECK(!is_fixed(k + d), "node ", k / 3, " is dependent and must not be fixed");
  // the mass comes after the first term: the rounding of sums depends on their order
  hessian_order_.insert(hessian_order_.begin() + (terms_.empty() ? 0 : 1), &inertia_);
  update_pattern();
}

void Potential::set_force(In<double> force) {
  std::copy(force.data, force.data + unknowns(), force_.begin());
}

void Potential::set_inertia(double weight, In<double> predictor) {
  inertia_.set(weight, predictor);
}

void Potential::full_gradient(const double* u, double* gradient) {
  for_each(unknowns(), [&](int64_t k) { gradient[k] = -force_[size_t(k)]; });
  const Span<double> g{gradient, rest_.rows, 3};
  for (Term* term : terms_) term->add_gradient(nodal(u), g);
  inertia_.add_gradient(nodal(u), g);
}

void Potential::held_gradient(const double* u, const Vec3& pull, double* gradient) {
  full_gradient(u, gradient);
  std::vector<double> inertia(force_.size()), acceleration(inertia);
  inertia_.add_gradient(nodal(u), {inertia.data(), rest_.rows, 3});
  for (size_t k = 0; k < inertia.size(); ++k)
    if (fixed_[k]) gradient[k] += force_[k] - inertia[k];
  if (!mass().consistent()) return;
  // the inertia of free components at fixed ones
  inertia_.find_accelerations(nodal(u), acceleration.data());
  for (size_t k = 0; k < inertia.size(); ++k)
    acceleration[k] = fixed_[k] ? 0 : acceleration[k] + pull[k % 3];
  mass().multiply(acceleration.data(), inertia.data());
  for (size_t k = 0; k < inertia.size(); ++k)
    if (fixed_[k]) gradient[k] += inertia[k];
}

void Potential::free_gradient(const double* u, double* gradient) {
  full_gradient(u, gradient);
  restrict(gradient);
}

void Potential::restrict(double* gradient) const {
  constraint_.fold(gradient);
  for_each(unknowns(), [&](int64_t k) { gradient[k] = fixed_[size_t(k)] ? 0 : gradient[k]; });
}

void Potential::carry(const double* now, double* candidate) const {
  for (int64_t k = 0; k < unknowns(); ++k)
    if (is_fixed(k)) candidate[k] = now[k];
  if (constraint_.empty()) return;
  std::vector<double> change(candidate, candidate + unknowns());
  for (size_t k = 0; k < change.size(); ++k) change[k] -= now[k];
  constraint_.follow(change.data());
  for (size_t k = 0; k < change.size(); ++k)
    if (bound_[k] && !fixed_[k]) candidate[k] = now[k] + change[k];
}

NewtonValue Potential::evaluate(const double* u, double* gradient) {
  free_gradient(u, gradient);
  TermValue sum;
  const auto add = [&](const TermValue& term) {
    sum.value += term.value;
    sum.size += term.size;
    sum.rounding += term.rounding;
  };
  for (Term* term : terms_) add(term->value(nodal(u)));
  const double work = dot(force_.data(), u, unknowns());
  sum.value -= work;
  add(inertia_.value(nodal(u)));
  sum.size += std::abs(work);
  return {sum.value, kEpsilon * (32 * sum.size + sum.rounding)};
}

/// Makes the pattern anew if a term has other stencils than before, and the analysis of the solver
/// if that changes the pattern.
void Potential::update_pattern() {
  bool same = stencils_.size() == hessian_order_.size();
  for (size_t t = 0; same && t < stencils_.size(); ++t)
    same = hessian_order_[t]->stencils() == stencils_[t];
  if (same) return;
  stencils_.clear();
  Stencils all;
  for (const Term* term : hessian_order_) {
    stencils_.push_back(term->stencils());
    all.append(stencils_.back());
  }
  SparseMatrix pattern =
      pattern_of(constraint_.empty() ? all : constraint_.widened(all), rest_.rows);
  const bool changed = pattern.start != hessian_.start || pattern.column != hessian_.column;
  if (changed) {
    hessian_ = std::move(pattern);
    solver_.reset(hessian_, rest_, bound_.data());
    root_solver_.reset();
  }
  for (Term* term : hessian_order_) term->take_pattern(hessian_);
}

/// Sums the Hessian in u.
void Potential::add_terms(const double* u, TangentKind kind) {
  update_pattern();
  std::fill(hessian_.value.begin(), hessian_.value.end(), 0.0);
  for (Term* term : hessian_order_) term->add_hessian(nodal(u), kind, hessian_);
}

/// Assembles the Hessian, with the rows of fixed components.
void Potential::assemble(const double* u, TangentKind kind) {
  add_terms(u, kind);
  constraint_.fold(hessian_);
}

/// Adds to the right-hand side what dependent nodes, moved by themselves, pull at the others:
/// -C^T H c, with the Hessian in u.
void Potential::pull_along(const double* moved) {
  std::vector<double> change(right_.size()), pull(right_.size());
  for (size_t k = 0; k < change.size(); ++k)
    if (bound_[k] && !fixed_[k]) change[k] = moved[k];
  multiply(hessian_, change.data(), pull.data());
  constraint_.fold(pull.data());
  for (size_t k = 0; k < change.size(); ++k)
    if (!bound_[k]) right_[k] -= pull[k];
}

/// Adds growing shares of the diagonal until the matrix can be factored.
bool Potential::factor_shifted() {
  const std::vector<double> start = diagonal(hessian_);
  const double largest = *std::max_element(start.begin(), start.end());
  for (double share = 1e-12; share < 1; share *= 100) {
    for (int64_t r = 0; r < hessian_.rows(); ++r)
      hessian_.at(r, r) = start[size_t(r)] + share * std::max(start[size_t(r)], 1e-3 * largest);
    if (solver_.factor(hessian_)) return true;
  }
  return false;
}

bool Potential::newton_step(const double* u, const double* gradient, TangentKind kind,
                            double tolerance, const double* moved, double* step) {
  const bool projected = kind == TangentKind::kProjected;
  add_terms(u, kind);
  for_each(unknowns(), [&](int64_t k) {
    const double given = moved ? moved[k] : 0;
    right_[size_t(k)] = bound_[size_t(k)] ? given : -gradient[k];
  });
  if (moved && constraint_.has_offset()) pull_along(moved);
  constraint_.fold(hessian_);
  fix_unknowns(bound_.data(), hessian_, right_.data());
  if (!solver_.factor(hessian_) && !(projected && factor_shifted())) return false;
  const bool solved = solver_.solve(right_.data(), step, tolerance);
  follow(moved, step);
  return solved || projected;
}

/// Makes dependent nodes follow in a step, and adds what they are moved by themselves.
void Potential::follow(const double* moved, double* step) const {
  constraint_.follow(step);
  if (!moved || constraint_.empty()) return;
  for (size_t k = 0; k < bound_.size(); ++k)
    if (bound_[k] && !fixed_[k]) step[k] += moved[k];
}

double Potential::gradient_noise(const double* u) const {
  double length = 0;
  for (const Term* term : terms_) length = std::max(length, term->length());
  const double square = ordered_sum(unknowns(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t r = begin; r < end; ++r) {
      if (bound_[size_t(r)]) continue;
      double row = 0;
      for (int32_t k = hessian_.start[size_t(r)]; k < hessian_.start[size_t(r) + 1]; ++k)
        row += std::abs(hessian_.value[size_t(k)]) *
               (std::abs(u[hessian_.column[size_t(k)]]) + length);
      sum += row * row;
    }
    return sum;
  });
  return kEpsilon * std::sqrt(square);
}

NewtonResult Potential::minimise(const NewtonOptions& options, double* u) {
  NewtonFunction function;
  function.unknowns = unknowns();
  function.evaluate = [&](const double* x, double* gradient) { return evaluate(x, gradient); };
  function.step = [&](const double* x, const double* gradient, TangentKind kind, double tolerance,
                      double* step) {
    return newton_step(x, gradient, kind, tolerance, nullptr, step);
  };
  function.longest_step = [&](const double* x, const double* end) { return longest_step(x, end); };
  function.gradient_noise = [&](const double* x) { return gradient_noise(x); };
  constraint_.place(u);
  const NewtonResult result = fem::minimise(function, options, u);
  constraint_.place(u);
  return result;
}

double Potential::longest_step(const double* u, const double* end) {
  double share = 1;
  for (Term* term : terms_) share = std::min(share, term->longest_step(nodal(u), nodal(end)));
  return share;
}

/// step = -J^-1 gradient with the true Jacobian J of the gradient.
bool Potential::root_step(const double* u, const double* gradient, double tolerance, double* step) {
  assemble(u, TangentKind::kTrue);
  if (!root_solver_) root_solver_.emplace(options_).reset(hessian_);
  for_each(unknowns(), [&](int64_t k) { right_[size_t(k)] = -gradient[k]; });
  fix_unknowns(bound_.data(), hessian_, right_.data());
  if (!root_solver_->factor(hessian_) || !root_solver_->solve(right_.data(), step, tolerance))
    return false;
  constraint_.follow(step);
  return true;
}

RootResult Potential::find_root(const RootOptions& options, double* u) {
  RootFunction function;
  function.unknowns = unknowns();
  function.residual = [&](const double* x, double* r) { free_gradient(x, r); };
  function.step = [&](const double* x, const double* r, double tolerance, double* step) {
    return root_step(x, r, tolerance, step);
  };
  function.longest_step = [&](const double* x, const double* end) { return longest_step(x, end); };
  function.noise = [&](const double* x) {
    assemble(x, TangentKind::kTrue);
    return gradient_noise(x);
  };
  constraint_.place(u);
  const RootResult result = solve_root(function, options, u);
  constraint_.place(u);
  return result;
}

void Potential::move_fixed(In<double> target, double* u) {
  std::vector<double> gradient(force_.size()), moved(gradient), step(gradient);
  for (size_t k = 0; k < moved.size(); ++k)
    if (fixed_[k]) moved[k] = target.data[k] - u[k];
  // dependent nodes by what has changed beside their parent nodes
  if (constraint_.has_offset()) {
    std::vector<double> placed(u, u + unknowns());
    constraint_.place(placed.data());
    for (size_t k = 0; k < moved.size(); ++k)
      if (bound_[k] && !fixed_[k]) moved[k] = placed[k] - u[k];
  }
  if (std::all_of(moved.begin(), moved.end(), [](double m) { return m == 0; })) return;
  evaluate(u, gradient.data());
  bool found = false;
  for (const TangentKind kind : {TangentKind::kTrue, TangentKind::kProjected})
    if (!found)
      found = newton_step(u, gradient.data(), kind, kFirstOrder, moved.data(), step.data());
  for (size_t k = 0; k < step.size(); ++k) {
    if (fixed_[k]) u[k] = target.data[k];
    if (!fixed_[k] && found) u[k] += step[k];
  }
  constraint_.place(u);
}

}  // namespace elastogen::fem
