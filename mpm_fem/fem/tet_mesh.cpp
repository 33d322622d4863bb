// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/tet_mesh.hpp"

namespace elastogen::fem {

ElementMesh take_mesh(tets::TetFile& file) {
  ElementMesh mesh;
  mesh.element = file.elements.cols() == 10  ? Element::kTet10
                 : file.elements.cols() == 4 ? Element::kTet4
                                             : Element::kTri3;
  mesh.rest = std::move(file.rest);
  mesh.elements = std::move(file.elements);
  mesh.material = Array<int32_t>(mesh.elements.rows());
  return mesh;
}

}  // namespace elastogen::fem
