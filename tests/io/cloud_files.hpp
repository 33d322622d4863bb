// SPDX-License-Identifier: Apache-2.0
// Bytes of point and splat files for tests, and checks of readers on damaged ones.

#pragma once

#include "io/asset_check.hpp"
#include "tests/io/test_files.hpp"

#include <bit>
#include <cmath>
#include <cstring>

namespace elastogen::test {

/// Little-endian bytes of values, one after the other.
template <class... T>
std::string bytes_of(T... values) {
  static_assert(std::endian::native == std::endian::little);
  std::string bytes;
  const auto add = [&](auto value) {
    char raw[sizeof value];
    std::memcpy(raw, &value, sizeof value);
    bytes.append(raw, sizeof value);
  };
  (add(values), ...);
  return bytes;
}

/// Writes values over the bytes at an offset.
template <class... T>
std::string with(std::string bytes, size_t offset, T... values) {
  const std::string part = bytes_of(values...);
  return bytes.replace(offset, part.size(), part);
}

using Parse = Asset (*)(std::string_view bytes, const std::string& path);

/// The asset that the bytes hold, checked.
inline Asset checked(Parse parse, std::string_view bytes) {
  Asset asset = parse(bytes, "file");
  check_asset(asset);
  return asset;
}

/// Reads and checks, or is refused as an asset; nothing else may happen.
/// @return whether it was read.
inline bool read_or_refused(Parse parse, std::string_view bytes) {
  try {
    checked(parse, bytes);
    return true;
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    return false;
  }
}

/// A file that is cut anywhere is refused; of a text, the end of its last word may be missing.
inline void expect_no_cut_is_read(Parse parse, const std::string& bytes, size_t may_lack = 0) {
  EXPECT_TRUE(read_or_refused(parse, bytes));
  for (size_t n = 0; n + may_lack < bytes.size(); ++n)
    EXPECT_FALSE(read_or_refused(parse, bytes.substr(0, n))) << n << " of " << bytes.size();
}

/// Any byte may have any value.
inline void expect_any_byte_is_read_or_refused(Parse parse, const std::string& bytes) {
  for (size_t n = 0; n < bytes.size(); ++n)
    for (const unsigned char value : {0, 1, 0x2d, 0x39, 0x7f, 0x80, 0xff}) {
      std::string changed = bytes;
      changed[n] = char(value);
      read_or_refused(parse, changed);
    }
}

/// The text with CRLF in place of LF and a byte order mark before it.
inline std::string with_mark_and_crlf(const std::string& text) {
  std::string out = "\xef\xbb\xbf";
  for (const char c : text) out += c == '\n' ? "\r\n" : std::string(1, c);
  return out;
}

/// Count of a finding, 0 if there is none of that id.
inline int64_t finding_of(const Asset& asset, const std::string& what) {
  for (const Finding& finding : asset.findings)
    if (finding.what == what) return finding.count;
  return 0;
}

}  // namespace elastogen::test
