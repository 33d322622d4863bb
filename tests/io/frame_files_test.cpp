// SPDX-License-Identifier: Apache-2.0
#include "io/frame_files.hpp"

#include "tests/io/test_files.hpp"

namespace elastogen::test {
namespace {

TEST(FrameFiles, AreNamedByTheEnding) {
  EXPECT_EQ(frame_file("a/b.ply", 3), "a/b_00003.ply");
  EXPECT_EQ(frame_file("a/b.mesh.ply", 3), "a/b.mesh_00003.ply");
  EXPECT_EQ(frame_file("b.obj", 12), "b_00012.obj");
  EXPECT_EQ(frame_file("b.VDB", 12), "b_00012.vdb");
  EXPECT_EQ(frame_file("b.pvd", 123456), "b_123456.vtu");
  EXPECT_EQ(frame_file("b_%d.png", 12), "b_12.png");
  EXPECT_EQ(frame_file("a.b/%04dx.PNG", 12), "a.b/0012x.PNG");
  EXPECT_EQ(frame_file("b_%02d.png", 123), "b_123.png");
  for (const char* single : {"b.png", "b.glb", "b.pc2", "b%04d.glb", "b%d", ""})
    EXPECT_EQ(frame_file(single, 0), "") << single;
}

TEST(FrameFiles, ThereIsAFileOfTheNameItselfUnlessAllAreNumbered) {
  for (const char* own : {"b.png", "b.glb", "b.pvd"}) EXPECT_TRUE(has_own_file(own)) << own;
  for (const char* none : {"b_%d.png", "b.ply", "b.obj", "b.vdb"})
    EXPECT_FALSE(has_own_file(none)) << none;
}

TEST(FrameFiles, KnowTheirOwn) {
  for (const char* own : {"c/b_0000.png", "c/b_0012.png", "c/b_0120.png"})
    EXPECT_TRUE(is_frame_of("c/b_%04d.png", 120, own)) << own;
  for (const char* other :
       {"c/b_0121.png", "c/b_12.png", "b_0012.png", "c/b_0012.jpg", "c/b_.png", "c/b_00012.png",
        "c/b_-001.png", "c/b_+012.png", "c/b_%04d.png", ".png"})
    EXPECT_FALSE(is_frame_of("c/b_%04d.png", 120, other)) << other;
  EXPECT_TRUE(is_frame_of("%d.png", 120, "12.png"));
  EXPECT_FALSE(is_frame_of("%d.png", 120, ".png"));
  EXPECT_FALSE(is_frame_of("b.png", 120, "b_0001.png"));
  EXPECT_TRUE(is_frame_of("b.pvd", 120, "b_00001.vtu"));
}

TEST(FrameFiles, RefuseEveryOtherPercentInTheNameOfPictures) {
  for (const char* name :
       {"a_%d_%d.png", "a_%04d%.png", "a_%s.png", "a_%4d.png", "a_%00d.png", "a_%012d.png",
        "a_%.png", "a_%%.png", "50%.png", "a%d/b.png", "a_%", "a_%04d_%s.png", "a_%x%d.png"}) {
    const std::string path = std::string(name).ends_with(".png") ? name : "a_%.png";
    expect_says(error_of([&] { frame_file(path, 0); }, ErrorKind::kUsage),
                path + ": a % in the name of pictures");
  }
}

}  // namespace
}  // namespace elastogen::test
