// SPDX-License-Identifier: Apache-2.0
#include "scene/carried_points.hpp"

#include "scene/pins.hpp"
#include "voxelize/labels.hpp"

#include <algorithm>

namespace elastogen {

CarriedPoints carried_points(const Setup& setup) {
  CarriedPoints points;
  points.count = setup.body.carried.rows();
  if (setup.tets || setup.particles)
    points.node_of = &setup.node_of;
  else
    points.embedding = embed(setup.scene.grid, setup.body.carried, parts_of_carried(setup.body));
  if (setup.tets)  // nodes behind borders move as their elements need it
    points.moved = points_behind(setup.borders, setup.body.surface.box, setup.body.carried);
  if (points.node_of) return points;
  points.moved = rest_behind(setup.borders, setup.body.surface.box, setup.body.carried,
                             points.embedding.weights);
  for (const HeldPoint& held : setup.held_points) {
    std::fill_n(points.embedding.weights.row(held.point), 8, 0.0);
    points.moved.push_back(held);
  }
  std::erase_if(points.moved, [&](const HeldPoint& point) {
    return !setup.scene.holders[size_t(point.holder)].moves();
  });
  return points;
}

void place_moved(const CarriedPoints& points, const Setup& setup, double time,
                 Array<double>& displacement, Array<double>* gradient) {
  for (const auto& [point, number] : points.moved) {
    const Holder& holder = setup.scene.holders[size_t(number)];
    const double* X = setup.body.carried.row(point);
    const Vec3 motion = held_displacement(holder, {X[0], X[1], X[2]}, time);
    std::ranges::copy(motion, displacement.row(point));
    if (gradient) std::ranges::copy(held_rotation(holder, time), gradient->row(point));
  }
}

NodeFrames::NodeFrames(const VoxelGrid& grid, const CarriedPoints& points, bool with_gradient)
    : grid_(grid), points_(points) {
  for (Frame& frame : frames_) {
    frame.displacement = Array<double>(points.count, 3);
    if (with_gradient) frame.gradient = Array<double>(points.count, 9);
  }
}

int64_t NodeFrames::make(In<double> x) {
  Frame& frame = frames_[count_ % 2];
  if (points_.node_of) {
    for (int64_t p = 0; p < points_.count; ++p)
      for (int d = 0; d < 3; ++d) {
        const int32_t node = (*points_.node_of)(p);
        frame.displacement(p, d) = x(node, d) - grid_.rest(node, d);
      }
    return count_++;
  }
  const In<double> of_grid = {x.data, grid_.node_count(), 3};
  deform_asset(grid_, points_.embedding, of_grid, frame.displacement);
  if (!frame.gradient.empty())
    deformation_gradient(grid_, points_.embedding, of_grid, frame.gradient);
  return count_++;
}

CarriedFrame NodeFrames::take(int64_t number) const {
  const Frame& frame = frames_[number % 2];
  return {frame.displacement.data(), frame.gradient.empty() ? nullptr : frame.gradient.data()};
}

}  // namespace elastogen
