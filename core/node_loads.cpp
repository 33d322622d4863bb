// SPDX-License-Identifier: Apache-2.0
#include "core/node_loads.hpp"

#include "core/parallel.hpp"
#include "core/scene.hpp"

namespace elastogen {

bool has_loads(const Scene& scene) {
  return !scene.load.empty() || has_changing_loads(scene);
}

bool has_changing_loads(const Scene& scene) {
  return !scene.forces.empty() || scene.wind.blows();
}

NodeLoads::NodeLoads(const Scene& scene) : scene_(scene) {
  if (!has_loads(scene)) return;
  load_ = Array<double>(scene.grid.node_count(), 3);
  if (scene.wind.blows()) wind_.emplace(scene.wind, scene.grid, scene.mass);
  add_up();
}

void NodeLoads::begin(double time, double k) {
  time_ = time;
  if (wind_) wind_->begin(time, k);
  add_up();
}

void NodeLoads::start_wind(const double* x, const double* v) {
  wind_->start(x, v);
  add_up();
}

void NodeLoads::take_wind(const double* x, const double* v) {
  wind_->take(x, v);
  add_up();
}

void NodeLoads::relax_wind() {
  wind_->relax();
  add_up();
}

/// Dead loads, forces of the time, and the wind.
void NodeLoads::add_up() {
  if (load_.empty()) return;
  std::vector<Vec3> forces;
  for (const TimedForce& force : scene_.forces) forces.push_back(offset_at(force.force, time_));
  for_each(load_.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      double sum = scene_.load.empty() ? 0 : scene_.load(n, d);
      for (size_t k = 0; k < forces.size(); ++k)
        sum += scene_.forces[k].share(n) * forces[k][size_t(d)];
      load_(n, d) = sum + (wind_ ? wind_->force()(n, d) : 0);
    }
  });
}

double NodeLoads::pull(int64_t n, int axis) const {
  const double g = scene_.gravity[size_t(axis)];
  return load_.empty() ? g : g + load_(n, axis) / scene_.mass(n);
}

}  // namespace elastogen
