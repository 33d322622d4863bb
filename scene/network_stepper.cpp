// SPDX-License-Identifier: Apache-2.0
#include "scene/network_stepper.hpp"

#include "network/contact/contact.hpp"

#include <algorithm>

namespace elastogen {
namespace {

StateNet state_net(const LearnedLaw& net) {
  StateNet result;
  result.hash = net.hash();
  result.weights = net.weights();
  if (net.evaluation() == Evaluation::kTable) {
    result.cells = net.table().cells();
    result.table = net.table().coefficients();
  }
  return result;
}

/// Steps by a Solver, which holds the state, on the host or on a card.
class NetworkStepper : public Stepper {
 public:
  NetworkStepper(const Scene& scene, const SolverOptions& options)
      : scene_(scene),
        nets_(options.learned),
        tolerance_(options.tolerance),
        solver_(scene, options) {}

  void begin(const StartMotion& motion) override { begin_at(initial_state(scene_, motion)); }
  void begin_at(const State& state) override { solver_.begin(state); }
  StepReport advance() override { return solver_.advance(); }
  const State& state() override {
    solver_.read(state_);
    return state_;
  }
  StageData stage_data() const override { return solver_.stage_data(); }
  bool fits_single() const override { return solver_.reach() < kLargestSingle; }
  void carry(const CarriedPoints& points, bool with_gradient) override {
    solver_.carry(points.embedding, with_gradient);
  }
  int64_t start_frame() override { return solver_.start_frame(); }
  CarriedFrame take_frame(int64_t number) const override { return solver_.take_frame(number); }
  Span<const double> residual() const override { return solver_.residual(); }
  std::string device() const override { return solver_.device(); }

  void describe(StateHeader& header) const override {
    header.solver = solver_name(solver_.mode());
    header.traction = scene_.load;
    header.forces = scene_.forces;
    header.fixed = fixed_components();
    header.moved = std::ranges::any_of(scene_.holders, [](const Holder& h) { return h.moves(); });
    header.tolerance = tolerance_;
    for (const auto& net : nets_) header.nets.push_back(net ? state_net(*net) : StateNet());
    if (!nets_.empty()) header.energy = "neural";
    if (!scene_.colliders.empty())
      header.contact = {{"layer", contact_layer(scene_)},
                        {"slip_range", slip_range(scene_)},
                        {"impact_speed", scene_.impact_speed}};
  }

 private:
  /// 1 where a component is pinned or fixed, (nodes, 3); empty: pins alone hold.
  Array<uint8_t> fixed_components() const {
    Array<uint8_t> fixed(scene_.fixed.rows(), 3);
    for (int64_t n = 0; n < fixed.rows(); ++n)
      for (int d = 0; d < 3; ++d)
        fixed(n, d) = scene_.pinned(n) == kPinnedNode || scene_.fixed(n, d) >= 0;
    return fixed;
  }

  const Scene& scene_;
  LearnedLaws nets_;
  double tolerance_;
  Solver solver_;
  State state_;  ///< as it was read last
};

}  // namespace

std::unique_ptr<Stepper> make_network_stepper(const Scene& scene, const SolverOptions& options) {
  return std::make_unique<NetworkStepper>(scene, options);
}

}  // namespace elastogen
