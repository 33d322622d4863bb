// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/smooth_corners.hpp"
#include "io/texture.hpp"
#include "tests/cli/picture_scenes.hpp"
#include "tests/io/image_files.hpp"
#include "tests/io/test_files.hpp"

namespace elastogen::test {
namespace {

/// A square seen from the front with the whole image on it, v down as glTF has it.
MeshScene textured_square(const std::string& image) {
  MeshScene scene({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}, {0, 1, 3, 0, 3, 2});
  scene.asset.meshes[0].uv = {{0, 1}, {1, 1}, {0, 0}, {1, 0}};
  scene.asset.materials.push_back({"skin", {1, 1, 1, 1}, image, false});
  scene.asset.meshes[0].groups[0].material = 0;
  scene.asset.path = "square.obj";
  scene.pose();
  return scene;
}

TEST(Texture, StandsUprightOnTheSurface) {
  const TempFolder folder;
  std::vector<uint8_t> rgba;
  for (int k = 0; k < 64; ++k) {
    const bool right = k % 8 >= 4, below = k / 8 >= 4;  // red, green; blue, white
    rgba.insert(rgba.end(), {uint8_t(right == below ? 255 : 0), uint8_t(right ? 255 : 0),
                             uint8_t(below ? 255 : 0), 255});
  }
  MeshScene scene = textured_square(folder.write("a.png", png_of(8, 8, rgba)));
  const Pixels picture = scene.drawn(0, {View::kFront, 100, 100});
  EXPECT_TRUE(scene.notes.empty());
  // the middles of the quarters of the square, which is 1 / 1.15 of the picture
  EXPECT_TRUE(is_red(at(picture, 28, 28)));
  EXPECT_TRUE(is_green(at(picture, 71, 28)));
  const Rgb blue = at(picture, 28, 71), white = at(picture, 71, 71);
  EXPECT_TRUE(blue[2] > 60 && blue[0] < 20 && blue[1] < 20);
  EXPECT_TRUE(white[0] > 60 && white[0] == white[1] && white[1] == white[2]);
}

TEST(Texture, ThatIsDamagedIsANoteAndTheBaseColour) {
  const TempFolder folder;
  for (const std::string& bytes :
       {four_colours().substr(0, 60), std::string("\xff\xd8\xff\xe0 no JPEG"),
        std::string("RIFF\x10\0\0\0WEBPVP8 ", 16) + "xxxx",
        std::string("\xabKTX 20\xbb\r\n\x1a\n")}) {
    MeshScene scene = textured_square(folder.write("broken.png", bytes));
    scene.asset.materials[0].base_colour = {1, 0, 0, 1};
    EXPECT_TRUE(is_red(at(scene.drawn(0, {View::kFront, 64, 64}), 32, 32)));
    ASSERT_EQ(scene.notes.size(), 1u);
    expect_says(scene.notes[0], "broken.png");
    expect_says(scene.notes[0], "base colour");
  }
}

TEST(Texture, WrapsAsItIsTold) {
  // one row: black, white
  const Texture texture({2, 1, {0, 0, 0, 255, 255, 255, 255, 255}});
  const auto at = [&](float u, Wrap wrap) { return texture.at(0, u, 0.5f, {wrap, wrap})[0]; };
  for (const Wrap wrap : {Wrap::kRepeat, Wrap::kClamp, Wrap::kMirror}) {
    EXPECT_EQ(at(0.25f, wrap), 0);
    EXPECT_EQ(at(0.75f, wrap), 1);
    EXPECT_FLOAT_EQ(at(0.5f, wrap), 0.5f);  // halfway in light
  }
  EXPECT_EQ(at(1.25f, Wrap::kRepeat), 0);
  EXPECT_EQ(at(1.25f, Wrap::kClamp), 1);
  EXPECT_EQ(at(1.25f, Wrap::kMirror), 1);
  EXPECT_EQ(at(-0.25f, Wrap::kRepeat), 1);
  EXPECT_EQ(at(-0.25f, Wrap::kClamp), 0);
  EXPECT_EQ(at(-0.25f, Wrap::kMirror), 0);
  EXPECT_TRUE(std::isfinite(at(1e30f, Wrap::kRepeat)));
}

TEST(Texture, SmallSizesAreMeansOfLight) {
  Image image{4, 4, {}};
  for (int k = 0; k < 16; ++k)
    for (int c = 0; c < 4; ++c)
      image.rgba.push_back(c == 3 || (k + k / 4) % 2 ? 255 : 0);  // a chessboard
  const Texture texture(image);
  EXPECT_EQ(texture.level(0.1), 0);
  EXPECT_EQ(texture.level(4), 1);
  EXPECT_EQ(texture.level(1e9), 2);
  // half of the light, rounded to a byte of sRGB (188)
  EXPECT_NEAR(texture.at(2, 0.5f, 0.5f, {})[0], 0.5, 0.005);
  EXPECT_EQ(texture.at(2, 0.5f, 0.5f, {})[3], 1);
}

TEST(Texture, WithoutAlphaIsNotThereWhereItIsMasked) {
  const TempFolder folder;
  std::vector<uint8_t> rgba(4 * 4 * 4, 255);
  for (size_t k = 0; k < 8; ++k) rgba[4 * k + 3] = 0;  // the upper half
  folder.write("half.png", png_of(4, 4, rgba));
  MeshScene scene = textured_square("");
  scene.asset.format = "gltf";
  scene.asset.path = folder.write(
      "a.gltf",
      "{\"asset\": {\"version\": \"2.0\"}, \"images\": [{\"uri\": \"half.png\"}], \"textures\": "
      "[{\"source\": 0}], \"materials\": [{\"alphaMode\": \"MASK\", \"pbrMetallicRoughness\": "
      "{\"baseColorTexture\": {\"index\": 0}}}]}");
  const Pixels picture = scene.drawn(0, {View::kFront, 64, 64});
  EXPECT_TRUE(is_sky(at(picture, 32, 16)));
  EXPECT_FALSE(is_sky(at(picture, 32, 48)));
}

/// Number of normals along the edge where two squares of a strip meet at an angle.
int64_t normals_at(double degrees, bool split, const std::vector<std::array<float, 3>>& file = {}) {
  const double angle = degrees * std::acos(-1.) / 180;
  std::vector<Vec3> x = {{-1, 0, 0}, {-1, 0, 1}, {0, 0, 0}, {0, 0, 1}};
  const Vec3 far = {std::cos(angle), -std::sin(angle), 0};
  x.push_back(far);
  x.push_back({far[0], far[1], 1});
  std::vector<int32_t> corner = {0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4};
  if (split) {  // a seam: the second square has vertices of its own there
    x.push_back(x[2]), x.push_back(x[3]);
    for (size_t k = 6; k < 12; ++k) corner[k] = corner[k] == 2 ? 6 : corner[k] == 3 ? 7 : corner[k];
  }
  const MeshScene scene(x, corner);
  return smooth_corners(scene.surface, file).normals;
}

TEST(SmoothCorners, JoinAcrossSeamsAndPartAtEdges) {
  // every vertex has one normal where all is smooth, those of the edge have two where it is not
  for (const bool split : {false, true}) {
    EXPECT_EQ(normals_at(30, split), 6);
    EXPECT_EQ(normals_at(80, split), 8);
  }
}

TEST(SmoothCorners, FollowTheNormalsOfTheFile) {
  const std::array<float, 3> up = {0, 1, 0}, side = {1, 0, 0};
  std::vector<std::array<float, 3>> agreed(12, up), apart(12, up);
  for (size_t k = 6; k < 12; ++k) apart[k] = side;
  EXPECT_EQ(normals_at(60, true, agreed), 6);
  EXPECT_EQ(normals_at(20, true, apart), 8);
}

}  // namespace
}  // namespace elastogen::test
