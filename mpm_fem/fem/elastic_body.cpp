// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/elastic_body.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/polar.hpp"
#include "mpm_fem/fem/positive_part.hpp"

#include <algorithm>

namespace elastogen::fem {

ElasticBody::ElasticBody(const ElementMesh& mesh, std::vector<Material> materials)
    : tables_(mesh), materials_(std::move(materials)) {
  for (const Material& material : materials_) check_material(material);
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    ELASTOGEN_CHECK(mesh.material(e) >= 0 && mesh.material(e) < int(materials_.size()), "element ",
                    e, " has material ", mesh.material(e), " of ", materials_.size());
  if (mesh.element != Element::kVoxel) return;
  rotation_ = Array<double>(mesh.elements.rows(), 9);
  for (int64_t e = 0; e < rotation_.rows(); ++e)
    for (int d = 0; d < 3; ++d) rotation_(e, 4 * d) = 1;
}

const Material& ElasticBody::material_of(int64_t element) const {
  return materials_[size_t(mesh().material(element))];
}

ElasticLaw<double> ElasticBody::law_of(int64_t element) const {
  const Material& material = material_of(element);
  return {{material.law, material.mu(), material.lambda()}};
}

void ElasticBody::freeze_rotations(In<double> u) {
  tables_.check_nodal(u);
  if (mesh().element != Element::kVoxel) return;
  for_each(mesh().elements.rows(), [&](int64_t e) {
    const Mat3<double> R = unique_rotation(fem::deformation_gradient(tables_.state(e, u), 0));
    std::copy(R.m, R.m + 9, rotation_.row(e));
  });
}

VoxelHourglass ElasticBody::hourglass(int64_t voxel) const {
  return voxel_hourglass(mesh(), voxel, material_of(voxel).mu(), rotation_.row(voxel));
}

EnergyParts ElasticBody::energy(In<double> u) const {
  tables_.check_nodal(u);
  const int64_t elements = mesh().elements.rows();
  Array<double> elastic(elements), hourglassed(elements);
  for_each(
      elements,
      [&](int64_t k) {
        const ElementState e = tables_.state(k, u);
        const PointGradients points(mesh().element, e);
        const ElasticLaw<double> law = law_of(k);
        for (int q = 0; q < e.points; ++q)
          elastic(k) += e.weight[q] * energy_density(law, points.F(q));
        if (mesh().element == Element::kVoxel) hourglassed(k) = hourglass_energy(hourglass(k), e.u);
      },
      kElementBlock);
  EnergyParts parts;
  parts.elastic = total(elastic);
  parts.hourglass = total(hourglassed);
  return parts;
}

void ElasticBody::add_gradient(In<double> u, Out<double> g) const {
  tables_.check_nodal(u);
  tables_.check_nodal(g);
  tables_.add_forces(
      [&](int64_t k, double* f) {
        const ElementState e = tables_.state(k, u);
        const PointGradients points(mesh().element, e);
        const ElasticLaw<double> law = law_of(k);
        Mat3<double> P[kMaxPoints];
        for (int q = 0; q < e.points; ++q) P[q] = piola_stress(law, points.F(q));
        points.add_force(e, P, f);
        if (mesh().element == Element::kVoxel) add_hourglass_gradient(hourglass(k), e.u, f);
      },
      g);
}

void ElasticBody::element_hessian(int64_t element, In<double> u, TangentKind kind,
                                  double* K) const {
  tables_.check_nodal(u);
  const ElementState e = tables_.state(element, u);
  const PointGradients points(mesh().element, e);
  const ElasticLaw<double> law = law_of(element);
  const bool projected = kind == TangentKind::kProjected;
  Mat3<double> P[kMaxPoints];
  double A[81 * kMaxPoints];
  for (int q = 0; q < e.points; ++q) {
    if (points.shares_dilatation()) P[q] = piola_stress(law, points.F(q));
    piola_gradient(law, points.F(q), points.shares_dilatation() ? TangentKind::kTrue : kind,
                   A + 81 * q);
  }
  points.stiffness(e, P, A, true, K);
  if (projected && points.shares_dilatation()) clamp_eigenvalues(3 * e.nodes, K);
  if (mesh().element == Element::kVoxel) add_hourglass_hessian(hourglass(element), K);
}

}  // namespace elastogen::fem
