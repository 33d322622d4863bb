// SPDX-License-Identifier: Apache-2.0
#include "network/step/host_stage_machine.hpp"

namespace elastogen {
HostStageMachine::HostStageMachine(IncrementalPotential& potential)
    : potential_(potential),
      pieces_(potential.scene()),
      first_stage_(3 * size_t(potential.scene().grid.node_count())),
      field_(first_stage_.size()) {
  for (const std::vector<int32_t>& nodes : pieces_.nodes()) first_.push_back(nodes.front());
}

StageNodes HostStageMachine::nodes() {
  const Scene& s = scene();
  StageNodes nodes;
  nodes.rest = s.grid.rest.data();
  nodes.mass = s.mass.data();
  nodes.pinned = pieces_.kinds().data();
  nodes.piece = s.grid.piece.data();
  nodes.first = first_.data();
  nodes.first_stage = first_stage_.data();
  nodes.parents = s.dependent.filled().view();
  nodes.gravity = s.gravity;
  nodes.load = potential_.loads().data();
  return nodes;
}

void HostStageMachine::run(const NodePass& pass) {
  std::visit(
      [&](const auto& body) {
        for_each(scene().grid.node_count(), body);
        complete_held(body, potential_.held());
      },
      pass);
}

std::vector<PieceSums> HostStageMachine::sum(const NodeSum& sum) {
  std::vector<PieceSums> result(pieces_.count());
  std::visit(
      [&](const auto& add) {
        for (size_t p = 0; p < result.size(); ++p)
          result[p] = pieces_.sum<kPieceSums>(
              p, [&](int64_t n, PieceSums& of_piece) { add(n, of_piece.data()); });
      },
      sum);
  return result;
}

}  // namespace elastogen
