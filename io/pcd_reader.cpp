// SPDX-License-Identifier: Apache-2.0
#include "io/pcd_reader.hpp"

#include "io/byte_reader.hpp"
#include "io/lzf.hpp"
#include "io/safe_file.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr size_t kMaxFields = 256;
constexpr int64_t kMostOwnValues = 16;  ///< a field of more is a descriptor and not carried
constexpr int64_t kMaxPoints = std::numeric_limits<int32_t>::max();

struct Field {
  std::string_view name;
  int64_t size = 4;    ///< bytes of a value
  char type = 'F';     ///< I signed, U unsigned, F floating
  int64_t count = 1;   ///< values a point
  int64_t offset = 0;  ///< of the first value in a point [bytes]
  int64_t word = 0;    ///< offset counted in values, for text
  int64_t index = 0;   ///< of the value that is read, where a field has several
};

class PcdParser {
 public:
  PcdParser(std::string_view bytes, const std::string& path)
      : rest_(without_mark(bytes)), path_(path) {}

  Asset parse() {
    while (data_.empty()) read_header_line();
    check_header();
    begin_own_columns();
    if (data_ == "ascii") {
      read_text();
    } else {
      read_binary();
    }
    note_own_columns(asset_, cloud_.own);
    note_lost_columns(asset_, lost_);
    asset_.points = std::move(cloud_);
    return std::move(asset_);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ':', line_, ": ", parts...);
  }

  void read_header_line() {
    check(rest_.find('\n') != rest_.npos, "the header has no DATA line");
    ++line_;
    std::string_view line = next_line(rest_);
    const std::string_view keyword = next_word(line);
    // what a value of each field is
    if (keyword == "FIELDS" || keyword == "COLUMNS") {
      for (std::string_view name; !(name = next_word(line)).empty();)
        fields_.emplace_back().name = name;
      check(fields_.size() <= kMaxFields, "more than ", kMaxFields, " fields");
    } else if (keyword == "SIZE") {
      for (Field& field : fields_) field.size = integer(line, 1, 8);
    } else if (keyword == "TYPE") {
      for (Field& field : fields_) {
        const std::string_view type = next_word(line);
        check(type == "I" || type == "U" || type == "F", "the type of ", field.name,
              " must be I, U or F");
        field.type = type[0];
      }
    } else if (keyword == "COUNT") {
      for (Field& field : fields_) field.count = integer(line, 0, 1 << 16);
    } else if (keyword == "WIDTH") {
      // how many points there are
      width_ = integer(line, 0, kMaxPoints);
    } else if (keyword == "HEIGHT") {
      height_ = integer(line, 0, kMaxPoints);
    } else if (keyword == "POINTS") {
      points_ = integer(line, 0, kMaxPoints);
    } else if (keyword == "DATA") {
      // DATA is the last line of the header
      data_ = next_word(line);
      check(data_ == "ascii" || data_ == "binary" || data_ == "binary_compressed",
            "DATA must be ascii, binary or binary_compressed");
    } else {
      check(keyword.empty() || keyword.starts_with('#') || keyword == "VERSION" ||
                keyword == "VIEWPOINT",
            "unknown header line \"", keyword.substr(0, 40), '"');
    }
  }

  int64_t integer(std::string_view& line, int64_t low, int64_t high) const {
    const std::optional<int64_t> value = to_integer(next_word(line));
    check(value && *value >= low && *value <= high, "an integer from ", low, " to ", high,
          " is expected");
    return *value;
  }

  void check_header() {
    for (Field& field : fields_) {
      check(field.size == 1 || field.size == 2 || field.size == 4 || field.size == 8, "a value of ",
            field.name, " has ", field.size, " bytes, not 1, 2, 4 or 8");
      check(field.type != 'F' || field.size >= 4, "a floating number of ", field.size, " bytes");
      field.offset = point_bytes_;
      field.word = point_words_;
      point_bytes_ += field.size * field.count;
      point_words_ += field.count;
    }
    const int64_t organised = width_ * height_;  // both below 2^31
    check(points_ < 0 || organised == 0 || organised == points_, "WIDTH times HEIGHT is ",
          organised, ", POINTS is ", points_);
    points_ = std::max(points_, organised);
    check(points_ <= kMaxPoints, points_, " points are too many");
    position_ = {find("x"), find("y"), find("z")};
    check(position_[0] && position_[1] && position_[2], "there are no fields x, y, z");
    normal_ = {find("normal_x"), find("normal_y"), find("normal_z")};
    has_alpha_ = find("rgba");
    colour_ = find(has_alpha_ ? "rgba" : "rgb");
    if (colour_ && colour_->size != 4) colour_ = nullptr;
  }

  /// Fields that nothing else uses, one column a value; padding ("_") is left out.
  void begin_own_columns() {
    for (const Field& field : fields_) {
      const bool is_normal =
          normal_[0] && normal_[1] && normal_[2] && std::ranges::count(normal_, &field) > 0;
      if (std::ranges::count(position_, &field) > 0 || is_normal || &field == colour_ ||
          field.name == "_")
        continue;
      const bool is_exact = field.type == 'F' || field.size <= 4;
      if (!is_exact || field.count > kMostOwnValues) {
        lost_.push_back(std::string(field.name));
        continue;
      }
      for (int64_t k = 0; k < field.count; ++k) {
        Field& value = own_.emplace_back(field);
        value.offset += k * field.size;
        value.word += k;
        value.index = k;
        const std::string name(field.name);
        cloud_.own.columns.push_back(
            {field.count > 1 ? concat(name, '_', k) : name, type_of(field)});
      }
    }
  }

  static PlyType type_of(const Field& field) {
    if (field.type == 'F') return field.size == 4 ? PlyType::kFloat32 : PlyType::kFloat64;
    const bool is_signed = field.type == 'I';
    if (field.size == 1) return is_signed ? PlyType::kInt8 : PlyType::kUint8;
    if (field.size == 2) return is_signed ? PlyType::kInt16 : PlyType::kUint16;
    return is_signed ? PlyType::kInt32 : PlyType::kUint32;
  }

  const Field* find(std::string_view name) const {
    const auto found = std::ranges::find(fields_, name, &Field::name);
    return found == fields_.end() || found->count == 0 ? nullptr : &*found;
  }

  /// Reads lines of numbers, as many in a line as the fields have values.
  void read_text() {
    check(points_ <= int64_t(rest_.size() + 1) / 2, points_, " points are claimed but only ",
          rest_.size(), " bytes are left");
    std::vector<double> row(size_t(point_words_), 0);
    while (int64_t(cloud_.position.size()) < points_) {
      check(!rest_.empty(), points_, " points are claimed but only ", cloud_.position.size(),
            " lines follow");
      ++line_;
      std::string_view line = trimmed(next_line(rest_));
      if (line.empty()) continue;
      for (double& value : row) {
        const std::string_view word = next_word(line);
        const std::optional<double> number = to_double(word);
        check(number.has_value(), "a number is expected, not \"", word.substr(0, 40), '"');
        value = *number;
      }
      add_point([&](const Field& field) { return row[size_t(field.word)]; },
                [&](const Field& field) { return bits_of(row[size_t(field.word)], field); });
    }
  }

  /// The 32 bits of a packed colour that is written as a number.
  static uint32_t bits_of(double value, const Field& field) {
    if (!std::isfinite(value)) return 0;
    if (field.type == 'F') return std::bit_cast<uint32_t>(float(value));
    return uint32_t(int64_t(std::clamp(value, -0x1p31, 0x1p32 - 1)));
  }

  /// Reads points one after the other or, if compressed, field after field for all points.
  void read_binary() {
    std::string unpacked;
    std::string_view values = rest_;
    const bool packed = data_ == "binary_compressed";
    if (packed) {
      ByteReader reader(rest_, path_);
      const uint32_t from = reader.read<uint32_t>(), to = reader.read<uint32_t>();
      reader.claim(from, 1, "compressed bytes");
      std::optional<std::string> out = lzf_unpacked(rest_.substr(8, from), to);
      check(out.has_value(), "the compressed points are damaged");
      values = unpacked = std::move(*out);
    }
    ByteReader(values, path_).claim(points_, point_bytes_, "points");
    for (int64_t i = 0; i < points_; ++i) {
      const auto bytes = [&](const Field& field) {
        const int64_t first = field.offset - field.index * field.size;
        const int64_t at = packed ? first * points_ + (i * field.count + field.index) * field.size
                                  : i * point_bytes_ + field.offset;
        return ByteReader(values.substr(size_t(at)), "");  // the claim above covers it
      };
      add_point([&](const Field& field) { return value_of(bytes(field), field); },
                [&](const Field& field) { return bytes(field).template read<uint32_t>(); });
    }
  }

  static double value_of(ByteReader bytes, const Field& field) {
    if (field.type == 'F') return field.size == 4 ? bytes.read<float>() : bytes.read<double>();
    const bool is_signed = field.type == 'I';
    switch (field.size) {
      case 1:
        return is_signed ? bytes.read<int8_t>() : bytes.read<uint8_t>();
      case 2:
        return is_signed ? bytes.read<int16_t>() : bytes.read<uint16_t>();
      case 4:
        return is_signed ? double(bytes.read<int32_t>()) : double(bytes.read<uint32_t>());
    }
    return is_signed ? double(bytes.read<int64_t>()) : double(bytes.read<uint64_t>());
  }

  /// @param value  of a field as a number  @param bits  of a field of four bytes
  template <class Value, class Bits>
  void add_point(const Value& value, const Bits& bits) {
    cloud_.position.push_back({value(*position_[0]), value(*position_[1]), value(*position_[2])});
    if (normal_[0] && normal_[1] && normal_[2])
      cloud_.normal.push_back(
          {float(value(*normal_[0])), float(value(*normal_[1])), float(value(*normal_[2]))});
    for (size_t k = 0; k < own_.size(); ++k) cloud_.own.add(k, value(own_[k]));
    if (!colour_) return;
    const uint32_t word = bits(*colour_);
    const auto channel = [&](int shift) { return double((word >> shift) & 255) / 255; };
    cloud_.colour.push_back({linear_from_srgb(channel(16)), linear_from_srgb(channel(8)),
                             linear_from_srgb(channel(0)), has_alpha_ ? float(channel(24)) : 1});
  }

  std::string_view rest_, data_;
  const std::string& path_;
  int64_t line_ = 0;
  std::vector<Field> fields_;
  std::array<const Field*, 3> position_ = {}, normal_ = {};  ///< null where there is none
  const Field* colour_ = nullptr;
  bool has_alpha_ = false;
  int64_t width_ = 0, height_ = 1, points_ = -1;
  int64_t point_bytes_ = 0, point_words_ = 0;
  std::vector<Field> own_;  ///< a field for each value
  std::vector<std::string> lost_;
  Asset asset_;
  PointCloud cloud_;
};

}  // namespace

Asset parse_pcd(std::string_view bytes, const std::string& path) {
  Asset asset = PcdParser(bytes, path).parse();
  asset.path = path;
  asset.format = "pcd";
  return asset;
}

Asset read_pcd(const std::string& path) {
  return parse_pcd(read_file(path), path);
}

}  // namespace elastogen
