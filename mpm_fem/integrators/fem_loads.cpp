// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/fem_loads.hpp"

#include "core/scene.hpp"
#include "mpm_fem/integrators/fem_state.hpp"

namespace elastogen::fem {

FemLoads::FemLoads(const FemScene& scene) : scene_(scene), force_(scene.mesh.rest.rows(), 3) {
  if (!scene.in_wind) return;
  const Scene& grid = *scene.in_wind;
  wind_.emplace(grid.wind, grid.grid, grid.mass);
  x_ = Array<double>(grid.grid.node_count(), 3);
}

void FemLoads::begin(double time, double k) {
  still_ = applied_force(scene_, time, 1);
  if (wind_) wind_->begin(time, k);
  add_up();
}

/// Of the nodes of the grid, which are the first ones of the mesh.
const double* FemLoads::positions(In<double> u) {
  for (int64_t k = 0; k < x_.size(); ++k) x_.data()[k] = scene_.mesh.rest.data()[k] + u.data[k];
  return x_.data();
}

void FemLoads::start_wind(In<double> u, In<double> v) {
  if (!wind_) return;
  wind_->start(positions(u), v.data);
  add_up();
}

void FemLoads::take_wind(In<double> u, In<double> v) {
  if (!wind_) return;
  wind_->take(positions(u), v.data);
  add_up();
}

void FemLoads::relax_wind() {
  if (!wind_) return;
  wind_->relax();
  add_up();
}

void FemLoads::add_up() {
  force_ = still_;
  for (int64_t k = 0; wind_ && k < x_.size(); ++k) force_.data()[k] += wind_->force().data()[k];
}

}  // namespace elastogen::fem
