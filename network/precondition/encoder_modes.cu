// SPDX-License-Identifier: Apache-2.0
// Compiled without fused operations, like the CPU's source, so that the modes equal its bit by bit.
#include "core/cuda/held_nodes.cuh"
#include "core/cuda/reduce.cuh"
#include "network/precondition/encoder_modes.cuh"
#include "network/precondition/encoder_modes.hpp"

#include <climits>

namespace elastogen::cuda {
namespace {

/// Extent of some nodes, at rest [m] and on the lattice.
struct Extent {
  double lower[3] = {1e300, 1e300, 1e300}, upper[3] = {-1e300, -1e300, -1e300};
  LatticeBox planes = {{{INT_MAX, INT_MAX, INT_MAX}}, {{INT_MIN, INT_MIN, INT_MIN}}};

  __device__ void add(const Extent& o) {
    for (int d = 0; d < 3; ++d) {
      lower[d] = fmin(lower[d], o.lower[d]);
      upper[d] = fmax(upper[d], o.upper[d]);
    }
    planes.add(o.planes);
  }
};

/// Tables by the number of a node.
struct NodeSource {
  const double* rest;
  const int32_t *coord, *piece;  ///< lattice coordinates; piece of the grid
  const uint8_t* pinned;

  __device__ LatticePlace place(int64_t n) const {
    return {{coord[3 * n], coord[3 * n + 1], coord[3 * n + 2]}};
  }
};

/// Extent of `count` nodes. Waits for the device.
Extent extent_of(const NodeSource& source, const int32_t* nodes, int64_t count) {
  DeviceArray<SumScratch<Extent>> scratch(1);
  PinnedArray<Extent> result(1);
  Extent* const to = result.data();
  ordered_sum(
      count, scratch.data(),
      [=] __device__(int64_t k, Extent & sum) {
        const int64_t n = nodes[k];
        Extent of;
        for (int d = 0; d < 3; ++d) of.lower[d] = of.upper[d] = source.rest[3 * n + d];
        of.planes = {source.place(n), source.place(n)};
        sum.add(of);
      },
      [=] __device__(const Extent& sum) { *to = sum; });
  synchronise();
  return result[0];
}

/// PinTrees in device memory.
struct PinTreesOnDevice {
  explicit PinTreesOnDevice(const PinTrees& of)
      : places(of.places), boxes(of.boxes), trees(of.trees) {}
  PinTreesView view() const { return {places.data(), boxes.data(), trees.data()}; }

