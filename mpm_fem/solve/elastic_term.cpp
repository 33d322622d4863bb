// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/elastic_term.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {

ElasticTerm::ElasticTerm(const ElementMesh& mesh, std::vector<Material> materials,
                         int32_t first_node)
    : body_(mesh, std::move(materials)),
      first_node_(first_node),
      assembly_(stencils_of(mesh.elements, first_node), first_node + mesh.rest.rows()) {
  const Array<double> volume = body_.volume();
  double total = 0;
  for (int64_t e = 0; e < volume.rows(); ++e) {
    const Material& m = body_.materials()[size_t(mesh.material(e))];
    stiffness_ += volume(e) * (2 * m.mu() + m.lambda());
    total += volume(e);
  }
  edge_ = element_edge(mesh, total);
}

/// The rows of the mesh's nodes.
template <class T>
Span<T> ElasticTerm::own(Span<T> nodal) const {
  return {nodal.row(first_node_), body_.mesh().rest.rows(), 3};
}

TermValue ElasticTerm::value(In<double> u) {
  const Span<const double> mine = own(u);
  const EnergyParts energy = body_.energy(mine);
  const double elastic = energy.elastic + energy.hourglass;
  double farthest = 0;
  for (int64_t k = 0; k < mine.size(); ++k) farthest = std::max(farthest, std::abs(mine.data[k]));
  const double rounding =
      4 * std::sqrt(2 * stiffness_ * std::max(elastic, 0.0)) * (1 + farthest / edge_);
  return {elastic, elastic, rounding};
}

void ElasticTerm::add_gradient(In<double> u, Out<double> g) {
  body_.add_gradient(own(u), own(g));
}

void ElasticTerm::add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) {
  assembly_.add(
      [&](int64_t element, double* K) { body_.element_hessian(element, own(u), kind, K); }, H);
}

}  // namespace elastogen::fem
