// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/fold_patch.hpp"

#include "core/reduce.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Cosine of the angle of a rotation from another.
double cosine(const Mat3<double>& a, const float* b) {
  double trace = 0;
  for (int k = 0; k < 9; ++k) trace += a.m[k] * double(b[k]);
  return (trace - 1) / 2;
}

/// y = K x of a 3x3 block, or its transpose.
void add_product(const float* K, const float* x, float y[3]) {
  for (int i = 0; i < 3; ++i) y[i] += K[3 * i] * x[0] + K[3 * i + 1] * x[1] + K[3 * i + 2] * x[2];
}
void add_transposed(const float* K, const float* x, float y[3]) {
  for (int i = 0; i < 3; ++i) y[i] += K[i] * x[0] + K[3 + i] * x[1] + K[6 + i] * x[2];
}

/// Voxels whose frames lie far from those of one of their nodes.
std::vector<int32_t> voxels_apart(const VoxelStiffness& stiffness) {
  const VoxelGrid& grid = stiffness.potential().scene().grid;
  const float* frames = stiffness.potential().nodal_rotation().data();
  return filtered(grid.voxel_count(), [&](int64_t v) {
    const Mat3<double> R = stiffness.frame(v);
    const int32_t* corners = grid.corners.row(v);
    return std::any_of(corners, corners + 8,
                       [&](int32_t n) { return cosine(R, frames + 9 * size_t(n)) < kFoldCosine; });
  });
}

}  // namespace

/// Adds value(i, j) to the block of two corners, if it is there.
template <class Value>
void FoldPatch::add_block(const int32_t* corners, int a, int b, const Value& value) {
  const int32_t row = of_->place[size_t(corners[a])], column = of_->place[size_t(corners[b])];
  if (row < 0 || column < 0 || row >= int32_t(of_->nodes.size())) return;
  const auto found = std::lower_bound(of_->columns.begin() + of_->begin[size_t(row)],
                                      of_->columns.begin() + of_->begin[size_t(row) + 1], column);
  float* block = blocks_.data() + 9 * (found - of_->columns.begin());
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) block[3 * i + j] += float(value(i, j));
}

void FoldPatch::add_voxels(const VoxelStiffness& stiffness) {
  const IncrementalPotential& potential = stiffness.potential();
  constexpr size_t kEntries = 24 * 24;
  std::vector<double> matrices(kEntries * of_->voxels.size());
  for_each(int64_t(of_->voxels.size()), [&](int64_t k) {
    stiffness.matrix(of_->voxels[size_t(k)], matrices.data() + kEntries * size_t(k));
  });
  for (size_t v = 0; v < of_->voxels.size(); ++v) {
    const double* K = matrices.data() + kEntries * v;
    const int32_t* corners = potential.scene().grid.corners.row(of_->voxels[v]);
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        add_block(corners, a, b, [&](int i, int j) { return K[24 * (3 * a + i) + 3 * b + j]; });
  }
  for (const int32_t n : of_->nodes)
    add_block(&n, 0, 0, [&](int i, int j) { return i == j ? potential.inertia(n) : 0; });
}

void FoldPatch::add_contact(const Contact& contact) {
  contact.for_each_frozen([&](const int32_t* corners, const double* w, const PointStiffness& k) {
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        add_block(corners, a, b,
                  [&](int i, int j) { return w[a] * w[b] * k.entry(size_t(i), size_t(j)); });
  });
}

void FoldPatch::find_inverses() {
  using Block = Eigen::Matrix<float, 3, 3, Eigen::RowMajor>;
  inverse_ = Zeroed<float>(9 * of_->nodes.size());
  for_each(count(), [&](int64_t k) {
    const auto first = of_->columns.begin() + of_->begin[size_t(k)],
               last = of_->columns.begin() + of_->begin[size_t(k) + 1];
    const auto number = size_t(std::lower_bound(first, last, int32_t(k)) - of_->columns.begin());
    const Eigen::Matrix3d D = Eigen::Map<const Block>(blocks_.data() + 9 * number).cast<double>();
    const Eigen::Matrix3d inverse = D.inverse();
    Eigen::Map<Block>(inverse_.data() + 9 * k) =
        ((inverse + inverse.transpose()) / 2).cast<float>();
  });
}

/// y = H x on the nodes of the patch, x on those reached.
void FoldPatch::product(const Zeroed<float>& x, Zeroed<float>& y) const {
  for_each(count(), [&](int64_t row) {
    float sum[3] = {};
    for (int32_t e = of_->begin[size_t(row)]; e < of_->begin[size_t(row) + 1]; ++e)
      add_product(blocks_.data() + 9 * size_t(e), x.data() + 3 * size_t(of_->columns[size_t(e)]),
                  sum);
    std::copy_n(sum, 3, y.begin() + 3 * row);
  });
}

