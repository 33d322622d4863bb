// SPDX-License-Identifier: Apache-2.0
// Bounded reads of bytes and text. A count is accepted only if the bytes for it are there.

#pragma once

#include "core/error.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

namespace elastogen {

/// Reads plain values of either byte order from a file in memory.
class ByteReader {
 public:
  /// @param name  of the file, for messages.
  ByteReader(std::string_view bytes, std::string name, std::endian order = std::endian::little)
      : bytes_(bytes), name_(std::move(name)), order_(order) {}

  int64_t left() const { return int64_t(bytes_.size()); }

  /// @throws Error (asset) unless `count` items of at least `size` bytes can follow.
  void claim(int64_t count, int64_t size, const char* what) const {
    ELASTOGEN_CHECK_ASSET(count >= 0 && (size == 0 || count <= left() / size), name_, ": ", count,
                          ' ', what, " are claimed but only ", left(), " bytes are left");
  }

  void skip(int64_t bytes, const char* what) {
    claim(bytes, 1, what);
    bytes_.remove_prefix(size_t(bytes));
  }

  template <class T>
  T read() {
    char raw[sizeof(T)];
    claim(sizeof(T), 1, "bytes of a value");
    std::memcpy(raw, bytes_.data(), sizeof(T));
    bytes_.remove_prefix(sizeof(T));
    if (order_ != std::endian::native)
      for (size_t k = 0; k < sizeof(T) / 2; ++k) std::swap(raw[k], raw[sizeof(T) - 1 - k]);
    return std::bit_cast<T>(raw);
  }

 private:
  std::string_view bytes_;
  std::string name_;
  std::endian order_;
};

inline bool is_blank(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

inline std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Cuts the next word (up to a blank) off the front of a line; empty at its end.
inline std::string_view next_word(std::string_view& line) {
  while (!line.empty() && is_blank(line.front())) line.remove_prefix(1);
  size_t n = 0;
  while (n < line.size() && !is_blank(line[n])) ++n;
  const std::string_view word = line.substr(0, n);
  line.remove_prefix(n);
  return word;
}

/// Cuts the next line (ended by LF, CRLF or the end) off the front of a text.
inline std::string_view next_line(std::string_view& text) {
  const size_t n = text.find('\n');
  std::string_view line = text.substr(0, n);
  text.remove_prefix(n == text.npos ? text.size() : n + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

/// The number that the whole word spells, in any locale; too large gives infinity, too small 0.
inline std::optional<double> to_double(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  double value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || error == std::errc::invalid_argument) return {};
  if (error == std::errc::result_out_of_range) {
    const bool small = word.find("e-") != word.npos || word.find("E-") != word.npos;
    value = small ? 0 : std::numeric_limits<double>::infinity();
    return word.starts_with('-') ? -value : value;
  }
  return value;
}

inline std::optional<int64_t> to_integer(std::string_view word) {
  if (word.starts_with('+')) word.remove_prefix(1);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (end != word.data() + word.size() || error != std::errc()) return {};
  return value;
}

/// The text without the byte order mark of UTF-8.
inline std::string_view without_mark(std::string_view text) {
  return text.starts_with("\xef\xbb\xbf") ? text.substr(3) : text;
}

/// Whether bytes are UTF-16: they begin with its mark, or have zeros in every second place of the
/// first 32 characters, as Latin text has.
inline bool is_utf16(std::string_view bytes) {
  if (bytes.starts_with("\xff\xfe") || bytes.starts_with("\xfe\xff")) return true;
  const size_t n = std::min<size_t>(bytes.size() / 2 * 2, 64);
  for (const size_t zero : {0u, 1u}) {
    bool all = n >= 8;
    for (size_t k = 0; k < n; ++k) all = all && (bytes[k] == '\0') == (k % 2 == zero);
    if (all) return true;
  }
  return false;
}

/// Linear light of an sRGB value in 0..1 (IEC 61966-2-1).
inline float linear_from_srgb(double s) {
  return float(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
}

/// The sRGB value of a linear share of light.
inline float srgb_from_linear(double l) {
  return float(l <= 0.0031308 ? 12.92 * l : 1.055 * std::pow(l, 1 / 2.4) - 0.055);
}

}  // namespace elastogen
