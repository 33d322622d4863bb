// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/plastic_term.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {

PlasticTerm::PlasticTerm(const ElementMesh& mesh, const std::vector<Solid>& solids)
    : body_(mesh, solids), assembly_(stencils_of(mesh.elements), mesh.rest.rows()) {
  double total = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    stiffness_ += body_.volume(e) * body_.stiffness(e);
    total += body_.volume(e);
  }
  edge_ = element_edge(mesh, total);
}

TermValue PlasticTerm::value(In<double> u) {
  const double energy = body_.energy(u), size = std::abs(energy);
  double farthest = 0;
  for (int64_t k = 0; k < u.size(); ++k) farthest = std::max(farthest, std::abs(u.data[k]));
  return {energy, size, 4 * std::sqrt(2 * stiffness_ * size) * (1 + farthest / edge_)};
}

void PlasticTerm::add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) {
  assembly_.add([&](int64_t element, double* K) { body_.element_hessian(element, u, kind, K); }, H);
}

}  // namespace elastogen::fem
