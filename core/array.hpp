// SPDX-License-Identifier: Apache-2.0
// Row-major matrices: Array owns, Span views. The only array types between modules.

#pragma once

#include "core/zeroed.hpp"

#include <cstdint>
#include <ostream>
#include <type_traits>
#include <utility>

namespace elastogen {

/// View of a row-major matrix, (rows, cols). Converts to a view of const.
template <class T>
struct Span {
  T* data = nullptr;
  int64_t rows = 0;
  int cols = 1;

  T& operator()(int64_t row, int col = 0) const { return data[row * cols + col]; }
  T* row(int64_t r) const { return data + r * cols; }
  int64_t size() const { return rows * cols; }
  bool is(int64_t r, int c) const { return rows == r && cols == c; }
  operator Span<const T>() const requires(!std::is_const_v<T>) { return {data, rows, cols}; }
};

/// Owns a row-major matrix, 0 at first.
template <class T>
class Array {
 public:
  Array() = default;
  explicit Array(int64_t rows, int cols = 1) : values_(rows * cols), rows_(rows), cols_(cols) {}

  T* data() { return values_.data(); }
  const T* data() const { return values_.data(); }
  int64_t rows() const { return rows_; }
  int cols() const { return cols_; }
  int64_t size() const { return rows_ * cols_; }
  bool empty() const { return values_.empty(); }
  T& operator()(int64_t row, int col = 0) { return values_[row * cols_ + col]; }
  const T& operator()(int64_t row, int col = 0) const { return values_[row * cols_ + col]; }
  T* row(int64_t r) { return data() + r * cols_; }
  const T* row(int64_t r) const { return data() + r * cols_; }
  void fill(T value) { values_.assign(values_.size(), value); }
  bool operator==(const Array&) const = default;

  operator Span<T>() { return {data(), rows_, cols_}; }
  operator Span<const T>() const { return {data(), rows_, cols_}; }

 private:
  Zeroed<T> values_;
  int64_t rows_ = 0;
  int cols_ = 1;
};

/// Parameters that accept an Array or a Span; T is deduced from another argument or named.
template <class T>
using In = std::type_identity_t<Span<const T>>;
template <class T>
using Out = std::type_identity_t<Span<T>>;

template <class T>
std::ostream& operator<<(std::ostream& out, const Span<T>& span) {
  return out << '(' << span.rows << ", " << span.cols << ')';
}

}  // namespace elastogen
