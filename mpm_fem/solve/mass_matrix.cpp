// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/mass_matrix.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/solve/assembly.hpp"

namespace elastogen::fem {
namespace {

void check_positive(const Array<double>& mass) {
  ELASTOGEN_CHECK(mass.cols() == 1, "mass must be (nodes, 1), got (", mass.rows(), ", ",
                  mass.cols(), ")");
  for (int64_t n = 0; n < mass.rows(); ++n)
    ELASTOGEN_CHECK(mass(n) > 0, "mass(", n, ") must be positive, got ", mass(n));
}

void check_mass(const FemScene& scene) {
  const int64_t nodes = scene.mesh.rest.rows();
  ELASTOGEN_CHECK(scene.mass_kind == Mass::kLumped,
                  "a mass of the nodes is lumped; with a consistent one leave it empty");
  ELASTOGEN_CHECK(scene.mass.rows() == nodes && scene.mass.cols() == 1,
                  "mass must be (nodes, 1) with ", nodes, " nodes, got (", scene.mass.rows(), ", ",
                  scene.mass.cols(), ")");
  check_positive(scene.mass);
}

/// Repeats an (n, n) matrix for each of the three components.
void expand(const double* M, int corners, double* K) {
  const int width = 3 * corners;
  std::fill(K, K + width * width, 0.0);
  for (int a = 0; a < corners; ++a)
    for (int b = 0; b < corners; ++b)
      for (int i = 0; i < 3; ++i) K[(3 * a + i) * width + 3 * b + i] = M[a * corners + b];
}

}  // namespace

MassMatrix::MassMatrix(const FemScene& scene, const ElasticBody& body) {
  if (!scene.mass.empty()) {
    check_mass(scene);
    nodal_ = scene.mass;
    return;
  }
  nodal_ = body.lumped_mass();
  if (scene.mass_kind == Mass::kLumped) return;
  const int corners = nodes_of(scene.mesh.element);
  Assembly assembly(stencils_of(scene.mesh.elements), nodal_.rows());
  stencils_ = assembly.stencils();
  matrix_ = pattern_of(stencils_, nodal_.rows());
  assembly.fit(matrix_);
  assembly.add(
      [&](int64_t element, double* K) {
        double M[100];
        body.element_mass(element, M);
        expand(M, corners, K);
      },
      matrix_);
}

MassMatrix::MassMatrix(Array<double> nodal) : nodal_(std::move(nodal)) {
  check_positive(nodal_);
}

void MassMatrix::multiply(const double* x, double* y) const {
  if (consistent()) return fem::multiply(matrix_, x, y);
  for_each(3 * nodal_.rows(), [&](int64_t k) { y[k] = nodal_(k / 3) * x[k]; });
}

void MassMatrix::add_to(double a, SparseMatrix& A) const {
  if (consistent())
    add_multiple(a, matrix_, A);
  else
    for_each(A.rows(), [&](int64_t r) { A.at(r, r) += a * nodal_(r / 3); });
}

}  // namespace elastogen::fem
