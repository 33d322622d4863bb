// SPDX-License-Identifier: Apache-2.0
// The values behind a PLY header, of either encoding, one after the other.

#pragma once

#include "io/byte_reader.hpp"
#include "io/ply_header.hpp"

namespace elastogen {

/// Hands out values as doubles (all types fit). An item of an element is a line in text. Every
/// member throws Error (asset) with the place where the file ends too early, a line has too few or
/// too many values, or something else than a number stands there.
class PlyValues {
 public:
  /// @param bytes  of the file behind the header; they, header and path must outlive this.
  PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& path);

  /// Begins the next item of an element, whose values are then taken in order.
  void begin_item(const PlyElement& element);

  double next(PlyType type);

  /// Length of a list whose values can all be there.
  int64_t next_length(const PlyProperty& list);

  void skip(const PlyProperty& property);

  /// All values of the item must have been taken.
  void end_item() const;

  /// The next item of an element, one value a property; 0 for lists, which are skipped.
  void next_row(const PlyElement& element, std::vector<double>& row);

  /// Skips all items of an element.
  void skip(const PlyElement& element);

  /// Bytes behind what was taken, but for blanks in text.
  int64_t left() const;

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const;
  double next_number();
  void need(int64_t bytes) const;
  std::string item() const;

  const std::string& path_;
  bool is_text_;
  std::string_view text_;  ///< lines to come
  std::string_view line_;  ///< what is left of the item's
  int64_t line_number_;
  ByteReader binary_;
  const PlyElement* element_ = nullptr;
  int64_t item_ = -1;  ///< of the element, counted from 0
};

/// Largest value of an integer type, by which colours are scaled; 0 for floats.
double colour_range(PlyType type);

}  // namespace elastogen
