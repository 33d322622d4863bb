// SPDX-License-Identifier: Apache-2.0
#include "network/law/mtl_table.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace elastogen {
namespace {

// knots beyond the reach: the ringing of the spline decays by 0.27 a knot there, then it is cut off
constexpr int kPad = 8;

/// A cube of numbers around rest.
struct Cube {
  int half;
  std::vector<double> values;

  explicit Cube(int h)
      : half(h), values(size_t(h * 2 + 1) * size_t(h * 2 + 1) * size_t(h * 2 + 1)) {}
  int points() const { return 2 * half + 1; }
  double& at(int x, int y, int z) {
    const size_t n = size_t(points());
    return values[(size_t(z + half) * n + size_t(y + half)) * n + size_t(x + half)];
  }
};

/// Turns values at the knots into coefficients of the cubic B-spline through them, in place: the
/// recursive filter with pole sqrt 3 - 2 (Unser, Splines, IEEE SPM 1999), mirrored ends.
void prefilter(double* c, int n, int64_t stride) {
  const double pole = std::sqrt(3.0) - 2;
  const auto at = [&](int k) -> double& { return c[k * stride]; };
  double sum = at(0), power = pole;
  for (int k = 1; k < std::min(n, 40); ++k, power *= pole) sum += power * at(k);
  at(0) = sum;
  for (int k = 1; k < n; ++k) at(k) += pole * at(k - 1);
  at(n - 1) = pole / (pole * pole - 1) * (at(n - 1) + pole * at(n - 2));
  for (int k = n - 2; k >= 0; --k) at(k) = pole * (at(k + 1) - at(k));
  for (int k = 0; k < n; ++k) at(k) *= 6;
}

void prefilter(Cube& cube) {
  const int n = cube.points(), h = cube.half;
  const int64_t line = n, plane = int64_t(n) * n;
  for_each(n, [&](int64_t a) {
    for (int b = -h; b <= h; ++b) prefilter(&cube.at(-h, b, int(a) - h), n, 1);
    for (int b = -h; b <= h; ++b) prefilter(&cube.at(b, -h, int(a) - h), n, line);
  });
  for_each(n, [&](int64_t a) {
    for (int b = -h; b <= h; ++b) prefilter(&cube.at(b, int(a) - h, -h), n, plane);
  });
}

/// Values of the source at the knots: a sixth of them are computed, the others follow by symmetry.
Cube sample(const MtlTable::Source& source, int cells) {
  const int reach = int(MtlTable::kReach * cells);
  Cube cube(reach + kPad);
  for_each(2 * reach + 1, [&](int64_t plane) {
    const int z = int(plane) - reach;
    std::vector<double> e;
    for (int y = z; y <= reach; ++y)
      for (int x = y; x <= reach; ++x)
        for (const int k : {x, y, z}) e.push_back(double(k) / cells);
    std::vector<double> value(e.size() / 3);
    source(e.data(), int64_t(value.size()), value.data());
    size_t next = 0;
    for (int y = z; y <= reach; ++y)
      for (int x = y; x <= reach; ++x, ++next)
        for (const auto& [i, j, k] :
             {std::array{x, y, z}, {x, z, y}, {y, x, z}, {y, z, x}, {z, x, y}, {z, y, x}})
          cube.at(i, j, k) = value[next];
  });
  return cube;
}

/// The quadratic value + slope sum x + square/2 sum x^2 + product sum x y, symmetric in three
/// arguments, as coefficients of the spline with knots at integers.
struct Quadratic {
  double value = 0, slope = 0, square = 0, product = 0;

  double coefficient(int x, int y, int z) const {
    const auto half_square = [](int k) { return (double(k) * k - 1.0 / 3) / 2; };
    return value + slope * (x + y + z) +
           square * (half_square(x) + half_square(y) + half_square(z)) +
           product * (double(x) * y + double(y) * z + double(z) * x);
  }
};

/// Value and derivatives of the spline at rest, from the 27 coefficients around it.
Quadratic at_rest(Cube& c) {
  constexpr double kValue[3] = {1.0 / 6, 4.0 / 6, 1.0 / 6}, kFirst[3] = {-0.5, 0, 0.5};
  constexpr double kSecond[3] = {1, -2, 1};
  Quadratic q;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) {
        const double value = c.at(i - 1, j - 1, k - 1);
        q.value += value * kValue[i] * kValue[j] * kValue[k];
        q.slope += value * kFirst[i] * kValue[j] * kValue[k];
        q.square += value * kSecond[i] * kValue[j] * kValue[k];
        q.product += value * kFirst[i] * kFirst[j] * kValue[k];
      }
  return q;
}

/// 1 for the knots next to rest, 0 six knots away from it: the error of the spline at rest is
/// subtracted near rest alone.
double window(int k) {
  const double x = std::clamp((std::abs(k) - 1.0) / 5, 0.0, 1.0);
  return 1 - x * x * x * (10 + x * (6 * x - 15));
}

}  // namespace

MtlTable::MtlTable(const Source& source, int cells) : cells_(cells) {
  ELASTOGEN_CHECK(cells >= 8 && cells <= 64, "a table has 8 to 64 cells, got ", cells);
  Cube cube = sample(source, cells);
  prefilter(cube);
  const Quadratic rest = at_rest(cube);
  half_ = cube.half - 1;
  coefficients_.resize(cube.values.size());
  const int edge = cube.half, zero = cube.half - 3;
  size_t next = 0;
  for (int z = -edge; z <= edge; ++z)
    for (int y = -edge; y <= edge; ++y)
      for (int x = -edge; x <= edge; ++x, ++next) {
        int k[3] = {x, y, z};
        std::sort(k, k + 3);                         // equal bits for every order of the stretches
        if (std::max(-k[0], k[2]) > zero) continue;  // C2 to 0 at the end of the table
        const double taken = rest.coefficient(k[0], k[1], k[2]) * window(x) * window(y) * window(z);
        coefficients_[next] = float(cube.at(k[0], k[1], k[2]) - taken);
      }
}

}  // namespace elastogen
