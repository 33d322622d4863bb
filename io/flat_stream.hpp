// SPDX-License-Identifier: Apache-2.0
// The flat stream of bytes by which the reader process answers on its pipe. It is not trusted:
// every count is compared with the bytes that follow it.

#pragma once

#include "core/error.hpp"

#include <cstring>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace elastogen {

inline constexpr std::string_view kAnswerMagic = "elastogen-asset1";

/// Why the reader process has no answer.
enum class ReaderFailure : uint8_t {
  kRefused = 1,  ///< the message says what is wrong with the file
  kMemory = 2,   ///< its limit of memory was reached
};

/// Appends values to a stream.
class StreamWriter {
 public:
  template <class T>
  void value(const T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&v), sizeof(T));
  }
  template <class Items>
  void array(const Items& items) {
    value(uint64_t(items.size()));
    bytes_.append(reinterpret_cast<const char*>(items.data()), items.size() * sizeof(items[0]));
  }
  template <class T, class Fields>
  void list(const std::vector<T>& items, const Fields& fields) {
    value(uint64_t(items.size()));
    for (const T& item : items) fields(item);
  }
  std::string take() { return std::move(bytes_); }

 private:
  std::string bytes_{kAnswerMagic};
};

/// Reads values from bytes that may hold anything.
class StreamReader {
 public:
  explicit StreamReader(std::string_view bytes) : bytes_(bytes) {}

  template <class T>
  void value(T& v) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::memcpy(&v, take(1, sizeof(T)).data(), sizeof(T));
  }
  template <class Items>
  void array(Items& items) {
    uint64_t count = 0;
    value(count);
    const std::string_view from = take(count, sizeof(items[0]));
    items.resize(size_t(count));
    if (count > 0) std::memcpy(items.data(), from.data(), from.size());
  }
  /// The list grows as the bytes of its items are read, whatever count is claimed.
  template <class T, class Fields>
  void list(std::vector<T>& items, const Fields& fields) {
    uint64_t count = 0;
    value(count);
    for (uint64_t k = 0; k < count; ++k) fields(items.emplace_back());
  }
  std::string_view take(uint64_t count, size_t size) {
    ELASTOGEN_CHECK_ASSET(count <= bytes_.size() / size, "its answer is cut off");
    const std::string_view taken = bytes_.substr(0, size_t(count) * size);
    bytes_.remove_prefix(taken.size());
    return taken;
  }
  size_t left() const { return bytes_.size(); }

 private:
  std::string_view bytes_;
};

/// The stream of a failure.
std::string encode_failure(ReaderFailure failure, std::string_view message);

/// Reads the begin of an answer. @throws Error (asset): the failure that was encoded, or bytes that
/// are no answer.
void begin_answer(StreamReader& stream);

/// One line of printable text, shortened.
std::string shown_line(std::string_view message);

}  // namespace elastogen
