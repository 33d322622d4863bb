// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/scene_picture.hpp"
#include "cli/png.hpp"
#include "core/error.hpp"
#include "tests/cli/picture_scenes.hpp"

#include <cmath>
#include <map>

namespace elastogen::test {
namespace {

TEST(Png, GivesBackEveryPixel) {
  Pixels picture(7, 5);
  for (size_t k = 0; k < picture.rgb.size(); ++k) picture.rgb[k] = uint8_t(37 * k);
  const Pixels back = decoded(encode_png(7, 5, picture.rgb));
  EXPECT_EQ(back.width, 7);
  EXPECT_EQ(back.height, 5);
  EXPECT_EQ(back.rgb, picture.rgb);
}

TEST(Png, RejectsPixelsThatDoNotFit) {
  EXPECT_THROW(encode_png(2, 2, std::vector<uint8_t>(11)), Error);
  EXPECT_THROW(encode_png(0, 2, {}), Error);
}

TEST(Picture, OfATriangleCoversItsShare) {
  // from above the longest edge of the box is 1 / 1.15 of the picture
  MeshScene scene({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}}, {0, 1, 2}, {kRed, kRed, kRed});
  const Pixels picture = scene.drawn(0, {View::kTop, 230, 230});
  const double edge = 200;
  // a border pixel counts from some light on: half of the border of (2 + sqrt(2)) edges at most
  EXPECT_NEAR(count(picture, [](const Rgb& c) { return !is_sky(c); }), edge * edge / 2,
              (2 + std::sqrt(2)) * edge / 2);
}

TEST(Picture, ShowsTheNearerSurface) {
  MeshScene scene = squares();
  const Pixels near_red = scene.drawn();
  for (Vec3& x : scene.asset.meshes[0].position) x[2] = -1 - x[2];
  scene.pose();
  const Pixels near_green = scene.drawn();
  EXPECT_GT(count(near_red, is_red), 1.2 * count(near_red, is_green));
  EXPECT_GT(count(near_green, is_green), 1.2 * count(near_green, is_red));
}

TEST(Picture, DoesNotDependOnTheWinding) {
  MeshScene scene = squares();
  const Pixels before = scene.drawn();
  std::vector<int32_t>& corner = scene.asset.meshes[0].groups[0].corner;
  for (size_t k = 0; k < corner.size(); k += 3) std::swap(corner[k], corner[k + 1]);
  scene.pose();
  EXPECT_EQ(scene.drawn().rgb, before.rgb);
}

TEST(Picture, DoesNotDependOnTheThreads) {
  MeshScene scene = squares();
  scene.colliders = {half_space({0, 1, 0}, -0.2, 0.5)};
  const PictureOptions options = {View::kThreeQuarter, 200, 300};
  const Pixels many = scene.drawn(0, options);
  const ThreadLimit one(1);
  EXPECT_EQ(scene.drawn(0, options).rgb, many.rgb);
}

TEST(Picture, ScalesAsTheProjectionSays) {
  // far behind each other no square hides the other: red and green cover the same area
  const Pixels picture = squares(8).drawn(0, {View::kThreeQuarter, 200, 200});
  const int red = count(picture, is_red), green = count(picture, is_green);
  EXPECT_GT(red, 50);
  EXPECT_NEAR(double(green) / red, 1, 0.15);
}

TEST(Picture, KeepsOneCameraForAllFrames) {
  MeshScene scene = squares();
  Array<double>& moved = scene.add_frame();
  for (int n = 4; n < 8; ++n) moved(n, 0) += 3;
  const Pixels first = scene.drawn(0), last = scene.drawn(1);
  int same = 0;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      EXPECT_EQ(is_red(at(first, x, y)), is_red(at(last, x, y))) << x << ' ' << y;
      same += is_red(at(first, x, y));
    }
  EXPECT_GT(same, 20);
}

