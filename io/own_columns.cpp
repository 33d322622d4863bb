// SPDX-License-Identifier: Apache-2.0
#include "io/own_columns.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/frame_files.hpp"
#include "io/ply_values.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr size_t kMostNames = 12;  ///< names in one sentence

template <class T>
void append_integer(std::string& bytes, double value) {
  using Limits = std::numeric_limits<T>;
  const double held = std::isnan(value) ? 0
                                        : std::clamp(std::round(value), double(Limits::min()),
                                                     double(Limits::max()));
  append(bytes, T(held));
}

std::string list_of(const std::vector<std::string>& names) {
  std::string text;
  for (size_t k = 0; k < std::min(names.size(), kMostNames); ++k)
    text += concat(k == 0 ? "" : ", ", names[k].substr(0, 40));
  if (names.size() > kMostNames) text += concat(" and ", names.size() - kMostNames, " more");
  return text;
}

}  // namespace

size_t OwnColumns::row_bytes() const {
  size_t bytes = 0;
  for (const Column& column : columns) bytes += size_t(size_of(column.type));
  return bytes;
}

double OwnColumns::value(size_t point, size_t column) const {
  size_t at = point * row_bytes();
  for (size_t k = 0; k < column; ++k) at += size_t(size_of(columns[k].type));
  ByteReader bytes(std::string_view(rows).substr(at), "columns");
  return read_number(bytes, columns[column].type);
}

void OwnColumns::add(size_t column, double value) {
  append_number(rows, columns[column].type, value);
}

void append_number(std::string& bytes, PlyType type, double value) {
  switch (type) {
    case PlyType::kInt8:
      return append_integer<int8_t>(bytes, value);
    case PlyType::kUint8:
      return append_integer<uint8_t>(bytes, value);
    case PlyType::kInt16:
      return append_integer<int16_t>(bytes, value);
    case PlyType::kUint16:
      return append_integer<uint16_t>(bytes, value);
    case PlyType::kInt32:
      return append_integer<int32_t>(bytes, value);
    case PlyType::kUint32:
      return append_integer<uint32_t>(bytes, value);
    case PlyType::kFloat32:
      return append(bytes, float(value));
    case PlyType::kFloat64:
      break;
  }
  append(bytes, value);
}

void note_own_columns(Asset& asset, const OwnColumns& own) {
  std::vector<std::string> names;
  for (const OwnColumns::Column& column : own.columns) names.push_back(column.name);
  add_finding(asset, "carried-columns", int64_t(names.size()),
              concat("columns are the file's own: ", list_of(names)));
}

void note_lost_columns(Asset& asset, const std::vector<std::string>& names) {
  add_finding(asset, "lost-columns", int64_t(names.size()),
              concat("columns cannot be carried: ", list_of(names)));
}

}  // namespace elastogen
