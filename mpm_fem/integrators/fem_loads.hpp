// SPDX-License-Identifier: Apache-2.0
// Loads on the nodes at the end of a step or stage: tractions, further forces, and wind, which depends
// on where the step leads (core/wind_load.hpp).

#pragma once

#include "core/wind_load.hpp"
#include "mpm_fem/fem_scene.hpp"

#include <optional>

namespace elastogen::fem {

inline constexpr int kMostWind = 40;  // solves of a step or stage for its wind

class FemLoads {
 public:
  /// The scene must outlive it.
  explicit FemLoads(const FemScene& scene);

  /// Begins a step or stage as WindLoad::begin.
  void begin(double time, double k);
  // the wind, as WindLoad; nothing where there is none
  bool blows() const { return wind_.has_value(); }
  void start_wind(In<double> u, In<double> v);
  void take_wind(In<double> u, In<double> v);
  void relax_wind();

  /// All of them [N], (nodes, 3).
  const Array<double>& force() const { return force_; }

 private:
  const double* positions(In<double> u);
  void add_up();

  const FemScene& scene_;
  std::optional<WindLoad> wind_;
  Array<double> x_;              // (nodes of the grid, 3)
  Array<double> still_, force_;  // without the wind, with it
};

}  // namespace elastogen::fem