/// By the power method on D^-1 H, from a vector without symmetry.
void FoldPatch::find_bound() {
  for (size_t k = 0; k < right_.size(); ++k) far_[k] = fold_power_start(uint32_t(k));
  std::fill(far_.begin() + int64_t(right_.size()), far_.end(), 0.f);
  bound_ = 1;
  for (int power = 0; power < kFoldPowers; ++power) {
    product(far_, Hz_);
    for_each(count(), [&](int64_t k) {
      float sum[3] = {};
      add_product(inverse_.data() + 9 * k, Hz_.data() + 3 * k, sum);
      std::copy_n(sum, 3, far_.begin() + 3 * k);
    });
    const double size = norm(far_.data(), int64_t(right_.size()));
    if (!(size > 0)) return;
    if (power > 0) bound_ = kFoldMargin * size;
    for (float& value : far_) value = float(value / size);
  }
}

/// z_ = S right_, Chebyshev's iteration from 0.
void FoldPatch::smooth() {
  const FoldSmoother smoother = fold_smoother();
  std::fill(z_.begin(), z_.end(), 0.f);
  for (size_t step = 0; step < FoldSmoother::kDegree; ++step) {
    if (step > 0) product(z_, Hz_);
    const auto keep = float(smoother.keep[step]), add = float(smoother.add[step] / bound_);
    for_each(count(), [&](int64_t k) {
      float r[3], Dr[3] = {};
      for (size_t i = 3 * size_t(k), j = 0; j < 3; ++i, ++j)
        r[j] = step == 0 ? right_[i] : right_[i] - Hz_[i];
      add_product(inverse_.data() + 9 * k, r, Dr);
      for (size_t i = 3 * size_t(k), j = 0; j < 3; ++i, ++j) {
        d_[i] = step == 0 ? add * Dr[j] : keep * d_[i] + add * Dr[j];
        z_[i] += d_[i];
      }
    });
  }
}

void FoldPatch::update(IncrementalPotential& potential, const double* u) {
  if (!of_) of_.emplace(potential.scene());
  const VoxelStiffness stiffness(potential, u);
  of_->find(voxels_apart(stiffness));
  if (empty()) return;
  // H
  blocks_ = Zeroed<float>(9 * of_->columns.size());
  add_voxels(stiffness);
  add_contact(potential.contact());
  // S
  for (Zeroed<float>* vector : {&right_, &d_, &Hz_}) *vector = Zeroed<float>(3 * of_->nodes.size());
  for (Zeroed<float>* vector : {&z_, &far_}) *vector = Zeroed<float>(3 * of_->reached.size());
  find_inverses();
  find_bound();
}

template <class T>
void FoldPatch::gather(const std::vector<int32_t>& nodes, const T* from, Zeroed<float>& to) const {
  for_each(int64_t(nodes.size()), [&](int64_t k) {
    for (size_t i = 0; i < 3; ++i)
      to[3 * size_t(k) + i] = float(from[3 * size_t(nodes[size_t(k)]) + i]);
  });
}

template <class T>
void FoldPatch::begin(T* r, T* z_1) {
  gather(of_->nodes, r, right_);
  smooth();
  for_each(int64_t(of_->reached.size()), [&](int64_t m) {
    float sum[3] = {};
    for (int32_t t = of_->first[size_t(m)]; t < of_->first[size_t(m) + 1]; ++t) {
      const auto [row, number] = of_->transposed[size_t(t)];
      add_transposed(blocks_.data() + 9 * size_t(number), z_.data() + 3 * size_t(row), sum);
    }
    const size_t n = 3 * size_t(of_->reached[size_t(m)]);
    for (size_t i = 0; i < 3; ++i) {
      r[n + i] -= T(sum[i]);
      if (m < count()) z_1[n + i] = T(z_[3 * size_t(m) + i]);
    }
  });
}

template <class T, class Z>
void FoldPatch::end(const T* r, const T* z_1, Z* p) {
  gather(of_->nodes, r, right_);
  gather(of_->reached, p, far_);
  product(far_, Hz_);
  for_each(int64_t(right_.size()), [&](int64_t k) { right_[size_t(k)] -= Hz_[size_t(k)]; });
  smooth();
  for_each(count(), [&](int64_t k) {
    const size_t n = 3 * size_t(of_->nodes[size_t(k)]);
    for (size_t i = 0; i < 3; ++i) p[n + i] += Z(z_1[n + i] + T(z_[3 * size_t(k) + i]));
  });
}

template void FoldPatch::begin(float*, float*);
template void FoldPatch::begin(double*, double*);
template void FoldPatch::end(const float*, const float*, float*);
template void FoldPatch::end(const float*, const float*, double*);
template void FoldPatch::end(const double*, const double*, float*);
template void FoldPatch::end(const double*, const double*, double*);

}  // namespace elastogen
