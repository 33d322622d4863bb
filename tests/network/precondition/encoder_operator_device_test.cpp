// SPDX-License-Identifier: Apache-2.0
// Data that the device computes from a scene at rest (tables of its voxels, modes of the encoder
// and their operators) against those of the CPU. Empty in builds without CUDA; skipped without a
// device.

#ifdef ELASTOGEN_CUDA

#include "network/precondition/encoder_operator.cuh"
#include "network/precondition/encoder_operator.hpp"
#include "tests/network/device_numbers.hpp"
#include "tests/network/device_support.hpp"
#include "tests/network/held_bodies.hpp"
#include "tests/network/precondition/multigrid_scenes.hpp"

#include <limits>

namespace elastogen::test {
namespace {

class RestOperatorOnCard : public OnCard {};

constexpr double kRounding = 1e-12;  // of the largest entry

/// The modes of all pieces, as a DeviceEncoder lists them.
template <class T>
struct ModeLists {
  using Number = cuda::ModeNumber<T>;

  ModeLists(const Scene& scene, const Encoder<T>& encoder)
      : entry(size_t(scene.grid.node_count()), -1) {
    for (const auto& piece : encoder.pieces()) {
      for (const int32_t node : piece.nodes) {
        entry[size_t(node)] = int32_t(nodes.size());
        nodes.push_back(node);
      }
      const size_t count = piece.nodes.size() * size_t(Encoder<T>::kModes);
      for (size_t k = 0; k < count; ++k) modes.push_back(Number(piece.modes[k]));
      begin.push_back(int32_t(nodes.size()));
    }
  }

  std::vector<Number> modes;
  std::vector<int32_t> nodes, entry;
  std::vector<int32_t> begin = {0};  ///< first entry of each piece, (pieces + 1)
};

/// A potential with the scheme of its scene, and its encoder.
template <class T>
struct AtRest {
  explicit AtRest(const Scene& s) : scene(s), potential(with_scheme(s)), encoder(potential) {}
  static IncrementalPotential with_scheme(const Scene& scene) {
    IncrementalPotential potential(scene);
    potential.set_scheme({TimeScheme::kEuler, scene.dt, 1});
    return potential;
  }

  const Scene& scene;
  IncrementalPotential potential;
  Encoder<T> encoder;
};

/// Operators of the pieces by the device, each made twice with the same bits.
template <class T>
std::vector<std::vector<double>> by_device(const AtRest<T>& rest, const ModeLists<T>& lists) {
  cuda::DevicePotential device(rest.potential);
  const Zeroed<double>& inertia = rest.potential.inertia();
  EXPECT_EQ(cudaMemcpy(device.inertia(), inertia.data(), inertia.size() * sizeof(double),
                       cudaMemcpyHostToDevice),
            cudaSuccess);
  OnDevice<typename ModeLists<T>::Number> modes(lists.modes);
  OnDevice<int32_t> nodes(lists.nodes), entry(lists.entry);
  const cuda::DeviceModes<T> view{modes.data(), nodes.data(), entry.data()};
  std::vector<std::vector<double>> operators;
  for (size_t p = 0; p + 1 < lists.begin.size(); ++p) {
    const int32_t first = lists.begin[p], end = lists.begin[p + 1];
    operators.push_back(cuda::reduced_rest_operator(device, view, first, end));
    EXPECT_EQ(cuda::reduced_rest_operator(device, view, first, end), operators.back());
  }
  return operators;
}

/// max |a - b| over max |b|.
double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, largest = 0;
  for (size_t k = 0; k < b.size(); ++k) {
    if (!std::isfinite(a[k])) return std::numeric_limits<double>::infinity();
    difference = std::max(difference, std::abs(a[k] - b[k]));
    largest = std::max(largest, std::abs(b[k]));
  }
  return difference / largest;
}

/// Three materials in turn in every row of voxels, so that a slab has more rows than lines.
Scene rows_of_three_materials() {
  Scene scene = scene_on(ragged_grid(19, 13, 11, 0.02, 3), solid(3e4, 0.4));
  scene.materials.push_back(solid(8e4, 0.3));
  scene.materials.push_back(solid(1e4, 0));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
    const int32_t* at = scene.grid.voxel_coord.row(v);
    scene.material(v) = (at[0] + at[1] + at[2] + 300) % 3;
  }
  finish_scene(scene);
  return scene;
}

