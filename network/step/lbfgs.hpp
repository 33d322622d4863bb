// SPDX-License-Identifier: Apache-2.0
// The hidden state of RNN-1: the last five pairs of L-BFGS (Nocedal 1980) around a first matrix
// that the caller supplies.

#pragma once

#include "core/reduce.hpp"

#include <utility>
#include <vector>

namespace elastogen {

template <class T>
class Lbfgs {
 public:
  static constexpr int kPairs = 5;

  explicit Lbfgs(int64_t size) : size_(size), s_(kPairs), y_(kPairs) {
    for (int k = 0; k < kPairs; ++k) s_[size_t(k)].resize(size_t(size)), y_[size_t(k)] = s_[0];
  }

  void clear() { count_ = 0; }
  int count() const { return count_; }

  /// Memory of the next pair; `keep` makes it the newest.
  T* next_s() { return s_[size_t(next_)].data(); }
  T* next_y() { return y_[size_t(next_)].data(); }

  /// Keeps the pair if its curvature s.y is safely positive. The oldest pair of a full history is
  /// lost in any case, because the new one is stored in its place.
  bool keep() {
    const double sy = dot(next_s(), next_y(), size_), ss = dot(next_s(), next_s(), size_),
                 yy = dot(next_y(), next_y(), size_);
    count_ = std::min(count_, kPairs - 1);
    if (!(sy > 1e-10 * std::sqrt(ss * yy)) || sy == 0) return false;
    rho_[next_] = 1 / sy;
    next_ = (next_ + 1) % kPairs;
    ++count_;
    return true;
  }

  /// d = H g by the two-loop recursion; first(q, d) applies the first matrix, d = B q.
  template <class First>
  void direction(const T* g, T* q, T* d, const First& first) const {
    double alpha[kPairs];
    for_blocks(size_,
               [=](int64_t begin, int64_t end) { std::copy(g + begin, g + end, q + begin); });
    for (int k = 0; k < count_; ++k) {
      const size_t p = pair(k);
      alpha[k] = rho_[p] * dot(s_[p].data(), q, size_);
      add_scaled(T(-alpha[k]), y_[p].data(), q, size_);
    }
    first(q, d);
    for (int k = count_ - 1; k >= 0; --k) {
      const size_t p = pair(k);
      const double beta = rho_[p] * dot(y_[p].data(), d, size_);
      add_scaled(T(alpha[k] - beta), s_[p].data(), d, size_);
    }
  }

 private:
  size_t pair(int newest) const { return size_t((next_ - 1 - newest + 2 * kPairs) % kPairs); }

  int64_t size_;
  int next_ = 0, count_ = 0;
  std::vector<std::vector<T>> s_, y_;
  double rho_[kPairs] = {};
};

}  // namespace elastogen
