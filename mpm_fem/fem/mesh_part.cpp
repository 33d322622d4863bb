// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/mesh_part.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// Some rows of a table; empty if the table is.
template <class T>
Array<T> rows_of(const Array<T>& table, const std::vector<int64_t>& rows) {
  if (table.empty()) return {};
  Array<T> result(int64_t(rows.size()), table.cols());
  for (size_t k = 0; k < rows.size(); ++k)
    std::copy_n(table.row(rows[k]), table.cols(), result.row(int64_t(k)));
  return result;
}

}  // namespace

ElementMesh part_of(const ElementMesh& mesh, const std::vector<bool>& wanted) {
  std::vector<int64_t> elements;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    const auto m = size_t(mesh.material(e));
    if (m < wanted.size() && wanted[m]) elements.push_back(e);
  }
  return some_elements(mesh, elements);
}

ElementMesh some_elements(const ElementMesh& mesh, const std::vector<int64_t>& elements) {
  ElementMesh part;
  part.element = mesh.element;
  part.rest = mesh.rest;
  part.elements = rows_of(mesh.elements, elements);
  part.material = rows_of(mesh.material, elements);
  part.fill = rows_of(mesh.fill, elements);
  part.part = rows_of(mesh.part, elements);
  part.h = mesh.h;
  part.shape_mean = rows_of(mesh.shape_mean, elements);
  part.variance = rows_of(mesh.variance, elements);
  part.hourglass = mesh.hourglass;
  return part;
}

}  // namespace elastogen::fem
