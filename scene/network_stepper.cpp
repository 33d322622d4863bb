// SPDX-License-Identifier: Apache-2.0
#include "scene/network_stepper.hpp"

#include "network/contact.hpp"
#include "scene/host_stepper.hpp"

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

/// Members that the steppers of CPU and card share.
struct Network {
  const Scene& scene;
  LearnedLaws nets;
  double tolerance;
  std::unique_ptr<Solver> solver;

  void describe(StateHeader& header) const {
    header.solver = solver_name(solver->mode());
    header.tolerance = tolerance;
    for (const auto& net : nets) header.nets.push_back(net ? state_net(*net) : StateNet());
    if (!nets.empty()) header.energy = "neural";
    if (!scene.colliders.empty())
      header.contact = {{"layer", contact_layer(scene)}, {"slip_range", slip_range(scene)}};
  }
};

/// Steps on the CPU, which change the state in place.
class CpuStepper : public HostStepper {
 public:
  explicit CpuStepper(Network network)
      : HostStepper(network.scene.grid), network_(std::move(network)) {}

  void begin(const StartMotion& motion) override {
    begin_at(initial_state(network_.scene, motion));
  }
  StepReport advance() override { return network_.solver->step(state_); }
  Span<const double> residual() const override { return network_.solver->residual(); }
  void describe(StateHeader& header) const override { network_.describe(header); }

 private:
  Network network_;
};

/// Steps on a card, where the state stays and frames are made.
class CardStepper : public Stepper {
 public:
  explicit CardStepper(Network network) : network_(std::move(network)) {}

  void begin(const StartMotion& motion) override {
    begin_at(initial_state(network_.scene, motion));
  }
  void begin_at(const State& state) override {
    state_ = state;
    network_.solver->begin(state);
  }
  StepReport advance() override { return network_.solver->advance(); }
  const State& state() override {
    network_.solver->read(state_);
    return state_;
  }
  bool fits_single() const override { return network_.solver->reach() < kLargestSingle; }
  void carry(const CarriedPoints& points, bool with_gradient) override {
    network_.solver->carry(points.embedding, with_gradient);
  }
  int64_t start_frame() override { return network_.solver->start_frame(); }
  CarriedFrame take_frame(int64_t number) const override {
    return network_.solver->take_frame(number);
  }
  Span<const double> residual() const override { return network_.solver->residual(); }
  std::string device() const override { return network_.solver->device(); }
  void describe(StateHeader& header) const override { network_.describe(header); }

 private:
  Network network_;
  State state_;  ///< the state as it was read last
};

}  // namespace

std::unique_ptr<Stepper> make_network_stepper(const Scene& scene, const SolverOptions& options) {
  Network network = {scene, options.learned, options.tolerance,
                     std::make_unique<Solver>(scene, options)};
  if (network.solver->device() == "cpu") return std::make_unique<CpuStepper>(std::move(network));
  return std::make_unique<CardStepper>(std::move(network));
}

}  // namespace elastogen