TEST(Picture, ShowsEveryVertexOfEveryFrameFromEverywhere) {
  MeshScene scene = squares(0.5);
  scene.add_frame({3, 2, -1});
  scene.add_frame({-7, 1, 2});
  for (const int up_axis : {0, 1, 2})
    for (const int sign : {1, -1})
      for (size_t view = 0; view < view_names().size(); ++view) {
        scene.up = {up_axis, sign};
        scene.use(
            [&](ScenePicture& picture) {
              double least = 1e300, most = -1e300, low = 1e300, high = -1e300;
              for (int64_t f = 0; f < 3; ++f)
                for (int64_t n = 0; n < 8; ++n) {
                  const double* x = scene.frames[size_t(f)].row(n);
                  const Vec3 p = picture.camera(f).project({x[0], x[1], x[2]});
                  least = std::min(least, p[0]), most = std::max(most, p[0]);
                  low = std::min(low, p[1]), high = std::max(high, p[1]);
                }
              EXPECT_GE(least, 0) << view_names()[view];
              EXPECT_GE(low, 0);
              EXPECT_LE(most, kSamples * 80);
              EXPECT_LE(high, kSamples * 50);
              if (View(view) == View::kTurntable) return;
              // and as near as that allows: one direction is filled but for the margin
              EXPECT_NEAR(
                  std::max((most - least) / (kSamples * 80), (high - low) / (kSamples * 50)),
                  1 / 1.15, 1e-9);
            },
            {View(view), 80, 50});
      }
}

TEST(Picture, IsSeenFromWhereTheViewSays) {
  // a point on the side of the camera is nearer than one on the other side
  struct Case {
    View view;
    Vec3 towards;
  };
  for (const Case& c : {Case{View::kFront, {0, 0, 1}},
                        {View::kBack, {0, 0, -1}},
                        {View::kLeft, {-1, 0, 0}},
                        {View::kRight, {1, 0, 0}},
                        {View::kTop, {0, 1, 0}},
                        {View::kThreeQuarter, {1, 1, 1}}}) {
    const Camera camera = camera_of(c.view, UpAxis{}, {});
    EXPECT_GT(camera.turn(c.towards)[2], 0.9) << view_names()[size_t(c.view)];
    EXPECT_NEAR(dot(cross(camera.right, camera.up), camera.back), 1, 1e-12);
    if (c.view != View::kTop) {
      EXPECT_GT(camera.turn({0, 1, 0})[1], 0.9 * (c.view != View::kThreeQuarter));
    }
  }
  // of an asset with z up the front looks to -y, as its GLB does
  EXPECT_GT(camera_of(View::kFront, UpAxis{2, 1}, {}).turn({0, -1, 0})[2], 0.9);
  EXPECT_GT(camera_of(View::kFront, UpAxis{2, 1}, {}).turn({0, 0, 1})[1], 0.9);
}

TEST(Picture, TurnsOnceAroundOnATurntable) {
  MeshScene scene = squares();
  for (int f = 1; f < 8; ++f) scene.add_frame();
  scene.use(
      [&](ScenePicture& picture) {
        const Camera first = picture.camera(0);
        for (int f = 0; f < 8; ++f) {
          const Camera camera = picture.camera(f);
          EXPECT_NEAR(dot(camera.right, first.right), std::cos(f * std::acos(-1.) / 4), 1e-12);
          EXPECT_NEAR(camera.right[1], 0, 1e-12);
          EXPECT_EQ(camera.scale, first.scale);
        }
        EXPECT_NE(picture.draw(0).rgb, picture.draw(2).rgb);
      },
      {View::kTurntable, 64, 64});
}

bool is_shadow(const Rgb& c) {
  return c[0] < 180 && c[0] > 100 && std::abs(c[0] - c[1]) < 12 && std::abs(c[1] - c[2]) < 12;
}

