// SPDX-License-Identifier: Apache-2.0
#include "io/safe_file.hpp"

#include "tests/io/test_files.hpp"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::TempFolder;
namespace fs = std::filesystem;

int64_t files_in(const std::string& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

TEST(SafeFile, TheTargetIsOldOrWhole) {
  const TempFolder folder;
  const std::string path = folder.write("out.bin", "old");
  {
    SafeFile file(path);
    file.write("new ");
    file.write("content");
    EXPECT_EQ(read_file(path), "old");
    EXPECT_EQ(read_file(file.temporary()), "new content");
    file.commit();
  }
  EXPECT_EQ(read_file(path), "new content");
  EXPECT_EQ(files_in(folder.path("")), 1);
}

TEST(SafeFile, WithoutCommitNothingRemains) {
  const TempFolder folder;
  {
    SafeFile first(folder.path("out")), second(folder.path("out"));
    EXPECT_NE(first.temporary(), second.temporary());
    first.write("half");
  }
  EXPECT_EQ(files_in(folder.path("")), 0);
}

TEST(SafeFile, CommitsWhatOthersWroteToTheTemporary) {
  const TempFolder folder;
  SafeFile file(folder.path("out"));
  std::ofstream(file.temporary()) << "by a library";
  file.commit();
  EXPECT_EQ(read_file(folder.path("out")), "by a library");
}

TEST(SafeFile, FailuresNamePathAndReason) {
  const TempFolder folder;
  const std::string path = folder.path("none/out.glb");
  const std::string message = error_of([&] { SafeFile file(path); }, ErrorKind::kResources);
  expect_says(message, path);
  expect_says(message, "No such file or directory");
  fs::create_directory(folder.path("taken"));
  expect_says(error_of([&] { write_file(folder.path("taken"), "x"); }, ErrorKind::kResources),
              "taken");
  EXPECT_EQ(files_in(folder.path("")), 1);
}

TEST(SafeFile, DevicesAndPipesAreNotReplaced) {
  const TempFolder folder;
  const std::string pipe = folder.path("pipe");
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  for (const std::string& path : {pipe, std::string("/dev/full")}) {
    try {
      SafeFile file(path);
      ADD_FAILURE() << path;
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(path + ": it is a device or pipe"),
                std::string::npos);
    }
  }
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(SafeFile, AFullDiskIsAnErrorAndLeavesNothing) {
  // a limit on the size of files stands for the disk
  const TempFolder folder;
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before = {};
  getrlimit(RLIMIT_FSIZE, &before);
  rlimit small = before;
  small.rlim_cur = 4096;
  setrlimit(RLIMIT_FSIZE, &small);
  const std::string message = error_of(
      [&] { write_file(folder.path("big"), std::string(10000, 'x')); }, ErrorKind::kResources);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, SIG_DFL);
  expect_says(message, "File too large");
  EXPECT_EQ(files_in(folder.path("")), 0);
}

TEST(ReadFile, GivesEveryByteOrSaysWhyNot) {
  const TempFolder folder;
  const std::string bytes("a\0\r\n\xff", 5);
  EXPECT_EQ(read_file(folder.write("Кот 名前", bytes)), bytes);
  EXPECT_EQ(read_file(folder.write("empty", "")), "");
  expect_says(error_of([&] { read_file(folder.path("none")); }), "No such file or directory");
  expect_says(error_of([&] { read_file(folder.path("")); }), "is a folder");
  expect_says(error_of([&] { read_file("/dev/zero"); }), "is not a regular file");
  expect_says(error_of([&] { read_file(folder.path("empty") + "/x"); }), "Not a directory");
  expect_says(error_of([&] { read_file(folder.write("long", "12345"), 4); }), "at most 4 are read");
}

TEST(ResolveBeside, StaysBeneathTheFolder) {
  const TempFolder folder;
  const std::string outside = folder.write("outside.png", "x");
  fs::create_directories(folder.path("asset/tex"));
  folder.write("asset/tex/skin 名.png", "x");
  const std::string asset = folder.write("asset/a.obj", "x");
  fs::create_symlink(outside, folder.path("asset/link.png"));
  fs::create_symlink(folder.path("asset/tex/skin 名.png"), folder.path("asset/good.png"));

  const std::string skin = fs::canonical(folder.path("asset/tex/skin 名.png")).string();
  EXPECT_EQ(resolve_beside(asset, "tex/skin 名.png"), skin);
  EXPECT_EQ(resolve_beside(asset, "tex\\skin 名.png"), skin);
  EXPECT_EQ(resolve_beside(asset, "./tex/../tex/skin 名.png"), skin);
  EXPECT_EQ(resolve_beside(asset, "good.png"), skin);
  for (const std::string& name :
       {std::string(), outside, std::string("../outside.png"), std::string("link.png"),
        std::string("tex"), std::string("none.png"), std::string("file:///etc/passwd"),
        std::string("C:\\a.png"), std::string("a.obj\0", 6), std::string("..")})
    EXPECT_EQ(resolve_beside(asset, name), "") << name;

  // a folder whose name begins alike is another folder
  fs::create_directory(folder.path("asset2"));
  folder.write("asset2/b.png", "x");
  EXPECT_EQ(resolve_beside(asset, "../asset2/b.png"), "");
}

TEST(SafeFile, EndingsAreLowerCaseWithoutTheDot) {
  EXPECT_EQ(ending_of("folder.d/NAME.Ply"), "ply");
  EXPECT_EQ(ending_of("a.tar.GZ"), "gz");
  for (const char* none : {"", "folder.d/name", ".hidden", "name."}) EXPECT_EQ(ending_of(none), "");
}

}  // namespace
}  // namespace elastogen
