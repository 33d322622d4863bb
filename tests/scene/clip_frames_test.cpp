// SPDX-License-Identifier: Apache-2.0
// Frames that are written beside the steps: the files of frames that are made and written one after
// the other, and clips that end early.
#include "scene/clip_frames.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "io/safe_file.hpp"
#include "scene/run.hpp"
#include "tests/io/test_files.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <thread>

namespace elastogen::test {
namespace {

namespace fs = std::filesystem;

constexpr int kFrames = 5, kSubsteps = 2;

/// Points of a sphere with normals, which frames turn by the deformation gradient.
Asset sphere_of_points() {
  Asset asset;
  asset.path = "sphere.ply";
  PointCloud& cloud = asset.points.emplace();
  constexpr int kPoints = 2000;
  for (int k = 0; k < kPoints; ++k) {
    const double z = 1 - (2 * k + 1.0) / kPoints, r = std::sqrt(1 - z * z), turn = 2.39996323 * k;
    cloud.position.push_back({r * std::cos(turn), r * std::sin(turn), z});
    cloud.normal.push_back({float(r * std::cos(turn)), float(r * std::sin(turn)), float(z)});
  }
  return asset;
}

/// A soft body that is held below and starts to turn, with one file of all frames and one a frame.
RunDescription options_in(const TempFolder& folder) {
  RunDescription options;
  options.outputs = {folder.path("a.pc2"), folder.path("a.ply")};
  options.material = {"soft", Law::kNeoHookean, 3e4, 0.4, 1000};
  options.energy = EnergySource::kAnalytic;
  options.solver.device = Device::kCpu;
  options.pins = {parse_pin("z<20%")};
  options.motion.spin[2] = 3;
  options.voxels = 8;
  options.frames = kFrames;
  options.substeps = kSubsteps;
  return options;
}

/// Sets up and plays a clip on as many threads as it says.
RunResult played(const Asset& asset, const RunDescription& run, const ClipHooks& hooks = {}) {
  const ThreadLimit limit(run.threads);
  RunResult result;
  result.end = play_clip(asset, set_up(asset, run), run, hooks, result.report);
  return result;
}

/// Names and bytes of all files.
std::map<std::string, std::string> files_in(const TempFolder& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder.path("")))
    files[entry.path().filename().string()] = read_file(entry.path().string());
  return files;
}

/// The clip by one loop: step, make the frame, write it.
void write_in_turns(const Asset& asset, const RunDescription& options) {
  const Setup setup = set_up(asset, options);
  std::vector<std::unique_ptr<AnimationWriter>> writers;
  for (const std::string& path : options.outputs)
    writers.push_back(AnimationWriter::create(path, asset, setup.body.surface));
  std::vector<std::string> notes;
  const auto stepper = make_stepper(setup, options, {}, notes);
  const Embedding embedding = embed(setup.scene.grid, setup.body.carried);
  Array<double> displacement(setup.body.carried.rows(), 3), gradient(setup.body.carried.rows(), 9);
  stepper->begin(options.motion);
  for (int64_t frame = 0; frame <= options.frames; ++frame) {
    for (int k = 0; frame > 0 && k < setup.substeps; ++k) stepper->advance();
    deform_asset(setup.scene.grid, embedding, stepper->state().x, displacement);
    deformation_gradient(setup.scene.grid, embedding, stepper->state().x, gradient);
    for (const auto& writer : writers)
      writer->frame({.displacement = displacement, .gradient = gradient});
  }
  for (const auto& writer : writers) writer->finish();
}

TEST(ClipFrames, HaveTheBytesOfFramesWrittenInTurns) {
  const Asset asset = sphere_of_points();
  const TempFolder in_turns;
  write_in_turns(asset, options_in(in_turns));
  const auto expected = files_in(in_turns);
  ASSERT_EQ(expected.size(), 2 + kFrames);
  EXPECT_NE(expected.at("a_00000.ply"), expected.at("a_00005.ply"));
  for (const int threads : {1, 2, 3}) {
    const TempFolder beside;
    RunDescription options = options_in(beside);
    options.threads = threads;
    int frames = 0;
    ClipHooks hooks;
    hooks.on_frame = [&](const Array<double>&) { ++frames; };
    EXPECT_EQ(played(asset, options, hooks).end, ClipEnd::kConverged);
    EXPECT_EQ(frames, 1 + kFrames);
    EXPECT_EQ(files_in(beside), expected) << threads << " threads";
  }
}

/// Files of single frames, which are complete by themselves, remain.
TEST(ClipFrames, AnErrorOfAFrameEndsTheClip) {
  const Asset asset = sphere_of_points();
  for (const int threads : {1, 2})
    for (const int last : {0, 2, kFrames}) {
      const TempFolder folder;
      RunDescription options = options_in(folder);
      options.threads = threads;
      // one frame fails, as on a full disk
      int frames = 0, steps = 0;
      ClipHooks hooks;
      hooks.on_step = [&](const StepReport&) { ++steps; };
      hooks.on_frame = [&](const Array<double>&) {
        if (frames++ == last) throw Error("the disk is full", ErrorKind::kResources);
      };
      try {
        played(asset, options, hooks);
        ADD_FAILURE() << "the error is lost";
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kResources);
        EXPECT_STREQ(error.what(), "the disk is full");
      }
      // no later frame was made, and few steps
      EXPECT_EQ(frames, last + 1);
      EXPECT_LE(steps, kSubsteps * (last + 1));  // no more than those of the next frame
      // files of single frames remain, the file of all frames does not
      const auto files = files_in(folder);
      EXPECT_EQ(files.count("a.pc2"), 0U);
      EXPECT_EQ(files.size(), size_t(last) + 1);
    }
}

/// Frames of a point cache as its header counts them.
int64_t frames_of_cache(const std::string& bytes) {
  int32_t count = 0;
  std::memcpy(&count, bytes.data() + 28, sizeof count);
  return count;
}

TEST(ClipFrames, AreAllWrittenWhereTimeIsOver) {
  const Asset asset = sphere_of_points();
  for (const int threads : {1, 2}) {
    const TempFolder folder;
    RunDescription options = options_in(folder);
    options.threads = threads;
    options.frames = 1000;
    options.max_time = 0.2;
    ClipHooks hooks;
    hooks.on_step = [](const StepReport&) {
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    };
    const RunResult result = played(asset, options, hooks);
    EXPECT_EQ(result.end, ClipEnd::kDraft);
    EXPECT_LT(result.report.frames, 20);
    const auto files = files_in(folder);
    EXPECT_EQ(int64_t(files.size()), result.report.frames + 2);
    EXPECT_EQ(frames_of_cache(files.at("a.pc2")), result.report.frames + 1);
  }
}

/// Frames with velocities are written at once, from the state of their step.
TEST(ClipFrames, WithVelocitiesHaveThoseOfTheirStep) {
  const Asset asset = sphere_of_points();
  std::map<std::string, std::string> expected;
  for (const int threads : {1, 2}) {
    const TempFolder folder;
    RunDescription options = options_in(folder);
    options.outputs = {folder.path("a.pvd"), folder.path("a.pc2")};
    options.threads = threads;
    EXPECT_EQ(played(asset, options).end, ClipEnd::kConverged);
    auto files = files_in(folder);
    if (threads == 1) expected = files;
    EXPECT_EQ(files, expected);
    EXPECT_EQ(frames_of_cache(files.at("a.pc2")), 1 + kFrames);
  }
}

}  // namespace
}  // namespace elastogen::test
