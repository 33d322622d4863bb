// SPDX-License-Identifier: Apache-2.0
#include "network/device_multigrid.cuh"
#include "network/device_rows.cuh"
#include "network/multigrid_element.hpp"

namespace elastogen::cuda {
namespace {

/// The coefficients of the smoother in the type of the cycle.
template <class T>
struct Smoother {
  explicit Smoother(const Chebyshev& c) : first(T(c.first)), keep(T(c.keep)), add(T(c.add)) {}
  T first, keep, add;
};

/// What the kernels of a level work on.
template <class T>
struct LevelView {
  const T *moduli, *border, *added, *inverse_diagonal, *inverses;
  const uint8_t *pinned, *odd_axes;
  const int32_t *parents, *children;
  T *r, *d, *other;
  int64_t nodes;
  Smoother<T> smoother;
};

}  // namespace

template <class T>
struct DeviceMultigridLevel {
  explicit DeviceMultigridLevel(const MultigridLevel<T>& host)
      : rows(host.rows),
        moduli(host.moduli),
        border(std::vector<T>(host.rows.border.begin(), host.rows.border.end())),
        added(host.added),
        inverse_diagonal(host.inverse_diagonal),
        inverses(host.inverses),
        pinned(host.pinned),
        odd_axes(host.odd_axes),
        parents(host.parents),
        children(host.children),
        parts(3 * rows.parts()),
        r(3 * host.nodes),
        z(3 * host.nodes),
        d(3 * host.nodes),
        other(3 * host.nodes),
        nodes(host.nodes),
        smoother(Chebyshev(host.lambda_max)) {}

  LevelView<T> view() {
    return {moduli.data(),   border.data(), added.data(),    inverse_diagonal.data(),
            inverses.data(), pinned.data(), odd_axes.data(), parents.data(),
            children.data(), r.data(),      d.data(),        other.data(),
            nodes,           smoother};
  }

