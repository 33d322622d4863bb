// SPDX-License-Identifier: Apache-2.0
// The loads of a scene (core/loads.hpp) on its nodes, at the end of a step or stage.

#pragma once

#include "core/wind_load.hpp"

#include <optional>

namespace elastogen {

class NodeLoads {
 public:
  /// The scene must be finished and outlive it. Loads are those of the time 0, without wind.
  explicit NodeLoads(const Scene& scene);

  /// Begins a step or stage as WindLoad::begin.
  void begin(double time, double k);
  // the wind, as WindLoad; where it blows
  bool blows() const { return wind_.has_value(); }
  void start_wind(const double* x, const double* v);
  void take_wind(const double* x, const double* v);
  void relax_wind();

  /// The load on each node [N], (nodes, 3); empty: none acts.
  const Array<double>& all() const { return load_; }
  /// The same, null: none acts. The place never changes.
  const double* data() const { return load_.empty() ? nullptr : load_.data(); }
  /// Acceleration of a node by gravity and load, along an axis [m/s^2].
  double pull(int64_t node, int axis) const;

 private:
  void add_up();

  const Scene& scene_;
  double time_ = 0;
  std::optional<WindLoad> wind_;
  Array<double> load_;  // (nodes, 3)
};

}  // namespace elastogen
