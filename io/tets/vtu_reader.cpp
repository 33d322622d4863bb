// SPDX-License-Identifier: Apache-2.0
// VTK's XML files of unstructured grids (VTK user's guide, "VTK file formats").

#include "io/tets/vtk_cells.hpp"
#include "io/tets/vtu_arrays.hpp"
#include "io/tets/xml_scanner.hpp"

#include <algorithm>

namespace elastogen::tets {
namespace {

constexpr std::string_view kPiece = "VTKFile/UnstructuredGrid/Piece";

struct VtuType {
  const char* name;
  Number type;
};
constexpr VtuType kVtuTypes[] = {{"Int8", Number::kInt8},       {"UInt8", Number::kUint8},
                                 {"Int16", Number::kInt16},     {"UInt16", Number::kUint16},
                                 {"Int32", Number::kInt32},     {"UInt32", Number::kUint32},
                                 {"Int64", Number::kInt64},     {"UInt64", Number::kUint64},
                                 {"Float32", Number::kFloat32}, {"Float64", Number::kFloat64}};

/// The numbers of an array.
class ArraySource {
 public:
  ArraySource(const VtuArray& array, const VtuEncoding& encoding, const std::string& path)
      : bytes_(array.format == VtuArray::Format::kText ? "" : decoded(array, encoding)),
        source_(make(array, encoding, path)) {}
  ArraySource(const ArraySource&) = delete;
  ArraySource& operator=(const ArraySource&) = delete;

  MeshSource& source() { return source_; }

 private:
  MeshSource make(const VtuArray& array, const VtuEncoding& encoding, const std::string& path) {
    if (array.format != VtuArray::Format::kText) {
      MeshSource source(bytes_, array.place);
      source.begin_binary(encoding.order);
      return source;
    }
    const auto begin = size_t(array.text.data() - encoding.file.data());
    MeshSource source(encoding.file.substr(0, begin + array.text.size()), path);
    source.go_to(begin);
    return source;
  }

  std::string bytes_;
  MeshSource source_;
};

class VtuParser {
 public:
  VtuParser(std::string_view bytes, const std::string& path) : xml_(bytes, path), path_(path) {
    encoding_.file = bytes;
  }

  TetSoup parse() {
    find_arrays();
    read_points();
    VtkCells cells;
    read(ends_, "offsets", cell_count_, [&](MeshSource& source, Number type) {
      cells.ends.push_back(source.integer(type, "an offset"));
    });
    read(types_, "types", cell_count_, [&](MeshSource& source, Number type) {
      cells.types.push_back(source.integer(type, "the type of a cell"));
    });
    const auto points = int64_t(soup_.points.size());
    const int64_t corners = cells.ends.empty() ? 0 : cells.ends.back();
    read(corners_, "connectivity", corners, [&](MeshSource& source, Number type) {
      cells.corners.push_back(int32_t(source.integer_below(type, points, "the point of a cell")));
    });
    if (region_)
      read(region_, "region", cell_count_, [&](MeshSource& source, Number type) {
        cells.region.push_back(source.integer(type, "the region of a cell"));
      });
    add_tets(cells, path_, soup_);
    return std::move(soup_);
  }

 private:
  void find_arrays() {
    while (xml_.next()) {
      const std::string& element = xml_.element();
      if (element.find('/') == element.npos) {
        begin_file();
      } else if (element == kPiece) {
        begin_piece();
      } else if (element == "VTKFile/AppendedData") {
        return find_appended();
      } else if (element.starts_with(kPiece) && element.ends_with("/DataArray")) {
        add_array(std::string_view(element).substr(kPiece.size()));
      }
    }
  }

  std::string_view attribute(std::string_view name, std::string_view otherwise) const {
    return xml_.attribute(name).value_or(otherwise);
  }

  int64_t count(std::string_view name, std::string_view otherwise) const {
    const std::string_view text = trimmed(attribute(name, otherwise));
    const std::optional<int64_t> value = to_integer(text);
    xml_.check(value && *value >= 0 && *value < std::numeric_limits<int32_t>::max(), name,
               " must be an integer from 0 to 2147483646, not \"", text.substr(0, 40), '"');
    return *value;
  }

  void begin_file() {
    xml_.check(xml_.element() == "VTKFile" && attribute("type", "") == "UnstructuredGrid",
               "VTKFile of the type UnstructuredGrid is expected");
    const std::string_view order = attribute("byte_order", "LittleEndian");
    const std::string_view header = attribute("header_type", "UInt32");
    const std::string_view compressor = attribute("compressor", "");
    xml_.check(order == "LittleEndian" || order == "BigEndian", "byte_order is unknown");
    xml_.check(header == "UInt32" || header == "UInt64", "header_type is unknown");
    xml_.check(compressor.empty() || compressor == "vtkZLibDataCompressor", "data packed by ",
               compressor.substr(0, 40), " are not read; zlib is");
    encoding_.order = order == "BigEndian" ? std::endian::big : std::endian::little;
    encoding_.header = header == "UInt64" ? Number::kUint64 : Number::kUint32;
    encoding_.is_packed = !compressor.empty();
  }

