// SPDX-License-Identifier: Apache-2.0
// The arrays of a VTU file: text, or bytes behind a header that counts them. Bytes are raw or
// base64, and plain or in blocks packed by zlib.

#pragma once

#include "io/tets/mesh_source.hpp"

namespace elastogen::tets {

/// Encoding that all arrays of a file share.
struct VtuEncoding {
  std::string_view file;  ///< all bytes of the file
  std::endian order = std::endian::little;
  Number header = Number::kUint32;  ///< type of the numbers before the bytes of an array
  bool is_packed = false;
  std::string_view appended;  ///< the bytes that the arrays' offsets count
  bool is_base64 = false;     ///< whether these are base64
};

/// One DataArray.
struct VtuArray {
  enum class Format : uint8_t { kText, kInline, kAppended };

  std::string place;  ///< for messages: file, line and name
  Number type = Number::kFloat64;
  int64_t columns = 1;
  Format format = Format::kText;
  std::string_view text;  ///< inline: up to the next tag
  size_t offset = 0;      ///< appended: where it begins
};

/// The bytes of an array that is not text.
/// @throws Error (asset) where they are damaged, are not there, or unpack to more than 100 times
///         the file.
std::string decoded(const VtuArray& array, const VtuEncoding& encoding);

}  // namespace elastogen::tets
