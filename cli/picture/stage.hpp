// SPDX-License-Identifier: Apache-2.0
// Floor and colliders in a picture, at their places at a time.

#pragma once

#include "cli/picture/camera.hpp"
#include "cli/picture/canvas.hpp"
#include "cli/picture/sun.hpp"
#include "io/collider_mesh.hpp"

#include <optional>

namespace elastogen {

/// Drawn in three steps: move, see, and draw, which may be called for several canvases at once.
class Stage {
 public:
  /// @param colliders  must outlive it.
  /// @param seen       all places of the body [m].
  Stage(const std::vector<Collider>& colliders, const UpAxis& up, const Box& seen);

  /// To where the colliders are at a time [s].
  void move(double time);

  /// Whether shadows fall on anything.
  bool has_anything() const { return !grounds_.empty() || !solids_.empty(); }

  /// Adds what a camera should see of it while the body is at a place: its foot where a floor is
  /// near below it.
  void add_foot(const Camera& camera, const Vec3& place, Box& box) const;
  /// The same of spheres and boxes, as far as they are near the body.
  void add_solids(const Camera& camera, Box& box) const;

  void see(const Camera& camera);

  /// Draws on a canvas that shows nothing yet: the sky, planes, spheres and boxes.
  /// @param sun  null: no shadows.
  void draw(Canvas& canvas, const Sun* sun) const;

  /// Draws the depths of spheres and boxes.
  void cast(Canvas& canvas) const;

 private:
  /// A plane that faces up: it is seen as far as the picture goes.
  struct Ground {
    const Collider* collider;
    Vec3 point;  ///< of the plane, at the time [m]
  };
  /// Anything else.
  struct Solid {
    const Collider* collider;
    ColliderMesh mesh;
    Vec3 offset;              ///< at the time [m]
    Array<double> projected;  ///< (vertices, 3)
    std::vector<float> lit;   ///< of each vertex
  };

  void draw_ground(const Ground& ground, Canvas& canvas, const Sun* sun) const;
  /// What light comes from a place of it.
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
