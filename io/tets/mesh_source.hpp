// SPDX-License-Identifier: Apache-2.0
// The numbers of a mesh file one after the other, as words or as bytes, within the file's bounds.
// All members throw Error (asset) that names the file and the line or, among bytes, the offset.

#pragma once

#include "io/byte_reader.hpp"

namespace elastogen::tets {

enum class Number : uint8_t {
  kInt8,
  kUint8,
  kInt16,
  kUint16,
  kInt32,
  kUint32,
  kInt64,
  kUint64,
  kFloat32,
  kFloat64
};

/// Bytes of a number.
inline int size_of(Number type) {
  constexpr int kSize[] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSize[int(type)];
}

inline bool is_integer(Number type) {
  return type < Number::kFloat32;
}

/// The order of bytes that the machine does not have.
constexpr std::endian other_order() {
  return std::endian::native == std::endian::little ? std::endian::big : std::endian::little;
}

class MeshSource {
 public:
  /// Numbers are words until begin_binary is called.
  /// @param name  of the file, for messages.
  MeshSource(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  void begin_text() { binary_ = false; }
  void begin_binary(std::endian order) { binary_ = true, order_ = order; }

  int64_t left() const { return int64_t(bytes_.size() - at_); }
  /// Goes to an offset within the file.
  void go_to(size_t offset) { at_ = last_ = offset; }

  /// Where the last item that was read begins, as "file:line: " or "file: byte offset: ".
  std::string place() const;
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, place(), parts...);
  }

  /// The rest of this line without its end; "" behind the last.
  std::string_view line();
  /// The next word of this or a later line; "" behind the last.
  std::string_view next_word();
  /// The next word; throws if there is none.
  std::string_view word(const char* expected);
  /// Goes behind the next occurrence of a text.
  void skip_past(const std::string& text);

  int64_t integer(Number type, const char* what);
  /// An integer in [0, limit).
  int64_t integer_below(Number type, int64_t limit, const char* what);
  double finite(Number type, const char* what);
  /// Refuses a count of numbers unless as many can follow.
  void claim(int64_t count, Number type, const char* what) const;
  /// Skips a count of numbers.
  void skip(int64_t count, Number type, const char* what);

 private:
  template <class T>
  T raw(const char* what);
  int64_t raw_integer(Number type, const char* what);

  std::string_view bytes_;
  std::string name_;
  size_t at_ = 0, last_ = 0;
  bool binary_ = false;
  std::endian order_ = std::endian::little;
};

}  // namespace elastogen::tets
