// SPDX-License-Identifier: Apache-2.0
// The values behind a PLY header in sequence, text or binary.

#pragma once

#include "io/byte_reader.hpp"
#include "io/ply_header.hpp"

namespace elastogen {

/// Gives the values as doubles (all types fit). In text an item of an element is a line. Every
/// member throws Error (asset) with the place if the file ends too early, a line has too few or too
/// many values, or a value is not a number.
class PlyValues {
 public:
  /// @param bytes  of the file behind the header; they, header and path must outlive this.
  PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& path);

  /// Begins the next item of an element, whose values are then read in order.
  void begin_item(const PlyElement& element);

  double next(PlyType type);

  /// Length of a list; throws unless the file can hold all its values.
  int64_t next_length(const PlyProperty& list);

  void skip(const PlyProperty& property);

  /// Ends the item; throws unless all its values have been read.
  void end_item() const;

  /// The next item of an element, one value a property; 0 for lists, which are skipped.
  void next_row(const PlyElement& element, std::vector<double>& row);

  /// Skips all items of an element.
  void skip(const PlyElement& element);

  /// Number of bytes that have not been read; blanks in text do not count.
  int64_t left() const;

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const;
  double next_number();
  void need(int64_t bytes) const;
  std::string item() const;

  const std::string& path_;
  bool is_text_;
  std::string_view text_;  ///< lines that follow
  std::string_view line_;  ///< rest of the item's line
  int64_t line_number_;
  ByteReader binary_;
  const PlyElement* element_ = nullptr;
  int64_t item_ = -1;  ///< of the element, counted from 0
};

/// The next number of a type. @throws Error (asset) if the bytes end.
double read_number(ByteReader& bytes, PlyType type);

/// Largest value of an integer type, the divisor of its colours; 0 for floats.
double colour_range(PlyType type);

}  // namespace elastogen
