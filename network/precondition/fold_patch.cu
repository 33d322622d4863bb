// SPDX-License-Identifier: Apache-2.0
#include "core/mat3.hpp"
#include "network/contact/contact_view.cuh"
#include "network/potential/voxel_stiffness.cuh"
#include "network/precondition/fold_nodes.hpp"
#include "network/precondition/fold_patch_device.hpp"

#include <algorithm>
#include <utility>

namespace elastogen::cuda {
namespace {

/// The patch, as kernels read it.
struct FoldView {
  int64_t count, reached_count;    ///< of its nodes, and with those beside them
  const int32_t* reached;          ///< node of each place, those of the patch first
  const int32_t *begin, *columns;  ///< of rows
  const float* blocks;             ///< (columns, 3, 3)
  const int32_t* first;            ///< of columns
  const FoldNodes::Entry* transposed;
  const float* inverse;  ///< of the diagonal blocks, (count, 3, 3)
  const double* bound;   ///< of the eigenvalues of D^-1 H
  float *right, *d;      ///< (count, 3)
};

constexpr int kWarp = 32, kRowThreads = 256;

/// Calls body(row, lane) for the rows [0, count), a warp for each.
template <class Body>
__global__ void __launch_bounds__(kRowThreads) rows_kernel(int64_t count, Body body) {
  begin_kernel();
  const int64_t row = (int64_t(blockIdx.x) * kRowThreads + threadIdx.x) / kWarp;
  if (row < count) body(row, int(threadIdx.x) % kWarp);
}

template <class Body>
void for_each_by_warp(int64_t count, const Body& body) {
  constexpr int kRows = kRowThreads / kWarp;
  launch(rows_kernel<Body>, unsigned((count + kRows - 1) / kRows), kRowThreads, 0, count, body);
}

/// The sum over the lanes of a warp, for all of them.
__device__ void warp_sum(float sum[3]) {
  for (int step = kWarp / 2; step > 0; step /= 2)
    for (int i = 0; i < 3; ++i) sum[i] += __shfl_xor_sync(~0u, sum[i], step);
}

/// y = H x in a row, by a warp.
/// @param nodes  of places: x is (nodes, 3); null: x has the nodes reached alone.
__device__ void row_product(const FoldView& v, int64_t row, int lane, const float* x,
                            const int32_t* nodes, float y[3]) {
  y[0] = y[1] = y[2] = 0;
  for (int32_t e = v.begin[row] + lane; e < v.begin[row + 1]; e += kWarp) {
    const int32_t place = v.columns[e];
    const float *K = v.blocks + 9 * int64_t(e), *of = x + 3 * int64_t(nodes ? nodes[place] : place);
    for (int i = 0; i < 3; ++i)
      y[i] += K[3 * i] * of[0] + K[3 * i + 1] * of[1] + K[3 * i + 2] * of[2];
  }
  warp_sum(y);
}

/// Component i of D^-1 r in a row.
__device__ float row_inverse(const FoldView& v, int64_t row, int i, const float r[3]) {
  const float* inverse = v.inverse + 9 * row + 3 * i;
  return inverse[0] * r[0] + inverse[1] * r[1] + inverse[2] * r[2];
}

/// The first step of S from right hand sides r, by three lanes of a warp.
__device__ void first_step(const FoldView& v, int64_t row, int lane, float add, const float r[3],
                           float* z) {
  if (lane >= 3) return;
  const int64_t k = 3 * row + lane;
  v.right[k] = r[lane];
  z[k] = v.d[k] = float(add / *v.bound) * row_inverse(v, row, lane, r);
}

/// A step of S behind the first one: the new z, by three lanes of a warp.
struct SmootherStep {
  FoldView v;
  const float* from;
  double keep, add;
  __device__ float operator()(int64_t row, int lane) const {
    float r[3];
    row_product(v, row, lane, from, nullptr, r);
    if (lane >= 3) return 0;
    for (int i = 0; i < 3; ++i) r[i] = v.right[3 * row + i] - r[i];
    const int64_t k = 3 * row + lane;
    v.d[k] = float(keep) * v.d[k] + float(add / *v.bound) * row_inverse(v, row, lane, r);
    return from[k] + v.d[k];
  }
};

/// The steps of S between the first and the last one, which it returns. z: of the first step, and
/// another vector.
SmootherStep smooth(const FoldView& v, const FoldSmoother& smoother, float* z, float* other) {
  size_t step = 1;
  for (; step + 1 < FoldSmoother::kDegree; ++step) {
    const SmootherStep advance{v, z, smoother.keep[step], smoother.add[step]};
    for_each_by_warp(v.count, [=] __device__(int64_t row, int lane) {
      const float value = advance(row, lane);
      if (lane < 3) other[3 * row + lane] = value;
    });
    std::swap(z, other);
  }
  return {v, z, smoother.keep[step], smoother.add[step]};
}

/// Inverses of the diagonal blocks of H.
void find_inverses(const FoldView& v, float* inverse) {
  cuda::for_each(v.count, [=] __device__(int64_t row) {
    int32_t number = v.begin[row];
    while (v.columns[number] != row) ++number;
    Mat3<double> D;
    for (int k = 0; k < 9; ++k) D.m[k] = double(v.blocks[9 * int64_t(number) + k]);
    const Mat3<double> found = elastogen::inverse(D);
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        inverse[9 * row + 3 * i + j] = float((found(i, j) + found(j, i)) / 2);
  });
}

/// Sets the bound by the power method on D^-1 H, as FoldPatch does. x and y: (count, 3); x has 0 at
/// places beyond.
void find_bound(const FoldView& v, SumScratch<Sums<1>>* sums, float* x, float* y, double* bound) {
  cuda::for_each(3 * v.count, [=] __device__(int64_t k) { x[k] = fold_power_start(uint32_t(k)); });
  for (int power = 0; power < kFoldPowers; ++power) {
    for_each_by_warp(v.count, [=] __device__(int64_t row, int lane) {
      float Hx[3];
      row_product(v, row, lane, x, nullptr, Hx);
      if (lane < 3) y[3 * row + lane] = row_inverse(v, row, lane, Hx);
    });
    ordered_sum(
        3 * v.count, sums,
        [=] __device__(int64_t k, Sums<1> & sum) { sum.value[0] += double(y[k]) * double(y[k]); },
        [=] __device__(const Sums<1>& sum) { *bound = sqrt(sum.value[0]); });
    cuda::for_each(3 * v.count, [=] __device__(int64_t k) {
      x[k] = *bound > 0 ? float(double(y[k]) / *bound) : 0.f;
    });
  }
  cuda::for_each(1, [=] __device__(int64_t) { *bound = *bound > 0 ? kFoldMargin * *bound : 1; });
}

}  // namespace

struct DeviceFoldPatch::Impl {
  explicit Impl(DevicePotential& p)
      : potential(p), stiffness(p), found(p.terms().scene()), smoother(fold_smoother()) {}

