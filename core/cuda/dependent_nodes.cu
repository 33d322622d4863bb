// SPDX-License-Identifier: Apache-2.0
// Compiled without fused operations, like the CPU's source, so that results equal its bit by bit.
#include "core/cuda/dependent_nodes.cuh"

namespace elastogen::cuda {
namespace {

/// before + sum w values of the sources of node i, for component d.
template <class T>
__device__ double sum_of(const WeightedSums& of, int64_t i, int64_t d, double before,
                         const T* values) {
  double sum = before;
  for (int32_t k = of.begin[i]; k < of.begin[i + 1]; ++k)
    sum += of.weights[k] * double(values[3 * int64_t(of.sources[k]) + d]);
  return sum;
}

}  // namespace

template <class T>
void DeviceDependentNodes::fill(T* values) const {
  const WeightedSums of = filled_.view();
  cuda::for_each(3 * of.count, [=] __device__(int64_t k) {
    const int64_t i = k / 3, d = k % 3;
    values[3 * int64_t(of.nodes[i]) + d] = T(sum_of(of, i, d, 0, values));
  });
}

void DeviceDependentNodes::fill(double* values, const Vec3* offsets) const {
  const WeightedSums of = filled_.view();
  cuda::for_each(3 * of.count, [=] __device__(int64_t k) {
    const int64_t i = k / 3, d = k % 3;
    values[3 * int64_t(of.nodes[i]) + d] = sum_of(of, i, d, 0, values) + offsets[i][size_t(d)];
  });
}

template <class T>
void DeviceDependentNodes::fold(T* gradient) const {
  const WeightedSums by_parent = folded_.view(), own = filled_.view();
  cuda::for_each(3 * by_parent.count, [=] __device__(int64_t k) {
    const int64_t i = k / 3, d = k % 3;
    T& of_parent = gradient[3 * int64_t(by_parent.nodes[i]) + d];
    of_parent = T(sum_of(by_parent, i, d, double(of_parent), gradient));
  });
  cuda::for_each(3 * own.count, [=] __device__(int64_t k) {
    gradient[3 * int64_t(own.nodes[k / 3]) + k % 3] = 0;
  });
}

template void DeviceDependentNodes::fill(float*) const;
template void DeviceDependentNodes::fill(double*) const;
template void DeviceDependentNodes::fold(float*) const;
template void DeviceDependentNodes::fold(double*) const;

}  // namespace elastogen::cuda
