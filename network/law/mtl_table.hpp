// SPDX-License-Identifier: Apache-2.0
// The correction of a law by a net, as a table: a tricubic B-spline D of the log stretches e. It is
// C2, and its gradient and Hessian are exact derivatives. D is symmetric in its three arguments;
// its value, slope and curvature are 0 at rest, and it is 0 far from rest.
//
//     psi = psi_law + E D(e),      D = w (psi_theta - psi_law)/E       (learned_law.hpp)
//
// The law is the stiff part (above all in volume) and is closed form, so a coarse table is enough.

#pragma once

#include "core/elastic_law.hpp"

#include <functional>
#include <vector>

namespace elastogen {

/// A function of log stretches and its derivatives.
template <class T>
struct LogResponse {
  T psi, w[3], ww[6];
};

/// The coefficients of a table, on the host or on a device.
struct MtlTableView {
  const float* coefficients;  ///< of the B-splines, a cube, the first index the fastest
  int cells;                  ///< in a unit of log stretch
  int half;                   ///< cells on each side of rest

  /// The spline at any log stretches; 0 a little beyond MtlTable::kReach.
  template <bool kHessian, class T>
  ELASTOGEN_HD LogResponse<T> evaluate(const T e[3]) const;
};

class MtlTable {
 public:
  /// D at log stretches e, (n, 3), which are within +-kReach.
  using Source = std::function<void(const double* e, int64_t n, double* difference)>;

  /// Log stretch beyond which D must be 0.
  static constexpr double kReach = 1.25;

  MtlTable() = default;
  /// Tabulates a source that is symmetric in e, vanishes with slope and curvature at rest, and is 0
  /// where some |e_i| >= kReach.
  /// @param cells  in a unit of log stretch, 8 to 64.
  MtlTable(const Source& source, int cells);

  template <bool kHessian, class T>
  LogResponse<T> evaluate(const T e[3]) const {
    return view().evaluate<kHessian>(e);
  }
  MtlTableView view() const { return {coefficients_.data(), cells_, half_}; }

  int cells() const { return cells_; }
  /// Coefficients of the B-splines, a cube, the first index the fastest; rest is in its middle.
  const std::vector<float>& coefficients() const { return coefficients_; }
  int64_t bytes() const { return int64_t(coefficients_.size() * sizeof(float)); }

