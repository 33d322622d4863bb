// SPDX-License-Identifier: Apache-2.0
#include "io/ply_header.hpp"

#include "io/byte_reader.hpp"

#include <algorithm>
#include <limits>

namespace elastogen {
namespace {

constexpr size_t kMaxHeaderBytes = 1 << 16;

struct TypeName {
  std::string_view name;
  PlyType type;
};

constexpr TypeName kTypeNames[] = {
    {"char", PlyType::kInt8},       {"int8", PlyType::kInt8},       {"uchar", PlyType::kUint8},
    {"uint8", PlyType::kUint8},     {"short", PlyType::kInt16},     {"int16", PlyType::kInt16},
    {"ushort", PlyType::kUint16},   {"uint16", PlyType::kUint16},   {"int", PlyType::kInt32},
    {"int32", PlyType::kInt32},     {"uint", PlyType::kUint32},     {"uint32", PlyType::kUint32},
    {"float", PlyType::kFloat32},   {"float32", PlyType::kFloat32}, {"double", PlyType::kFloat64},
    {"float64", PlyType::kFloat64},
};

class HeaderParser {
 public:
  HeaderParser(std::string_view bytes, const std::string& path)
      : all_(bytes), rest_(bytes.substr(0, kMaxHeaderBytes)), path_(path) {}

  PlyHeader parse() {
    std::string_view line = trimmed(line_of_header());
    check(line == "ply", "a PLY file begins with \"ply\"");
    while ((line = trimmed(line_of_header())) != "end_header") read_line(line);
    check(has_format_, "the header has no format line");
    header_.bytes = size_t(rest_.data() - all_.data());
    for (const PlyElement& element : header_.elements) check_count(element);
    return std::move(header_);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ':', header_.lines, ": ", parts...);
  }

  /// Only whole lines count, as the values follow the last line of the header directly.
  std::string_view line_of_header() {
    check(rest_.find('\n') != rest_.npos, "the header has no end");
    ++header_.lines;
    return next_line(rest_);
  }

  void read_line(std::string_view line) {
    const std::string_view keyword = next_word(line);
    if (keyword == "format") {
      read_format(line);
    } else if (keyword == "element") {
      PlyElement& element = header_.elements.emplace_back();
      element.name = next_word(line);
      const std::optional<int64_t> count = to_integer(next_word(line));
      check(count && *count >= 0 && *count < std::numeric_limits<int32_t>::max(), "the element ",
            element.name, " has no valid count");
      element.count = *count;
    } else if (keyword == "property") {
      check(!header_.elements.empty(), "a property before the first element");
      header_.elements.back().properties.push_back(read_property(line));
    } else if (keyword == "comment") {
      if (next_word(line) == "TextureFile") header_.textures.emplace_back(trimmed(line));
    } else if (keyword != "obj_info" && !keyword.empty()) {
      header_.skipped.emplace_back(keyword.substr(0, 40));
    }
  }

  void read_format(std::string_view line) {
    const std::string_view format = next_word(line);
    if (format == "binary_little_endian") header_.encoding = PlyHeader::kLittleEndian;
    if (format == "binary_big_endian") header_.encoding = PlyHeader::kBigEndian;
    check(format == "ascii" || header_.encoding != PlyHeader::kText, "unknown format \"",
          format.substr(0, 40), '"');
    has_format_ = true;
  }

  PlyProperty read_property(std::string_view line) const {
    PlyProperty property;
    std::string_view word = next_word(line);
    property.is_list = word == "list";
    if (property.is_list) {
      property.count_type = type_of(next_word(line));
      word = next_word(line);
    }
    property.type = type_of(word);
    property.name = next_word(line);
    check(!property.name.empty(), "a property without a name");
    return property;
  }

  PlyType type_of(std::string_view name) const {
    const auto found = std::ranges::find(kTypeNames, name, &TypeName::name);
    check(found != std::end(kTypeNames), "unknown type \"", name.substr(0, 40), '"');
    return found->type;
  }

  /// Accepts a count only if the file can hold as many items of the least size. In text the least
  /// size is a digit and a blank for each value.
  void check_count(const PlyElement& element) const {
    int64_t least = 0;
    for (const PlyProperty& p : element.properties) {
      const int binary = size_of(p.is_list ? p.count_type : p.type);
      least += header_.encoding == PlyHeader::kText ? 2 : binary;
    }
    const int64_t left = int64_t(all_.size() - header_.bytes);
    const int64_t end = header_.encoding == PlyHeader::kText ? 1 : 0;  // the last needs no blank
    check(least == 0 || element.count <= (left + end) / least, "the header claims ", element.count,
          " times ", element.name, " but only ", left, " bytes follow");
  }

  std::string_view all_, rest_;
  std::string path_;
  PlyHeader header_;
  bool has_format_ = false;
};

}  // namespace

int size_of(PlyType type) {
  static constexpr int kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[int(type)];
}

int PlyElement::find(std::initializer_list<std::string_view> names) const {
  for (const std::string_view name : names)
    for (size_t k = 0; k < properties.size(); ++k)
      if (properties[k].name == name) return int(k);
  return -1;
}

size_t PlyElement::number(const std::string& property, const std::string& path) const {
  const int column = find({property});
  ELASTOGEN_CHECK_ASSET(column >= 0 && !properties[size_t(column)].is_list, path, ": its element ",
                        name, " has no number ", property);
  return size_t(column);
}

PlyHeader read_ply_header(std::string_view bytes, const std::string& path) {
  return HeaderParser(bytes, path).parse();
}

}  // namespace elastogen
