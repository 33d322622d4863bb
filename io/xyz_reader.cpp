// SPDX-License-Identifier: Apache-2.0
#include "io/xyz_reader.hpp"

#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <algorithm>

namespace elastogen {
namespace {

using Row = std::array<float, 3>;

constexpr size_t kMaxColumns = 64;
constexpr float kUnitTolerance = 0.02f;  ///< of a normal's length; three decimals suffice

/// A column behind the position.
struct Further {
  size_t column = 0;
  std::vector<double> value;
  bool is_number = true;  ///< every word of the column is a number
  bool is_known = false;  ///< is part of a colour or normal
};

/// Three neighbouring columns behind the position that may be one attribute.
struct Triple {
  enum Meaning { kUnknown, kColour, kNormal } meaning = kUnknown;
  std::array<size_t, 3> column;
  std::vector<Row> value;
};

bool are_unit(const std::vector<Row>& rows) {
  return std::ranges::all_of(rows, [](const Row& v) {
    return std::abs(std::hypot(v[0], v[1], v[2]) - 1) < kUnitTolerance;
  });
}

float largest(const std::vector<Row>& rows) {
  float value = 0;
  for (const Row& row : rows) value = std::max({value, row[0], row[1], row[2]});
  return value;
}

bool are_colours(const std::vector<Row>& rows) {
  return largest(rows) <= 255 && std::ranges::all_of(rows, [](const Row& v) {
           return std::ranges::all_of(v, [](float x) { return x >= 0; });
         });
}

class XyzParser {
 public:
  XyzParser(std::string_view bytes, const std::string& path)
      : rest_(without_mark(bytes)), path_(path) {}

  Asset parse() {
    while (!rest_.empty()) {
      ++line_;
      read_line(trimmed(next_line(rest_)));
    }
    check(claimed_ < 0 || claimed_ == int64_t(cloud_.position.size()), "the first line says ",
          claimed_, " points, the file has ", cloud_.position.size());
    for (Triple& triple : triples_) add_attribute(triple);
    add_own_columns();
    asset_.points = std::move(cloud_);
    return std::move(asset_);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ':', line_, ": ", parts...);
  }

  void read_line(std::string_view line) {
    const bool is_comment = line.starts_with('#') || line.starts_with("//");
    while (is_comment && (line.starts_with('#') || line.starts_with('/'))) line.remove_prefix(1);
    split(line);
    if (words_.empty()) return;
    if (columns_ == 0 && !is_named_ && read_names()) return;
    if (is_comment) return;
    if (columns_ == 0 && claimed_ < 0 && words_.size() == 1) {
      claimed_ = to_integer(words_[0]).value_or(-1);
      if (claimed_ >= 0) return;
    }
    read_point(line);
  }

  /// Splits a line into words, at most kMaxColumns + 1 of them.
  void split(std::string_view line) {
    words_.clear();
    constexpr std::string_view kSeparators = " \t,;\r\v\f";
    while (words_.size() <= kMaxColumns) {
      line.remove_prefix(std::min(line.find_first_not_of(kSeparators), line.size()));
      if (line.empty()) return;
      words_.push_back(line.substr(0, line.find_first_of(kSeparators)));
      line.remove_prefix(words_.back().size());
    }
  }

  /// Reads the names of the columns from a line that names x, y and z.
  bool read_names() {
    std::vector<std::string> names(words_.begin(), words_.end());
    for (std::string& name : names)
      for (char& c : name) c = c >= 'A' && c <= 'Z' ? char(c - 'A' + 'a') : c;
    const auto find = [&](std::array<const char*, 3> wanted) {
      std::array<size_t, 3> columns;
      for (size_t k = 0; k < 3; ++k)
        columns[k] = size_t(std::ranges::find(names, wanted[k]) - names.begin());
      const bool has_all = std::ranges::max(columns) < names.size();
      return has_all ? std::optional(columns) : std::nullopt;
    };
    const auto position = find({"x", "y", "z"});
    if (!position) return false;
    is_named_ = true;
    names_.assign(words_.begin(), words_.end());
    position_ = *position;
    const auto rgb = find({"r", "g", "b"}), colour = rgb ? rgb : find({"red", "green", "blue"});
    const auto normal = find({"nx", "ny", "nz"});
    if (colour) triples_.push_back({Triple::kColour, *colour, {}});
    if (normal) triples_.push_back({Triple::kNormal, *normal, {}});
    return true;
  }

