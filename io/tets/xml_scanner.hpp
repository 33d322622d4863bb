// SPDX-License-Identifier: Apache-2.0
// The tags of an XML file one after the other, as VTK writes them: no entities, no document type,
// no CDATA. Elements are at most 32 deep and have at most 32 attributes; names have at most 64
// letters.

#pragma once

#include "core/error.hpp"

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace elastogen::tets {

class XmlScanner {
 public:
  /// @param path  for messages; it and the bytes must outlive this.
  XmlScanner(std::string_view bytes, const std::string& path) : bytes_(bytes), path_(path) {}

  /// Goes to the next start of an element, over text, comments, declarations and ends of elements.
  /// @return false behind the end of the outermost element.
  /// @throws Error (asset) with file and line on anything else.
  bool next();

  /// The element that began last and those around it, outermost first, as "VTKFile/Piece".
  const std::string& element() const { return element_; }
  std::optional<std::string_view> attribute(std::string_view name) const;
  /// Offset of the first byte behind its tag.
  size_t position() const { return at_; }
  /// The text from there to the next tag.
  std::string_view text() const;

  /// Of the last tag, from 1.
  int64_t line() const;
  /// @throws Error (asset) with that line unless the condition holds.
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ':', line(), ": ", parts...);
  }

 private:
  bool starts(std::string_view text) const { return bytes_.substr(at_).starts_with(text); }
  void skip_past(std::string_view text);
  void skip_blanks();
  std::string_view name();
  void read_attributes();
  void close();

  std::string_view bytes_;
  const std::string& path_;
  size_t at_ = 0, last_ = 0;
  std::vector<std::string_view> open_;
  std::vector<std::pair<std::string_view, std::string_view>> attributes_;
  std::string element_;
  bool is_empty_ = false;  ///< the last tag ends its own element
};

}  // namespace elastogen::tets
