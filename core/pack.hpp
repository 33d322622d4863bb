// SPDX-License-Identifier: Apache-2.0
// Packs of eight numbers. The formulas of one voxel are written once, as templates on T; with
// T = Pack<float> or Pack<double> they run on a row of eight voxels, with T = double on one.
//
// A pack is a vector of the compiler: + - * /, comparisons and m ? a : b work lane by lane. Where
// the machine's vectors are shorter, the last two are split into single numbers, so code that
// compares many doubles uses a WidePack.

#pragma once

#include "core/base.hpp"

#include <cmath>
#include <cstring>

namespace elastogen {

inline constexpr int kLanes = 8;

namespace detail {
template <class T>
struct PackOf;
template <>
struct PackOf<float> {
  typedef float type __attribute__((vector_size(32)));
  typedef int32_t mask __attribute__((vector_size(32)));
};
template <>
struct PackOf<double> {
  typedef double type __attribute__((vector_size(64)));
  typedef int64_t mask __attribute__((vector_size(64)));
};
typedef double HalfOfDoubles __attribute__((vector_size(32)));
typedef int64_t HalfOfMasks __attribute__((vector_size(32)));
template <class T>
struct ScalarOf {
  using type = T;
};
template <>
struct ScalarOf<HalfOfDoubles> {
  using type = double;
};
template <>
struct ScalarOf<HalfOfMasks> {
  using type = int64_t;
};
template <>
struct ScalarOf<PackOf<float>::type> {
  using type = float;
};
template <>
struct ScalarOf<PackOf<double>::type> {
  using type = double;
};
template <>
struct ScalarOf<PackOf<float>::mask> {
  using type = int32_t;
};
template <>
struct ScalarOf<PackOf<double>::mask> {
  using type = int64_t;
};
}  // namespace detail

template <class T>
using Pack = typename detail::PackOf<T>::type;
template <class T>
using PackMask = typename detail::PackOf<T>::mask;

/// Half a pack of doubles; the functions below accept it as a pack.
using HalfPack = detail::HalfOfDoubles;

/// The longer of both for which the machine has comparisons.
#ifdef __AVX512F__
using WidePack = Pack<double>;
#else
using WidePack = HalfPack;
#endif

/// The type of one lane: T itself for a scalar.
template <class T>
using Scalar = typename detail::ScalarOf<T>::type;

template <class T>
inline constexpr bool is_pack = !std::is_same_v<T, Scalar<T>>;

template <class T>
inline constexpr int lane_count = sizeof(T) / sizeof(Scalar<T>);

/// One number in every lane.
template <class T>
ELASTOGEN_HD inline T constant(Scalar<T> value) {
  return T{} + value;
}

template <class S, class T = Pack<S>>
inline T load(const S* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

template <class S>
inline void store(S* to, const Pack<S>& value) {
  std::memcpy(to, &value, sizeof value);
}

template <class T>
ELASTOGEN_HD inline T square_root(const T& a) {
  if constexpr (is_pack<T>) {
    T result;
    for (int k = 0; k < lane_count<T>; ++k) result[k] = std::sqrt(a[k]);
    return result;
  } else {
    return std::sqrt(a);
  }
}

/// 1 / sqrt(a); on the device to 2 eps, which is faster there than a root and a quotient.
template <class T>
ELASTOGEN_HD inline T inverse_root(const T& a) {
#ifdef __CUDA_ARCH__
  if constexpr (!is_pack<T>) return rsqrt(a);
#endif
  return 1 / square_root(a);
}

/// a / b; floats on the device to 2 eps, 0 where |b| is above 2^126.
template <class T>
ELASTOGEN_HD inline T rough_quotient(const T& a, const T& b) {
#ifdef __CUDA_ARCH__
  if constexpr (std::is_same_v<T, float>) return __fdividef(a, b);
#endif
  return a / b;
}

template <class T>
ELASTOGEN_HD inline T absolute(const T& a) {
  return a < 0 ? -a : a;
}

template <class T>
ELASTOGEN_HD inline T larger(const T& a, const T& b) {
  return a > b ? a : b;
}

template <class T>
ELASTOGEN_HD inline T smaller(const T& a, const T& b) {
  return a < b ? a : b;
}

/// Whether a condition holds in some lane.
template <class Mask>
ELASTOGEN_HD inline bool any(const Mask& mask) {
  if constexpr (std::is_same_v<Mask, bool>) {
    return mask;
  } else {
    uint64_t words[sizeof(Mask) / 8], all = 0;
    std::memcpy(words, &mask, sizeof mask);
    for (const uint64_t word : words) all |= word;
    return all != 0;
  }
}

}  // namespace elastogen
