// SPDX-License-Identifier: Apache-2.0
#include "core/loads.hpp"

#include "core/mat3.hpp"
#include "core/parallel.hpp"
#include "core/scene.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// F at the centre of a voxel.
Mat3<double> deformation_of(const VoxelGrid& grid, int64_t voxel, const double* x) {
  Mat3<double> F{};
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        F(i, j) +=
            x[3 * int64_t(grid.corners(voxel, c)) + i] * (c >> j & 1 ? 1 : -1) / (4 * grid.h);
  return F;
}

/// cof(F) A, of a body with A before.
Vec3 turned_area(const Mat3<double>& F, const Vec3& A) {
  const Mat3<double> C = cofactor(F);
  Vec3 a = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a[size_t(i)] += C(i, j) * A[size_t(j)];
  return a;
}

}  // namespace

bool has_loads(const Scene& scene) {
  return !scene.load.empty() || !scene.forces.empty() || scene.wind.blows();
}

NodeLoads::NodeLoads(const Scene& scene) : scene_(scene) {
  if (!has_loads(scene)) return;
  load_ = Array<double>(scene.grid.node_count(), 3);
  if (scene.wind.blows()) {
    wind_ = Array<double>(load_.rows(), 3);
    drag_.resize(size_t(load_.rows()));
  }
  set_time(0);
}

void NodeLoads::begin_step(const double* x, const double* v, double time, double h) {
  if (wind_.empty()) return;
  add_wind(x, v, time);
  for_each(wind_.rows(), [&](int64_t n) {
    const double most = scene_.mass(n) / h, drag = drag_[size_t(n)];
    for (int d = 0; d < 3 && drag > most; ++d) wind_(n, d) *= most / drag;
  });
}

void NodeLoads::add_wind(const double* x, const double* v, double time) {
  const Wind& wind = scene_.wind;
  const Vec3 W = offset_at(wind.velocity, time);
  wind_.fill(0);
  std::ranges::fill(drag_, 0.0);
  // in the order of the points, so that sums have the same bits on any number of threads
  for (int64_t p = 0; p < wind.voxel.rows(); ++p) {
    const int32_t* corners = scene_.grid.corners.row(wind.voxel(p));
    const double* weights = wind.weights.row(p);
    Vec3 relative = W;
    for (int c = 0; c < 8; ++c)
      for (size_t d = 0; d < 3; ++d) relative[d] -= weights[c] * v[3 * size_t(corners[c]) + d];
    const Vec3 a = turned_area(deformation_of(scene_.grid, wind.voxel(p), x),
                               {wind.area(p, 0), wind.area(p, 1), wind.area(p, 2)});
    const double square = dot(a, a), flow = dot(relative, a);
    if (!(square > 0)) continue;
    const double drag = wind.share * wind.density / 2 * std::abs(flow);
    for (int c = 0; c < 8; ++c) {
      drag_[size_t(corners[c])] += std::abs(weights[c]) * drag;
      for (size_t d = 0; d < 3; ++d)
        wind_(corners[c], int(d)) += weights[c] * drag * flow * a[d] / square;
    }
  }
}

void NodeLoads::set_time(double time) {
  if (load_.empty()) return;
  std::vector<Vec3> forces;
  for (const TimedForce& force : scene_.forces) forces.push_back(offset_at(force.force, time));
  for_each(load_.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      double sum = scene_.load.empty() ? 0 : scene_.load(n, d);
      for (size_t k = 0; k < forces.size(); ++k)
        sum += scene_.forces[k].share(n) * forces[k][size_t(d)];
      load_(n, d) = sum + (wind_.empty() ? 0 : wind_(n, d));
    }
  });
}

double NodeLoads::pull(int64_t n, int axis) const {
  const double g = scene_.gravity[size_t(axis)];
  return load_.empty() ? g : g + load_(n, axis) / scene_.mass(n);
}

}  // namespace elastogen
