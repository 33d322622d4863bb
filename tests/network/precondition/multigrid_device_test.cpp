// SPDX-License-Identifier: Apache-2.0
// The V-cycle of the device against that of the CPU. Nothing is here in builds without CUDA;
// skipped where there is no device.

#ifdef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/precondition/multigrid.cuh"
#include "network/precondition/multigrid_grid.hpp"
#include "tests/network/device_numbers.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/held_bodies.hpp"
#include "tests/network/precondition/multigrid_scenes.hpp"

#include <optional>

namespace elastogen::test {
namespace {

class MultigridOnCard : public OnCard {};

/// The cycle of the device, and the potential that it is made of.
template <class T>
struct Made {
  explicit Made(const Scene& scene) : Made(scene, dense_nodes(scene)) {}
  Made(const Scene& scene, int64_t dense)
      : potential(with_scheme(scene)), tables(potential, dense) {
    cycle.emplace(tables);
  }
  static IncrementalPotential with_scheme(const Scene& scene) {
    IncrementalPotential potential(scene);
    potential.set_scheme({TimeScheme::kEuler, scene.dt, 1});
    return potential;
  }
  IncrementalPotential potential;
  cuda::DevicePotential tables;
  std::optional<cuda::DeviceMultigrid<T>> cycle;
};

/// A plate of one voxel, long and thin: its operators are worse conditioned than those of blocks.
Scene thin_plate() {
  Scene plate = box_at({-5, 3, 7}, 140, 19, 1);
  pin_below(plate, 0, -0.35);
  finish_scene(plate);
  return plate;
}

/// A cycle of the device like one of the host, and more with the same bits.
template <class T>
void expect_cycle_of_host(const Scene& scene, Multigrid<T>& host, cuda::DeviceMultigrid<T>& device,
                          double bound, int more = 1) {
  const std::vector<double> random = random_field(scene, 1, 9);
  const std::vector<T> r(random.begin(), random.end());
  std::vector<T> expected(r.size());
  host.apply(r.data(), expected.data());
  // the values in z before the call must not matter
  OnDevice<T> from(r), z(std::vector<T>(r.size(), T(7))), again(std::vector<T>(r.size(), T(-3)));
  device.apply(from.data(), z.data());
  EXPECT_LT(relative_difference(z.host(), expected), bound);
  for (int k = 0; k < more; ++k) device.apply(from.data(), again.data());
  EXPECT_EQ(z.host(), again.host());
}

template <class T>
void check_cycles(double bound) {
  for (const NamedScene& named : multigrid_scenes()) {
    SCOPED_TRACE(named.name);
    Multigrid<T> host(named.scene, 1);
    Made<T> device(named.scene);
    expect_cycle_of_host(named.scene, host, *device.cycle, bound);
  }
}

TEST_F(MultigridOnCard, CyclesAreThoseOfTheHostInDouble) {
  check_cycles<double>(1e-12);
}

/// Levels that are solved as a step on the card does, which smooths them on the CPU.
template <class T>
void check_large_solves(double bound) {
  const Scene ragged = ragged_of_two_materials(50, 26, 37),
              many = clamped_beam(45, 35, 31, 0.02, solid(1e5, 0.45)), plate = thin_plate(),
              whole = clamped_beam(30, 11, 7, 0.02, solid(1e5, 0.3));
  for (const Scene* scene : {&ragged, &many, &plate, &whole}) {
    Multigrid<T> host(*scene, 1, {}, cuda::kDenseNodes);
    const int64_t n = host.level(host.level_count() - 1).nodes;
    SCOPED_TRACE(concat(n, " nodes"));
    EXPECT_GT(n, dense_nodes(*scene));
    Made<T> device(*scene, cuda::kDenseNodes);
    expect_cycle_of_host(*scene, host, *device.cycle, bound);
  }
}

TEST_F(MultigridOnCard, LargeSolvesAreThoseOfTheHost) {
  check_large_solves<double>(1e-11);  // two methods of inversion, and the plate multiplies rounding
  check_large_solves<float>(2e-5);
}

TEST_F(MultigridOnCard, CyclesAreThoseOfTheHostInFloat) {
  check_cycles<float>(2e-5);
}

/// Some stiffness as contact gives it: by the free nodes that have any.
struct StiffNodes {
  explicit StiffNodes(const std::vector<double>& stiffness) {
    for (size_t n = 0; n < stiffness.size() / 3; ++n) {
      const double* of = stiffness.data() + 3 * n;
      if (of[0] == 0 && of[1] == 0 && of[2] == 0) continue;
      nodes.push_back(int32_t(n));
      blocks.insert(blocks.end(), {of[0], 0, 0, of[1], 0, of[2]});
    }
  }
  std::vector<int32_t> nodes;
  std::vector<double> blocks;
};

TEST_F(MultigridOnCard, StiffenedCyclesAreThoseOfTheHost) {
  for (NamedScene& named : multigrid_scenes()) {
    SCOPED_TRACE(named.name);
    Scene& scene = named.scene;
    scene.colliders = {half_space({0, 1, 0}, -100, 0.5)};  // far below: coarser levels
    scene.surface = face_points(scene.grid);
    Multigrid<double> host(scene, 1);
    Made<double> device(scene);
    device.cycle->expect_stiffness();
    const std::vector<double> stiffness = some_stiffness(scene);
    const StiffNodes stiff(stiffness);
    OnDevice<int32_t> nodes(stiff.nodes);
    OnDevice<double> blocks(stiff.blocks);
    host.set_nodal_stiffness(stiffness);
    device.cycle->set_nodal_stiffness({nodes.data(), blocks.data(), int64_t(stiff.nodes.size())});
    device.cycle->use_stiffness(true);
    expect_cycle_of_host(scene, host, *device.cycle, 1e-12);
    host.set_nodal_stiffness({});
    device.cycle->use_stiffness(false);
    expect_cycle_of_host(scene, host, *device.cycle, 1e-12);
  }
}

/// Inertia of steps of another length counts as a stiffness of the free nodes.
TEST_F(MultigridOnCard, CyclesOfStepsOfOtherLengthsAreThoseOfTheHost) {
  for (NamedScene& named : multigrid_scenes()) {
    SCOPED_TRACE(named.name);
    Scene& scene = named.scene;
    scene.scheme = TimeScheme::kAuto;
    Multigrid<double> host(scene, 1, {}, cuda::kMostChangedNodes);
    Made<double> device(scene);
    device.cycle->expect_stiffness(device.tables.mass());
    device.cycle->use_stiffness(true);
    const std::vector<double> stiffness = some_stiffness(scene);
    const StiffNodes stiff(stiffness);
    OnDevice<int32_t> nodes(stiff.nodes);
    OnDevice<double> blocks(stiff.blocks);
    // other inertia alone, then with the stiffness of nodes
    for (const double factor : {0.4, 40.0}) {
      const double more = (factor - 1) / (scene.dt * scene.dt);
      std::vector<double> added(stiffness.size());
      for (size_t k = 0; k < added.size(); ++k)
        if (!scene.pinned(int64_t(k / 3))) added[k] = more * scene.mass(int64_t(k / 3));
      host.set_nodal_stiffness(added);
      device.cycle->add_inertia(more);
      device.cycle->set_nodal_stiffness({});
      expect_cycle_of_host(scene, host, *device.cycle, 1e-11);
      for (size_t k = 0; k < added.size(); ++k) added[k] += stiffness[k];
      host.set_nodal_stiffness(added);
      device.cycle->set_nodal_stiffness({nodes.data(), blocks.data(), int64_t(stiff.nodes.size())});
      expect_cycle_of_host(scene, host, *device.cycle, 1e-11);
    }
  }
}

/// Parent nodes are stiffer on all levels, by up to 50 times where the offset is large.
TEST_F(MultigridOnCard, CyclesBesideDependentNodesAreThoseOfTheHost) {
  for (Scene scene : {swinging_bar(TimeScheme::kEuler, 0.3), swinging_bar(TimeScheme::kEuler, 0.88),
                      block_on_ball(TimeScheme::kEuler)}) {
    SCOPED_TRACE(concat(scene.dependent.count(), " dependent nodes"));
    for (const int64_t dense : {int64_t(100), cuda::kDenseNodes}) {
      Multigrid<double> host(scene, 1, {}, dense);
      Made<double> device(scene, dense);
      expect_cycle_of_host(scene, host, *device.cycle, 1e-11);
    }
    // of steps of another length
    scene.scheme = TimeScheme::kAuto;
    Multigrid<double> host(scene, 1, {}, cuda::kMostChangedNodes);
    Made<double> device(scene);
    device.cycle->expect_stiffness(device.tables.mass());
    device.cycle->use_stiffness(true);
    const double more = 39 / (scene.dt * scene.dt);
    std::vector<double> added(3 * size_t(scene.grid.node_count()));
    for (size_t k = 0; k < added.size(); ++k)
      if (!scene.pinned(int64_t(k / 3))) added[k] = more * scene.mass(int64_t(k / 3));
    host.set_nodal_stiffness(added);
    device.cycle->add_inertia(more);
    device.cycle->set_nodal_stiffness({});
    expect_cycle_of_host(scene, host, *device.cycle, 1e-11);
  }
}

TEST_F(MultigridOnCard, CycleOfManyLevels) {
  // levels of their own launches above those of the cluster
  const Scene scene = clamped_beam(90, 70, 61, 0.02, solid(1e5, 0.45));
  Multigrid<double> host(scene, 1);
  EXPECT_GE(host.level_count(), 5);
  Made<double> device(scene);
  expect_cycle_of_host(scene, host, *device.cycle, 1e-12);
}

TEST_F(MultigridOnCard, AThousandCyclesLeaveNothingBehind) {
  // values left in slots without a free node would grow from cycle to cycle
  const Scene scene = clamped_beam(90, 70, 61, 0.02, solid(1e5, 0.45));
  Multigrid<float> host(scene, 1);
  Made<float> device(scene);
  expect_cycle_of_host(scene, host, *device.cycle, 2e-5, 1000);
}

TEST_F(MultigridOnCard, CycleIsSymmetric) {
  const Scene scene = ragged_of_two_materials(50, 26, 37);
  Made<double> device(scene);
  const std::vector<double> x = random_field(scene, 1, 1), y = random_field(scene, 1, 2);
  OnDevice<double> from_x(x), from_y(y), Bx(x), By(y);
  device.cycle->apply(from_x.data(), Bx.data());
  device.cycle->apply(from_y.data(), By.data());
  const std::vector<double> bx = Bx.host(), by = By.host();
  EXPECT_NEAR(dot(x, by), dot(y, bx), 1e-12 * norm(x) * norm(by));
  EXPECT_GT(dot(x, bx), 0);
}

TEST_F(MultigridOnCard, AUniformBlockNeedsARowForEachKindOfNode) {
  // inner nodes, faces, edges and corners are 27 kinds; row 0 is that of no node
  const Scene scene = box_at({-9, -8, -1}, 40, 30, 20);
  Made<float> device(scene);
  EXPECT_EQ(cuda::hierarchy_rows<float>(device.tables)[0].distinct, 28);
}

TEST_F(MultigridOnCard, RowsAreToldApartWhateverTheirHashes) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  Made<float> device(scene);
  const auto rows = cuda::hierarchy_rows<float>(device.tables),
             again = cuda::hierarchy_rows<float>(device.tables),
             few = cuda::hierarchy_rows<float>(device.tables, 6);
  EXPECT_GT(rows[0].distinct, 1000);
  for (size_t l = 0; l < rows.size(); ++l) {
    EXPECT_EQ(rows[l].by_node, again[l].by_node);
    EXPECT_EQ(rows[l].by_node, few[l].by_node);
    EXPECT_EQ(rows[l].distinct, few[l].distinct);
  }
}

}  // namespace
}  // namespace elastogen::test

#endif
