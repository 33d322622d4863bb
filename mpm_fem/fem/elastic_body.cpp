// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/elastic_body.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/polar.hpp"
#include "mpm_fem/fem/mean_dilatation.hpp"
#include "mpm_fem/fem/pointwise.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// Gradients (points, nodes, 3) and weights of an element with nodes X.
void fill_shape(Element element, const double* X, double* gradient, double* weight) {
  const int nodes = nodes_of(element);
  for (const QuadraturePoint& point : potential_rule(element)) {
    double dN[kMaxDofs];
    Mat3<double> J;
    shape_gradients(element, point.xi, dN);
    jacobian(element, X, dN, J.m);
    const double volume = determinant(J);
    const Mat3<double> C = cofactor(J);
    *weight++ = point.weight * volume;
    for (int a = 0; a < nodes; ++a)
      for (int d = 0; d < 3; ++d) {
        double sum = 0;
        for (int k = 0; k < 3; ++k) sum += dN[3 * a + k] * C(d, k);
        *gradient++ = sum / volume;
      }
  }
}

constexpr int64_t kElementBlock = 64;

/// Sum over the elements of values (elements, 1), in a fixed order.
double total(const Array<double>& values) {
  return ordered_sum(values.rows(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t e = begin; e < end; ++e) sum += values(e);
    return sum;
  });
}

}  // namespace

ElasticBody::ElasticBody(const ElementMesh& mesh, std::vector<Material> materials)
    : mesh_(mesh), materials_(std::move(materials)) {
  check_mesh(mesh_);
  for (const Material& material : materials_) check_material(material);
  for (int64_t e = 0; e < mesh_.elements.rows(); ++e)
    ELASTOGEN_CHECK(mesh_.material(e) >= 0 && mesh_.material(e) < int(materials_.size()),
                    "element ", e, " has material ", mesh_.material(e), " of ", materials_.size());
  fill_tables();
  fill_neighbours();
}

void ElasticBody::fill_tables() {
  const int64_t elements = mesh_.elements.rows();
  const int nodes = nodes_of(mesh_.element);
  if (mesh_.element == Element::kVoxel) {
    gradient_ = Array<double>(elements, 24);
    weight_ = Array<double>(elements, 1);
    weight_.fill(mesh_.h * mesh_.h * mesh_.h);
    for_each(elements, [&](int64_t e) {
      voxel_gradient(mesh_.shape_mean.row(e), mesh_.h, gradient_.row(e));
    });
    rotation_ = Array<double>(elements, 9);
    for (int64_t e = 0; e < elements; ++e)
      for (int d = 0; d < 3; ++d) rotation_(e, 4 * d) = 1;
    return;
  }
  const auto points = int(potential_rule(mesh_.element).size());
  const int64_t shapes = is_voxel_mesh(mesh_) ? 1 : elements;
  gradient_ = Array<double>(shapes, points * nodes * 3);
  weight_ = Array<double>(shapes, points);
  for_each(shapes, [&](int64_t e) {
    double X[kMaxDofs];
    element_nodes(mesh_, e, X);
    fill_shape(mesh_.element, X, gradient_.row(e), weight_.row(e));
  });
}

void ElasticBody::fill_neighbours() {
  const int64_t corners = mesh_.elements.size();
  first_corner_.assign(size_t(mesh_.rest.rows() + 1), 0);
  for (int64_t k = 0; k < corners; ++k) ++first_corner_[size_t(mesh_.elements.data()[k]) + 1];
  for (size_t n = 1; n < first_corner_.size(); ++n) first_corner_[n] += first_corner_[n - 1];
  corner_.resize(size_t(corners));
  std::vector<int64_t> next = first_corner_;
  for (int64_t k = 0; k < corners; ++k)
    corner_[size_t(next[size_t(mesh_.elements.data()[k])]++)] = k;
}

