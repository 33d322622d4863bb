// SPDX-License-Identifier: Apache-2.0
#include "io/las_reader.hpp"

#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Bytes of a record of each point format, and where its RGB stands (0: it has none).
constexpr int kRecordBytes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
constexpr int kRgbOffset[] = {0, 0, 20, 28, 0, 28, 0, 30, 30, 0, 30};
constexpr size_t kHeaderBytes = 227, kHeaderBytes14 = 375;

struct LasHeader {
  int64_t points = 0;      ///< records
  size_t data_offset = 0;  ///< of the first record [bytes]
  int format = 0;          ///< of the points
  int64_t record_bytes = 0;
  Vec3 scale, offset;
};

/// The value at an offset of a file that is long enough.
template <class T>
T at(std::string_view bytes, size_t offset) {
  return ByteReader(bytes.substr(offset), "").read<T>();
}

LasHeader read_las_header(std::string_view bytes, const std::string& path) {
  // versions and point formats that are read
  ELASTOGEN_CHECK_ASSET(bytes.starts_with("LASF") && bytes.size() >= kHeaderBytes, path,
                        ": has no LAS header of ", kHeaderBytes, " bytes that begin with LASF");
  const int major = at<uint8_t>(bytes, 24), minor = at<uint8_t>(bytes, 25);
  ELASTOGEN_CHECK_ASSET(major == 1 && minor <= 4, path, ": LAS ", major, '.', minor,
                        " is not read; versions 1.0 to 1.4 are");
  const int format = at<uint8_t>(bytes, 104);
  ELASTOGEN_CHECK_ASSET(format < 128, path,
                        ": compressed points (LAZ) are not read; laszip or las2las turns the file "
                        "into LAS");
  ELASTOGEN_CHECK_ASSET(format <= 10, path, ": the point format ", format,
                        " is not read; 0 to 10 are");
  // where the records are; version 1.4 may count them in 64 bits
  LasHeader header;
  header.format = format;
  header.data_offset = at<uint32_t>(bytes, 96);
  header.record_bytes = at<uint16_t>(bytes, 105);
  header.points = at<uint32_t>(bytes, 107);
  if (minor == 4 && bytes.size() >= kHeaderBytes14 && header.points == 0) {
    const uint64_t points = at<uint64_t>(bytes, 247);
    ELASTOGEN_CHECK_ASSET(points <= bytes.size(), path, ": claims ", points, " points in ",
                          bytes.size(), " bytes");
    header.points = int64_t(points);
  }
  // integers times scale plus offset are positions
  for (size_t k = 0; k < 3; ++k) {
    header.scale[k] = at<double>(bytes, 131 + 8 * k);
    header.offset[k] = at<double>(bytes, 155 + 8 * k);
  }
  // what the header states must fit its format and the file
  ELASTOGEN_CHECK_ASSET(header.record_bytes >= kRecordBytes[format], path,
                        ": points of the format ", format, " take ", kRecordBytes[format],
                        " bytes, not ", header.record_bytes);
  ELASTOGEN_CHECK_ASSET(header.data_offset >= kHeaderBytes && header.data_offset <= bytes.size(),
                        path, ": its points begin at byte ", header.data_offset, " of ",
                        bytes.size());
  return header;
}

/// An attribute that points carry to the output.
struct Attribute {
  const char* name;
  PlyType type;
  size_t offset;    ///< in a record [bytes]
  int shift, bits;  ///< of an integer that shares its byte; bits 0: the whole value
};