  void begin_piece() {
    xml_.check(!has_piece_, "more than one piece is not read");
    has_piece_ = true;
    point_count_ = count("NumberOfPoints", "");
    cell_count_ = count("NumberOfCells", "");
  }

  /// Where an array belongs, null if it is not needed.
  std::optional<VtuArray>* slot(std::string_view element) {
    const std::string_view name = attribute("Name", "");
    if (element == "/Points/DataArray") return &points_;
    if (element == "/CellData/DataArray")
      return is_region_name(name) && !region_ && count("NumberOfComponents", "1") == 1 &&
                     !attribute("type", "").starts_with("Float")
                 ? &region_
                 : nullptr;
    if (element != "/Cells/DataArray") return nullptr;
    if (name == "connectivity") return &corners_;
    if (name == "offsets") return &ends_;
    return name == "types" ? &types_ : nullptr;
  }

  void add_array(std::string_view element) {
    // only arrays that are needed are kept
    std::optional<VtuArray>* place = slot(element);
    if (!place) return;
    const std::string name(attribute("Name", "Points"));
    xml_.check(!*place, "a second array ", name.substr(0, 40));
    VtuArray& array = place->emplace();
    array.place = concat(path_, ':', xml_.line(), ": the array ", name.substr(0, 40));
    // type and number of components
    const auto* type =
        std::find_if(std::begin(kVtuTypes), std::end(kVtuTypes),
                     [&](const VtuType& t) { return attribute("type", "") == t.name; });
    xml_.check(type != std::end(kVtuTypes), "numbers of type \"",
               attribute("type", "").substr(0, 40), "\" are not read");
    array.type = type->type;
    array.columns = count("NumberOfComponents", "1");
    xml_.check(array.columns == (place == &points_ ? 3 : 1), "it has ", array.columns,
               " components");
    // where its numbers are: as text, inline, or appended at an offset
    const std::string_view format = attribute("format", "ascii");
    xml_.check(format == "ascii" || format == "binary" || format == "appended",
               "format must be ascii, binary or appended");
    array.format = format == "ascii"    ? VtuArray::Format::kText
                   : format == "binary" ? VtuArray::Format::kInline
                                        : VtuArray::Format::kAppended;
    array.text = xml_.text();
    if (format == "appended") array.offset = size_t(offset());
  }

  int64_t offset() const {
    const std::optional<int64_t> value = to_integer(trimmed(attribute("offset", "")));
    xml_.check(value && *value >= 0, "offset must be an integer from 0");
    return *value;
  }

  /// The data begin behind an underscore and go on to the end of the file.
  void find_appended() {
    const std::string_view kind = attribute("encoding", "");
    xml_.check(kind == "raw" || kind == "base64", "encoding must be raw or base64");
    encoding_.is_base64 = kind == "base64";
    const std::string_view rest = encoding_.file.substr(xml_.position());
    const size_t begin = rest.find_first_not_of(" \t\r\n");
    xml_.check(begin != rest.npos && rest[begin] == '_', "appended data begin with _");
    encoding_.appended = rest.substr(begin + 1);
  }

  /// Calls take(source, type) for each number; there must be exactly as many as stated.
  template <class Take>
  void read(const std::optional<VtuArray>& array, const char* name, int64_t rows,
            const Take& take) {
    ELASTOGEN_CHECK_ASSET(array.has_value(), path_, ": it has no array ", name);
    ArraySource of_array(*array, encoding_, path_);
    MeshSource& source = of_array.source();
    const int64_t numbers = rows * array->columns;
    source.claim(numbers, array->type, name);
    for (int64_t k = 0; k < numbers; ++k) take(source, array->type);
    const bool is_text = array->format == VtuArray::Format::kText;
    source.check(is_text ? source.next_word().empty() : source.left() == 0, "more than ", numbers,
                 " numbers of ", name);
  }

  void read_points() {
    std::vector<double> x;
    read(points_, "Points", point_count_, [&](MeshSource& source, Number type) {
      x.push_back(source.finite(type, "a coordinate of a point"));
    });
    for (size_t k = 0; k < x.size(); k += 3) soup_.points.push_back({x[k], x[k + 1], x[k + 2]});
  }

  XmlScanner xml_;
  const std::string& path_;
  VtuEncoding encoding_;
  std::optional<VtuArray> points_, corners_, ends_, types_, region_;
  TetSoup soup_;
  bool has_piece_ = false;
  int64_t point_count_ = 0, cell_count_ = 0;
};

}  // namespace

TetSoup parse_vtu(std::string_view bytes, const std::string& path) {
  return VtuParser(bytes, path).parse();
}

}  // namespace elastogen::tets