  void upload();
  FoldView view();
  int64_t count() const { return found.count(); }

  DevicePotential& potential;
  DeviceVoxelStiffness stiffness;
  FoldNodes found;
  const FoldSmoother smoother;
  bool is_without_memory = false;
  GrowingArray<int32_t> reached, begin, columns, first;
  GrowingArray<int32_t> corner;  // place of each corner of the patch's voxels, (voxels, 8)
  GrowingArray<int32_t> voxel;   // of which a node is corner c, among these, (count, 8)
  GrowingArray<FoldNodes::Entry> transposed;
  GrowingArray<float> blocks, inverse, right, d, first_z, left;
  GrowingArray<float> z[2];  // of the nodes reached
  GrowingArray<double> bound;
  GrowingArray<SumScratch<Sums<1>>> sums;
};

DeviceFoldPatch::DeviceFoldPatch(DevicePotential& potential)
    : impl_(std::make_unique<Impl>(potential)) {}

DeviceFoldPatch::~DeviceFoldPatch() = default;

void DeviceFoldPatch::clear() {
  impl_->found.clear();
}

bool DeviceFoldPatch::empty() const {
  return impl_->found.empty();
}

int64_t DeviceFoldPatch::count() const {
  return impl_->count();
}

void DeviceFoldPatch::find(const double* u) {
  Impl& s = *impl_;
  if (s.is_without_memory) return;
  try {
    // lists are kept while they have all voxels: the host takes longer for them than the card for H
    const std::vector<int32_t> apart = s.stiffness.apart(u, kFoldCosine);
    const bool again = !s.found.cover(apart);
    if (again) s.found.find(apart);
    if (empty()) return;
    s.stiffness.update(u, s.found.voxels);
    if (again) s.upload();
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kResources) throw;
    s.is_without_memory = true;
    s.found.clear();
  }
}

void DeviceFoldPatch::Impl::upload() {
  // places of the corners of the patch's voxels, and which of these voxels are at each of its nodes
  const VoxelGrid& grid = potential.terms().scene().grid;
  std::vector<int32_t> corners, voxels;
  for (const int32_t v : found.voxels)
    for (int c = 0; c < 8; ++c) corners.push_back(found.place[size_t(grid.corners(v, c))]);
  for (const int32_t n : found.nodes)
    for (int c = 0; c < 8; ++c) {
      const auto at = std::ranges::lower_bound(found.voxels, grid.voxels(n, c));
      const bool is_one = at != found.voxels.end() && *at == grid.voxels(n, c);
      voxels.push_back(is_one ? int32_t(at - found.voxels.begin()) : -1);
    }
  corner.upload(corners);
  voxel.upload(voxels);
  reached.upload(found.reached);
  begin.upload(found.begin);
  columns.upload(found.columns);
  first.upload(found.first);
  transposed.upload(found.transposed);
  // what kernels write; places beyond the patch stay 0
  const int64_t rows = 3 * count(), places = 3 * int64_t(found.reached.size());
  blocks.resize(9 * columns.size());
  for (GrowingArray<float>* vector : {&right, &d}) vector->resize(rows);
  inverse.resize(3 * rows);
  for (GrowingArray<float>* vector : {&first_z, &z[0], &z[1]}) {
    vector->resize(0);
    vector->resize(places);
  }
  left.resize(3 * potential.nodes());
  bound.resize(1);
  sums.resize(1);
}

