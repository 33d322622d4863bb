// SPDX-License-Identifier: Apache-2.0
#include "tests/stress/runner.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/stress/equations.hpp"

#include <malloc.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <optional>

namespace elastogen::stress {
namespace {

constexpr double kEnergyShare = 1e-6;  // of the largest energy of the run
constexpr double kSlowStep = 20;       // times the median work of a step

bool finite(const Array<double>& a) {
  return std::all_of(a.data(), a.data() + a.size(), [](double v) { return std::isfinite(v); });
}

/// Noise of the residual in float64: that of strains, as float_floor is in float and 2^29 times
/// smaller, and that of positions over dt^2.
double double_floor(const Scene& scene, const State& state) {
  double farthest = 0;
  for (int64_t k = 0; k < state.x.size(); ++k)
    farthest = std::max(farthest, std::abs(state.x.data()[k]));
  const double places = std::exp2(-53) * farthest / (scene.dt * scene.dt * 9.81);
  return 4 * std::exp2(-29) * float_floor(scene) + 16 * places;
}

/// By how much the recomputed residual changes where positions change by their last bit: voxels
/// that an impact has folded have forces far above those that the floor counts with.
double rounding(const Scene& scene, const State& before, State after, TimeScheme scheme,
                double residual) {
  for (int64_t k = 0; k < after.x.size(); ++k)
    after.x.data()[k] = std::nextafter(after.x.data()[k], k % 2 == 0 ? 1e300 : -1e300);
  return std::abs(balance(scene, before, after, scheme).residual - residual);
}

/// Checks of one step; remembers the first fault of each kind only.
class Watch {
 public:
  Watch(Record& record, const Plan& plan) : record_(record), plan_(plan) {}

  void step(const Scene& scene, const State& before, const State& after, const StepReport& r) {
    record_.iterations.push_back(r.inner);
    record_.drafts += r.finite && !r.converged;
    record_.refusals += !r.finite;
    if (r.float64) {
      record_.float64 = true;
      record_.first_float64 = std::min(record_.first_float64, float_floor(scene));
    }
    const bool bounded = finite(after.x) && finite(after.v) && std::isfinite(r.residual) &&
                         std::isfinite(r.energy.kinetic + r.energy.elastic + r.energy.hourglass +
                                       r.energy.gravity + r.energy.contact);
    fault(0, bounded || !r.finite, "step ", r.step, ": a number is not finite");
    fault(1, r.finite || hash(before) == hash(after), "step ", r.step,
          ": refused, but the state moved");
    if (!r.finite || r.step % plan_.check_every != 0) return;
    const Balance b = balance(scene, before, after, r.scheme);
    const double floor = double_floor(scene, after);
    const double limit = plan_.options.tolerance * (1 + 1e-9) + floor;
    fault(2, !r.converged || b.residual <= limit, "step ", r.step, ": converged, but the residual ",
          "is ", b.residual);
    // a draft a million tolerances away has points within rounding of a collider: there the last
    // bits of a position decide the barrier's force
    const bool lost = std::min(b.residual, r.residual) > 1e6 * plan_.options.tolerance;
    const double gap = std::abs(b.residual - r.residual);
    fault(3,
          lost || gap <= 1e-6 * b.residual + floor ||
              gap <= 16 * rounding(scene, before, after, r.scheme, b.residual),
          "step ", r.step, ": residual ", r.residual, " reported, ", b.residual, " recomputed");
    energy(b, r);
  }

 private:
  /// E' <= E + work of gravity and of the forces left unbalanced.
  void energy(const Balance& b, const StepReport& r) {
    if (!plan_.passive || plan_.check_every != 1 || r.scheme != TimeScheme::kEuler) return;
    const double start = last_energy_.value_or(b.energy_before);
    last_energy_ = b.energy;
    largest_ = std::max({largest_, start, b.energy, std::abs(b.gravity_work)});
    const double gain = b.energy - start - b.gravity_work - std::max(b.residual_work, 0.0);
    const double turned = b.energy_before - start, concave = std::max(0.0, -b.convexity);
    fault(4, gain <= kEnergyShare * largest_, "step ", r.step, ": energy rises by ",
          gain / largest_, " of the largest; ", turned / largest_,
          " came with new torsion rotations, up to ", concave / largest_,
          " with negative curvature");
  }

