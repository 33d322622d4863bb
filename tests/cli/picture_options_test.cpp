// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/picture_options.hpp"

#include "cli/typed.hpp"
#include "tests/io/test_files.hpp"

namespace elastogen::test {
namespace {

TEST(PictureOptions, KnowTheirViews) {
  for (size_t k = 0; k < view_names().size(); ++k)
    EXPECT_EQ(view_from_name(view_names()[k]), View(k));
  const auto says = [](const char* name) {
    return error_of([&] { view_from_name(name); }, ErrorKind::kUsage);
  };
  expect_says(says("frnot"), "known are three-quarter, front, back, left, right, top, turntable");
  expect_says(says("frnot"), "did you mean front?");
  expect_says(says("turn-table"), "did you mean turntable?");
  expect_says(says(""), "--camera ''");
}

TEST(PictureOptions, ReadSizes) {
  PictureOptions options;
  set_image_size("960x540", options);
  EXPECT_EQ(options.width, 960);
  EXPECT_EQ(options.height, 540);
  set_image_size("auto", options);
  EXPECT_EQ(options.width, 0);
  for (const char* wrong :
       {"", "x", "0x0", "960", "960x", "x540", "960x540x2", "15x100", "100x4097", "-960x540",
        "960 x 540", "9e2x540", "99999999999999999999x100"})
    expect_says(error_of([&] { set_image_size(wrong, options); }, ErrorKind::kUsage),
                "expected auto or WIDTHxHEIGHT");
}

TEST(PictureOptions, SheetsHaveSmallerPictures) {
  check_pictures({"a.glb", "a.png", "a_%d.png"}, {View::kFront, 2048, 2048});
  check_pictures({"a.glb", "a_%d.png"}, {View::kFront, 4096, 4096});
  const auto says = [](const std::string& name) {
    return error_of([&] { check_pictures({name}, {View::kFront, 4096, 4096}); }, ErrorKind::kUsage);
  };
  expect_says(says("a.png"), "NAME_%04d.png writes one a frame");
  expect_says(says("a_%s.png"), "a % in the name of pictures");
}

TEST(PictureOptions, ScenesSideBySideShareNoPicture) {
  const auto check = [](const char* report) {
    AnimateOptions a, b;
    a.input = "a.obj", b.input = "b.obj";
    a.outputs = {"x_%02d.png"}, b.outputs = {"b.png"};
    b.report = report;
    check_outputs({{"a.toml", a}, {"b.toml", b}});
    check_outputs({{"b.toml", b}, {"a.toml", a}});
  };
  for (const char* free : {"x_121.png", "x_7.png", "x_07.json", "x.png"}) check(free);
  for (const char* taken : {"x_00.png", "x_07.png", "./x_120.png"})
    expect_says(error_of([&] { check(taken); }, ErrorKind::kUsage), "png");
}

}  // namespace
}  // namespace elastogen::test
