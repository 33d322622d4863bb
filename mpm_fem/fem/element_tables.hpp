// SPDX-License-Identifier: Apache-2.0
// The elements of a mesh without their law: shape gradients and weights at quadrature points, and
// the sum of the forces on their corners.

#pragma once

#include "mpm_fem/fem/element_state.hpp"

#include <functional>
#include <vector>

namespace elastogen::fem {

class ElementTables {
 public:
  /// @throws Error as check_mesh.
  explicit ElementTables(const ElementMesh& mesh);

  const ElementMesh& mesh() const { return mesh_; }
  int points() const { return weight_.cols(); }  ///< of an element

  /// One element under displacements u [m], (nodes, 3).
  ElementState state(int64_t element, In<double> u) const;

  /// Rest volume of an element, fill included [m^3].
  double volume(int64_t element) const;

  /// Adds the values of all corners to their nodes, at each node in the order of the elements.
  /// @param corner  value of node a of element e in row e nodes_of(element) + a, (corners, n)
  /// @param nodal   (nodes, n)
  void add_to_nodes(In<double> corner, Out<double> nodal) const;

  /// Adds forces on the corners of all elements to g [N], (nodes, 3).
  /// @param force  adds those of an element to f, (nodes_of(element), 3)
  void add_forces(const std::function<void(int64_t element, double* f)>& force,
                  Out<double> g) const;

  /// @throws Error unless nodal values are (nodes, 3).
  void check_nodal(In<double> u) const;

 private:
  int64_t shape_of(int64_t element) const {
    if (!shape_.empty()) return shape_[size_t(element)];
    return gradient_.rows() == 1 ? 0 : element;
  }
  std::vector<int64_t> find_shapes();
  void fill_gradients();
  void fill_neighbours();

  ElementMesh mesh_;

  // filled by fill_gradients; one row for all elements if they have one shape, with parts of voxels
  // those that shape_ says
  Array<double> gradient_;  ///< dN_a/dX at the quadrature points [1/m], (shapes, points nodes 3)
  Array<double> weight_;    ///< quadrature weights without the fill [m^3], (shapes, points)
  std::vector<int32_t> shape_;  ///< of each element; empty: see above

  // filled by fill_neighbours: the corners of elements that meet in a node, in the order of the
  // elements
  std::vector<int64_t> first_corner_;  ///< where the corners of each node begin, (nodes + 1)
  std::vector<int64_t> corner_;        ///< nodes_of(element) times the element, plus the corner
};

inline constexpr int64_t kElementBlock = 64;  ///< elements of a task

/// Sum over the elements of values (elements, 1), in a fixed order.
double total(const Array<double>& values);

}  // namespace elastogen::fem
