// SPDX-License-Identifier: Apache-2.0
#include "cli/stepper.hpp"

#include "cli/fem_stepper.hpp"
#include "cli/static_stepper.hpp"
#include "cli/weights.hpp"
#include "network/contact.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kLargestSingle = 1e37;

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

class NetworkStepper : public Stepper {
 public:
  NetworkStepper(const Scene& scene, const SolverOptions& options)
      : scene_(scene),
        nets_(options.learned),
        tolerance_(options.tolerance),
        solver_(scene, options),
        on_card_(solver_.device() != "cpu") {}

  State start(const StartMotion& motion) const override { return initial_state(scene_, motion); }
  StepReport step(State& state) override { return solver_.step(state); }
  // steps on the CPU work on the state in place
  void begin(const State& state) override {
    if (on_card_) solver_.begin(state);
  }
  StepReport advance(State& state) override {
    return on_card_ ? solver_.advance() : solver_.step(state);
  }
  void read(State& state) const override {
    if (on_card_) solver_.read(state);
  }
  bool fits_single(const State& state) const override {
    return on_card_ ? solver_.reach() < kLargestSingle : Stepper::fits_single(state);
  }
  bool carry(const Embedding& embedding, bool with_gradient) override {
    if (on_card_) solver_.carry(embedding, with_gradient);
    return on_card_;
  }
  int64_t start_frame() override { return solver_.start_frame(); }
  CarriedFrame take_frame(int64_t number) const override { return solver_.take_frame(number); }
  Span<const double> residual() const override { return solver_.residual(); }
  std::string device() const override { return solver_.device(); }

  void describe(StateHeader& header) const override {
    header.solver = solver_name(solver_.mode());
    header.tolerance = tolerance_;
    for (const auto& net : nets_) header.nets.push_back(net ? state_net(*net) : StateNet());
    if (!nets_.empty()) header.energy = "neural";
    if (!scene_.colliders.empty())
      header.contact = {{"layer", contact_layer(scene_)}, {"slip_range", slip_range(scene_)}};
  }

 private:
  const Scene& scene_;
  LearnedLaws nets_;
  double tolerance_;
  Solver solver_;
  bool on_card_;  // asking the card for its name takes longer than a small step
};

}  // namespace

bool Stepper::fits_single(const State& state) const {
  const auto fits = [](double value) { return std::abs(value) < kLargestSingle; };
  return std::all_of(state.x.data(), state.x.data() + state.x.size(), fits);
}

std::unique_ptr<Stepper> make_stepper(const Setup& setup, const AnimateOptions& options,
                                      std::function<bool()> interrupted,
                                      std::vector<std::string>& notes) {
  if (options.fem && options.fem->statics) return make_static_stepper(setup, options);
  if (options.fem) return make_fem_stepper(setup, options, std::move(interrupted));
  SolverOptions solver = options.solver;
  solver.learned = scene_nets(setup.scene, options, notes);
  solver.interrupted = std::move(interrupted);
  return std::make_unique<NetworkStepper>(setup.scene, solver);
}

}  // namespace elastogen
