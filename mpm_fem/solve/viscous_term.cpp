// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/viscous_term.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

double volume_of(const ElementMesh& mesh) {
  const ElementTables tables(mesh);
  double sum = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) sum += tables.volume(e);
  return sum;
}

}  // namespace

ViscousTerm::ViscousTerm(const ElementMesh& mesh, std::vector<Material> materials)
    : body_(mesh, std::move(materials)),
      assembly_(stencils_of(mesh.elements, 0), mesh.rest.rows()),
      edge_(element_edge(mesh, volume_of(mesh))) {}

TermValue ViscousTerm::value(In<double> u) {
  const double lost = body_.energy(u);
  double farthest = 0;
  for (int64_t k = 0; k < u.size(); ++k) farthest = std::max(farthest, std::abs(u.data[k]));
  return {lost, lost, 4 * std::sqrt(2 * body_.stiffness() * lost) * (1 + farthest / edge_)};
}

void ViscousTerm::add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) {
  assembly_.add([&](int64_t element, double* K) { body_.element_hessian(element, u, kind, K); }, H);
}

}  // namespace elastogen::fem
