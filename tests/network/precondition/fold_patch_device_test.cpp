// SPDX-License-Identifier: Apache-2.0
// The correction of folds on the device against that of the host. Empty in builds without CUDA;
// skipped without a device.

#ifdef ELASTOGEN_CUDA

#include "network/precondition/fold_patch_device.hpp"

#include "network/precondition/fold_patch.hpp"
#include "tests/network/device_numbers.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/precondition/folded_bar.hpp"

namespace elastogen::test {
namespace {

class FoldPatchOnCard : public OnCard {};

/// A float field that is 0 on pinned nodes.
std::vector<float> free_field(const Scene& scene, unsigned seed) {
  const std::vector<double> random = random_field(scene, 1, seed);
  std::vector<float> field(random.begin(), random.end());
  for (size_t k = 0; k < field.size(); ++k)
    if (scene.pinned(int64_t(k / 3))) field[k] = 0;
  return field;
}

/// Both parts of the correction, by host and card, on one random r and P r.
void expect_like_host(Folded& of) {
  FoldPatch patch;
  patch.update(of.potential, of.u.data());
  ASSERT_FALSE(patch.empty());
  cuda::DevicePotential device(of.potential);
  device.begin_step(of.potential);
  OnDevice<double> u(of.u);
  device.set_nodal_rotations(u.data());
  cuda::DeviceFoldPatch card(device);
  card.find(u.data());
  device.linearise(u.data(), TangentKind::kProjected);
  card.assemble();
  EXPECT_EQ(card.count(), patch.count());
  // begin, and end on a P r of about its size
  std::vector<float> r = free_field(of.scene, 4), z = free_field(of.scene, 5), first(r.size());
  for (float& value : z) value *= 1e-4f;
  OnDevice<float> device_r(r), device_z(z);
  const float* device_left = card.begin(device_r.data());
  patch.begin(r.data(), first.data());
  std::vector<float> left(r.size());
  ASSERT_EQ(
      cudaMemcpy(left.data(), device_left, left.size() * sizeof(float), cudaMemcpyDeviceToHost),
      cudaSuccess);
  EXPECT_LT(relative_difference(left, std::vector<double>(r.begin(), r.end())), 1e-4);
  card.end(device_z.data());
  patch.end(r.data(), first.data(), z.data());
  EXPECT_LT(relative_difference(device_z.host(), std::vector<double>(z.begin(), z.end())), 1e-4);
}

TEST_F(FoldPatchOnCard, CorrectsAsOnTheHost) {
  Folded of(2.6);
  expect_like_host(of);
}

TEST_F(FoldPatchOnCard, KnowsTheStiffnessOfContact) {
  Folded of(2.6, true);
  ASSERT_FALSE(of.potential.contact().stiff_nodes().empty());
  expect_like_host(of);
}

TEST_F(FoldPatchOnCard, IsEmptyWhereNothingFolds) {
  Folded of(0.3);
  cuda::DevicePotential device(of.potential);
  device.begin_step(of.potential);
  OnDevice<double> u(of.u);
  device.set_nodal_rotations(u.data());
  cuda::DeviceFoldPatch card(device);
  card.find(u.data());
  EXPECT_TRUE(card.empty());
}

}  // namespace
}  // namespace elastogen::test

#endif
