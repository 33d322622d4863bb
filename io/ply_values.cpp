// SPDX-License-Identifier: Apache-2.0
#include "io/ply_values.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

}  // namespace

PlyValues::PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& path)
    : path_(path),
      is_text_(header.encoding == PlyHeader::kText),
      text_(bytes),
      binary_(bytes, path,
              header.encoding == PlyHeader::kBigEndian ? std::endian::big : std::endian::little) {}

double PlyValues::next(PlyType type) {
  if (is_text_) return next_number();
  switch (type) {
    case PlyType::kInt8:
      return binary_.read<int8_t>();
    case PlyType::kUint8:
      return binary_.read<uint8_t>();
    case PlyType::kInt16:
      return binary_.read<int16_t>();
    case PlyType::kUint16:
      return binary_.read<uint16_t>();
    case PlyType::kInt32:
      return binary_.read<int32_t>();
    case PlyType::kUint32:
      return binary_.read<uint32_t>();
    case PlyType::kFloat32:
      return binary_.read<float>();
    case PlyType::kFloat64:
      break;
  }
  return binary_.read<double>();
}

int64_t PlyValues::next_length(const PlyProperty& list) {
  const double length = next(list.count_type);
  ELASTOGEN_CHECK_ASSET(length >= 0 && length == std::floor(length) && length < 0x1p31, path_,
                        ": a list of ", list.name, " has the length ", length);
  const int64_t n = int64_t(length);
  if (is_text_) {
    ELASTOGEN_CHECK_ASSET(n <= int64_t(text_.size() + 1) / 2, path_, ": ", n, " values of ",
                          list.name, " are claimed but only ", text_.size(), " bytes are left");
  } else {
    binary_.claim(n, size_of(list.type), "values of a list");
  }
  return n;
}

void PlyValues::next_row(const PlyElement& element, std::vector<double>& row) {
  row.assign(element.properties.size(), 0);
  for (size_t k = 0; k < row.size(); ++k) {
    const PlyProperty& p = element.properties[k];
    p.is_list ? skip(p) : void(row[k] = next(p.type));
  }
}

void PlyValues::skip(const PlyProperty& property) {
  const int64_t n = property.is_list ? next_length(property) : 1;
  if (!is_text_) return binary_.skip(n * size_of(property.type), "bytes of values");
  for (int64_t k = 0; k < n; ++k) next_number();
}

void PlyValues::skip(const PlyElement& element) {
  if (element.properties.empty()) return;
  for (int64_t k = 0; k < element.count; ++k)
    for (const PlyProperty& property : element.properties) skip(property);
}

double PlyValues::next_number() {
  const size_t begin = std::min(text_.find_first_not_of(kBlanks), text_.size());
  text_.remove_prefix(begin);
  const std::string_view word = text_.substr(0, text_.find_first_of(kBlanks));
  text_.remove_prefix(word.size());
  ELASTOGEN_CHECK_ASSET(!word.empty(), path_, ": the file ends before its values do");
  const std::optional<double> value = to_double(word);
  ELASTOGEN_CHECK_ASSET(value.has_value(), path_, ": a number is expected, not \"",
                        word.substr(0, 40), '"');
  return *value;
}

double colour_range(PlyType type) {
  static constexpr double kRange[] = {127, 255, 32767, 65535, 2147483647., 4294967295., 0, 0};
  return kRange[int(type)];
}

}  // namespace elastogen
