// SPDX-License-Identifier: Apache-2.0
// Some elements of a mesh, on all of its nodes.

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"

#include <vector>

namespace elastogen::fem {

/// The elements whose materials are wanted, in their order.
/// @param wanted  of each material; elements with a material index beyond it are left out
ElementMesh part_of(const ElementMesh& mesh, const std::vector<bool>& wanted);
/// Some elements, by their numbers.
ElementMesh some_elements(const ElementMesh& mesh, const std::vector<int64_t>& elements);

}  // namespace elastogen::fem