bool ElasticBody::has_mean_dilatation() const {
  return mesh_.element == Element::kHexBbar || mesh_.element == Element::kTet10Bbar;
}

const Material& ElasticBody::material_of(int64_t element) const {
  return materials_[size_t(mesh_.material(element))];
}

ElementState ElasticBody::state(int64_t element, In<double> u) const {
  const Material& material = material_of(element);
  const int64_t shape = shape_of(element);
  ElementState e;
  e.nodes = nodes_of(mesh_.element);
  e.points = weight_.cols();
  e.gradient = gradient_.row(shape);
  e.law = {{material.law, material.mu(), material.lambda()}};
  const double fill = fill_of(mesh_, element);
  for (int q = 0; q < e.points; ++q) e.weight[q] = fill * weight_(shape, q);
  const int32_t* nodes = mesh_.elements.row(element);
  for (int a = 0; a < e.nodes; ++a)
    for (int d = 0; d < 3; ++d) e.u[3 * a + d] = u(nodes[a], d) - u(nodes[0], d);
  return e;
}

void ElasticBody::freeze_rotations(In<double> u) {
  check_nodal(u);
  if (mesh_.element != Element::kVoxel) return;
  for_each(mesh_.elements.rows(), [&](int64_t e) {
    const Mat3<double> R = unique_rotation(fem::deformation_gradient(state(e, u), 0));
    std::copy(R.m, R.m + 9, rotation_.row(e));
  });
}

void ElasticBody::check_nodal(In<double> u) const {
  ELASTOGEN_CHECK(u.is(mesh_.rest.rows(), 3), "nodal values must be (", mesh_.rest.rows(),
                  ", 3), got ", u);
}

VoxelHourglass ElasticBody::hourglass(int64_t voxel) const {
  return voxel_hourglass(mesh_, voxel, material_of(voxel).mu(), rotation_.row(voxel));
}

EnergyParts ElasticBody::energy(In<double> u) const {
  check_nodal(u);
  const int64_t elements = mesh_.elements.rows();
  Array<double> elastic(elements), hourglassed(elements);
  for_each(
      elements,
      [&](int64_t k) {
        const ElementState e = state(k, u);
        elastic(k) = has_mean_dilatation() ? mean_dilatation_energy(e) : pointwise_energy(e);
        if (mesh_.element == Element::kVoxel) hourglassed(k) = hourglass_energy(hourglass(k), e.u);
      },
      kElementBlock);
  EnergyParts parts;
  parts.elastic = total(elastic);
  parts.hourglass = total(hourglassed);
  return parts;
}

void ElasticBody::add_gradient(In<double> u, Out<double> g) const {
  check_nodal(u);
  check_nodal(g);
  const int nodes = nodes_of(mesh_.element);
  Array<double> force(mesh_.elements.size(), 3);
  for_each(
      mesh_.elements.rows(),
      [&](int64_t k) {
        const ElementState e = state(k, u);
        double* f = force.row(k * nodes);
        has_mean_dilatation() ? add_mean_dilatation_gradient(e, f) : add_pointwise_gradient(e, f);
        if (mesh_.element == Element::kVoxel) add_hourglass_gradient(hourglass(k), e.u, f);
      },
      kElementBlock);
  for_each(mesh_.rest.rows(), [&](int64_t n) {
    for (int64_t k = first_corner_[size_t(n)]; k < first_corner_[size_t(n) + 1]; ++k)
      for (int d = 0; d < 3; ++d) g(n, d) += force(corner_[size_t(k)], d);
  });
}

void ElasticBody::element_hessian(int64_t element, In<double> u, TangentKind kind,
                                  double* K) const {
  check_nodal(u);
  const ElementState e = state(element, u);
  if (has_mean_dilatation()) return mean_dilatation_hessian(e, kind, K);
  pointwise_hessian(e, kind, K);
  if (mesh_.element == Element::kVoxel) add_hourglass_hessian(hourglass(element), K);
}

}  // namespace elastogen::fem
