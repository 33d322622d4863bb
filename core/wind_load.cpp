// SPDX-License-Identifier: Apache-2.0
#include "core/wind_load.hpp"

#include "core/mat3.hpp"
#include "core/parallel.hpp"
#include "core/reduce.hpp"
#include "core/vec3.hpp"
#include "core/voxel_grid.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr size_t kTrials = 4;        // that a combination is made of
constexpr double kDependent = 1e-8;  // squared share of a difference that the others leave: none

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

void add(double share, const std::vector<double>& of, std::vector<double>& to) {
  for (size_t k = 0; k < to.size(); ++k) to[k] += share * of[k];
}

double product(const std::vector<double>& a, const std::vector<double>& b) {
  return dot(a.data(), b.data(), int64_t(a.size()));
}

}  // namespace

WindLoad::WindLoad(const Wind& wind, const VoxelGrid& grid, const Array<double>& mass)
    : wind_(wind),
      grid_(grid),
      mass_(mass),
      points_(size_t(wind.voxel.rows())),
      drag_(size_t(grid.node_count())),
      given_(3 * drag_.size()),
      force_(grid.node_count(), 3) {
  list_points();
}

void WindLoad::list_points() {
  begin_.assign(drag_.size() + 1, 0);
  const auto each = [&](const auto& visit) {
    for (int64_t p = 0; p < wind_.voxel.rows(); ++p)
      for (int c = 0; c < 8; ++c) visit(size_t(grid_.corners(wind_.voxel(p), c)), p, c);
  };
  each([&](size_t n, int64_t, int) { ++begin_[n + 1]; });
  for (size_t n = 0; n < drag_.size(); ++n) begin_[n + 1] += begin_[n];
  parts_.resize(size_t(begin_.back()));
  std::vector<int64_t> next(begin_.begin(), begin_.end() - 1);
  each([&](size_t n, int64_t p, int c) {
    parts_[size_t(next[n]++)] = {int32_t(p), wind_.weights(p, c)};
  });
}

void WindLoad::begin(double time, double k) {
  time_ = time, k_ = k;
  trials_.clear();
  std::copy_n(force_.data(), given_.size(), given_.begin());
}

void WindLoad::start(const double* x, const double* v) {
  take(x, v);
  relax();
  trials_.clear();
}

WindLoad::PointForce WindLoad::at(int64_t p, const Vec3& air, const double* x,
                                  const double* v) const {
  const int32_t* corners = grid_.corners.row(wind_.voxel(p));
  const double* weights = wind_.weights.row(p);
  Vec3 relative = air;
  for (int c = 0; c < 8; ++c)
    for (size_t d = 0; d < 3; ++d) relative[d] -= weights[c] * v[3 * size_t(corners[c]) + d];
  const Vec3 a = turned_area(deformation_of(grid_, wind_.voxel(p), x),
                             {wind_.area(p, 0), wind_.area(p, 1), wind_.area(p, 2)});
  const double square = dot(a, a), flow = dot(relative, a);
  if (!(square > 0)) return {};
  const double drag = wind_.share * wind_.density / 2 * std::abs(flow);
  return {scaled(a, drag * flow / square), drag};
}

void WindLoad::take(const double* x, const double* v) {
  const Vec3 air = offset_at(wind_.velocity, time_);
  for_each(int64_t(points_.size()), [&](int64_t p) { points_[size_t(p)] = at(p, air, x, v); });
  for_each(force_.rows(), [&](int64_t n) {
    Vec3 force = {};
    double drag = 0;
    for (int64_t k = begin_[size_t(n)]; k < begin_[size_t(n) + 1]; ++k) {
      const auto& [point, weight] = parts_[size_t(k)];
      force = plus(force, scaled(points_[size_t(point)].force, weight));
      drag += std::abs(weight) * points_[size_t(point)].drag;
    }
    drag_[size_t(n)] = drag;
    std::ranges::copy(force, force_.row(n));
  });
}

void WindLoad::relax() {
  // Newton's step of each node; the slope of a force by the square of speed is twice the force over it
  std::vector<double> step(given_.size());
  for_each(force_.rows(), [&](int64_t n) {
    const double share = 1 / (1 + 2 * k_ * drag_[size_t(n)] / mass_(n));
    for (int64_t k = 3 * n; k < 3 * n + 3; ++k)
      step[size_t(k)] = share * (force_.data()[k] - given_[size_t(k)]);
  });
  const std::vector<double> next = combined(step);
  if (trials_.size() == kTrials) trials_.erase(trials_.begin());
  trials_.push_back({given_, std::move(step)});
  given_ = next;
  std::ranges::copy(given_, force_.data());
}

/// Where the next solve begins: given + step, less the combination of the last trials' differences
/// from here that leaves the shortest step (Anderson 1965, by Gram and Schmidt).
std::vector<double> WindLoad::combined(const std::vector<double>& step) const {
  std::vector<double> left = step, next = given_;
  std::vector<Trial> basis;  // differences, their steps orthogonal
  for (auto trial = trials_.rbegin(); trial != trials_.rend(); ++trial) {
    Trial change = {given_, step};
    add(-1, trial->given, change.given);
    add(-1, trial->step, change.step);
    const double whole = product(change.step, change.step);
    for (const Trial& other : basis) {
      const double share = -product(change.step, other.step) / product(other.step, other.step);
      add(share, other.given, change.given);
      add(share, other.step, change.step);
    }
    const double square = product(change.step, change.step);
    if (!(square > kDependent * whole)) continue;
    const double share = -product(left, change.step) / square;
    add(share, change.given, next);
    add(share, change.step, left);
    basis.push_back(std::move(change));
  }
  add(1, left, next);
  return next;
}

}  // namespace elastogen