TEST(Picture, DrawsGroundAndShadowBelowTheBody) {
  MeshScene scene = squares();
  const Rgb sky = at(scene.drawn(), 2, 40);
  scene.colliders = {half_space({0, 1, 0}, -0.5, 0.5)};
  const Rgb ground = at(scene.drawn(), 2, 40);
  EXPECT_LT(ground[0], sky[0]);
  // a flat plate casts a shadow of its own area
  for (int n = 0; n < 8; ++n)
    scene.asset.meshes[0].position[size_t(n)] = {double(n & 1), 0, double(n >> 1 & 1)};
  scene.pose();
  scene.colliders = {half_space({0, 1, 0}, -1.2, 0.5)};
  const Pixels plate = scene.drawn(0, {View::kThreeQuarter, 128, 128});
  const int body = count(plate, is_red) + count(plate, is_green);
  EXPECT_GT(body, 800);
  EXPECT_NEAR(count(plate, is_shadow), body, 0.15 * body);
}

TEST(Picture, DrawsCollidersWhereTheyAreAtTheTime) {
  MeshScene scene = squares();
  scene.add_frame();
  Collider ball;
  ball.shape = Collider::Shape::kSphere;
  ball.radius = 0.3;
  ball.centre = {0.5, 0.5, 1};
  ball.path = {{0, {}}, {1.0 / 30, {1.5, 0, 0}}};
  scene.colliders = {ball};
  const PictureOptions front = {View::kFront, 100, 100};
  const Pixels before = scene.drawn(0, front), after = scene.drawn(1, front);
  // it hides 9 pi / 100 of the red square, then nothing of it
  EXPECT_NEAR(double(count(before, is_red)) / count(after, is_red), 1 - 0.09 * std::acos(-1.),
              0.03);
  // a plane is seen from its free side only
  for (const double facing : {1., -1.}) {
    Collider wall = half_space({0, 0, facing}, -facing * 2, 0.5);
    wall.centre = {0, 0, -2};
    scene.colliders = {wall};
    const Rgb corner = at(scene.drawn(0, front), 50, 2);
    EXPECT_EQ(is_sky(corner), facing < 0);
  }
}

TEST(Picture, BlendsFromBackToFront) {
  // a green plane behind a red one, both half transparent, before the sky
  MeshScene scene = squares();
  for (auto& colour : scene.asset.meshes[0].colour) colour[3] = 0.5f;
  scene.asset.materials.push_back({"", {1, 1, 1, 0.999f}, "", false});
  scene.asset.meshes[0].groups[0].material = 0;
  for (int n = 4; n < 8; ++n) scene.asset.meshes[0].position[size_t(n)][2] = -0.001;
  scene.pose();
  const auto middle = [&](View view) { return at(scene.drawn(0, {view, 64, 64}), 32, 32); };
  const Rgb front = middle(View::kFront), back = middle(View::kBack);
  EXPECT_GT(front[0], front[1]);
  EXPECT_GT(back[1], back[0]);
  EXPECT_GT(front[2], 60);  // a quarter of the sky's light comes through
  EXPECT_LT(front[2], 150);
}

TEST(Picture, OfACubeHasThreeEvenFaces) {
  std::vector<Vec3> corner;
  for (int n = 0; n < 8; ++n) corner.push_back({double(n & 1), double(n >> 1 & 1), double(n >> 2)});
  MeshScene cube(corner, {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                          2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5});
  const Pixels picture = cube.drawn(0, {View::kThreeQuarter, 100, 100});
  std::map<Rgb, int> colours;
  for (int y = 0; y < 100; ++y)
    for (int x = 0; x < 100; ++x) ++colours[at(picture, x, y)];
  int large = 0, pixels = 0;
  for (const auto& [colour, number] : colours)
    if (number > 300) ++large, pixels += number;
  EXPECT_EQ(large, 4);      // and the sky
  EXPECT_GT(pixels, 9500);  // all but the edges
}

TEST(Picture, RejectsWhatItsDocumentationForbids) {
  MeshScene scene = squares();
  EXPECT_THROW(scene.drawn(0, {View::kFront, 0, 64}), Error);
  EXPECT_THROW(scene.drawn(0, {View::kFront, 64, -1}), Error);
  scene.framed.clear();
  EXPECT_THROW(scene.drawn(), Error);
  scene = squares();
  scene.frames.clear();
  EXPECT_THROW(scene.drawn(), Error);
}

}  // namespace
}  // namespace elastogen::test