  DeviceArray<LatticePlace> places;
  DeviceArray<LatticeBox> boxes;
  DeviceArray<PinTree> trees;
};

/// Distance to the nearest pin [m], 1e300 if there is none.
__device__ double pin_distance(const NodeSource& source, const PinTreesView& pins, double h,
                               int64_t n) {
  if (source.pinned[n]) return 0;
  const PinTree& tree = pins.trees[source.piece[n]];
  if (tree.count == 0) return 1e300;
  const LatticePlace at = source.place(n);
  const LatticePlace pin = pins.nearest(source.piece[n], at, pins.places[tree.first]);
  return h * sqrt(double(square_between(at, pin)));
}

template <class T>
void fill_modes(const NodeSource& source, const PinTreesView& pins, double h, const int32_t* nodes,
                int64_t count, ModeNumber<T>* values) {
  const Extent extent = extent_of(source, nodes, count);
  Box box;
  for (size_t d = 0; d < 3; ++d) box.lower[d] = extent.lower[d], box.upper[d] = extent.upper[d];
  const PlaneCosines cosines(h, extent.planes, lowest_waves(box, kEncoderCosines), box);
  ModeShape shape = mode_shape(box, cosines);
  const DeviceArray<double> table[3] = {DeviceArray<double>(cosines.table(0)),
                                        DeviceArray<double>(cosines.table(1)),
                                        DeviceArray<double>(cosines.table(2))};
  for (int d = 0; d < 3; ++d) shape.cosines.table[d] = table[d].data();
  cuda::for_each(count, [=] __device__(int64_t k) {
    const int64_t n = nodes[k];
    const LatticePlace at = source.place(n);
    for_modes<T>(shape, pin_distance(source, pins, h, n), at.at, source.rest + 3 * n,
                 [=](int m, T value) { values[k * kEncoderModes + m] = ModeNumber<T>(value); });
  });
  synchronise();
}

/// Modes of dependent nodes follow those of their parent nodes in the same piece.
/// @param piece  of the grid, (nodes)
template <class T>
void follow_parents(const DevicePotential& potential, const int32_t* piece,
                    PieceModesOnDevice<T>& made) {
  const WeightedSums of = potential.held().dependent().sums();
  if (of.count == 0) return;
  // entry of each node, -1: in no piece
  DeviceArray<int32_t> entries(potential.nodes());
  int32_t* const entry = entries.data();
  check(
      cudaMemsetAsync(entry, 0xff, size_t(entries.size()) * sizeof(int32_t), cudaStreamPerThread));
  const int32_t* const node = made.nodes.data();
  cuda::for_each(made.nodes.size(), [=] __device__(int64_t k) { entry[node[k]] = int32_t(k); });
  ModeNumber<T>* const values = made.values.data();
  cuda::for_each(of.count * kEncoderModes, [=] __device__(int64_t k) {
    const int64_t i = k / kEncoderModes, m = k % kEncoderModes, n = of.nodes[i];
    if (entry[n] < 0) return;
    double sum = 0;
    for (int32_t s = of.begin[i]; s < of.begin[i + 1]; ++s) {
      const int64_t parent = of.sources[s];
      if (piece[parent] != piece[n]) continue;
      sum += of.weights[s] * double(T(values[entry[parent] * int64_t(kEncoderModes) + m]));
    }
    values[entry[n] * int64_t(kEncoderModes) + m] = ModeNumber<T>(kept_sum(sum, T{}));
  });
  synchronise();
}

}  // namespace

template <class T>
PieceModesOnDevice<T> make_modes(DevicePotential& potential,
                                 const std::vector<std::vector<int32_t>>& pieces) {
  const Scene& scene = potential.terms().scene();
  const VoxelGrid& grid = scene.grid;
  PieceModesOnDevice<T> made;
  made.first.push_back(0);
  for (const std::vector<int32_t>& nodes : pieces)
    made.first.push_back(made.first.back() + int32_t(nodes.size()));
  made.nodes = DeviceArray<int32_t>(made.first.back());
  made.values = DeviceArray<ModeNumber<T>>(made.nodes.size() * kEncoderModes);
  if (MemoryCount::present()) return made;
  for (size_t p = 0; p < pieces.size(); ++p)
    made.nodes.upload(pieces[p].data(), made.first[p], int64_t(pieces[p].size()));
  const DeviceArray<int32_t> coord(grid.node_coord.data(), grid.node_coord.size());
  const DeviceArray<int32_t> piece(grid.piece.data(), grid.piece.size());
  const PinTreesOnDevice pins{PinTrees(scene)};
  const NodeSource source{potential.rest(), coord.data(), piece.data(), potential.pinned()};
  for (size_t p = 0; p < pieces.size(); ++p)
    fill_modes<T>(source, pins.view(), grid.h, made.nodes.data() + made.first[p],
                  int64_t(pieces[p].size()),
                  made.values.data() + int64_t(made.first[p]) * kEncoderModes);
  follow_parents<T>(potential, piece.data(), made);
  return made;
}

template <class T>
std::vector<ModeNumber<T>> modes_by_device(DevicePotential& potential,
                                           const std::vector<std::vector<int32_t>>& pieces) {
  const PieceModesOnDevice<T> made = make_modes<T>(potential, pieces);
  std::vector<ModeNumber<T>> values(size_t(made.values.size()));
  made.values.download(values.data());
  return values;
}

template PieceModesOnDevice<float> make_modes(DevicePotential&,
                                              const std::vector<std::vector<int32_t>>&);
template PieceModesOnDevice<double> make_modes(DevicePotential&,
                                               const std::vector<std::vector<int32_t>>&);
template std::vector<ModeNumber<float>> modes_by_device<float>(
    DevicePotential&, const std::vector<std::vector<int32_t>>&);
template std::vector<ModeNumber<double>> modes_by_device<double>(
    DevicePotential&, const std::vector<std::vector<int32_t>>&);

}  // namespace elastogen::cuda