  DeviceRows rows;
  DeviceArray<T> moduli, border, added, inverse_diagonal, inverses;
  DeviceArray<uint8_t> pinned, odd_axes;
  DeviceArray<int32_t> parents, children;
  DeviceArray<T> parts, r, z, d, other;  // other: z between the two products of a smoothing
  int64_t nodes;
  Smoother<T> smoother;
};

namespace {

template <class T>
using Level = DeviceMultigridLevel<T>;

/// finish(k, (A p)_k) over the numbers k = 3 node + component; p(k) is 0 on pinned nodes, pinned
/// rows are left as they come.
template <class T, class Vector, class Finish>
void product(Level<T>& level, const Vector& p, const Finish& finish) {
  const LevelView<T> v = level.view();
  for_each_voxel<T, NoSums>(
      level.rows, level.parts.data(), nullptr,
      [=] __device__(int64_t n, int64_t, T value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = p(3 * n + i);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const T u[3][8], T f[3][8],
                     NoSums&) {
        T k[6], M[7] = {};
        for (int j = 0; j < 6; ++j) k[j] = v.moduli[(r * 6 + j) * kLanes + lane];
        if (row.border < 0) {
          for (int i = 0; i < 3; ++i) scalar_element<false>(k, M, i, u[i], f[i]);
          return;
        }
        for (int m = 0; m < 7; ++m) M[m] = v.border[(int64_t(row.border) * 7 + m) * kLanes + lane];
        for (int i = 0; i < 3; ++i) scalar_element<true>(k, M, i, u[i], f[i]);
      },
      [=] __device__(int64_t n, const T force[3]) {
        for (int i = 0; i < 3; ++i) {
          const int64_t k = 3 * n + i;
          finish(k, force[i] + v.added[k] * p(k));
        }
      });
}

/// z = p(D^-1 A) D^-1 r from z = 0. The first step is a multiple of D^-1 r, which the product forms
/// as it reads.
template <class T>
void smooth_from_zero(Level<T>& level, T* z) {
  const LevelView<T> v = level.view();
  const auto first = [=] __device__(int64_t k) {
    return v.smoother.first * v.inverse_diagonal[k] * v.r[k];
  };
  product(level, first, [=] __device__(int64_t k, T Az) {
    const T z0 = first(k);
    z[k] = z0 + (v.smoother.keep * z0 + v.smoother.add * v.inverse_diagonal[k] * (v.r[k] - Az));
  });
}

/// The same polynomial on the residual of the present z. A product must not change what other
/// bricks still read, so z goes to `other` and back.
template <class T>
void smooth(Level<T>& level, T* z) {
  const LevelView<T> v = level.view();
  const auto start = [=] __device__(int64_t k) { return z[k]; };
  product(level, start, [=] __device__(int64_t k, T Az) {
    v.d[k] = v.smoother.first * v.inverse_diagonal[k] * (v.r[k] - Az);
    v.other[k] = z[k] + v.d[k];
  });
  const auto next = [=] __device__(int64_t k) { return v.other[k]; };
  product(level, next, [=] __device__(int64_t k, T Az) {
    const T step = v.smoother.add * v.inverse_diagonal[k] * (v.r[k] - Az);
    z[k] = v.other[k] + (v.smoother.keep * v.d[k] + step);
  });
}

/// d = r - A z on the free nodes, 0 on the pinned ones.
template <class T>
void find_residual(Level<T>& level, const T* z) {
  const LevelView<T> v = level.view();
  const auto present = [=] __device__(int64_t k) { return z[k]; };
  product(level, present,
          [=] __device__(int64_t k, T Az) { v.d[k] = v.pinned[k / 3] ? T(0) : v.r[k] - Az; });
}

/// r of the coarse level = P^T d of the fine one, 0 on pinned coarse nodes.
template <class T>
void restrict_residual(Level<T>& fine, Level<T>& coarse) {
  const LevelView<T> v = coarse.view();
  const T* d = fine.d.data();
  cuda::for_each(3 * v.nodes, [=] __device__(int64_t k) {
    const int64_t n = k / 3, i = k % 3;
    T sum = 0;
    if (!v.pinned[n])
#pragma unroll
      for (int c = 0; c < 27; ++c) {
        const int64_t child = v.children[27 * n + c];
        if (child < 0) continue;
        const T half = T(0.5), one = 1;
        sum += (c % 3 == 1 ? one : half) * (c / 3 % 3 == 1 ? one : half) *
               (c / 9 == 1 ? one : half) * d[3 * child + i];
      }
    v.r[k] = sum;
  });
}

/// z of the fine level += P times that of the coarse one, on the free nodes.
template <class T>
void prolong_correction(Level<T>& fine, const T* coarse, T* z) {
  const LevelView<T> v = fine.view();
  cuda::for_each(3 * v.nodes, [=] __device__(int64_t k) {
    const int64_t n = k / 3, i = k % 3;
    if (v.pinned[n]) return;
    // the corners that differ: those along the odd axes
    const int odd = v.odd_axes[n];
    T sum = 0;
    int corners = 0;
    for (int c = odd;; c = (c - 1) & odd) {
      ++corners;
      const int64_t parent = v.parents[8 * n + c];
      if (parent >= 0) sum += coarse[3 * parent + i];
      if (c == 0) break;
    }
    z[k] += sum / T(corners);
  });
}

/// z_i = A_i^-1 r_i. Neighbouring threads take neighbouring rows of a component; the inverses are
/// symmetric, so they read along a row of the matrix.
template <class T>
void solve(Level<T>& level, T* z) {
  const LevelView<T> v = level.view();
  cuda::for_each(3 * v.nodes, [=] __device__(int64_t k) {
    const int64_t n = v.nodes, i = k / n, row = k % n;
    const T* inverse = v.inverses + i * n * n + row;
    T sum = 0;
    for (int64_t j = 0; j < n; ++j) sum += inverse[j * n] * v.r[3 * j + i];
    z[3 * row + i] = sum;
  });
}

}  // namespace

template <class T>
DeviceMultigrid<T>::DeviceMultigrid(const Multigrid<T>& host) : scale_(T(1 / host.level(0).unit)) {
  for (int l = 0; l < host.level_count(); ++l)
    levels_.push_back(std::make_unique<DeviceMultigridLevel<T>>(host.level(l)));
}

template <class T>
DeviceMultigrid<T>::~DeviceMultigrid() = default;

template <class T>
void DeviceMultigrid<T>::apply(const T* r, T* z) {
  T* const scaled = levels_.front()->r.data();
  const T scale = scale_;
  cuda::for_each(3 * levels_.front()->nodes,
                 [=] __device__(int64_t k) { scaled[k] = scale * r[k]; });
  cycle(0, z);
}

template <class T>
void DeviceMultigrid<T>::cycle(size_t l, T* z) {
  DeviceMultigridLevel<T>& level = *levels_[l];
  if (level.inverses.size() > 0) return solve(level, z);
  smooth_from_zero(level, z);
  if (l + 1 < levels_.size()) {
    DeviceMultigridLevel<T>& coarse = *levels_[l + 1];
    find_residual(level, z);
    restrict_residual(level, coarse);
    cycle(l + 1, coarse.z.data());
    prolong_correction(level, coarse.z.data(), z);
  }
  smooth(level, z);
}

template class DeviceMultigrid<float>;
template class DeviceMultigrid<double>;

}  // namespace elastogen::cuda