 private:
  int cells_ = 0, half_ = 0;  // half_: cells on each side of rest
  std::vector<float> coefficients_;
};

namespace spline {

/// The four cubic B-splines that reach a cell, with first and second derivative, at t in [0, 1].
template <class T>
struct Basis {
  T value[4], first[4], second[4];
};

template <class T>
ELASTOGEN_HD inline Basis<T> basis(const T& t, Scalar<T> cells) {
  using S = Scalar<T>;
  const T u = 1 - t, t2 = t * t;
  const S c = cells, c2 = cells * cells;
  Basis<T> b;
  b.value[0] = u * u * u / 6;
  b.value[1] = (t2 * (3 * t - 6) + 4) / 6;
  b.value[3] = t2 * t / 6;
  b.value[2] = 1 - b.value[0] - b.value[1] - b.value[3];
  b.first[0] = -c / 2 * u * u;
  b.first[1] = c / 2 * t * (3 * t - 4);
  b.first[3] = c / 2 * t2;
  b.first[2] = -b.first[0] - b.first[1] - b.first[3];
  b.second[0] = c2 * u;
  b.second[1] = c2 * (3 * t - 2);
  b.second[2] = c2 * (1 - 3 * t);
  b.second[3] = c2 * t;
  return b;
}

/// The cell of a coordinate, y = index - half + t.
template <class T>
struct Cell {
  int index[is_pack<T> ? kLanes : 1];
  T t;
};

/// Coordinates beyond the table, and those that are not finite, count as its ends.
template <class T>
ELASTOGEN_HD inline Cell<T> cell(const T& y, int half) {
  using S = Scalar<T>;
  const S end = S(half);
  const T inside = smaller(larger(y, constant<T>(-end)), constant<T>(end));
  Cell<T> c;
  const auto place = [half](S value, S& rest) {
    int k = int(value);
    if (value < S(k)) --k;
    if (k > half - 1) k = half - 1;
    rest = value - S(k);
    return k + half;
  };
  if constexpr (is_pack<T>) {
    for (int l = 0; l < kLanes; ++l) {
      S rest;
      c.index[l] = place(inside[l], rest);
      c.t[l] = rest;
    }
  } else {
    c.index[0] = place(inside, c.t);
  }
  return c;
}

/// Loads four consecutive numbers for each lane, at an offset from its place.
template <class T>
requires is_pack<T>
inline void gather(const float* from, const int* place, int offset, T result[4]) {
  using Four = float __attribute__((vector_size(16)));
  Four of[kLanes];
  for (int l = 0; l < kLanes; ++l) std::memcpy(&of[l], from + place[l] + offset, sizeof(Four));
  // transposes: joins lanes four apart, then neighbours, then these
  Pack<float> pair[4], low[2], high[2];
  for (int l = 0; l < 4; ++l)
    pair[l] = __builtin_shufflevector(of[l], of[l + 4], 0, 1, 2, 3, 4, 5, 6, 7);
  for (int k = 0; k < 2; ++k) {
    const Pack<float>&a = pair[2 * k], &b = pair[2 * k + 1];
    low[k] = __builtin_shufflevector(a, b, 0, 8, 1, 9, 4, 12, 5, 13);
    high[k] = __builtin_shufflevector(a, b, 2, 10, 3, 11, 6, 14, 7, 15);
  }
  const auto numbers = [](const Pack<float>& p) { return __builtin_convertvector(p, T); };
  result[0] = numbers(__builtin_shufflevector(low[0], low[1], 0, 1, 8, 9, 4, 5, 12, 13));
  result[1] = numbers(__builtin_shufflevector(low[0], low[1], 2, 3, 10, 11, 6, 7, 14, 15));
  result[2] = numbers(__builtin_shufflevector(high[0], high[1], 0, 1, 8, 9, 4, 5, 12, 13));
  result[3] = numbers(__builtin_shufflevector(high[0], high[1], 2, 3, 10, 11, 6, 7, 14, 15));
}

/// gather for one place.
template <class T>
ELASTOGEN_HD inline void gather(const float* from, const int* place, int offset, T result[4]) {
  for (int k = 0; k < 4; ++k) result[k] = Scalar<T>(from[place[0] + offset + k]);
}

/// A plane of the spline with its derivatives in x and y: the sum over 16 coefficients.
template <class T>
struct Plane {
  T value, x, y, xx, yy, xy;
};

/// @param place  of each lane's first coefficient. @param row  from a row of them to the next.
template <bool kHessian, class T>
ELASTOGEN_HD inline Plane<T> plane(const float* from, const int* place, int row, const Basis<T>& bx,
                                   const Basis<T>& by) {
  Plane<T> p{};
  for (int y = 0; y < 4; ++y) {
    T c[4], q{}, qx{}, qxx{};
    gather(from, place, y * row, c);
    for (int x = 0; x < 4; ++x) {
      q += c[x] * bx.value[x], qx += c[x] * bx.first[x];
      if constexpr (kHessian) qxx += c[x] * bx.second[x];
    }
    p.value += q * by.value[y], p.x += qx * by.value[y], p.y += q * by.first[y];
    if constexpr (kHessian)
      p.xx += qxx * by.value[y], p.yy += q * by.second[y], p.xy += qx * by.first[y];
  }
  return p;
}

}  // namespace spline

template <bool kHessian, class T>
ELASTOGEN_HD LogResponse<T> MtlTableView::evaluate(const T e[3]) const {
  using S = Scalar<T>;
  constexpr int kCount = is_pack<T> ? kLanes : 1;
  const int n = 2 * half + 3;
  spline::Cell<T> place[3];
  spline::Basis<T> b[3];
  for (int i = 0; i < 3; ++i) {
    place[i] = spline::cell(T(e[i] * S(cells)), half);
    b[i] = spline::basis(place[i].t, S(cells));
  }
  int corner[kCount];
  for (int l = 0; l < kCount; ++l)
    corner[l] = (place[2].index[l] * n + place[1].index[l]) * n + place[0].index[l];

  LogResponse<T> r{};
  // sum over four planes of coefficients
  for (int z = 0; z < 4; ++z) {
    const float* from = coefficients + size_t(z) * size_t(n) * size_t(n);
    const spline::Plane<T> p = spline::plane<kHessian>(from, corner, n, b[0], b[1]);
    const T bz = b[2].value[z], dz = b[2].first[z];
    r.psi += p.value * bz;
    r.w[0] += p.x * bz, r.w[1] += p.y * bz, r.w[2] += p.value * dz;
    if constexpr (kHessian) {
      r.ww[0] += p.xx * bz, r.ww[1] += p.yy * bz, r.ww[2] += p.value * b[2].second[z];
      r.ww[3] += p.xy * bz, r.ww[4] += p.y * dz, r.ww[5] += p.x * dz;
    }
  }
  return r;
}

}  // namespace elastogen
