// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/element_tables.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/fem/voxel_element.hpp"

#include <array>
#include <map>
#include <numeric>

namespace elastogen::fem {
namespace {

/// Gradients (points, nodes, 3) and weights of an element.
void fill_shape(const ElementMesh& mesh, int64_t element, double* gradient, double* weight) {
  const int nodes = nodes_of(mesh.element);
  double X[kMaxDofs];
  element_nodes(mesh, element, X);
  for (const QuadraturePoint& point : potential_rule(mesh.element)) {
    double dN[kMaxDofs];
    Mat3<double> J;
    shape_gradients(mesh.element, in_part(mesh, element, point.xi), dN);
    jacobian(mesh.element, X, dN, J.m);
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

}  // namespace

double total(const Array<double>& values) {
  return ordered_sum(values.rows(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t e = begin; e < end; ++e) sum += values(e);
    return sum;
  });
}

ElementTables::ElementTables(const ElementMesh& mesh) : mesh_(mesh) {
  check_mesh(mesh_);
  fill_gradients();
  fill_neighbours();
}

/// The elements of different shapes, of each the first one.
std::vector<int64_t> ElementTables::find_shapes() {
  const int64_t elements = mesh_.elements.rows();
  std::vector<int64_t> first = {0};
  if (!is_voxel_mesh(mesh_)) first.resize(size_t(elements));
  std::iota(first.begin(), first.end(), 0);
  if (mesh_.part.empty() || !is_voxel_mesh(mesh_)) return first;
  // voxels with the same part
  first.clear();
  std::map<std::array<double, 6>, int32_t> known;
  for (int64_t e = 0; e < elements; ++e) {
    std::array<double, 6> part;
    std::copy_n(mesh_.part.row(e), 6, part.begin());
    const auto [found, is_new] = known.try_emplace(part, int32_t(first.size()));
    if (is_new) first.push_back(e);
    shape_.push_back(found->second);
  }
  return first;
}

void ElementTables::fill_gradients() {
  const int64_t elements = mesh_.elements.rows();
  const int nodes = nodes_of(mesh_.element);
  if (mesh_.element == Element::kVoxel) {
    gradient_ = Array<double>(elements, 24);
    weight_ = Array<double>(elements, 1);
    weight_.fill(mesh_.h * mesh_.h * mesh_.h);
    for_each(elements, [&](int64_t e) {
      voxel_gradient(mesh_.shape_mean.row(e), mesh_.h, gradient_.row(e));
    });
    return;
  }
  const auto points = int(potential_rule(mesh_.element).size());
  const std::vector<int64_t> first = find_shapes();
  gradient_ = Array<double>(int64_t(first.size()), points * nodes * 3);
  weight_ = Array<double>(int64_t(first.size()), points);
  for_each(int64_t(first.size()), [&](int64_t s) {
    fill_shape(mesh_, first[size_t(s)], gradient_.row(s), weight_.row(s));
  });
}

void ElementTables::fill_neighbours() {
  const int64_t corners = mesh_.elements.size();
  first_corner_.assign(size_t(mesh_.rest.rows() + 1), 0);
  for (int64_t k = 0; k < corners; ++k) ++first_corner_[size_t(mesh_.elements.data()[k]) + 1];
  for (size_t n = 1; n < first_corner_.size(); ++n) first_corner_[n] += first_corner_[n - 1];
  corner_.resize(size_t(corners));
  std::vector<int64_t> next = first_corner_;
  for (int64_t k = 0; k < corners; ++k)
    corner_[size_t(next[size_t(mesh_.elements.data()[k])]++)] = k;
}

ElementState ElementTables::state(int64_t element, In<double> u) const {
  const int64_t shape = shape_of(element);
  ElementState e;
  e.nodes = nodes_of(mesh_.element);
  e.points = weight_.cols();
  e.gradient = gradient_.row(shape);
  const double fill = fill_of(mesh_, element);
  for (int q = 0; q < e.points; ++q) e.weight[q] = fill * weight_(shape, q);
  const int32_t* nodes = mesh_.elements.row(element);
  for (int a = 0; a < e.nodes; ++a)
    for (int d = 0; d < 3; ++d) e.u[3 * a + d] = u(nodes[a], d) - u(nodes[0], d);
  return e;
}

double ElementTables::volume(int64_t element) const {
  double volume = 0;
  for (int q = 0; q < weight_.cols(); ++q) volume += weight_(shape_of(element), q);
  return volume * fill_of(mesh_, element);
}

void ElementTables::add_to_nodes(In<double> corner, Out<double> nodal) const {
  const int columns = corner.cols;
  for_each(mesh_.rest.rows(), [&](int64_t n) {
    for (int64_t k = first_corner_[size_t(n)]; k < first_corner_[size_t(n) + 1]; ++k)
      for (int d = 0; d < columns; ++d) nodal(n, d) += corner(corner_[size_t(k)], d);
  });
}

void ElementTables::add_forces(const std::function<void(int64_t, double*)>& force,
                               Out<double> g) const {
  const int nodes = nodes_of(mesh_.element);
  Array<double> forces(mesh_.elements.size(), 3);
  for_each(
      mesh_.elements.rows(), [&](int64_t k) { force(k, forces.row(k * nodes)); }, kElementBlock);
  add_to_nodes(forces, g);
}

void ElementTables::check_nodal(In<double> u) const {
  ELASTOGEN_CHECK(u.is(mesh_.rest.rows(), 3), "nodal values must be (", mesh_.rest.rows(),
                  ", 3), got ", u);
}

}  // namespace elastogen::fem
