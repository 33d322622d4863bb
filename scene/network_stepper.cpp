// SPDX-License-Identifier: Apache-2.0
#include "scene/network_stepper.hpp"

#include "network/contact.hpp"

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

/// What both machines share.
class NetworkStepper : public Stepper {
 public:
  NetworkStepper(const Scene& scene, const SolverOptions& options, std::unique_ptr<Solver> solver)
      : scene_(scene),
        nets_(options.learned),
        tolerance_(options.tolerance),
        solver_(std::move(solver)) {}

  void begin(const StartMotion& motion) override { begin_at(initial_state(scene_, motion)); }
  Span<const double> residual() const override { return solver_->residual(); }
  std::string device() const override { return solver_->device(); }

  void describe(StateHeader& header) const override {
    header.solver = solver_name(solver_->mode());
    header.tolerance = tolerance_;
    for (const auto& net : nets_) header.nets.push_back(net ? state_net(*net) : StateNet());
    if (!nets_.empty()) header.energy = "neural";
    if (!scene_.colliders.empty())
      header.contact = {{"layer", contact_layer(scene_)}, {"slip_range", slip_range(scene_)}};
  }

 protected:
  const Scene& scene_;
  LearnedLaws nets_;
  double tolerance_;
  std::unique_ptr<Solver> solver_;
};

/// Its state lies here, and steps work on it in place.
class CpuStepper : public NetworkStepper {
 public:
  using NetworkStepper::NetworkStepper;

  void begin_at(const State& state) override { state_ = state; }
  StepReport advance() override { return solver_->step(state_); }
  const State& state() override { return state_; }
  bool fits_single() const override { return elastogen::fits_single(state_.x); }
  void carry(const CarriedPoints& points, bool with_gradient) override {
    frames_.emplace(scene_.grid, points, with_gradient);
  }
  int64_t start_frame() override { return frames_->make(state_.x); }
  CarriedFrame take_frame(int64_t number) const override { return frames_->take(number); }

 private:
  State state_;
  std::optional<NodeFrames> frames_;
};

/// Its state stays on the card, where frames are made too.
class CardStepper : public NetworkStepper {
 public:
  using NetworkStepper::NetworkStepper;

  void begin_at(const State& state) override {
    state_ = state;
    solver_->begin(state);
  }
  StepReport advance() override { return solver_->advance(); }
  const State& state() override {
    solver_->read(state_);
    return state_;
  }
  bool fits_single() const override { return solver_->reach() < kLargestSingle; }
  void carry(const CarriedPoints& points, bool with_gradient) override {
    solver_->carry(points.embedding, with_gradient);
  }
  int64_t start_frame() override { return solver_->start_frame(); }
  CarriedFrame take_frame(int64_t number) const override { return solver_->take_frame(number); }

 private:
  State state_;  ///< as it was read last
};

}  // namespace

std::unique_ptr<Stepper> make_network_stepper(const Scene& scene, const SolverOptions& options) {
  auto solver = std::make_unique<Solver>(scene, options);
  if (solver->device() == "cpu")
    return std::make_unique<CpuStepper>(scene, options, std::move(solver));
  return std::make_unique<CardStepper>(scene, options, std::move(solver));
}

}  // namespace elastogen
