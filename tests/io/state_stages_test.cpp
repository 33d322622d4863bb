// SPDX-License-Identifier: Apache-2.0
// State files of steps that are made by stages.
#include "core/error.hpp"
#include "tests/io/state_files.hpp"

#include <cmath>

namespace elastogen::test {
namespace {

constexpr int kPoints = 2, kColliders = 3;

class StateStagesTest : public StateWriterTest {
 protected:
  StateStagesTest() : scene(two_voxels()) {
    scene.scheme = TimeScheme::kAuto;
    scene.surface.voxel = counted<int32_t>(kPoints, 1, 0, 1);
    scene.surface.weights = counted<double>(kPoints, 8, 0.1, 0.01);
    scene.surface.area = counted<double>(kPoints, 1, 0.2, 0.1);
    for (int c = 0; c < kColliders; ++c) scene.colliders.push_back(half_space({0, 1, 0}, c, 0.1));
  }

  /// A step of two stages, of BDF2, of implicit Euler.
  static StepReport report(int step) {
    StepReport r = report_at(step);
    r.scheme = step == 1 ? TimeScheme::kSdirk2 : step == 2 ? TimeScheme::kBdf2 : TimeScheme::kEuler;
    r.guarded = step == 2;
    r.time_error = 1e-4 * step, r.time_ratio = 0.4 * step;
    r.converged = true;
    if (step == 2) r.mesh_error = {3e-3, 7e-3, true};
    return r;
  }

  void write_stages(const Scene& of) {
    StateWriter writer(path, of, header, state_at(0));
    for (int step = 1; step <= kSteps; ++step)
      writer.step(state_at(step), report(step), nullptr, {first(step), bonds(step), {}, {}});
    writer.finish();
    open();
  }
  static const Array<double>& first(int step) {
    static const Array<double> values[] = {counted<double>(kNodes, 3, 1.5, 0.01),
                                           counted<double>(kNodes, 3, 2.5, 0.01),
                                           counted<double>(kNodes, 3, 3.5, 0.01)};
    return values[step - 1];
  }
  static const Array<double>& bonds(int step) {
    static const Array<double> values[] = {counted<double>(kColliders * kPoints, 3, 1, 0.1),
                                           counted<double>(kColliders * kPoints, 3, 2, 0.1),
                                           counted<double>(kColliders * kPoints, 3, 3, 0.1)};
    return values[step - 1];
  }

  Scene scene;
};

TEST_F(StateStagesTest, HasTheFirstStageWhereThereIsOne) {
  write_stages(scene);
  EXPECT_EQ(text("time_scheme"), "auto");
  EXPECT_EQ(attribute("/", "moved")[0], 0);
  EXPECT_EQ(shape("/steps/x_stage"), (std::vector<hsize_t>{kSteps, kNodes, 3}));
  const std::vector<double> x = numbers("/steps/x_stage");
  for (int k = 0; k < 3 * kNodes; ++k) {
    EXPECT_EQ(x[size_t(k)], first(1).data()[k]);
    EXPECT_TRUE(std::isnan(x[size_t(3 * kNodes + k)]));
    EXPECT_TRUE(std::isnan(x[size_t(6 * kNodes + k)]));
  }
  EXPECT_EQ(numbers("/steps/scheme"), (std::vector<double>{2, 1, 0}));
  EXPECT_EQ(numbers("/steps/guarded"), (std::vector<double>{0, 1, 0}));
  // positions and velocities as without stages
  EXPECT_EQ(numbers("/steps/x")[3 * kNodes], state_at(1).x.data()[0]);
  EXPECT_EQ(numbers("/steps/v").back(), state_at(3).v.data()[3 * kNodes - 1]);
}

TEST_F(StateStagesTest, HasTimeErrorsAndWhatTheyMakeOfASolvedStep) {
  write_stages(scene);
  for (int t = 0; t < kSteps; ++t) {
    EXPECT_EQ(numbers("/steps/time_error")[size_t(t)], report(t + 1).time_error);
    EXPECT_EQ(numbers("/steps/time_ratio")[size_t(t)], report(t + 1).time_ratio);
  }
  // the third step is 1.2 times what is accepted
  EXPECT_EQ(numbers("/steps/converged"), (std::vector<double>{1, 1, 0}));
}

TEST_F(StateStagesTest, HasMeshNumbersWhereFramesEnd) {
  write_stages(scene);
  const std::vector<double> rms = numbers("/steps/mesh_error"),
                            largest = numbers("/steps/mesh_error_largest");
  EXPECT_TRUE(std::isnan(rms[0]) && std::isnan(largest[0]) && std::isnan(rms[2]));
  EXPECT_EQ(rms[1], 3e-3);
  EXPECT_EQ(largest[1], 7e-3);
  EXPECT_EQ(numbers("/steps/mesh_error_trusted"), (std::vector<double>{0, 1, 0}));
}

TEST_F(StateStagesTest, HasTheBondsOfEveryEntryWhichBeginAtZero) {
  write_stages(scene);
  EXPECT_EQ(shape("/contact/bonds"), (std::vector<hsize_t>{kSteps + 1, kColliders, kPoints, 3}));
  const std::vector<double> all = numbers("/contact/bonds");
  const size_t size = size_t(kColliders * kPoints * 3);
  for (size_t k = 0; k < size; ++k) {
    EXPECT_EQ(all[k], 0);
    for (int step = 1; step <= kSteps; ++step)
      EXPECT_EQ(all[size * size_t(step) + k], bonds(step).data()[k]);
  }
}

TEST_F(StateStagesTest, NothingOfThisIsInOtherFiles) {
  scene.scheme = TimeScheme::kBdf2;
  write_stages(scene);
  for (const char* name : {"/steps/x_stage", "/steps/guarded", "/steps/time_error",
                           "/steps/time_ratio", "/contact/bonds"})
    EXPECT_FALSE(H5Lexists(file, name, H5P_DEFAULT) > 0) << name;
}

TEST_F(StateStagesTest, LengthAndToleranceAreThoseOfTheRunWhereAStepNamesNone) {
  StateWriter writer(path, scene, header, state_at(0));
  StepReport r = report(2);
  r.length = r.tolerance = 0;
  writer.step(state_at(1), r);
  writer.finish();
  open();
  EXPECT_EQ(numbers("/steps/length")[0], scene.dt);
  EXPECT_EQ(numbers("/steps/tolerance")[0], header.tolerance);
}

TEST_F(StateStagesTest, RefusesArraysOfOtherSizes) {
  StateWriter writer(path, scene, header, state_at(0));
  const Array<double> few(kNodes - 1, 3);
  EXPECT_THROW(writer.step(state_at(1), report(1), nullptr, {few, bonds(1), {}, {}}), Error);
  EXPECT_THROW(writer.step(state_at(1), report(1), nullptr, {first(1), few, {}, {}}), Error);
  EXPECT_THROW(writer.step(state_at(1), report(1)), Error);  // two stages, but not the first one
}

}  // namespace
}  // namespace elastogen::test
