// SPDX-License-Identifier: Apache-2.0
// Eight numbers that are worked on at once. The maths of one voxel is written once, as templates on
// T; with T = Pack<float> or Pack<double> it runs on a row of eight voxels, with T = double on one.
//
// A pack is a vector of the compiler: + - * /, comparisons and m ? a : b work lane by lane.

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
template <class T>
struct ScalarOf {
  using type = T;
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

/// The type of one lane: T itself for a scalar.
template <class T>
using Scalar = typename detail::ScalarOf<T>::type;

template <class T>
inline constexpr bool is_pack = !std::is_same_v<T, Scalar<T>>;

/// The same number in every lane.
template <class T>
ELASTOGEN_HD inline T constant(Scalar<T> value) {
  return T{} + value;
}

template <class S>
inline Pack<S> load(const S* from) {
  Pack<S> value;
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
    for (int k = 0; k < kLanes; ++k) result[k] = std::sqrt(a[k]);
    return result;
  } else {
    return std::sqrt(a);
  }
}

/// 1 / sqrt(a); on the device to 2 eps, which costs it less than a root and a quotient.
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

/// ln(1 + x) for x > -1, accurate relative to x near 0.
///
/// Packs: 1 + x = 2^k m with m in [sqrt(1/2), sqrt 2), and ln m = 2 artanh((m - 1) / (m + 1)) by
/// its series; within 4 eps of the exact value.
template <class T>
ELASTOGEN_HD inline T log_1p(const T& x) {
  if constexpr (!is_pack<T>) {
    return std::log1p(x);
  } else {
    using S = Scalar<T>;
    using Bits = PackMask<S>;
    // bits of sqrt(1/2) subtracted, so that the exponent rounds to nearest in the logarithm
    constexpr int kFraction = sizeof(S) == 4 ? 23 : 52;
    constexpr auto kRoot = Scalar<Bits>(sizeof(S) == 4 ? 0x3f3504f3 : 0x3fe6a09e667f3bcd);
    const T y = 1 + x;
    Bits bits;
    std::memcpy(&bits, &y, sizeof y);
    const Bits e = (bits - kRoot) >> kFraction;
    bits -= e << kFraction;
    T m;
    std::memcpy(&m, &bits, sizeof m);
    const T exponent = __builtin_convertvector(e, T);
    const T rest = e == 0 ? x : m - 1;
    const T z = rest / (2 + rest), z2 = z * z;
    constexpr int kTerms = sizeof(S) == 4 ? 5 : 11;
    T sum = constant<T>(S(1) / (2 * kTerms + 1));
    for (int k = kTerms - 1; k >= 1; --k) sum = sum * z2 + S(1) / S(2 * k + 1);
    return exponent * S(0.693147180559945309417) + 2 * z * (1 + z2 * sum);
  }
}

/// exp(x) for x up to 80; packs: within 4 eps of the exact value, 0 or so below -80.
///
/// Packs: x = k ln 2 + r with |r| <= ln(2)/2, and exp(r) by its series.
template <class T>
ELASTOGEN_HD inline T exponential(const T& x) {
  if constexpr (!is_pack<T>) {
    return std::exp(x);
  } else {
    using S = Scalar<T>;
    using Bits = PackMask<S>;
    constexpr bool kSingle = sizeof(S) == 4;
    // ln 2 in two parts, the first with few bits, so that k times it is exact
    constexpr S kHigh = kSingle ? S(0.693359375) : S(0.693147180369123816490);
    constexpr S kLow = kSingle ? S(-2.12194440054690583e-4) : S(1.90821492927058770002e-10);
    const T bounded = larger(x, constant<T>(S(-80)));
    const T scaled = bounded * S(1.44269504088896340736);
    const Bits k = __builtin_convertvector(
        scaled + (scaled < 0 ? constant<T>(S(-0.5)) : constant<T>(S(0.5))), Bits);
    const T whole = __builtin_convertvector(k, T);
    const T r = (bounded - whole * kHigh) - whole * kLow;
    constexpr int kTerms = kSingle ? 7 : 13;
    T sum = constant<T>(1);
    for (int n = kTerms; n >= 1; --n) sum = 1 + r / S(n) * sum;
    Bits bits;
    std::memcpy(&bits, &sum, sizeof sum);
    bits += k << (kSingle ? 23 : 52);
    std::memcpy(&sum, &bits, sizeof sum);
    return sum;
  }
}

}  // namespace elastogen
