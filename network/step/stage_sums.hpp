// SPDX-License-Identifier: Apache-2.0
// What stages add up over the nodes of each piece: a node adds to kPieceSums numbers. Arrays are
// (nodes, 3), in the memory of the machine. Shared by host and device.

#pragma once

#include "network/step/stage_nodes.hpp"

#include <variant>

namespace elastogen {

inline constexpr int kPieceSums = 9;
using PieceSums = std::array<double, kPieceSums>;

/// m r and m v, r from the first node of the piece, so that no digits are lost far from the origin;
/// then the place of that node. v may be null: at rest.
struct FirstMoments {
  StageNodes of;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const int64_t first = of.first[of.piece[n]];
    const Vec3 r = minus(vector_at(x, n), vector_at(x, first));
    for (size_t i = 0; i < 3; ++i) {
      sum[i] += of.mass[n] * r[i];
      if (v != nullptr) sum[3 + i] += of.mass[n] * v[3 * n + int64_t(i)];
      if (n == first) sum[6 + i] += x[3 * n + int64_t(i)];
    }
  }
};

/// Spin about the centre of mass, m r_i^2 and m r_i r_j, r from that.
struct SecondMoments {
  StageNodes of;
  const PieceMotion* about;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const PieceMotion& whole = about[of.piece[n]];
    const Vec3 r = minus(vector_at(x, n), whole.centre);
    const Vec3 L = cross(r, minus(v != nullptr ? vector_at(v, n) : Vec3{}, whole.velocity));
    for (size_t i = 0; i < 3; ++i) {
      sum[i] += of.mass[n] * L[i];
      sum[3 + i] += of.mass[n] * r[i] * r[i];
      sum[6 + i] += of.mass[n] * r[i] * r[(i + 1) % 3];
    }
  }
};

/// m a.a, m a.b and m b.b.
struct Products {
  StageNodes of;
  const double *a, *b;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const Vec3 p = vector_at(a, n), q = vector_at(b, n);
    sum[0] += of.mass[n] * dot(p, p);
    sum[1] += of.mass[n] * dot(p, q);
    sum[2] += of.mass[n] * dot(q, q);
  }
};

/// Kinetic energy and that of gravity.
struct MotionEnergies {
  StageNodes of;
  const double *x, *v;
  ELASTOGEN_HD void operator()(int64_t n, double* sum) const {
    const Vec3 speed = vector_at(v, n);
    sum[0] += of.mass[n] * (dot(speed, speed) / 2 - dot(of.gravity, vector_at(x, n)));
  }
};

using NodeSum = std::variant<FirstMoments, SecondMoments, Products, MotionEnergies>;

}  // namespace elastogen