  template <class... Parts>
  void fault(int kind, bool condition, const Parts&... parts) {
    if (condition || seen_[kind]) return;
    seen_[kind] = true;
    record_.faults.push_back(concat(parts...));
  }

  Record& record_;
  const Plan& plan_;
  bool seen_[5] = {};
  std::optional<double> last_energy_;
  double largest_ = 0;
};

using Seen = std::function<void(const State& before, const State& after, const StepReport&)>;

Outcome steps(Scene& scene, const State& start, const Plan& plan, int count, const Seen& seen) {
  Outcome outcome{start, {}};
  Solver solver(scene, plan.options);
  for (int k = 0; k < count; ++k) {
    if (plan.before_step) plan.before_step(scene, k);
    State before;
    if (seen) before = outcome.state;
    outcome.reports.push_back(solver.step(outcome.state));
    const StepReport& report = outcome.reports.back();
    if (seen) seen(before, outcome.state, report);
    if (!report.finite || (plan.done && plan.done(outcome.state, report))) break;
  }
  return outcome;
}

int64_t status(const char* key) {
  std::ifstream file("/proc/self/status");
  for (std::string word; file >> word;)
    if (int64_t kilobytes = 0; word == key && file >> kilobytes) return 1024 * kilobytes;
  return 0;
}

/// How a run ended, from its reports.
void label_run(Record& record, const Outcome& outcome) {
  const size_t count = outcome.reports.size();
  if (record.refusals > 0)
    record.label = concat("refused at step ", count, ": not finite");
  else if (record.drafts > 0)
    record.label = concat("draft ", record.drafts, " of ", record.iterations.size());
  else
    record.label = "converged";
  std::vector<int> work;
  for (const StepReport& r : outcome.reports) work.push_back(r.inner);
  if (work.empty()) return;
  std::nth_element(work.begin(), work.begin() + long(count / 2), work.end());
  const double median = std::max(1, work[count / 2]);
  for (const StepReport& r : outcome.reports)
    if (r.inner > kSlowStep * median) {
      record.note("step ", r.step, " took ", r.inner / median, " times the median work");
      break;
    }
}

}  // namespace

Outcome run(Record& record, Scene& scene, const State& start, const Plan& plan) {
  Outcome outcome{start, {}};
  const Vec3 gravity = scene.gravity;
  try {
    Watch watch(record, plan);
    // two threads, checked step by step
    std::vector<uint64_t> hashes;
    {
      const ThreadLimit threads(2);
      outcome = steps(scene, start, plan, plan.steps,
                      [&](const State& before, const State& after, const StepReport& r) {
                        watch.step(scene, before, after, r);
                        hashes.push_back(hash(after));
                      });
    }
    label_run(record, outcome);
    // one thread, compared by hashes
    scene.gravity = gravity;
    const ThreadLimit threads(1);
    size_t step = 0;
    bool same = true;
    steps(scene, start, plan, std::min(int(hashes.size()), plan.repeated_steps),
          [&](const State&, const State& after, const StepReport&) {
            same = same && hash(after) == hashes[step];
            ++step;
          });
    record.expect(same, "one thread gives other bits than two");
  } catch (const Error& error) {
    record.label = concat("refused: ", error.what());
    ++record.refusals;
  }
  return outcome;
}

Outcome plain_run(Scene& scene, const State& start, const Plan& plan) {
  const ThreadLimit threads(2);
  return steps(scene, start, plan, plan.steps, {});
}

void expect_error(Record& record, const std::function<void()>& action, ErrorKind kind) {
  try {
    action();
  } catch (const Error& error) {
    record.label = concat("refused: ", error.what());
    record.expect(error.kind() == kind, "an error of kind ", int(error.kind()), ", not ",
                  int(kind));
    return;
  }
  record.label = "accepted";
  record.faults.push_back("accepted, should be refused");
}

uint64_t hash(const State& state) {
  uint64_t h = 14695981039346656037u;
  for (const Array<double>* a : {&state.x, &state.v})
    for (int64_t k = 0; k < a->size(); ++k)
      h = (h ^ std::bit_cast<uint64_t>(a->data()[k])) * 1099511628211u;
  return h;
}

int64_t resident_memory() {
  malloc_trim(0);
  return status("VmRSS:");
}

int64_t peak_memory() {
  return status("VmHWM:");
}

void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << 5;
}

}  // namespace elastogen::stress
