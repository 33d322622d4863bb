// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/particles.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::mpm {
namespace {

template <class T>
void append(Array<T>& to, const Array<T>& from) {
  if (from.empty()) return;
  Array<T> both(to.rows() + from.rows(), from.cols());
  std::copy(to.data(), to.data() + to.size(), both.data());
  std::copy(from.data(), from.data() + from.size(), both.data() + to.size());
  to = std::move(both);
}

}  // namespace

Particles particles_at(In<double> x, double volume, int32_t solid, double density) {
  ELASTOGEN_CHECK(x.cols == 3, "x must be (count, 3), got ", x);
  ELASTOGEN_CHECK(volume > 0 && std::isfinite(volume), "the volume of a particle must be positive",
                  ", got ", volume);
  Particles p;
  p.x = p.v = Array<double>(x.rows, 3);
  p.C = p.F = Array<double>(x.rows, 9);
  p.stress = Array<double>(x.rows, 6);
  p.history = p.mass = p.volume = Array<double>(x.rows, 1);
  p.solid = Array<int32_t>(x.rows, 1);
  std::copy(x.data, x.data + x.size(), p.x.data());
  p.volume.fill(volume);
  p.mass.fill(density * volume);
  p.solid.fill(solid);
  for (int64_t k = 0; k < x.rows; ++k) p.F(k, 0) = p.F(k, 4) = p.F(k, 8) = 1;
  return p;
}

void append(Particles& p, const Particles& o) {
  append(p.x, o.x), append(p.v, o.v), append(p.C, o.C), append(p.F, o.F);
  append(p.stress, o.stress), append(p.history, o.history);
  append(p.mass, o.mass), append(p.volume, o.volume), append(p.solid, o.solid);
}

Momentum momentum(const Particles& p, double h) {
  Momentum total;
  for (int64_t k = 0; k < p.count(); ++k) {
    const double m = p.mass(k), spread = h * h / 4;
    const double *x = p.x.row(k), *v = p.v.row(k), *C = p.C.row(k);
    total.mass += m;
    for (size_t a = 0; a < 3; ++a) {
      const size_t b = (a + 1) % 3, c = (a + 2) % 3;
      total.linear[a] += m * v[a];
      total.angular[a] += m * (x[b] * v[c] - x[c] * v[b] + spread * (C[3 * c + b] - C[3 * b + c]));
    }
  }
  return total;
}

double kinetic_energy(const Particles& p, double h) {
  return ordered_sum(p.count(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t k = begin; k < end; ++k) {
      double square = 0;
      for (int a = 0; a < 3; ++a) square += p.v(k, a) * p.v(k, a);
      for (int a = 0; a < 9; ++a) square += h * h / 4 * p.C(k, a) * p.C(k, a);
      sum += p.mass(k) / 2 * square;
    }
    return sum;
  });
}

}  // namespace elastogen::mpm
