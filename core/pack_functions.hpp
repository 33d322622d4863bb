// SPDX-License-Identifier: Apache-2.0
// Logarithm and exponential of numbers and packs.

#pragma once

#include "core/pack.hpp"

namespace elastogen {

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
    using Bits = decltype(x < x);
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
    using Bits = decltype(x < x);
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
    for (int n = kTerms; n >= 1; --n) sum = 1 + r * (1 / S(n)) * sum;
    Bits bits;
    std::memcpy(&bits, &sum, sizeof sum);
    bits += k << (kSingle ? 23 : 52);
    std::memcpy(&sum, &bits, sizeof sum);
    return sum;
  }
}

}  // namespace elastogen
