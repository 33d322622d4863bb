// SPDX-License-Identifier: Apache-2.0
// What an incremental potential takes from the state at the start of a step.
#include "network/potential/incremental_potential.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

void IncrementalPotential::set_scheme(const StepScheme& scheme) {
  scheme_ = scheme;
  for_each(scene_.grid.node_count(), [&](int64_t n) {
    inertia_[size_t(n)] = scheme.a0 * scene_.mass(n) / (scheme.dt * scheme.dt);
  });
}

/// @param motion  of the predictor from x on, by node and component.
template <class Motion>
void IncrementalPotential::begin(In<double> positions, const Motion& motion) {
  const Array<double>& X = scene_.grid.rest;
  for_each(X.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      const double x = positions(n, d);
      now_[size_t(3 * n + d)] = x - X(n, d);
      predictor_[size_t(3 * n + d)] = x - X(n, d) + (is_fixed(n) ? 0 : motion(n, d));
    }
  });
  held_.place_pinned(predictor_.data());
  rotations(now_.data(), rotation_);
}

void IncrementalPotential::begin_loads(const State& state, const StepScheme& scheme, bool first) {
  if (!loads_.data()) return;
  loads_.begin(state.time + scheme.end(), scheme.response());
  if (first && loads_.blows()) loads_.start_wind(state.x.data(), state.v.data());
}

void IncrementalPotential::add_loads_to_predictor(double share) {
  const double* load = loads_.data();
  for_each(scene_.grid.node_count(), [&](int64_t n) {
    for (int64_t k = 3 * n; k < 3 * n + 3 && !is_fixed(n); ++k)
      predictor_[size_t(k)] += share * load[k] / inertia_[size_t(n)];
  });
}

void IncrementalPotential::take_wind(const double* x, const double* v) {
  add_loads_to_predictor(-1);
  loads_.take_wind(x, v);
  add_loads_to_predictor(1);
  held_.place_pinned(predictor_.data());
}

void IncrementalPotential::relax_wind() {
  add_loads_to_predictor(-1);
  loads_.relax_wind();
  add_loads_to_predictor(1);
  held_.place_pinned(predictor_.data());
}

void IncrementalPotential::begin_step(const State& state, const StepScheme& scheme) {
  set_scheme(scheme);
  held_.set_time(state.time + scheme.end());
  const bool has_before = !state.x_before.empty();
  begin(state.x, [&](int64_t n, int d) {
    const double x = state.x(n, d);
    return predicted_motion(scheme, x, state.v(n, d), has_before ? state.x_before(n, d) : x,
                            has_before ? state.v_before(n, d) : 0, loads_.pull(n, d));
  });
  begin_damping(state, scheme.scheme == TimeScheme::kBdf2 ? -1.0 / 3 : 0, nullptr);
  contact_.begin_step(now_.data(), state.time, scheme.end());
}

void IncrementalPotential::begin_stage(const State& state, const StepScheme& scheme,
                                       const double* motion, const double* stage_before) {
  set_scheme(scheme);
  held_.set_time(state.time + scheme.end());
  begin(state.x, [&](int64_t n, int d) { return motion[3 * n + d]; });
  begin_damping(state, scheme.stage.w_v, stage_before);
  const double lag_time = state.time + (stage_before ? scheme.stage.t_b : 0);
  contact_.begin_stage(now_.data(), state.time, scheme.end(),
                       stage_before ? stage_before : now_.data(), lag_time);
}

void IncrementalPotential::begin_still(In<double> x, const StepScheme& scheme) {
  set_scheme(scheme);
  begin(x, [](int64_t, int) { return 0.0; });
  if (rate_of(scheme) > 0) begin_damping({}, 0, nullptr);
}

}  // namespace elastogen
