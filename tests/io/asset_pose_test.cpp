// SPDX-License-Identifier: Apache-2.0
#include "io/asset_pose.hpp"

#include "tests/io/test_files.hpp"

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

constexpr const char* kNames[] = {"x", "y", "z", "-x", "-y", "-z"};

Asset asset_of(const std::string& format, int up = 0, double unit = 0) {
  Asset asset;
  asset.format = format;
  asset.up = up;
  asset.unit = unit;
  return asset;
}

TEST(AssetPose, NamesAreReadAsTheyAreWritten) {
  for (const char* name : kNames) EXPECT_EQ(up_name(up_from_name(name).value()), name);
  EXPECT_FALSE(up_from_name("auto"));
  for (const char* wrong : {"", "w", "+y", "xy", "-"})
    expect_says(error_of([&] { up_from_name(wrong); }, ErrorKind::kUsage), "-x, -y, -z");
}

TEST(AssetPose, UpIsAskedForThenStatedThenGuessed) {
  const UpChoice asked = choose_up(asset_of("glb", 2), UpAxis{0, -1});
  EXPECT_EQ(up_name(asked.up), "-x");
  EXPECT_FALSE(asked.from.guessed);
  const UpChoice stated = choose_up(asset_of("las", -2), std::nullopt);
  EXPECT_EQ(up_name(stated.up), "-y");
  EXPECT_FALSE(stated.from.guessed);
  for (const auto& [format, up] :
       {std::pair{"stl", "z"}, {"las", "z"}, {"obj", "y"}, {"ply", "y"}, {"xyz", "y"}}) {
    const UpChoice guess = choose_up(asset_of(format), std::nullopt);
    EXPECT_EQ(up_name(guess.up), up) << format;
    EXPECT_TRUE(guess.from.guessed);
    EXPECT_FALSE(guess.from.reason.empty());
  }
}

TEST(AssetPose, AGuessedSizeThatLooksWrongIsAWarning) {
  for (const double edge : {1e-3, 0.2, 100.})
    EXPECT_EQ(choose_size(asset_of("obj"), edge, false).warning, "") << edge;
  for (const double edge : {0.9e-3, 943.}) {
    EXPECT_TRUE(choose_size(asset_of("obj"), edge, false).from.guessed);
    expect_says(choose_size(asset_of("obj"), edge, false).warning, "give --size");
    EXPECT_EQ(choose_size(asset_of("obj"), edge, true).warning, "");
    EXPECT_EQ(choose_size(asset_of("glb", 2, 1), edge, false).warning, "");
    EXPECT_FALSE(choose_size(asset_of("glb", 2, 1), edge, false).from.guessed);
  }
  expect_says(choose_size(asset_of("obj"), 943, false).warning,
              "numbers taken as metres; longest edge 943 m: millimetres? give --size");
}

TEST(AssetPose, TheRootIsARotationThatTakesUpToY) {
  for (const char* name : kNames) {
    const UpAxis up = up_from_name(name).value();
    const Matrix4 m = root_matrix(2, up);
    const auto at = [&](int row, int column) { return m[size_t(4 * column + row)] / 2; };
    for (int row = 0; row < 3; ++row)
      EXPECT_EQ(at(row, up.axis) * up.sign, row == 1 ? 1 : 0) << name;
    double determinant = 0;
    for (int k = 0; k < 3; ++k)
      determinant += at(0, k) * (at(1, (k + 1) % 3) * at(2, (k + 2) % 3) -
                                 at(1, (k + 2) % 3) * at(2, (k + 1) % 3));
    EXPECT_EQ(determinant, 1) << name;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        double product = 0;
        for (int row = 0; row < 3; ++row) product += at(row, a) * at(row, b);
        EXPECT_EQ(product, a == b ? 1 : 0) << name;
      }
  }
  EXPECT_EQ(root_matrix(1, UpAxis{}), kIdentity4);
}

}  // namespace
}  // namespace elastogen
