// SPDX-License-Identifier: Apache-2.0
#include "training/silu_jet.hpp"

#include "training/silu_jet_impl.hpp"

#include <ATen/Parallel.h>

namespace elastogen::cpu {
namespace {

constexpr int64_t kGrain = 64;  // points of one parallel task

/// Eight neurons of a point: loads its channels, which are `stride` apart.
template <int kChannels>
void load_jet(const float* from, int64_t stride, const float* bias, Pack<float> z[kChannels]) {
  for (int c = 0; c < kChannels; ++c) z[c] = load(from + c * stride);
  if (bias) z[0] += load(bias);
}

template <int kChannels>
void store_jet(float* to, int64_t stride, const Pack<float> a[kChannels]) {
  for (int c = 0; c < kChannels; ++c) store(to + c * stride, a[c]);
}

/// Calls body(offset of a point's value channel, stride between channels, net, channels) for all.
template <class Body>
void for_points(const JetShape& shape, const Body& body) {
  const int64_t points = shape.second + shape.first;
  at::parallel_for(0, shape.nets * points, kGrain, [&](int64_t begin, int64_t end) {
    for (int64_t i = begin; i < end; ++i) {
      const int64_t net = i / points, point = i % points;
      const bool second = point < shape.second;
      const int64_t row = second ? point : 9 * shape.second + point;
      const int64_t stride = (second ? shape.second : shape.first) * shape.width;
      body((net * shape.rows() + row) * shape.width, stride, net * shape.width, second);
    }
  });
}

template <int kChannels>
void value(const float* z, const float* bias, float* a, int64_t stride, int64_t width) {
  for (int64_t h = 0; h < width; h += kLanes) {
    Pack<float> in[kChannels], out[kChannels];
    load_jet<kChannels>(z + h, stride, bias + h, in);
    silu::forward<kChannels>(in, out);
    store_jet<kChannels>(a + h, stride, out);
  }
}

template <int kChannels>
void gradient(const float* z, const float* bias, const float* g, float* dz, int64_t stride,
              int64_t width) {
  for (int64_t h = 0; h < width; h += kLanes) {
    Pack<float> in[kChannels], slope[kChannels], out[kChannels];
    load_jet<kChannels>(z + h, stride, bias + h, in);
    load_jet<kChannels>(g + h, stride, nullptr, slope);
    silu::backward<kChannels>(in, slope, out);
    store_jet<kChannels>(dz + h, stride, out);
  }
}

}  // namespace

void silu_jet(const JetShape& shape, const float* z, const float* bias, float* a) {
  for_points(shape, [&](int64_t at, int64_t stride, int64_t b, bool second) {
    if (second)
      value<silu::kSecond>(z + at, bias + b, a + at, stride, shape.width);
    else
      value<silu::kFirst>(z + at, bias + b, a + at, stride, shape.width);
  });
}

void silu_jet_gradient(const JetShape& shape, const float* z, const float* bias, const float* g,
                       float* dz) {
  for_points(shape, [&](int64_t at, int64_t stride, int64_t b, bool second) {
    if (second)
      gradient<silu::kSecond>(z + at, bias + b, g + at, dz + at, stride, shape.width);
    else
      gradient<silu::kFirst>(z + at, bias + b, g + at, dz + at, stride, shape.width);
  });
}

}  // namespace elastogen::cpu
