// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/held_nodes.cuh"
#include "network/step/device_stage_machine.cuh"

#include <algorithm>

namespace elastogen::cuda {
namespace {

/// The sum of a node, for the sums over groups.
template <class Add>
struct NodeOfPiece {
  Add add;
  __device__ void operator()(int64_t, int64_t n, Sums<kPieceSums>& sum) const { add(n, sum.value); }
};

struct KeepPieceSum {
  Sums<kPieceSums>* to;
  __device__ void operator()(int64_t p, const Sums<kPieceSums>& sum) const { to[p] = sum; }
};

}  // namespace

DeviceStageMachine::DeviceStageMachine(DevicePotential& potential)
    : potential_(potential),
      pieces_(scene()),
      groups_(pieces_.nodes()),
      piece_(scene().grid.piece.data(), scene().grid.node_count()),
      kinds_(pieces_.kinds()),
      first_stage_(3 * potential.nodes()),
      field_(3 * potential.nodes()),
      poses_(groups_.count()),
      motions_(groups_.count()),
      parts_(groups_.chunks()),
      sums_(groups_.count()) {}

StageNodes DeviceStageMachine::nodes() {
  StageNodes nodes;
  nodes.rest = potential_.rest();
  nodes.mass = potential_.mass();
  nodes.pinned = kinds_.data();
  nodes.piece = piece_.data();
  nodes.first = groups_.view().first;
  nodes.first_stage = first_stage_.data();
  nodes.parents = potential_.held().dependent().sums();
  nodes.gravity = scene().gravity;
  nodes.load = potential_.load();
  return nodes;
}

const PiecePoses* DeviceStageMachine::put(const std::vector<PiecePoses>& of) {
  poses_.upload(of.data());
  return poses_.data();
}

const PieceMotion* DeviceStageMachine::put(const std::vector<PieceMotion>& of) {
  motions_.upload(of.data());
  return motions_.data();
}

void DeviceStageMachine::run(const NodePass& pass) {
  std::visit(
      [&](const auto& body) {
        cuda::for_each(potential_.nodes(), body);
        complete_held(body, potential_.held());
      },
      pass);
}

std::vector<PieceSums> DeviceStageMachine::sum(const NodeSum& sum) {
  std::visit(
      [&](const auto& add) {
        using Add = std::decay_t<decltype(add)>;
        groups_.sums(parts_, NodeOfPiece<Add>{add}, KeepPieceSum{sums_.data()});
      },
      sum);
  synchronise();
  std::vector<PieceSums> result(size_t(groups_.count()));
  for (size_t p = 0; p < result.size(); ++p)
    std::copy_n(sums_[int64_t(p)].value, kPieceSums, result[p].begin());
  return result;
}

}  // namespace elastogen::cuda
