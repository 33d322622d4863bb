// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "tests/io/state_files.hpp"

#include <sys/resource.h>

#include <csignal>
#include <fstream>

namespace elastogen::test {
namespace {

TEST_F(StateWriterTest, WritesARunThatStoppedBeforeItsFirstStep) {
  write(two_voxels(), 0);
  open();
  EXPECT_EQ(shape("/steps/x"), (std::vector<hsize_t>{1, kNodes, 3}));
  EXPECT_EQ(shape("/steps/residual"), (std::vector<hsize_t>{0}));
}

TEST_F(StateWriterTest, LeavesTheOldFileAloneWithoutFinish) {
  std::ofstream(path) << "old";
  const Scene scene = two_voxels();
  {
    StateWriter writer(path, scene, header, state_at(0));
    writer.step(state_at(1), report_at(1));
  }
  std::string content;
  std::ifstream(path) >> content;
  EXPECT_EQ(content, "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 1);
}

/// Kind of the error of a run of so many steps where no file may grow beyond 512 kB.
ErrorKind error_on_a_full_disk(const fs::path& path, const StateHeader& header, int steps) {
  const Scene scene = two_voxels();
  try {
    StateWriter writer(path, scene, header, state_at(0));
    for (int step = 1; step <= steps; ++step) writer.step(state_at(step), report_at(step));
    writer.finish();
  } catch (const Error& error) {
    return error.kind();
  }
  return ErrorKind::kUsage;
}

TEST_F(StateWriterTest, ReportsAFullDiskAndLeavesNothing) {
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small = {512 * 1024, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  // a step keeps 576 bytes: the raw file outgrows the limit, then only the packed one
  const ErrorKind raw = error_on_a_full_disk(path, header, 2000);
  const ErrorKind packed = error_on_a_full_disk(path, header, 900);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(raw, ErrorKind::kResources);
  EXPECT_EQ(packed, ErrorKind::kResources);
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST_F(StateWriterTest, RejectsAStateOfAnotherGridAndAMissingFolder) {
  const Scene scene = two_voxels();
  State state = state_at(0);
  state.v = Array<double>(kNodes - 1, 3);
  EXPECT_THROW(StateWriter(path, scene, header, state), Error);
  try {
    StateWriter(folder / "absent" / "run.h5", scene, header, state_at(0));
    ADD_FAILURE() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kResources);
  }
}

}  // namespace
}  // namespace elastogen::test
