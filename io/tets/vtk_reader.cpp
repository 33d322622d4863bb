// SPDX-License-Identifier: Apache-2.0
// Legacy VTK files (VTK user's guide, "VTK file formats"): lists of cells as pairs of count and
// points, since version 5 as offsets and points.

#include "io/tets/mesh_source.hpp"
#include "io/tets/vtk_cells.hpp"

#include <algorithm>
#include <cctype>

namespace elastogen::tets {
namespace {

struct VtkType {
  const char* name;
  Number type;
};
constexpr VtkType kVtkTypes[] = {{"char", Number::kInt8},
                                 {"signed_char", Number::kInt8},
                                 {"unsigned_char", Number::kUint8},
                                 {"short", Number::kInt16},
                                 {"unsigned_short", Number::kUint16},
                                 {"int", Number::kInt32},
                                 {"unsigned_int", Number::kUint32},
                                 {"long", Number::kInt64},
                                 {"unsigned_long", Number::kUint64},
                                 {"vtkidtype", Number::kInt32},
                                 {"vtktypeint64", Number::kInt64},
                                 {"vtktypeuint64", Number::kUint64},
                                 {"float", Number::kFloat32},
                                 {"double", Number::kFloat64}};

std::string lower_case(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = char(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

class VtkParser {
 public:
  VtkParser(std::string_view bytes, const std::string& path) : source_(bytes, path), path_(path) {}

  TetSoup parse() {
    read_header();
    for (std::string word; !(word = keyword()).empty();)
      if (!read_section(word)) break;
    source_.check(has_types_, "the file ends without CELL_TYPES");
    add_tets(cells_, path_, soup_);
    return std::move(soup_);
  }

 private:
  /// The next word of the text, in lower case.
  std::string keyword() {
    source_.begin_text();
    return lower_case(source_.next_word());
  }

  void expect(const char* word) {
    source_.begin_text();
    const std::string_view got = source_.word(word);
    source_.check(lower_case(got) == word, word, " is expected, not \"", got.substr(0, 40), '"');
  }

  void read_header() {
    const std::string_view first = source_.line();
    constexpr std::string_view kMagic = "# vtk DataFile Version ";
    const std::string_view version = trimmed(first.substr(std::min(kMagic.size(), first.size())));
    const std::optional<int64_t> major = to_integer(version.substr(0, version.find('.')));
    source_.check(first.starts_with(kMagic) && major && *major >= 1 && *major <= 5, "version \"",
                  version.substr(0, 40), "\" is not read");
    has_offsets_ = *major >= 5;
    source_.line();  // the title
    const std::string kind = keyword();
    source_.check(kind == "ascii" || kind == "binary", "ASCII or BINARY is expected");
    is_binary_ = kind == "binary";
    expect("dataset");
    expect("unstructured_grid");
  }

  /// @return false once all that is needed has been read.
  bool read_section(const std::string& word) {
    if (word == "field") {
      read_field(false);
    } else if (word == "metadata") {
      skip_metadata();
    } else if (word == "points") {
      source_.check(soup_.points.empty(), "a second list of points");
      read_points();
    } else if (word == "cells") {
      source_.check(cells_.ends.empty(), "a second list of cells");
      has_offsets_ ? read_cells_5() : read_cells();
    } else if (word == "cell_types") {
      source_.check(!has_types_, "a second list of types");
      read_types();
    } else if (word == "cell_data") {
      read_cell_data();
      return false;
    } else {
      source_.check(has_types_, "POINTS, CELLS or CELL_TYPES should begin here");
      return false;
    }
    return true;
  }

  /// Switches to binary data behind the end of this line, if the file is binary.
  void begin_data() {
    if (!is_binary_) return;
    source_.line();
    source_.begin_binary(std::endian::big);
  }

  Number type() {
    const std::string name = lower_case(source_.word("a type of numbers"));
    const auto* found = std::find_if(std::begin(kVtkTypes), std::end(kVtkTypes),
                                     [&](const VtkType& t) { return name == t.name; });
    source_.check(found != std::end(kVtkTypes), "numbers of type \"", name.substr(0, 40),
                  "\" are not read");
    return found->type;
  }

  int64_t count(const char* what) {
    return source_.integer_below(Number::kInt64, std::numeric_limits<int32_t>::max(), what);
  }

  /// Blocks of attributes end with an empty line.
  void skip_metadata() {
    source_.line();
    while (source_.left() > 0 && !trimmed(source_.line()).empty()) {
    }
  }

  void read_points() {
    const int64_t points = count("the number of points");
    const Number number = type();
    begin_data();
    source_.claim(3 * points, number, "points");
    for (int64_t k = 0; k < points; ++k) {
      Vec3 x;
      for (double& value : x) value = source_.finite(number, "a coordinate of a point");
      soup_.points.push_back(x);
    }
  }

  void read_corner(Number number) {
    cells_.corners.push_back(int32_t(
        source_.integer_below(number, int64_t(soup_.points.size()), "the point of a cell")));
  }

  void read_cells() {
    const int64_t cells = count("the number of cells");
    int64_t numbers = count("the number of integers");
    begin_data();
    source_.claim(numbers, Number::kInt32, "cells");
    for (int64_t c = 0; c < cells; ++c) {
      const int64_t corners =
          source_.integer_below(Number::kInt32, numbers, "the number of points of a cell");
      for (int64_t k = 0; k < corners; ++k) read_corner(Number::kInt32);
      numbers -= 1 + corners;
      cells_.ends.push_back(int64_t(cells_.corners.size()));
    }
    source_.check(numbers == 0, "the cells end ", numbers, " integers too early");
  }

  void read_cells_5() {
    const int64_t offsets = count("the number of offsets");
    const int64_t corners = count("the number of points of cells");
    expect("offsets");
    const Number offset = type();
    begin_data();
    source_.claim(offsets, offset, "offsets");
    for (int64_t k = 0; k < offsets; ++k) {
      const int64_t end = source_.integer_below(offset, corners + 1, "an offset");
      source_.check(k > 0 || end == 0, "the first offset is not 0");
      if (k > 0) cells_.ends.push_back(end);
    }
    expect("connectivity");
    const Number number = type();
    begin_data();
    source_.claim(corners, number, "points of cells");
    for (int64_t k = 0; k < corners; ++k) read_corner(number);
  }

  void read_types() {
    const int64_t cells = count("the number of types");
    begin_data();
    source_.claim(cells, Number::kInt32, "types of cells");
    for (int64_t k = 0; k < cells; ++k)
      cells_.types.push_back(source_.integer(Number::kInt32, "the type of a cell"));
    check_last_word();
    has_types_ = true;
  }

  /// Arrays of the cells up to one that is neither scalars nor a field.
  void read_cell_data() {
    const int64_t cells = count("the number of cells");
    source_.check(cells == int64_t(cells_.types.size()), "data of ", cells, " cells, there are ",
                  cells_.types.size());
    for (std::string word; !(word = keyword()).empty();) {
      if (word == "scalars")
        read_scalars();
      else if (word == "field")
        read_field(true);
      else if (word == "metadata")
        skip_metadata();
      else
        return;
    }
  }

  void read_scalars() {
    const std::string name = array_name();
    const Number number = type();
    const std::string_view components = trimmed(source_.line());
    expect("lookup_table");
    source_.word("the name of a table");
    const std::optional<int64_t> columns = components.empty() ? 1 : to_integer(components);
    source_.check(columns && *columns >= 1 && *columns <= 4,
                  "scalars have from 1 to 4 components, not \"", components.substr(0, 40), '"');
    read_array(name, *columns, int64_t(cells_.types.size()), number, true);
  }

  std::string array_name() {
    source_.begin_text();
    return std::string(source_.word("the name of an array"));
  }

  void read_field(bool of_cells) {
    source_.word("the name of a field");
    const int64_t arrays = count("the number of arrays");
    for (int64_t a = 0; a < arrays; ++a) {
      std::string name = array_name();
      if (lower_case(name) == "metadata") {
        skip_metadata();
        name = array_name();
      }
      const int64_t columns = count("the number of components");
      const int64_t rows = count("the number of rows");
      read_array(name, columns, rows, type(), of_cells);
    }
  }

  /// Keeps an array that gives the regions of the cells, and leaves out any other.
  void read_array(const std::string& name, int64_t columns, int64_t rows, Number number,
                  bool of_cells) {
    begin_data();
    const bool are_regions = of_cells && cells_.region.empty() && columns == 1 &&
                             rows == int64_t(cells_.types.size()) && is_integer(number) &&
                             is_region_name(name);
    if (!are_regions) return source_.skip(columns * rows, number, "an array");
    source_.claim(rows, number, "regions");
    for (int64_t k = 0; k < rows; ++k)
      cells_.region.push_back(source_.integer(number, "the region of a cell"));
    check_last_word();
  }

  /// The word before the end of a file may be the beginning of a longer one.
  void check_last_word() const {
    source_.check(is_binary_ || source_.left() > 0, "the file ends within its last line");
  }

  MeshSource source_;
  const std::string& path_;
  TetSoup soup_;
  VtkCells cells_;
  bool is_binary_ = false, has_offsets_ = false, has_types_ = false;
};

}  // namespace

TetSoup parse_vtk(std::string_view bytes, const std::string& path) {
  return VtkParser(bytes, path).parse();
}

}  // namespace elastogen::tets
