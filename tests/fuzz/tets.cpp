// SPDX-License-Identifier: Apache-2.0
// Any bytes as a file of tetrahedra: the same mesh or the same reason twice, and a mesh has finite
// nodes, all of them used, and positive volumes between its corners.

#include "core/vec3.hpp"
#include "mpm_fem/fem/tet_mesh.hpp"
#include "mpm_fem/fem/tet_surface.hpp"
#include "tests/fuzz/harness.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace elastogen::fem {
namespace {

void check_mesh_of(const tets::TetFile& file, const ElementMesh& mesh) {
  using fuzz::require;
  // elements and their regions
  const int64_t count = mesh.elements.rows();
  require(count > 0 && mesh.elements.cols() == (mesh.element == Element::kTet10 ? 10 : 4),
          "there are tetrahedra");
  require(mesh.material.rows() == count && file.region.rows() == count, "each has a region");
  for (int64_t k = 0; k < mesh.rest.size(); ++k)
    require(std::isfinite(mesh.rest.data()[k]), "nodes are finite");
  // corners are nodes, volumes are positive, every node is used
  std::vector<bool> used(size_t(mesh.rest.rows()));
  for (int64_t e = 0; e < count; ++e) {
    require(size_t(file.region(e)) < file.region_ids.size(), "each has a region that is there");
    Vec3 x[4];
    for (int k = 0; k < mesh.elements.cols(); ++k) {
      const int32_t node = mesh.elements(e, k);
      require(node >= 0 && node < mesh.rest.rows(), "each has nodes that are there");
      used[size_t(node)] = true;
      if (k < 4) x[k] = {mesh.rest(node, 0), mesh.rest(node, 1), mesh.rest(node, 2)};
    }
    require(dot(minus(x[1], x[0]), cross(minus(x[2], x[0]), minus(x[3], x[0]))) > 0,
            "volumes are positive");
  }
  for (const bool is_used : used) require(is_used, "nodes are used");
  // the surface
  const Array<int32_t> surface = outer_triangles(mesh);
  for (int64_t k = 0; k < surface.size(); ++k)
    require(size_t(surface.data()[k]) < used.size(), "the surface has nodes that are there");
  require(mean_edge(mesh) > 0, "tetrahedra have a mean edge");
}

/// The mesh as one text, or the reason why there is none.
std::string read(std::string_view bytes) {
  try {
    tets::TetFile file = tets::parse_tets(bytes, "fuzz");
    const ElementMesh mesh = take_mesh(file);
    check_mesh_of(file, mesh);
    const auto text = [](const void* data, size_t size) {
      return std::string(static_cast<const char*>(data), size);
    };
    return concat(file.turned, ' ', file.skipped, ' ', file.unused, ' ',
                  text(mesh.rest.data(), size_t(mesh.rest.size()) * 8),
                  text(mesh.elements.data(), size_t(mesh.elements.size()) * 4));
  } catch (const Error& error) {
    fuzz::require_kind(error, ErrorKind::kAsset);
    return error.what();
  }
}

}  // namespace
}  // namespace elastogen::fem

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  fuzz::require(fem::read(bytes) == fem::read(bytes), "a file reads the same twice");
  return 0;
}
