// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"
#include "network/step/free_flight.cuh"
#include "network/step/free_flight.hpp"

namespace elastogen::cuda {
namespace {

/// Whether a piece does not turn, as in predictor.cpp.
__device__ bool steady(const PieceFrame& before, const PieceFrame& now, const PieceFrame& next) {
  double largest = 0;
  for (int k = 0; k < 9; ++k)
    for (const double turn :
         {now.rotation.m[k] - before.rotation.m[k], next.rotation.m[k] - now.rotation.m[k]})
      largest = fmax(largest, fabs(turn));
  return largest < 1e-9;
}

}  // namespace

DevicePieces::DevicePieces(const Scene& scene) : DevicePieces(scene, free_pieces(scene)) {}

DevicePieces::DevicePieces(const Scene& scene, const std::vector<std::vector<int32_t>>& pieces)
    : groups_(pieces) {
  // masses and centres at rest, piece by piece
  std::vector<double> rest_centre, per_mass;
  for (const std::vector<int32_t>& list : pieces) {
    const auto sum = [&](const auto& value) {
      return ::elastogen::ordered_sum(int64_t(list.size()), [&](int64_t begin, int64_t end) {
        double part = 0;
        for (int64_t k = begin; k < end; ++k) part += value(list[size_t(k)]);
        return part;
      });
    };
    const double mass = sum([&](int32_t n) { return scene.mass(n); });
    for (int i = 0; i < 3; ++i)
      rest_centre.push_back(sum([&](int32_t n) { return scene.mass(n) * scene.grid.rest(n, i); }) /
                            mass);
    per_mass.push_back(1 / mass);
  }
  rest_centre_ = DeviceArray<double>(rest_centre);
  per_mass_ = DeviceArray<double>(per_mass);
  shift_ = DeviceArray<double>(rest_centre_.size());
  excess_ = DeviceArray<Sums<3>>(groups_.chunks());
  moments_ = DeviceArray<Sums<12>>(groups_.chunks());
  frames_ = DeviceArray<PieceFrame>(3 * count());
}

/// Finds the frames of the pieces with number k = 3 node + component at position(k). Positions are
/// relative to the first node of a piece, so that no digits are lost where the body is far from the
/// origin. The moment sum m (x - c)(X - R)^T does not depend on c, because R is the centre at rest.
template <class Position>
void DevicePieces::find_frames(const double* rest, const double* mass, const Position& position,
                               PieceFrame* frames) {
  const PiecesView g = view();
  groups_.sums(
      moments_,
      [=] __device__(int64_t p, int64_t n, Sums<12> & sum) {
        const int64_t origin = g.first[p];
        for (int i = 0; i < 3; ++i) {
          const double weight = mass[n] * (position(3 * n + i) - position(3 * origin + i));
          sum.value[i] += weight;
          for (int j = 0; j < 3; ++j)
            sum.value[3 + 3 * i + j] += weight * (rest[3 * n + j] - g.rest_centre[3 * p + j]);
        }
      },
      [=] __device__(int64_t p, const Sums<12>& sum) {
        PieceFrame frame;
        Mat3<double> A;
        for (int i = 0; i < 3; ++i)
          frame.centre[i] = position(3 * int64_t(g.first[p]) + i) + sum.value[i] * g.per_mass[p];
        for (int k = 0; k < 9; ++k) A.m[k] = sum.value[3 + k];
        frame.rotation = polar_rotation(A);
        frames[p] = frame;
      });
}

void DevicePieces::start(const double* rest, const double* mass, const double* x,
                         const double* x_before, const double* predictor, double* u) {
  if (count() == 0) return;
  PieceFrame *all = frames_.data(), *of_before = all + count(), *of_next = all + 2 * count();
  // frames of all pieces now, a step before, and where the predictor has them
  find_frames(
      rest, mass, [=] __device__(int64_t k) { return x[k]; }, all);
  find_frames(
      rest, mass, [=] __device__(int64_t k) { return x_before[k]; }, of_before);
  find_frames(
      rest, mass, [=] __device__(int64_t k) { return rest[k] + predictor[k]; }, of_next);
  // the shape of a piece that turns is extrapolated in its own frame, then moved with the next one
  for_each([=] __device__(int64_t p, int64_t n) {
    const PieceFrame &now = all[p], &before = of_before[p], &next = of_next[p];
    if (steady(before, now, next)) return;
    double shape[3];
    for (int j = 0; j < 3; ++j) {
      shape[j] = 0;
      for (int k = 0; k < 3; ++k)
        shape[j] += 2 * now.rotation(k, j) * (x[3 * n + k] - now.centre[k]) -
                    before.rotation(k, j) * (x_before[3 * n + k] - before.centre[k]);
    }
    for (int i = 0; i < 3; ++i) {
      double sum = next.centre[i] - rest[3 * n + i];
      for (int j = 0; j < 3; ++j) sum += next.rotation(i, j) * shape[j];
      u[3 * n + i] = sum;
    }
  });
}

}  // namespace elastogen::cuda
