// SPDX-License-Identifier: Apache-2.0
#include "io/animation_writer.hpp"

#include "io/gltf_reader.hpp"
#include "tests/io/glb_files.hpp"

#include <cmath>

namespace elastogen {
namespace {

using test::error_of, test::expect_says;

/// A triangle and its surface in a folder.
class AnimationWriterTest : public ::testing::Test {
 protected:
  test::TempFolder folder;
  Asset asset = read_gltf(folder.write("a.glb", test::triangle().file()));
  Surface surface = pose_surface(asset);
};

TEST_F(AnimationWriterTest, LeavesNothingBehindWithoutFinish) {
  std::filesystem::create_directory(folder.path("empty"));
  {
    const auto writer = AnimationWriter::create(folder.path("empty/a.glb"), asset, surface);
    writer->frame({.displacement = Array<double>(3, 3)});
    expect_says(
        error_of([&] { writer->frame({.displacement = Array<double>(2, 3)}); }, ErrorKind::kUsage),
        "(3, 3)");
    Array<double> bad(3, 3);
    bad(1, 1) = NAN;
    expect_says(error_of([&] { writer->frame({.displacement = bad}); }, ErrorKind::kUsage),
                "finite");
    EXPECT_TRUE(std::filesystem::is_empty(folder.path("empty")));
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path("empty")));
}

TEST_F(AnimationWriterTest, RefusesWhatItsDocumentationForbids) {
  const auto refused = [&](const std::string& path, const AnimationOptions& options) {
    return error_of([&] { AnimationWriter::create(path, asset, surface, options); },
                    ErrorKind::kUsage);
  };
  expect_says(refused(folder.path("a.fbx"), {}), ".glb");
  expect_says(refused(folder.path("out.glb"), {.fps = 0}), "fps");
  expect_says(refused(folder.path("out.glb"), {.root = Matrix4{}}), "inverse");
  expect_says(error_of([&] { AnimationWriter::create(folder.path("no/a.glb"), asset, surface); },
                       ErrorKind::kResources),
              "no/a.glb");
  expect_says(
      error_of([&] { AnimationWriter::create(folder.path("out.glb"), asset, surface)->finish(); },
               ErrorKind::kUsage),
      "no frame");
}

}  // namespace
}  // namespace elastogen
