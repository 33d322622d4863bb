// SPDX-License-Identifier: Apache-2.0
// Floor and colliders in a picture, where they are at a time.

#pragma once

#include "cli/picture/camera.hpp"
#include "cli/picture/canvas.hpp"
#include "cli/picture/sun.hpp"
#include "io/collider_mesh.hpp"

#include <optional>

namespace elastogen {

/// Drawn in three steps: move, see and draw. draw may run for several canvases at once.
class Stage {
 public:
  /// @param colliders  must outlive it.
  /// @param seen       box of all positions of the body [m].
  Stage(const std::vector<Collider>& colliders, const UpAxis& up, const Box& seen);

  /// Moves the colliders to where they are at a time [s].
  void move(double time);

  /// Whether shadows fall on anything.
  bool has_anything() const { return !grounds_.empty() || !solids_.empty(); }

  /// Adds to the box what a camera should see of the stage below a point of the body: its foot, if
  /// a floor is near below it.
  void add_foot(const Camera& camera, const Vec3& place, Box& box) const;
  /// Adds spheres and boxes to the box, as far as they are near the body.
  void add_solids(const Camera& camera, Box& box) const;

  void see(const Camera& camera);

  /// Draws sky, planes, spheres and boxes on an empty canvas.
  /// @param sun  null: no shadows.
  void draw(Canvas& canvas, const Sun* sun) const;

  /// Draws the depths of spheres and boxes.
  void cast(Canvas& canvas) const;

 private:
  /// A plane that faces up. It extends as far as the picture does.
  struct Ground {
    const Collider* collider;
    Vec3 point;  ///< point of the plane at that time [m]
  };
  /// Any other collider.
  struct Solid {
    const Collider* collider;
    ColliderMesh mesh;
    Vec3 offset;              ///< at that time [m]
    Array<double> projected;  ///< (vertices, 3)
    std::vector<float> lit;   ///< of each vertex
  };

  void draw_ground(const Ground& ground, Canvas& canvas, const Sun* sun) const;
  /// The light from a place on the ground.
  Light ground_light(const Ground& ground, const Vec3& place, const Sun* sun) const;
  void draw_solid(const Solid& solid, Canvas& canvas, const Sun* sun) const;
  Vec3 place(const Solid& solid, int64_t vertex) const;

  Box seen_;
  Vec3 up_;
  double size_ = 0;  ///< diagonal of the box [m]
  Camera camera_;
  std::vector<Ground> grounds_;
  std::vector<Solid> solids_;
};

}  // namespace elastogen
