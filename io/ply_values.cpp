// SPDX-License-Identifier: Apache-2.0
#include "io/ply_values.hpp"

#include <algorithm>

namespace elastogen {

PlyValues::PlyValues(std::string_view bytes, const PlyHeader& header, const std::string& path)
    : path_(path),
      is_text_(header.encoding == PlyHeader::kText),
      text_(bytes),
      line_number_(header.lines),
      binary_(bytes, path,
              header.encoding == PlyHeader::kBigEndian ? std::endian::big : std::endian::little) {}

template <class... Parts>
void PlyValues::check(bool condition, const Parts&... parts) const {
  if (condition) return;
  const std::string place = is_text_ ? concat(path_, ':', line_number_) : path_;
  throw Error(concat(place, ": ", parts...), ErrorKind::kAsset);
}

std::string PlyValues::item() const {
  return concat(element_->name, ' ', item_, " of ", element_->count, " (counted from 0)");
}

void PlyValues::begin_item(const PlyElement& element) {
  item_ = element_ == &element ? item_ + 1 : 0;
  element_ = &element;
  if (!is_text_ || element.properties.empty()) return;
  do {
    check(!text_.empty(), "the file ends before ", item());
    ++line_number_;
    line_ = trimmed(next_line(text_));
  } while (line_.empty());
}

void PlyValues::end_item() const {
  if (is_text_) check(trimmed(line_).empty(), item(), " has more numbers than its properties");
}

void PlyValues::need(int64_t bytes) const {
  check(bytes <= binary_.left(), "the file ends within ", item());
}

int64_t PlyValues::left() const {
  if (!is_text_) return binary_.left();
  return std::ranges::count_if(text_, [](char c) { return c != '\n' && !is_blank(c); });
}

double PlyValues::next(PlyType type) {
  if (is_text_) return next_number();
  need(size_of(type));
  return read_number(binary_, type);
}

int64_t PlyValues::next_length(const PlyProperty& list) {
  const double length = next(list.count_type);
  check(length >= 0 && length == std::floor(length) && length < 0x1p31, item(), " has a list of ",
        list.name, " of the length ", length);
  const int64_t n = int64_t(length);
  if (is_text_)
    check(n <= int64_t(line_.size() + 1) / 2, item(), " claims ", n, " values of ", list.name,
          " but only ", line_.size(), " bytes are left of its line");
  else
    need(n * size_of(list.type));
  return n;
}

void PlyValues::skip(const PlyProperty& property) {
  const int64_t n = property.is_list ? next_length(property) : 1;
  for (int64_t k = 0; k < n; ++k) next(property.type);
}

void PlyValues::next_row(const PlyElement& element, std::vector<double>& row) {
  row.assign(element.properties.size(), 0);
  begin_item(element);
  for (size_t k = 0; k < row.size(); ++k) {
    const PlyProperty& p = element.properties[k];
    p.is_list ? skip(p) : void(row[k] = next(p.type));
  }
  end_item();
}

void PlyValues::skip(const PlyElement& element) {
  if (element.properties.empty()) return;
  std::vector<double> row;
  for (int64_t k = 0; k < element.count; ++k) next_row(element, row);
}

double PlyValues::next_number() {
  const std::string_view word = next_word(line_);
  check(!word.empty(), item(), " has fewer numbers than its properties");
  const std::optional<double> value = to_double(word);
  check(value.has_value(), "a number is expected, not \"", word.substr(0, 40), '"');
  return *value;
}

double read_number(ByteReader& bytes, PlyType type) {
  switch (type) {
    case PlyType::kInt8:
      return bytes.read<int8_t>();
    case PlyType::kUint8:
      return bytes.read<uint8_t>();
    case PlyType::kInt16:
      return bytes.read<int16_t>();
    case PlyType::kUint16:
      return bytes.read<uint16_t>();
    case PlyType::kInt32:
      return bytes.read<int32_t>();
    case PlyType::kUint32:
      return bytes.read<uint32_t>();
    case PlyType::kFloat32:
      return bytes.read<float>();
    case PlyType::kFloat64:
      break;
  }
  return bytes.read<double>();
}

double colour_range(PlyType type) {
  static constexpr double kRange[] = {127, 255, 32767, 65535, 2147483647., 4294967295., 0, 0};
  return kRange[int(type)];
}

}  // namespace elastogen
