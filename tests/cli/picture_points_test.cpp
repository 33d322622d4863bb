// SPDX-License-Identifier: Apache-2.0
// Pictures of points and splats.
#include "cli/picture/scene_picture.hpp"
#include "tests/cli/picture_scenes.hpp"

#include <cmath>

namespace elastogen::test {
namespace {

/// A camera of the front, 1 sample a metre, its middle in the middle of 200 x 200 samples.
Camera plain_camera() {
  Camera camera;
  camera.middle = {100, 100};
  return camera;
}

Canvas dark() {
  return Canvas(200, 0, 200);
}

SplatCloud splat(const std::vector<Vec3>& places, float scale, float opacity) {
  SplatCloud splats;
  splats.position = places;
  splats.scale.assign(places.size(), {scale, scale, scale});
  splats.rotation.assign(places.size(), {1, 0, 0, 0});
  splats.opacity.assign(places.size(), opacity);
  splats.harmonics.assign(3 * places.size(), 0);
  return splats;
}

/// First coefficients of a colour 0 ... 1: colour = 1/2 + c / (2 sqrt(pi)).
float coefficient(double colour) {
  return float((colour - 0.5) * 2 * std::sqrt(std::acos(-1.)));
}

void draw(const SplatCloud& splats, Canvas& canvas, const Array<double>& gradient) {
  const auto subject = make_splat_subject(splats, 1);
  const auto points = int64_t(splats.position.size());
  Array<double> positions(points, 3);
  for (int64_t p = 0; p < points; ++p)
    std::copy_n(splats.position[size_t(p)].begin(), 3, positions.row(p));
  subject->pose(positions, gradient);
  subject->see(plain_camera());
  subject->draw(canvas);
}

Array<double> identities(int64_t points, double stretch = 1) {
  Array<double> gradient(points, 9);
  for (int64_t p = 0; p < points; ++p)
    for (int d = 0; d < 3; ++d) gradient(p, 4 * d) = d == 0 ? stretch : 1;
  return gradient;
}

/// sRGB of a share of light.
double srgb(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

TEST(SplatPicture, IsAGaussianOfItsWidth) {
  SplatCloud splats = splat({{0.5, -0.5, 0}}, 12, 0.8f);
  for (float& c : splats.harmonics) c = coefficient(1);
  for (const double stretch : {1., 1.5}) {
    Canvas canvas = dark();
    draw(splats, canvas, identities(1, stretch));
    for (const int away : {0, 5, 10, 20}) {
      // white splats on black show alpha; their variance is s^2 plus that of a pixel
      const auto expected = [&](double s) {
        return 0.8 * std::exp(-away * away / (2 * (s * s + 0.3 * kSamples * kSamples)));
      };
      EXPECT_NEAR(srgb(canvas.light[canvas.sample(100 + away, 100)][0]), expected(12 * stretch),
                  2e-3);
      EXPECT_NEAR(srgb(canvas.light[canvas.sample(100, 100 - away)][1]), expected(12), 2e-3);
    }
  }
}

TEST(SplatPicture, BlendsFromBackToFront) {
  // given from front to back and in reverse: red lies in front of green
  for (const bool turned : {false, true}) {
    SplatCloud splats = splat({{0, 0, turned ? -5. : 5.}, {0, 0, turned ? 5. : -5.}}, 20, 0.5f);
    for (int k = 0; k < 6; ++k)
      splats.harmonics[size_t(k)] = coefficient(k == (turned ? 3 : 0) || k == (turned ? 1 : 4));
    Canvas canvas = dark();
    draw(splats, canvas, identities(2));
    const Light& middle = canvas.light[canvas.sample(100, 100)];
    EXPECT_NEAR(srgb(middle[0]), 0.5, 5e-3);
    EXPECT_NEAR(srgb(middle[1]), 0.25, 5e-3);
    EXPECT_NEAR(srgb(middle[2]), 0, 5e-3);
  }
}

TEST(SplatPicture, IsHiddenByWhatIsNearer) {
  Canvas canvas = dark();
  std::fill(canvas.depth.begin(), canvas.depth.end(), 1.0f);
  SplatCloud splats = splat({{0, 0, 0}}, 20, 0.9f);
  draw(splats, canvas, identities(1));
  for (const Light& light : canvas.light) EXPECT_EQ(light, Light{});
}

TEST(SplatPicture, HasTheColourOfItsView) {
  // degree 1: -0.4886 y, 0.4886 z, -0.4886 x of the direction from the camera, here -z
  SplatCloud splats = splat({{0, 0, 0}}, 20, 0.999f);
  splats.degree = 1;
  splats.harmonics.assign(12, 0);
  splats.harmonics[3 * 2] = -0.5f;
  Canvas canvas = dark();
  draw(splats, canvas, identities(1));
  const Light& middle = canvas.light[canvas.sample(100, 100)];
  EXPECT_NEAR(srgb(middle[0]), 0.5 + 0.5 * 0.4886025, 5e-3);
  EXPECT_NEAR(srgb(middle[1]), 0.5, 5e-3);
}

/// A lattice of points of edge 1 in a plane.
PointCloud plate(Array<double>& rest) {
  PointCloud cloud;
  for (int k = 0; k < 400; ++k)
    cloud.position.push_back({5. * (k % 20) - 50, 5. * (k / 20) - 50, 0});
  rest = Array<double>(400, 3);
  for (int64_t p = 0; p < 400; ++p) std::copy_n(cloud.position[size_t(p)].begin(), 3, rest.row(p));
  return cloud;
}

Canvas drawn(const PointCloud& cloud, const Array<double>& rest, const Array<double>& gradient) {
  const auto subject = make_point_subject(cloud, rest);
  EXPECT_EQ(subject->needs_gradient(), !cloud.normal.empty());
  subject->pose(rest, gradient);
  subject->see(plain_camera());
  Canvas canvas = dark();
  subject->draw(canvas);
  return canvas;
}

TEST(PointPicture, ClosesTheSpacingWithItsColours) {
  Array<double> rest;
  PointCloud cloud = plate(rest);
  cloud.colour.assign(400, {1, 0.25f, 0, 1});
  const Canvas canvas = drawn(cloud, rest, {});
  for (int y = 60; y < 140; ++y)
    for (int x = 60; x < 140; ++x)
      EXPECT_EQ(canvas.light[canvas.sample(x, y)], (Light{1, 0.25f, 0}));
  EXPECT_EQ(canvas.depth[canvas.sample(5, 5)], kNothing);
}

TEST(PointPicture, IsLitByTurnedNormals) {
  Array<double> rest;
  PointCloud cloud = plate(rest);
  cloud.normal.assign(400, {0, 0, 1});
  cloud.colour.assign(400, {1, 1, 1, 1});
  // a quarter turn about x maps z to -y: lit like a face that looks down
  Array<double> gradient(400, 9);
  for (int64_t p = 0; p < 400; ++p) gradient(p, 0) = gradient(p, 7) = 1, gradient(p, 5) = -1;
  const float facing = drawn(cloud, rest, identities(400)).light[100 * 200 + 100][0];
  const float down = drawn(cloud, rest, gradient).light[100 * 200 + 100][0];
  EXPECT_FLOAT_EQ(facing, light_on({0, 0, 1}));
  EXPECT_FLOAT_EQ(down, light_on({0, -1, 0}));
  EXPECT_LT(down, 0.7f * facing);
}

TEST(PointPicture, WithoutColourIsDarkerFurtherAway) {
  Array<double> rest;
  const PointCloud cloud = plate(rest);
  for (int64_t p = 0; p < 400; ++p) rest(p, 2) = rest(p, 0);
  const Canvas canvas = drawn(cloud, rest, {});
  EXPECT_GT(canvas.light[canvas.sample(140, 100)][0], 2 * canvas.light[canvas.sample(60, 100)][0]);
}

}  // namespace
}  // namespace elastogen::test
