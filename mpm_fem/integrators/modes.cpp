// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/modes.hpp"

#include "core/error.hpp"
#include "mpm_fem/solve/assembly.hpp"
#include "mpm_fem/solve/constraint.hpp"
#include "mpm_fem/solve/mass_matrix.hpp"
#include "mpm_fem/solve/sparse_direct.hpp"

#include <Eigen/Core>
#include <Spectra/SymGEigsShiftSolver.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen::fem {
namespace {

constexpr double kResidual = 1e-13;  // of the eigenpairs, relative
constexpr int kMaxRestarts = 1000;

/// y = (K - sigma M)^-1 x.
class ShiftInvert {
 public:
  using Scalar = double;
  explicit ShiftInvert(SparseDirect& factor, int64_t rows) : factor_(factor), rows_(rows) {}
  Eigen::Index rows() const { return rows_; }
  Eigen::Index cols() const { return rows_; }
  void set_shift(double) {}  // the factor is that of the shift
  void perform_op(const double* x, double* y) const { factor_.solve(x, y); }

 private:
  SparseDirect& factor_;
  Eigen::Index rows_;
};

class MassProduct {
 public:
  using Scalar = double;
  explicit MassProduct(const SparseMatrix& M) : M_(M) {}
  Eigen::Index rows() const { return M_.rows(); }
  Eigen::Index cols() const { return M_.rows(); }
  void perform_op(const double* x, double* y) const { multiply(M_, x, y); }

 private:
  const SparseMatrix& M_;
};

/// A hundredth of the squared rate at which a wave crosses the body [1/s^2].
double slow_rate(const FemScene& scene) {
  Box box;
  const Array<double>& X = scene.mesh.rest;
  for (int64_t n = 0; n < X.rows(); ++n) box.add({X(n, 0), X(n, 1), X(n, 2)});
  double speed = 0, size = 0;
  for (const Material& m : scene.materials) speed = std::max(speed, m.young / m.density);
  for (int d = 0; d < 3; ++d) size += box.extent(d) * box.extent(d);
  return 0.01 * speed / size;
}

struct Problem {
  SparseMatrix K, M;             // of the free unknowns
  std::vector<int64_t> unknown;  // of each row
};

Problem linearised(const FemScene& scene, const Array<double>& u) {
  const int64_t nodes = scene.mesh.rest.rows();
  ElasticBody body(scene.mesh, scene.materials);
  body.freeze_rotations(u);
  const MassMatrix mass(scene, body);
  Assembly assembly(stencils_of(scene.mesh.elements), nodes);
  const Constraint constraint(scene.dependent);
  SparseMatrix K = pattern_of(constraint.widened(assembly.stencils()), nodes), M = K;
  assembly.fit(K);
  assembly.add(
      [&](int64_t element, double* matrix) {
        body.element_hessian(element, u, TangentKind::kTrue, matrix);
      },
      K);
  mass.add_to(1, M);
  // their parts of the free unknowns
  for (SparseMatrix* A : {&K, &M}) constraint.fold(*A);
  Problem problem;
  std::vector<uint8_t> bound(size_t(3 * nodes));
  if (!scene.fixed.empty()) bound.assign(scene.fixed.data(), scene.fixed.data() + 3 * nodes);
  constraint.mark(bound);
  for (int64_t k = 0; k < 3 * nodes; ++k)
    if (!bound[size_t(k)]) problem.unknown.push_back(k);
  problem.K = free_part(bound.data(), K);
  problem.M = free_part(bound.data(), M);
  return problem;
}

/// Factors K - sigma M at the first sigma = -rate, -10 rate, ... where it is positive definite.
double factor_shifted(const Problem& problem, double rate, SparseDirect& factor) {
  SparseMatrix shifted = problem.K;
  for (double sigma = -rate; sigma > -1e12 * rate; sigma *= 10) {
    for (size_t k = 0; k < shifted.value.size(); ++k)
      shifted.value[k] = problem.K.value[k] - sigma * problem.M.value[k];
    if (factor.factor(shifted)) return sigma;
  }
  throw Error("the body is too far from a stable equilibrium to have modes", ErrorKind::kDiverged);
}

}  // namespace

Modes vibration_modes(const FemScene& scene, int count, const Array<double>& u) {
  const int64_t nodes = scene.mesh.rest.rows();
  ELASTOGEN_CHECK(u.empty() || (u.rows() == nodes && u.cols() == 3), "u must be (nodes, 3) with ",
                  nodes, " nodes, got (", u.rows(), ", ", u.cols(), ")");
  const Problem problem = linearised(scene, u.empty() ? Array<double>(nodes, 3) : u);
  const int64_t rows = problem.K.rows();
  ELASTOGEN_CHECK(count >= 1 && count < rows, "modes must be 1 to ", rows - 1, ", got ", count);

  // factors of a shifted, positive definite matrix
  SparseDirect factor(problem.K);
  const double sigma = factor_shifted(problem, slow_rate(scene), factor);
  ShiftInvert inverse(factor, rows);
  MassProduct product(problem.M);
  // Lanczos on its inverse
  const int64_t krylov = std::min<int64_t>(rows, std::max(2 * count + 10, 20));
  Spectra::SymGEigsShiftSolver<ShiftInvert, MassProduct, Spectra::GEigsMode::ShiftInvert> lanczos(
      inverse, product, count, krylov, sigma);
  lanczos.init();
  const Eigen::Index found = lanczos.compute(Spectra::SortRule::LargestMagn, kMaxRestarts,
                                             kResidual, Spectra::SortRule::SmallestAlge);
  if (found < count)
    throw Error(concat("found ", found, " of ", count, " modes"), ErrorKind::kDiverged);

  // shapes on all nodes, 0 at fixed components, dependent nodes following
  Modes modes;
  modes.shape = Array<double>(count, int(3 * nodes));
  const Eigen::VectorXd values = lanczos.eigenvalues();
  const Eigen::MatrixXd vectors = lanczos.eigenvectors();
  for (int k = 0; k < count; ++k) {
    modes.omega_squared.push_back(values(k));
    modes.frequency.push_back(std::sqrt(std::max(0.0, values(k))) / (2 * std::numbers::pi));
    for (int64_t r = 0; r < rows; ++r)
      modes.shape.row(k)[problem.unknown[size_t(r)]] = vectors(r, k);
    scene.dependent.fill(modes.shape.row(k));
  }
  return modes;
}

}  // namespace elastogen::fem
