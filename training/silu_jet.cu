// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/launch.cuh"
#include "training/silu_jet.hpp"
#include "training/silu_jet_impl.hpp"

namespace elastogen::cuda {
namespace {

/// Place of the jet of one neuron at one point.
struct Place {
  int64_t at, stride, bias;
  bool second;
};

/// One block for a point of a net, one thread for a neuron: neighbours access neighbouring words.
__device__ Place place(const JetShape& shape) {
  const int64_t point = blockIdx.x, net = blockIdx.y, h = threadIdx.x;
  const bool second = point < shape.second;
  const int64_t row = second ? point : 9 * shape.second + point;
  const int64_t rows = 10 * shape.second + 4 * shape.first;
  return {(net * rows + row) * shape.width + h, (second ? shape.second : shape.first) * shape.width,
          net * shape.width + h, second};
}

template <int kChannels>
__device__ void load_jet(const float* from, int64_t stride, float bias, float z[kChannels]) {
  for (int c = 0; c < kChannels; ++c) z[c] = from[c * stride];
  z[0] += bias;
}

template <int kChannels>
__device__ void value(const Place& p, const float* z, float bias, float* a) {
  float in[kChannels], out[kChannels];
  load_jet<kChannels>(z + p.at, p.stride, bias, in);
  silu::forward<kChannels>(in, out);
  for (int c = 0; c < kChannels; ++c) a[p.at + c * p.stride] = out[c];
}

template <int kChannels>
__device__ void gradient(const Place& p, const float* z, float bias, const float* g, float* dz) {
  float in[kChannels], slope[kChannels], out[kChannels];
  load_jet<kChannels>(z + p.at, p.stride, bias, in);
  load_jet<kChannels>(g + p.at, p.stride, 0, slope);
  silu::backward<kChannels>(in, slope, out);
  for (int c = 0; c < kChannels; ++c) dz[p.at + c * p.stride] = out[c];
}

__global__ void value_kernel(JetShape shape, const float* z, const float* bias, float* a) {
  const Place p = place(shape);
  if (p.second)
    value<silu::kSecond>(p, z, bias[p.bias], a);
  else
    value<silu::kFirst>(p, z, bias[p.bias], a);
}

__global__ void gradient_kernel(JetShape shape, const float* z, const float* bias, const float* g,
                                float* dz) {
  const Place p = place(shape);
  if (p.second)
    gradient<silu::kSecond>(p, z, bias[p.bias], g, dz);
  else
    gradient<silu::kFirst>(p, z, bias[p.bias], g, dz);
}

dim3 blocks(const JetShape& shape) {
  return dim3(unsigned(shape.second + shape.first), unsigned(shape.nets));
}

}  // namespace

void silu_jet(const JetShape& shape, const float* z, const float* bias, float* a) {
  value_kernel<<<blocks(shape), unsigned(shape.width)>>>(shape, z, bias, a);
  check(cudaGetLastError());
}

void silu_jet_gradient(const JetShape& shape, const float* z, const float* bias, const float* g,
                       float* dz) {
  gradient_kernel<<<blocks(shape), unsigned(shape.width)>>>(shape, z, bias, g, dz);
  check(cudaGetLastError());
}

}  // namespace elastogen::cuda
