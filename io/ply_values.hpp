// SPDX-License-Identifier: Apache-2.0
// The values behind a PLY header, of either encoding, one after the other.

#pragma once

#include "io/byte_reader.hpp"
#include "io/ply_header.hpp"

namespace elastogen {

/// Hands out values as doubles (all types fit). Every member throws Error (asset) where the file
/// ends too early or holds something else than a number.
class PlyValues {
 public:
  /// @param bytes  of the file behind the header; they and the path must outlive this.
  PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& path);

  double next(PlyType type);

  /// Length of a list whose values can all be there.
  int64_t next_length(const PlyProperty& list);

  /// The next item of an element, one value a property; 0 for lists, which are skipped.
  void next_row(const PlyElement& element, std::vector<double>& row);

  void skip(const PlyProperty& property);

  /// Skips all items of an element.
  void skip(const PlyElement& element);

 private:
  double next_number();

  const std::string& path_;
  bool is_text_;
  std::string_view text_;
  ByteReader binary_;
};

/// Largest value of an integer type, by which colours are scaled; 0 for floats.
double colour_range(PlyType type);

}  // namespace elastogen