/// @return how many pieces there were.
template <class T>
int expect_operators_of_host(const Scene& scene) {
  const AtRest<T> rest(scene);
  const std::vector<std::vector<double>> operators =
      by_device(rest, ModeLists<T>(scene, rest.encoder));
  for (size_t p = 0; p < operators.size(); ++p) {
    SCOPED_TRACE(p);
    EXPECT_LT(largest_difference(operators[p], rest.encoder.pieces()[p].rest), kRounding);
  }
  return int(operators.size());
}

std::vector<NamedScene> all_scenes() {
  std::vector<NamedScene> scenes = multigrid_scenes();
  scenes.push_back({"three blocks", three_blocks(TimeScheme::kEuler)});
  scenes.push_back({"falling bar", falling_bar(TimeScheme::kEuler)});
  scenes.push_back({"rows of three materials", rows_of_three_materials()});
  scenes.push_back({"held bar", swinging_bar(TimeScheme::kEuler)});
  scenes.push_back({"block on a ball", block_on_ball(TimeScheme::kEuler)});
  return scenes;
}

template <class T>
void check_scenes() {
  int pieces = 0;
  for (NamedScene& named : all_scenes())
    for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
      SCOPED_TRACE(named.name + ", hourglass " + std::to_string(int(hourglass)));
      named.scene.hourglass = hourglass;
      finish_scene(named.scene);
      pieces += expect_operators_of_host<T>(named.scene);
    }
  EXPECT_GE(pieces, 3 * 12);
}

TEST_F(RestOperatorOnCard, OperatorsAreThoseOfTheHostInDouble) {
  check_scenes<double>();
}

TEST_F(RestOperatorOnCard, OperatorsAreThoseOfTheHostInFloat) {
  check_scenes<float>();
}

/// Bit for bit. @return how many modes there were.
template <class T>
size_t expect_modes_of_host(const Scene& scene) {
  const AtRest<T> rest(scene);
  const ModeLists<T> expected(scene, rest.encoder);
  std::vector<std::vector<int32_t>> pieces;
  for (const auto& piece : rest.encoder.pieces()) pieces.push_back(piece.nodes);
  cuda::DevicePotential device(rest.potential);
  const auto found = cuda::modes_by_device<T>(device, pieces);
  EXPECT_EQ(found.size(), expected.modes.size());
  size_t others = 0, there = 0;
  for (size_t k = 0; k < found.size(); ++k) {
    others += double(found[k]) != double(expected.modes[k]);
    there += double(found[k]) != 0;
  }
  EXPECT_EQ(others, 0u);
  EXPECT_GE(2 * there, found.size());
  return found.size();
}

TEST_F(RestOperatorOnCard, ModesAreThoseOfTheHost) {
  size_t modes = 0;
  for (const NamedScene& named : all_scenes()) {
    SCOPED_TRACE(named.name);
    modes += expect_modes_of_host<float>(named.scene);
    modes += expect_modes_of_host<double>(named.scene);
  }
  EXPECT_GT(modes, 1000000u);
}

template <class Vector>
size_t differences(const Vector& a, const Vector& b) {
  EXPECT_EQ(a.size(), b.size());
  if (a.size() != b.size()) return 1;
  size_t count = 0;
  for (size_t k = 0; k < a.size(); ++k) count += !(a[k] == b[k]);
  return count;
}