/// Attributes of a point format that are carried, from the tables of the standard.
std::vector<Attribute> attributes_of(int format) {
  using T = PlyType;
  std::vector<Attribute> all = {{"intensity", T::kUint16, 12, 0, 0}};
  const auto add = [&](const Attribute& attribute) { all.push_back(attribute); };
  // formats 0 to 5
  if (format < 6) {
    add({"return_number", T::kUint8, 14, 0, 3});
    add({"number_of_returns", T::kUint8, 14, 3, 3});
    add({"scan_direction", T::kUint8, 14, 6, 1});
    add({"edge_of_flight_line", T::kUint8, 14, 7, 1});
    add({"classification", T::kUint8, 15, 0, 5});
    add({"classification_flags", T::kUint8, 15, 5, 3});
    add({"scan_angle", T::kInt8, 16, 0, 0});
    add({"user_data", T::kUint8, 17, 0, 0});
    add({"point_source_id", T::kUint16, 18, 0, 0});
    if (format != 0 && format != 2) add({"gps_time", T::kFloat64, 20, 0, 0});
    return all;
  }
  // formats 6 to 10
  add({"return_number", T::kUint8, 14, 0, 4});
  add({"number_of_returns", T::kUint8, 14, 4, 4});
  add({"classification_flags", T::kUint8, 15, 0, 4});
  add({"scanner_channel", T::kUint8, 15, 4, 2});
  add({"scan_direction", T::kUint8, 15, 6, 1});
  add({"edge_of_flight_line", T::kUint8, 15, 7, 1});
  add({"classification", T::kUint8, 16, 0, 0});
  add({"user_data", T::kUint8, 17, 0, 0});
  add({"scan_angle", T::kInt16, 18, 0, 0});
  add({"point_source_id", T::kUint16, 20, 0, 0});
  add({"gps_time", T::kFloat64, 22, 0, 0});
  if (format == 8 || format == 10) add({"nir", T::kUint16, 36, 0, 0});
  return all;
}

double value_of(std::string_view record, const Attribute& a) {
  switch (a.type) {
    case PlyType::kInt8:
      return at<int8_t>(record, a.offset);
    case PlyType::kInt16:
      return at<int16_t>(record, a.offset);
    case PlyType::kUint16:
      return at<uint16_t>(record, a.offset);
    case PlyType::kFloat64:
      return at<double>(record, a.offset);
    default:
      break;
  }
  const int byte = at<uint8_t>(record, a.offset);
  return a.bits == 0 ? byte : byte >> a.shift & ((1 << a.bits) - 1);
}

void note_columns(const LasHeader& header, const OwnColumns& own, Asset& asset) {
  std::vector<std::string> lost;
  const bool has_waves =
      header.format == 4 || header.format == 5 || header.format == 9 || header.format == 10;
  if (has_waves) lost.push_back("wave packets");
  const int64_t extra = header.record_bytes - kRecordBytes[header.format];
  if (extra > 0) lost.push_back(concat(extra, " extra bytes a point"));
  note_own_columns(asset, own);
  note_lost_columns(asset, lost);
}

}  // namespace

Asset parse_las(std::string_view bytes, const std::string& path) {
  const LasHeader header = read_las_header(bytes, path);
  const std::string_view records = bytes.substr(header.data_offset);
  ByteReader(records, path).claim(header.points, header.record_bytes, "points");
  Asset asset;
  asset.path = path;
  asset.format = "las";
  asset.up = 3;
  PointCloud& cloud = asset.points.emplace();
  const size_t rgb = size_t(kRgbOffset[header.format]);
  const std::vector<Attribute> attributes = attributes_of(header.format);
  for (const Attribute& a : attributes) cloud.own.columns.push_back({a.name, a.type});
  note_columns(header, cloud.own, asset);
  std::vector<std::array<uint16_t, 3>> colours;
  uint16_t brightest = 0;
  for (int64_t i = 0; i < header.points; ++i) {
    const std::string_view record = records.substr(size_t(i * header.record_bytes));
    Vec3& p = cloud.position.emplace_back();
    for (size_t k = 0; k < 3; ++k)
      p[k] = header.scale[k] * at<int32_t>(record, 4 * k) + header.offset[k];
    for (size_t k = 0; k < attributes.size(); ++k)
      cloud.own.add(k, value_of(record, attributes[k]));
    if (rgb == 0) continue;
    auto& c = colours.emplace_back();
    for (size_t k = 0; k < 3; ++k) c[k] = at<uint16_t>(record, rgb + 2 * k);
    brightest = std::max({brightest, c[0], c[1], c[2]});
  }

  // many writers store 8 bits where the standard asks for 16
  const double range = brightest > 255 ? 65535 : 255;
  for (const auto& c : colours)
    cloud.colour.push_back({linear_from_srgb(c[0] / range), linear_from_srgb(c[1] / range),
                            linear_from_srgb(c[2] / range), 1});
  return asset;
}

Asset read_las(const std::string& path) {
  return parse_las(read_file(path), path);
}

}  // namespace elastogen