FoldView DeviceFoldPatch::Impl::view() {
  return {count(),        reached.size(), reached.data(), begin.data(),
          columns.data(), blocks.data(),  first.data(),   transposed.data(),
          inverse.data(), bound.data(),   right.data(),   d.data()};
}

void DeviceFoldPatch::assemble() {
  if (empty()) return;
  Impl& s = *impl_;
  // blocks of voxels, inertia and contact
  const FoldView v = s.view();
  const int32_t *corner = s.corner.data(), *voxel = s.voxel.data();
  const float* matrices = s.stiffness.matrices();
  const double* inertia = s.potential.inertia();
  const FrozenStiffness contact =
      s.potential.contact() ? s.potential.contact()->frozen_stiffness() : FrozenStiffness{};
  float* blocks = s.blocks.data();
  cuda::for_each(s.transposed.size(), [=] __device__(int64_t t) {
    const auto [row, number] = v.transposed[t];
    const int32_t column = v.columns[number];
    float sum[9] = {};
    for (int a = 0; a < 8; ++a) {
      const int32_t w = voxel[8 * int64_t(row) + a];
      for (int b = 0; w >= 0 && b < 8; ++b) {
        if (corner[8 * int64_t(w) + b] != column) continue;
        const float* K = matrices + DeviceVoxelStiffness::kEntries * w + 24 * 3 * a + 3 * b;
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) sum[3 * i + j] += K[24 * i + j];
      }
    }
    if (row == column)
      for (int i = 0; i < 3; ++i) sum[4 * i] += float(inertia[v.reached[row]]);
    contact.add(v.reached[row], v.reached[column], sum);
    for (int k = 0; k < 9; ++k) blocks[9 * int64_t(number) + k] = sum[k];
  });
  find_inverses(v, s.inverse.data());
  find_bound(v, s.sums.data(), s.z[0].data(), s.d.data(), s.bound.data());
}

const float* DeviceFoldPatch::begin(const float* r) {
  Impl& s = *impl_;
  const FoldView v = s.view();
  float *z = s.z[0].data(), *first = s.first_z.data(), *left = s.left.data();
  const double add = s.smoother.add[0];
  for_each_by_warp(v.count, [=] __device__(int64_t row, int lane) {
    first_step(v, row, lane, float(add), r + 3 * int64_t(v.reached[row]), z);
  });
  const SmootherStep last = smooth(v, s.smoother, z, s.z[1].data());
  for_each_by_warp(v.count, [=] __device__(int64_t row, int lane) {
    const float value = last(row, lane);
    if (lane < 3) first[3 * row + lane] = value;
  });
  // r - H z_1, by the transposed rows
  cuda::for_each(s.left.size(), [=] __device__(int64_t k) { left[k] = r[k]; });
  for_each_by_warp(v.reached_count, [=] __device__(int64_t place, int lane) {
    float sum[3] = {};
    for (int32_t t = v.first[place] + lane; t < v.first[place + 1]; t += kWarp) {
      const auto [row, number] = v.transposed[t];
      const float *K = v.blocks + 9 * int64_t(number), *of = first + 3 * int64_t(row);
      for (int i = 0; i < 3; ++i) sum[i] += K[i] * of[0] + K[3 + i] * of[1] + K[6 + i] * of[2];
    }
    warp_sum(sum);
    if (lane < 3) left[3 * int64_t(v.reached[place]) + lane] -= sum[lane];
  });
  return s.left.data();
}

void DeviceFoldPatch::end(float* z) {
  Impl& s = *impl_;
  const FoldView v = s.view();
  const float *left = s.left.data(), *first = s.first_z.data();
  float* own = s.z[0].data();
  const double add = s.smoother.add[0];
  for_each_by_warp(v.count, [=] __device__(int64_t row, int lane) {
    float r[3];
    row_product(v, row, lane, z, v.reached, r);
    for (int i = 0; i < 3; ++i) r[i] = left[3 * int64_t(v.reached[row]) + i] - r[i];
    first_step(v, row, lane, float(add), r, own);
  });
  const SmootherStep last = smooth(v, s.smoother, own, s.z[1].data());
  for_each_by_warp(v.count, [=] __device__(int64_t row, int lane) {
    const float value = last(row, lane);
    if (lane < 3) z[3 * int64_t(v.reached[row]) + lane] += first[3 * row + lane] + value;
  });
}

}  // namespace elastogen::cuda