  void read_point(std::string_view line) {
    check(words_.size() >= 3, "a point has three numbers, not ", words_.size());
    check(words_.size() <= kMaxColumns, "more than ", kMaxColumns, " columns");
    check(line.find(',') == line.npos || line.find(';') == line.npos,
          "commas and semicolons: write decimal points instead of commas");
    if (columns_ == 0) begin_columns();
    check(words_.size() == columns_, "the first point has ", columns_, " columns, this one ",
          words_.size());
    cloud_.position.push_back({number(position_[0]), number(position_[1]), number(position_[2])});
    for (Triple& t : triples_)
      t.value.push_back(
          {float(number(t.column[0])), float(number(t.column[1])), float(number(t.column[2]))});
    for (Further& further : further_) {
      const std::optional<double> value = to_double(words_[further.column]);
      further.value.push_back(value.value_or(0));
      further.is_number = further.is_number && value;
    }
  }

  /// Learns the columns from the first point.
  void begin_columns() {
    columns_ = words_.size();
    for (size_t k = 0; k < columns_; ++k)
      if (std::ranges::count(position_, k) == 0) further_.emplace_back().column = k;
    if (is_named_) {
      check(std::ranges::max(position_) < columns_, "the first line names more columns");
      for (const Triple& t : triples_)
        check(std::ranges::max(t.column) < columns_, "the first line names more columns");
      return;
    }
    for (size_t k = claimed_ >= 0 && columns_ == 7 ? 4 : 3; k + 3 <= columns_; k += 3)
      if (triples_.size() < 2) triples_.push_back({Triple::kUnknown, {k, k + 1, k + 2}, {}});
  }

  double number(size_t column) const {
    const std::optional<double> value = to_double(words_[column]);
    check(value.has_value(), "a number is expected, not \"", words_[column].substr(0, 40), '"');
    return *value;
  }

  void add_attribute(Triple& triple) {
    if (triple.meaning == Triple::kUnknown && are_unit(triple.value)) {
      triple.meaning = Triple::kNormal;
    } else if (triple.meaning == Triple::kUnknown && are_colours(triple.value)) {
      triple.meaning = Triple::kColour;
    }
    const auto take = [&] {
      for (Further& further : further_)
        further.is_known |= std::ranges::count(triple.column, further.column) > 0;
    };
    if (triple.meaning == Triple::kNormal && cloud_.normal.empty()) {
      take();
      cloud_.normal.swap(triple.value);
    } else if (triple.meaning == Triple::kColour && cloud_.colour.empty()) {
      take();
      const double range = largest(triple.value) > 1 ? 255 : 1;
      for (const Row& row : triple.value) {
        auto& colour = cloud_.colour.emplace_back(std::array<float, 4>{0, 0, 0, 1});
        for (size_t k = 0; k < 3; ++k)
          colour[k] = linear_from_srgb(std::clamp(row[k] / range, 0., 1.));
      }
    }
  }

  std::string name_of(size_t column) const {
    if (column < names_.size()) return names_[column];
    const bool is_pts = !is_named_ && claimed_ >= 0 && columns_ == 7 && column == 3;
    return is_pts ? "intensity" : concat("column_", column + 1);
  }

  void add_own_columns() {
    std::vector<const Further*> own;
    std::vector<std::string> lost;
    for (const Further& further : further_) {
      const std::string name = name_of(further.column);
      if (further.is_known) continue;
      if (!further.is_number) {
        lost.push_back(name);
        continue;
      }
      own.push_back(&further);
      cloud_.own.columns.push_back({name, PlyType::kFloat64});
    }
    for (size_t i = 0; i < cloud_.position.size(); ++i)
      for (size_t k = 0; k < own.size(); ++k) cloud_.own.add(k, own[k]->value[i]);
    note_own_columns(asset_, cloud_.own);
    note_lost_columns(asset_, lost);
  }

  std::string_view rest_;
  const std::string& path_;
  int64_t line_ = 0, claimed_ = -1;
  std::vector<std::string_view> words_;
  size_t columns_ = 0;  ///< of the first point
  bool is_named_ = false;
  std::array<size_t, 3> position_ = {0, 1, 2};
  std::vector<std::string> names_;  ///< of the first line
  std::vector<Triple> triples_;
  std::vector<Further> further_;
  Asset asset_;
  PointCloud cloud_;
};

}  // namespace

Asset parse_xyz(std::string_view bytes, const std::string& path) {
  Asset asset = XyzParser(bytes, path).parse();
  asset.path = path;
  asset.format = "xyz";
  return asset;
}

Asset read_xyz(const std::string& path) {
  return parse_xyz(read_file(path), path);
}

}  // namespace elastogen
