// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/held_nodes.cuh"
#include "tests/support/on_card.hpp"

#include <random>

namespace elastogen::test {
namespace {

class HeldNodesOnCard : public OnCard {};

constexpr int kEdge = 14;  // nodes of the block along an axis

std::vector<double> random_values(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<double> values(3 * kEdge * kEdge * kEdge);
  for (double& value : values) value = uniform(random);
  return values;
}

/// Nodes of a block without voxels: pinned below by a shift, a layer above that follows a turn, and
/// a node that is pinned by nobody.
Scene held_block() {
  Scene scene;
  const int64_t count = kEdge * kEdge * kEdge, layer = kEdge * kEdge;
  scene.grid.rest = Array<double>(count, 3);
  scene.pinned = Array<uint8_t>(count);
  scene.holder = Array<int32_t>(count);
  scene.mass = Array<double>(count);
  for (int64_t n = 0; n < count; ++n) {
    const double X[3] = {double(n % kEdge), double(n / kEdge % kEdge), double(n / layer)};
    for (int d = 0; d < 3; ++d) scene.grid.rest(n, d) = 0.1 * X[d];
    scene.pinned(n) = n < layer || n == 3 * layer ? kPinnedNode : kFreeNode;
    scene.holder(n) = n < layer ? 0 : -1;
    scene.mass(n) = 1;
  }
  // each follows the two nodes below it
  std::vector<int32_t> nodes, begin = {0}, parents;
  std::vector<double> weights;
  for (int64_t n = count - layer; n < count; ++n) {
    nodes.push_back(int32_t(n));
    parents.insert(parents.end(), {int32_t(n - layer), int32_t(n - 2 * layer)});
    weights.insert(weights.end(), {-0.3, 0.1});
    begin.push_back(int32_t(parents.size()));
    scene.pinned(n) = kDependentNode;
    scene.holder(n) = 1;
  }
  scene.dependent = DependentNodes(nodes, begin, parents, weights);
  scene.holders.resize(2);
  scene.holders[0].path = {{0, {}}, {1, {0.3, -0.2, 0.1}}};
  scene.holders[1].turns = true;
  scene.holders[1].centre = {0.7, 0.6, 1.3};
  scene.holders[1].path = {{0, {}}, {1, {0.2, 0.1, 1.5}}};
  scene.load = Array<double>(count, 3);
  for (int64_t k = 0; k < scene.load.size(); ++k) scene.load.data()[k] = double(k % 7);
  return scene;
}

std::vector<double> host_copy(const cuda::DeviceArray<double>& array) {
  std::vector<double> values(size_t(array.size()));
  array.download(values.data());
  return values;
}

TEST_F(HeldNodesOnCard, PlacesAndVelocitiesHaveTheBitsOfTheHost) {
  const Scene scene = held_block();
  HeldNodes host(scene);
  cuda::DeviceHeldNodes device(scene);
  ASSERT_TRUE(device.move());
  for (const double time : {0.4, 0.7}) {
    host.set_time(time);
    device.set_time(time);
    std::vector<double> u = random_values(3), followed = u, v = random_values(4);
    cuda::DeviceArray<double> to_place(u), to_follow(u), velocities(v);
    host.place(u.data());
    host.follow(followed.data());
    host.set_velocities(u.data(), v.data());
    device.place(to_place.data());
    device.follow(to_follow.data());
    device.set_velocities(to_place.data(), velocities.data());
    EXPECT_EQ(host_copy(to_place), u);
    EXPECT_EQ(host_copy(to_follow), followed);
    EXPECT_EQ(host_copy(velocities), v);
  }
}

TEST_F(HeldNodesOnCard, ReactionsAreThoseOfTheHostAndRepeat) {
  const Scene scene = held_block();
  const HeldNodes host(scene);
  cuda::DeviceHeldNodes device(scene);
  ASSERT_TRUE(device.has_reactions());
  const std::vector<double> r = random_values(5), u = random_values(6);
  const std::vector<Reaction> expected =
      host.reactions(r.data(), u.data(), scene.load.empty() ? nullptr : scene.load.data());
  const cuda::DeviceArray<double> rest(scene.grid.rest.data(), scene.grid.rest.size()),
      load(scene.load.data(), scene.load.size()), place(u);
  std::vector<Reaction> before;
  // bounds from the rounding of some hundred forces of size 1
  for (int pass = 0; pass < 3; ++pass) {
    cuda::DeviceArray<double> gradient(r);
    device.start_reactions(rest.data(), load.data(), place.data(), gradient.data());
    const std::vector<double> left = host_copy(gradient);
    const std::vector<Reaction> found = device.reactions();
    for (size_t k = 0; k < r.size(); ++k)
      EXPECT_EQ(left[k], scene.pinned(int64_t(k / 3)) == kPinnedNode ? 0 : r[k]);
    for (size_t h = 0; h < 2; ++h)
      for (size_t d = 0; d < 3; ++d) {
        EXPECT_NEAR(found[h].force[d], expected[h].force[d], 1e-12 * 200);
        EXPECT_NEAR(found[h].moment[d], expected[h].moment[d], 1e-12 * 600);
        EXPECT_NEAR(found[h].about[d], expected[h].about[d], 1e-14);
        if (pass > 0) EXPECT_EQ(found[h].force[d], before[h].force[d]);
        if (pass > 0) EXPECT_EQ(found[h].moment[d], before[h].moment[d]);
      }
    before = found;
  }
}

TEST_F(HeldNodesOnCard, WithoutHoldersNothingIsTouched) {
  Scene scene = held_block();
  scene.holders.clear();
  scene.holder = {};
  scene.dependent = {};
  cuda::DeviceHeldNodes none(scene);
  EXPECT_FALSE(none.move());
  EXPECT_FALSE(none.has_reactions());
  none.set_time(1);
  none.place(nullptr);
  none.set_velocities(nullptr, nullptr);
  EXPECT_TRUE(none.reactions().empty());
  cuda::synchronise();
}

}  // namespace
}  // namespace elastogen::test
