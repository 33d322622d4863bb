// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/contact/contact_points.hpp"

#include "core/point_contact.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// Points of the scene's surface; their carriers and stiffness are to be set by the caller.
ContactPoints points_of(const Scene& scene, int carriers) {
  const SurfacePoints& s = scene.surface;
  ContactPoints points;
  points.area = s.area;
  points.position = s.position;
  points.layer = contact_layer(scene);
  points.slip_range = slip_range(scene);
  points.nodes = Array<int32_t>(s.position.rows(), carriers);
  points.stiffness = Array<double>(s.position.rows());
  return points;
}

}  // namespace

ContactPoints voxel_contact(const Scene& scene) {
  const SurfacePoints& s = scene.surface;
  ContactPoints points = points_of(scene, 8);
  points.weights = s.weights;
  for (int64_t p = 0; p < s.voxel.rows(); ++p) {
    std::copy_n(scene.grid.corners.row(s.voxel(p)), 8, points.nodes.row(p));
    const Material& m = scene.materials[size_t(scene.material(s.voxel(p)))];
    const double held = contact_young(m, scene.impact_speed);
    points.stiffness(p) = contact_stiffness(held, points.layer, scene.grid.h);
  }
  return points;
}

ContactPoints node_contact(const Scene& scene, const ElementMesh& mesh, In<int32_t> nodes) {
  std::vector<double> young(size_t(mesh.rest.rows()));
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int64_t c = 0; c < mesh.elements.cols(); ++c) {
      double& largest = young[size_t(mesh.elements(e, c))];
      const Material& m = scene.materials[size_t(mesh.material(e))];
      largest = std::max(largest, contact_young(m, scene.impact_speed));
    }
  ContactPoints points = points_of(scene, 1);
  points.weights = Array<double>(nodes.rows);
  points.weights.fill(1);
  for (int64_t p = 0; p < nodes.rows; ++p) {
    points.nodes(p) = nodes(p);
    points.stiffness(p) = contact_stiffness(young[size_t(nodes(p))], points.layer, scene.grid.h);
  }
  return points;
}

}  // namespace elastogen::fem
