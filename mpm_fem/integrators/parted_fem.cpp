// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/parted_fem.hpp"

#include "core/stopwatch.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr int kMostParts = 16;    // that a step begins with
constexpr int kTicks = 16;        // of each: four halvings
constexpr double kFarthest = 1;   // motion of a collider in a part, in edges of an element
constexpr double kPressed = 0.1;  // of one that touches the body

/// Whether a collider at a time touches the body as it is now.
bool touches(const FemScene& scene, const Array<double>& u, const Collider& collider, double time) {
  const ContactPoints& points = scene.contact;
  const Vec3 offset = offset_at(collider, time);
  for (int64_t p = 0; p < points.position.rows(); ++p) {
    const double* rest = points.position.row(p);
    Vec3 x = {rest[0], rest[1], rest[2]};
    for (int64_t k = 0; k < points.nodes.cols(); ++k)
      for (int a = 0; a < 3; ++a) x[size_t(a)] += points.weights(p, k) * u(points.nodes(p, k), a);
    if (proximity(collider, offset, x).distance <= 0) return true;
  }
  return false;
}

/// Count of equal parts in which no collider goes too far. Where it touches the body now or would
/// at the end, its way is that of the flow.
int parts_of(const FemScene& scene, const Array<double>& u, double start, double edge) {
  double parts = 1;
  const double end = start + scene.dt;
  for (const Collider& collider : scene.colliders) {
    const double way = norm(minus(offset_at(collider, end), offset_at(collider, start)));
    if (way == 0) continue;
    const bool presses = touches(scene, u, collider, start) || touches(scene, u, collider, end);
    parts = std::max(parts, std::ceil(way / ((presses ? kPressed : kFarthest) * edge) - 1e-9));
  }
  return int(std::min(parts, double(kMostParts)));
}

/// Adds the cost of a try to a report and, if the try is kept, its result.
void add(const FemStepReport& part, bool kept, FemStepReport& all) {
  all.outer += part.outer;
  all.inner += part.inner;
  all.fallbacks += part.fallbacks + !kept;
  all.halvings += !kept;
  if (!kept) return;
  all.finite = part.finite, all.refusal = part.refusal;
  all.scheme = part.scheme, all.used = part.used, all.stop = part.stop;
  all.yields = part.yields, all.float64 = part.float64;
  all.converged &= part.converged;
  all.residual = std::max(all.residual, part.residual);
  all.floor = std::max(all.floor, part.floor);
  all.deepest_overlap = std::max(all.deepest_overlap, part.deepest_overlap);
  all.min_j = part.min_j;
  all.energy = part.energy;
  ++all.parts;
}

bool is_good(const FemStepReport& part) {
  return part.finite && (part.converged || part.stop == NewtonStop::kRoundOff);
}

/// Makes a part of `size` ticks of a step, from the state after `done` of them.
FemStepReport take_part(ImplicitFem& solver, int done, int size, int ticks, FemState& state) {
  if (size == ticks) return solver.step(state);
  const double dt = solver.scene().dt;
  state.u_before = state.v_before = {};
  state.time = dt * (double(state.steps) + double(done) / ticks);
  return solver.step_part(state, dt * size / ticks);
}

/// Completes the state after all parts of a step, as if it had been one.
void end_step(double dt, const FemState& before, FemState& state) {
  state.u_before = before.u, state.v_before = before.v;
  state.steps = before.steps + 1;
  state.time = double(state.steps) * dt;
}

}  // namespace

FemStepReport step_in_parts(ImplicitFem& solver, FemState& state,
                            const std::function<bool()>& stop) {
  const Stopwatch watch;
  const double dt = solver.scene().dt;
  const int ticks =
      kTicks * parts_of(solver.scene(), state.u, double(state.steps) * dt, solver.edge());
  FemState now = state;
  FemStepReport all;
  all.converged = true, all.parts = 0;
  // a part that fails is halved, the next one after a success doubled
  for (int done = 0, size = kTicks; done < ticks;) {
    all.interrupted = stop();
    if (all.interrupted) return all;
    FemState tried = now;
    const int taken = std::min(size, ticks - done);
    const FemStepReport part = take_part(solver, done, taken, ticks, tried);
    const bool kept = is_good(part) || taken == 1;
    add(part, kept, all);
    if (kept && !part.finite) break;
    size = kept ? 2 * size : taken / 2;
    size = std::min(size, kTicks);
    if (!kept) continue;
    done += taken;
    now = std::move(tried);
  }
  // the parts together count as one step
  if (all.finite) end_step(dt, state, now);
  if (all.finite) state = std::move(now);
  all.step = state.steps + !all.finite;
  all.time = double(all.step) * dt;
  all.ms = watch.milliseconds();
  return all;
}

}  // namespace elastogen::fem
