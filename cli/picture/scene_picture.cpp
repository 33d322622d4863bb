// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/scene_picture.hpp"

#include "core/error.hpp"

namespace elastogen {
namespace {

void add_box(const Box& from, Box& to) {
  if (from.lower[0] > from.upper[0]) return;
  to.add(from.lower);
  to.add(from.upper);
}

void check_scene(const PictureScene& scene, const FrameSource& source,
                 const PictureOptions& options) {
  ELASTOGEN_CHECK(source.frames > 0 && !scene.framed.empty(), "there is no frame to draw");
  ELASTOGEN_CHECK(options.width > 0 && options.height > 0, "a picture needs a positive size, got ",
                  options.width, " x ", options.height);
}

}  // namespace

ScenePicture::ScenePicture(const PictureScene& scene, const FrameSource& source,
                           const PictureOptions& options)
    : scene_((check_scene(scene, source, options), scene)),
      source_(source),
      options_(options),
      positions_(source.points, 3),
      gradient_(scene.subject.needs_gradient() ? source.points : 0, 9),
      places_(all_places()),
      stage_(scene.colliders, scene.up, places_),
      seen_(all_seen()) {}

Vec3 ScenePicture::place(int32_t point) const {
  return {positions_(point, 0), positions_(point, 1), positions_(point, 2)};
}

Box ScenePicture::all_places() {
  Box box;
  for (int64_t f = 0; f < source_.frames; ++f) {
    source_.positions(f, positions_);
    for (const int32_t point : scene_.framed) box.add(place(point));
  }
  return box;
}

/// Directions of a frame's camera about the middle of all framed points.
Camera ScenePicture::directions(int64_t frame) const {
  const Vec3 pivot = scaled(plus(places_.lower, places_.upper), 0.5);
  return camera_of(options_.view, scene_.up, pivot, double(frame) / double(source_.frames));
}

Box ScenePicture::all_seen() {
  Box seen;
  for (int64_t f = 0; f < source_.frames; ++f) {
    const Camera camera = directions(f);
    source_.positions(f, positions_);
    stage_.move(double(f) / source_.fps);
    stage_.add_solids(camera, seen);
    // a box for each block; the order of joining them does not matter
    const auto count = int64_t(scene_.framed.size());
    std::vector<Box> boxes(size_t((count + kBlock - 1) / kBlock));
    for_blocks(count, [&](int64_t begin, int64_t end) {
      Box& box = boxes[size_t(begin / kBlock)];
      for (int64_t k = begin; k < end; ++k) {
        const Vec3 p = place(scene_.framed[size_t(k)]);
        box.add(camera.turn(p));
        stage_.add_foot(camera, p, box);
      }
    });
    for (const Box& box : boxes) add_box(box, seen);
  }
  return seen;
}

Camera ScenePicture::camera(int64_t frame) const {
  Camera camera = directions(frame);
  fit(camera, seen_, kSamples * options_.width, kSamples * options_.height,
      options_.view == View::kTurntable);
  return camera;
}

/// The shadow map of the frame that was read: heights of subject and solids seen from above.
std::optional<Sun> ScenePicture::shine() {
  if (!stage_.has_anything()) return std::nullopt;
  Camera above = camera_above(scene_.up, scaled(plus(places_.lower, places_.upper), 0.5));
  Box below;
  for (const int32_t point : scene_.framed) below.add(above.turn(place(point)));
  stage_.add_solids(above, below);
  fit(above, below, Sun::kEdge, Sun::kEdge, false);
  Sun sun(above);
  scene_.subject.see(above);
  stage_.see(above);
  for_strips(Sun::kEdge, Sun::kEdge, [&](Canvas& canvas) {
    stage_.cast(canvas);
    scene_.subject.cast(canvas);
    sun.take(canvas);
  });
  return sun;
}

Pixels ScenePicture::draw(int64_t frame) {
  source_.positions(frame, positions_);
  if (scene_.subject.needs_gradient()) source_.gradient(frame, gradient_);
  scene_.subject.pose(positions_, gradient_);
  stage_.move(double(frame) / source_.fps);
  const std::optional<Sun> sun = shine();
  const Camera view = camera(frame);
  scene_.subject.see(view);
  stage_.see(view);
  Pixels pixels(options_.width, options_.height);
  for_strips(kSamples * options_.width, kSamples * options_.height, [&](Canvas& canvas) {
    stage_.draw(canvas, sun ? &*sun : nullptr);
    scene_.subject.draw(canvas);
    develop(canvas, pixels);
  });
  return pixels;
}

}  // namespace elastogen