TEST_F(RestOperatorOnCard, TablesOfVoxelsAreThoseOfTheHost) {
  int64_t border_rows = 0, shared = 0;
  for (const NamedScene& named : all_scenes()) {
    SCOPED_TRACE(named.name);
    const IncrementalPotential host(named.scene);
    cuda::DevicePotential device(host);
    // tables are equal to the bit
    const BrickRows found = device.download_rows();
    const BrickRows& expected = host.rows();
    EXPECT_EQ(differences(found.rows, expected.rows), 0u);
    EXPECT_EQ(found.row_begin, expected.row_begin);
    EXPECT_EQ(found.tile_begin, expected.tile_begin);
    EXPECT_EQ(differences(found.tile_node, expected.tile_node), 0u);
    EXPECT_EQ(differences(found.tile_place, expected.tile_place), 0u);
    EXPECT_EQ(differences(found.tile_part, expected.tile_part), 0u);
    EXPECT_EQ(found.shared_node, expected.shared_node);
    EXPECT_EQ(found.shared_begin, expected.shared_begin);
    EXPECT_EQ(differences(found.border, expected.border), 0u);
    const std::vector<double> weights(host.voxel_weights().begin(), host.voxel_weights().end());
    EXPECT_EQ(differences(device.download_weights(), weights), 0u);
    border_rows += int64_t(expected.border.size());
    shared += int64_t(expected.shared_node.size());
  }
  // some scenes have border rows and shared nodes
  EXPECT_GT(border_rows, 0);
  EXPECT_GT(shared, 0);
}

TEST_F(RestOperatorOnCard, AModeOfOneNodeChangesIt) {
  const Scene scene = ragged_of_two_materials(19, 13, 11);
  const AtRest<double> rest(scene);
  const auto& piece = rest.encoder.pieces().at(0);
  ASSERT_EQ(rest.encoder.piece_count(), 1);
  const size_t local = piece.nodes.size() / 2, mode = local * Encoder<double>::kModes + 19;
  ModeLists<double> lists(scene, rest.encoder);
  Zeroed<double> modes = piece.modes;
  lists.modes[mode] = modes[mode] += 0.125;

  Zeroed<EncoderPlace> place(size_t(scene.grid.node_count()));
  for (EncoderPlace& none : place) none.piece = -1;
  for (size_t k = 0; k < piece.nodes.size(); ++k) place[size_t(piece.nodes[k])] = {0, int32_t(k)};
  std::vector<int32_t> voxels;
  for (int32_t v = 0; v < scene.grid.voxel_count(); ++v)
    if (place[size_t(scene.grid.corners(v, 0))].piece == 0) voxels.push_back(v);
  const std::vector<double> expected =
      reduced_rest_operator<double>(rest.potential, {piece.nodes, place, voxels, modes});
  const std::vector<double> found = by_device(rest, lists)[0];
  EXPECT_LT(largest_difference(found, expected), kRounding);
  EXPECT_GT(largest_difference(found, piece.rest), 1e6 * kRounding);
}

TEST_F(RestOperatorOnCard, TheMaterialOfOneVoxelChangesIt) {
  Scene scene = box_at({-9, -8, -1}, 18, 17, 16);
  scene.materials.push_back(solid(3e5, 0.2));
  finish_scene(scene);
  const AtRest<float> before(scene);
  Scene changed = scene;
  changed.material(scene.grid.voxel_count() / 3) = 1;
  finish_scene(changed);
  const AtRest<float> after(changed);
  const std::vector<double> found = by_device(after, ModeLists<float>(changed, after.encoder))[0];
  EXPECT_LT(largest_difference(found, after.encoder.pieces()[0].rest), kRounding);
  EXPECT_GT(largest_difference(found, before.encoder.pieces()[0].rest), 1e6 * kRounding);
}

TEST_F(RestOperatorOnCard, OfNoEntriesItIsZero) {
  const Scene scene = box_at({0, 0, 0}, 7, 7, 7);
  const AtRest<float> rest(scene);
  ModeLists<float> lists(scene, rest.encoder);
  lists.begin = {5, 5};
  const std::vector<double> found = by_device(rest, lists)[0];
  EXPECT_EQ(found, std::vector<double>(found.size()));
}

}  // namespace
}  // namespace elastogen::test

#endif
