// SPDX-License-Identifier: Apache-2.0
// Any number of threads, starved iterations, and the published algorithm where it is out of its
// depth.
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/stress/cases.hpp"

namespace elastogen::stress {
namespace {

/// A ragged block of several blocks of nodes falls on the floor; 7 threads against 1 and 2.
void threads(Record& record, SolverMode mode) {
  Scene scene = box_scene(16, 16, 16, 0.05, test::solid(1e5, 0.4));
  put_floor(scene, -0.01);
  finish_scene(scene);
  const State start = initial_state(scene, {.velocity = {0.5, -1, 0}, .spin = {1, 2, 3}});
  const Plan plan = {.steps = 4, .options = {.mode = mode}};
  const Outcome two = run(record, scene, start, plan);
  const ThreadLimit limit(7);
  Solver solver(scene, plan.options);
  State state = start;
  for (int k = 0; k < plan.steps; ++k) solver.step(state);
  record.expect(hash(state) == hash(two.state), "seven threads give other bits than two");
}

/// Fewer and fewer iterations: the error against the converged run grows, and no step that is not
/// converged says so.
void starved(Record& record, SolverMode mode) {
  Scene scene = box_scene(10, 3, 3, 0.025, test::solid(2e5, 0.4), 0);
  const auto end = [&](int outer, double tolerance) {
    const Plan plan = {.steps = 10,
                       .options = {.mode = mode, .tolerance = tolerance, .max_outer = outer}};
    return run(record, scene, initial_state(scene), plan).state.x;
  };
  const Array<double> exact = end(400, 1e-5);
  const int64_t drafts = record.drafts;
  double before = 1e300;
  std::string errors;
  for (const int outer : {1, 3, 5, 20, 50}) {
    const double error = largest_difference(end(outer, 1e-5), exact);
    errors += concat(errors.empty() ? "" : ", ", error);
    record.expect(error <= before, "the error grows to ", error, " m at ", outer, " iterations");
    before = error;
  }
  record.note("errors at 1, 3, 5, 20, 50 iterations [m]: ", errors);
  record.expect(drafts == 0, "the reference run has drafts");
  record.expect(record.drafts >= 10, "no drafts at one iteration");
}

constexpr SolverMode kPaper = SolverMode::kPaper;

void paper(Record& record, Scene scene, const State& start) {
  scene.hourglass = Hourglass::kVariance;
  finish_scene(scene);
  run(record, scene, start, {.steps = 20, .options = {.mode = kPaper}, .passive = false});
}

void paper_beam(Record& record) {
  const Scene scene = box_scene(8, 2, 2, 0.05, test::solid(1e6, 0.3), 0);
  paper(record, scene, initial_state(scene));
}

void paper_stiff(Record& record) {
  const Scene scene = box_scene(8, 2, 2, 0.05, test::solid(1e10, 0.3), 0);
  paper(record, scene, initial_state(scene));
}

void paper_flat(Record& record) {
  const Scene scene = box_scene(3, 3, 3, 0.1, test::solid(1e5, 0.3));
  State start = initial_state(scene);
  for (int64_t n = 0; n < start.x.rows(); ++n) start.x(n, 1) = 0.15;
  paper(record, scene, start);
}

}  // namespace

std::vector<Case> solver_cases() {
  std::vector<Case> cases;
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    const std::string name(solver_name(mode));
    cases.push_back({"threads." + name, true, [=](Record& r) { threads(r, mode); }});
    cases.push_back({"starved." + name, true, [=](Record& r) { starved(r, mode); }});
  }
  cases.push_back({"paper.beam", true, paper_beam});
  cases.push_back({"paper.stiff", true, paper_stiff});
  cases.push_back({"paper.flat", true, paper_flat});
  return cases;
}

}  // namespace elastogen::stress
