// SPDX-License-Identifier: Apache-2.0
// Files of tetrahedra in all formats and encodings that are read.

#pragma once

#include "core/base.hpp"

#include <zlib.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

namespace elastogen::test {

/// Cells by VTK's types and in its order of points.
struct TetCells {
  std::vector<Vec3> points;
  std::vector<std::vector<int>> cells;
  std::vector<int> types, regions;
};

/// A triangle, a tetrahedron, a point that nothing uses, and a tetrahedron of the other winding.
inline TetCells two_tets() {
  return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {9, -9, 0.125}, {0, 0, 1}, {1, 1, 1.5}},
          {{0, 1, 2}, {0, 1, 2, 4}, {2, 1, 4, 5}},
          {5, 10, 10},
          {4, 9, 7}};
}

/// A quadratic tetrahedron with straight edges. @param turned  of the other winding.
inline TetCells quadratic_tet(bool turned) {
  TetCells tet{{{0, 0, 0}, {2, 0, 0}, {0, 4, 0}, {0, 0, 8}}, {{0, 1, 2, 3}}, {24}, {3}};
  if (turned) std::swap(tet.points[1], tet.points[2]);
  constexpr size_t kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (const auto& [a, b] : kEdges) {
    Vec3 middle;
    for (size_t d = 0; d < 3; ++d) middle[d] = 0.5 * (tet.points[a][d] + tet.points[b][d]);
    tet.cells[0].push_back(int(tet.points.size()));
    tet.points.push_back(middle);
  }
  return tet;
}

/// Numbers as words or bytes.
class NumberWriter {
 public:
  NumberWriter(bool binary, std::endian order) : binary_(binary), order_(order) {}

  template <class T>
  void put(T value) {
    if (!binary_) {
      std::ostringstream word;
      word.precision(17);
      word << +value;
      out_ += word.str() + ' ';
      return;
    }
    char raw[sizeof(T)];
    std::memcpy(raw, &value, sizeof(T));
    if (order_ != std::endian::native) std::reverse(raw, raw + sizeof(T));
    out_.append(raw, sizeof(T));
  }
  /// Ends a line of a text.
  void end_line() {
    if (!binary_) out_ += '\n';
  }
  void text(const std::string& text) { out_ += text; }
  const std::string& str() const { return out_; }

 private:
  std::string out_;
  bool binary_;
  std::endian order_;
};

/// Gmsh's number of a node: neither dense nor ascending.
inline int msh_number(size_t point) {
  return int((point * 5 + 3) % 16 * 3 + 1);
}

inline int msh_type(int vtk_type) {
  return vtk_type == 3 ? 1 : vtk_type == 5 ? 2 : vtk_type == 10 ? 4 : vtk_type == 24 ? 11 : 5;
}

template <class Int>
void put_msh_nodes(const TetCells& mesh, size_t cell, NumberWriter& out) {
  std::vector<int> nodes = mesh.cells[cell];
  if (nodes.size() == 10) std::swap(nodes[8], nodes[9]);
  for (const int n : nodes) out.put(Int(msh_number(size_t(n))));
  out.end_line();
}

inline std::string msh_head(const char* version, bool binary, NumberWriter& out) {
  std::ostringstream head;
  head << "$MeshFormat\n" << version << ' ' << binary << " 8\n";
  out.text(head.str());
  if (binary) {
    out.put(int32_t(1));
    out.text("\n");
  }
  out.text("$EndMeshFormat\n$PhysicalNames\n1\n3 7 \"a body\"\n$EndPhysicalNames\n");
  return out.str();
}

/// Binary elements stand in blocks of one type.
inline std::string msh2_file(const TetCells& mesh, bool binary,
                             std::endian order = std::endian::little) {
  NumberWriter out(binary, order);
  msh_head("2.2", binary, out);
  // nodes, then elements
  out.text("$Nodes\n" + std::to_string(mesh.points.size()) + '\n');
  for (size_t p = 0; p < mesh.points.size(); ++p) {
    out.put(int32_t(msh_number(p)));
    for (const double x : mesh.points[p]) out.put(x);
    out.end_line();
  }
  out.text("\n$EndNodes\n$Elements\n" + std::to_string(mesh.cells.size()) + '\n');
  for (size_t c = 0; c < mesh.cells.size(); ++c) {
    const auto number = int32_t(100 + c), type = int32_t(msh_type(mesh.types[c])),
               region = int32_t(mesh.regions[c]);
    if (binary) {  // a header before each block, here one of one element
      for (const int32_t value : {type, 1, 2, number, region, 55}) out.put(value);
    } else {  // the first region as entity, the others as physical group
      const int32_t group = c == 0 ? 0 : region, entity = c == 0 ? region : 55;
      for (const int32_t value : {number, type, 2, group, entity}) out.put(value);
    }
    put_msh_nodes<int32_t>(mesh, c, out);
  }
  out.text("\n$EndElements\n");
  return out.str();
}

/// A volume for each cell, number 20 + cell, whose physical group is the region, after a point and
/// a face.
inline void put_msh4_entities(const TetCells& mesh, NumberWriter& out) {
  out.text("$Entities\n");
  for (const size_t count : {size_t(1), size_t(0), size_t(1), mesh.cells.size()})
    out.put(uint64_t(count));
  out.end_line();
  out.put(int32_t(6));
  for (int k = 0; k < 3; ++k) out.put(0.5);
  out.put(uint64_t(0));
  out.end_line();
  for (size_t c = 0; c <= mesh.cells.size(); ++c) {
    out.put(int32_t(c == 0 ? 20 : 20 + c - 1));
    for (int k = 0; k < 6; ++k) out.put(0.25 * k);
    out.put(uint64_t(c == 0 ? 0 : 2));
    if (c > 0) out.put(int32_t(mesh.regions[c - 1])), out.put(int32_t(99));
    out.put(uint64_t(1));
    out.put(int32_t(-6));
    out.end_line();
  }
  out.text("\n$EndEntities\n");
}

inline std::string msh4_file(const TetCells& mesh, bool binary,
                             std::endian order = std::endian::little) {
  NumberWriter out(binary, order);
  msh_head("4.1", binary, out);
  put_msh4_entities(mesh, out);
  // nodes in two blocks, with and without parameters
  out.text("$Nodes\n");
  for (const size_t value : {size_t(2), mesh.points.size(), size_t(1), size_t(46)})
    out.put(uint64_t(value));
  out.end_line();
  for (const auto& [begin, end] : {std::pair(size_t(0), size_t(2)), {2, mesh.points.size()}}) {
    const bool parametric = begin == 0;  // on a face, with u and v
    for (const int32_t value : {2, 20, int32_t(parametric)}) out.put(value);
    out.put(uint64_t(end - begin));
    out.end_line();
    for (size_t p = begin; p < end; ++p) out.put(uint64_t(msh_number(p)));
    out.end_line();
    for (size_t p = begin; p < end; ++p) {
      for (const double x : mesh.points[p]) out.put(x);
      if (parametric) out.put(0.5), out.put(0.75);
      out.end_line();
    }
  }
  // a block for each element
  out.text("\n$EndNodes\n$Elements\n");
  for (const size_t value : {mesh.cells.size(), mesh.cells.size(), size_t(100), size_t(999)})
    out.put(uint64_t(value));
  out.end_line();
  for (size_t c = 0; c < mesh.cells.size(); ++c) {
    for (const int32_t value : {3, int32_t(20 + c), msh_type(mesh.types[c])}) out.put(value);
    out.put(uint64_t(1));
    out.end_line();
    out.put(uint64_t(100 + c));
    put_msh_nodes<uint64_t>(mesh, c, out);
  }
  out.text("\n$EndElements\n");
  return out.str();
}

/// CELLS, since version 5 as OFFSETS and CONNECTIVITY.
inline void put_vtk_cells(const TetCells& mesh, int version, NumberWriter& out) {
  const size_t count = mesh.cells.size();
  size_t corners = 0;
  for (const std::vector<int>& cell : mesh.cells) corners += cell.size();
  if (version < 5) {
    out.text("CELLS " + std::to_string(count) + ' ' + std::to_string(count + corners) + '\n');
  } else {
    out.text("CELLS " + std::to_string(count + 1) + ' ' + std::to_string(corners) +
             "\nOFFSETS vtktypeint64\n");
    int64_t end = 0;
    out.put(end);
    for (const std::vector<int>& cell : mesh.cells) out.put(end += int64_t(cell.size()));
    out.text("\nCONNECTIVITY vtktypeint64\n");
  }
  for (const std::vector<int>& cell : mesh.cells) {
    if (version < 5) out.put(int32_t(cell.size()));
    for (const int c : cell) version < 5 ? out.put(int32_t(c)) : out.put(int64_t(c));
  }
}

inline std::string vtk_file(const TetCells& mesh, bool binary, int version) {
  NumberWriter out(binary, std::endian::big);
  std::ostringstream head;
  head << "# vtk DataFile Version " << version << ".1\na title\n"
       << (binary ? "BINARY" : "ASCII") << "\nDATASET UNSTRUCTURED_GRID\n"
       << "FIELD FieldData 1\nTimeValue 1 1 double\n";
  out.text(head.str());
  out.put(0.5);
  out.text("\nPOINTS " + std::to_string(mesh.points.size()) + " float\n");
  for (const Vec3& point : mesh.points)
    for (const double x : point) out.put(float(x));
  out.text("\nMETADATA\nINFORMATION 0\n\n");
  put_vtk_cells(mesh, version, out);
  // types and fields of cells
  const size_t count = mesh.cells.size();
  out.text("\nCELL_TYPES " + std::to_string(count) + '\n');
  for (const int type : mesh.types) out.put(int32_t(type));
  out.text("\nCELL_DATA " + std::to_string(count) +
           "\nSCALARS quality double\nLOOKUP_TABLE default\n");
  for (size_t c = 0; c < count; ++c) out.put(0.5);
  out.text("\nFIELD FieldData 1\nregion 1 " + std::to_string(count) + " int\n");
  for (const int region : mesh.regions) out.put(int32_t(region));
  out.text("\n");
  return out.str();
}

inline std::string base64(const std::string& bytes) {
  constexpr char kLetters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (size_t k = 0; k < bytes.size(); k += 3) {
    uint32_t bits = 0;
    for (size_t b = 0; b < 3; ++b)
      bits = bits << 8 | (k + b < bytes.size() ? uint8_t(bytes[k + b]) : 0u);
    for (size_t b = 0; b < 4; ++b)
      out += k + b > bytes.size() ? '=' : kLetters[bits >> (18 - 6 * b) & 63];
  }
  return out;
}

struct VtuOptions {
  std::string format = "ascii";  ///< or binary, raw, base64; the last two are appended
  bool packed = false, wide = false;
  std::endian order = std::endian::little;
};

/// A VTU file, array by array.
class VtuBuilder {
 public:
  explicit VtuBuilder(const VtuOptions& options) : options_(options) {}

  template <class T>
  void array(const std::string& name, const char* type, const std::vector<T>& values,
             const char* more = "") {
    const bool is_text = options_.format == "ascii", is_inline = options_.format == "binary";
    NumberWriter numbers(!is_text, options_.order);
    for (const T value : values) numbers.put(value);
    const std::string data = is_text ? numbers.str() : encoded(numbers.str());
    xml_ += "<DataArray Name='" + name + "' type=\"" + type + "\" " + more + " format=\"";
    if (is_text || is_inline) {
      xml_ += options_.format + "\">\n" + data + "\n</DataArray>\n";
    } else {
      xml_ += "appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
      appended_ += data;
    }
  }
  void xml(const std::string& text) { xml_ += text; }

  std::string file() const {
    std::string all =
        "<?xml version=\"1.0\"?>\n<!-- <VTKFile> -->\n<VTKFile type=\"UnstructuredGrid\"";
    all += options_.order == std::endian::big ? " byte_order=\"BigEndian\""
                                              : " byte_order = 'LittleEndian'";
    if (options_.wide) all += " header_type=\"UInt64\"";
    if (options_.packed) all += " compressor=\"vtkZLibDataCompressor\"";
    all += ">\n" + xml_;
    if (!appended_.empty())
      all += "<AppendedData encoding=\"" + options_.format + "\">\n_" + appended_ +
             "\n</AppendedData>\n";
    return all + "</VTKFile>\n";
  }

 private:
  std::string header(const std::vector<size_t>& counts) const {
    NumberWriter out(true, options_.order);
    for (const size_t n : counts) options_.wide ? out.put(uint64_t(n)) : out.put(uint32_t(n));
    return out.str();
  }

  /// Header and bytes; packed in blocks of 20 bytes, the last shorter.
  std::string encoded(const std::string& bytes) const {
    const bool is_raw = options_.format == "raw";
    if (!options_.packed) {
      const std::string all = header({bytes.size()}) + bytes;
      return is_raw ? all : base64(all);
    }
    constexpr size_t kBlock = 20;
    std::vector<size_t> counts = {(bytes.size() + kBlock - 1) / kBlock, kBlock,
                                  bytes.size() % kBlock};
    std::string blocks;
    for (size_t at = 0; at < bytes.size(); at += kBlock) {
      const std::string block = bytes.substr(at, kBlock);
      std::string packed(100, '\0');
      auto size = uLongf(packed.size());
      compress(reinterpret_cast<Bytef*>(packed.data()), &size,
               reinterpret_cast<const Bytef*>(block.data()), block.size());
      counts.push_back(size);
      blocks += packed.substr(0, size);
    }
    return is_raw ? header(counts) + blocks : base64(header(counts)) + base64(blocks);
  }

  VtuOptions options_;
  std::string xml_, appended_;
};

inline std::string vtu_file(const TetCells& mesh, const VtuOptions& options) {
  // points and cells as flat lists
  std::vector<double> x;
  for (const Vec3& point : mesh.points) x.insert(x.end(), point.begin(), point.end());
  std::vector<int32_t> corners;
  std::vector<int64_t> ends;
  for (const std::vector<int>& cell : mesh.cells) {
    corners.insert(corners.end(), cell.begin(), cell.end());
    ends.push_back(int64_t(corners.size()));
  }
  // data of points and cells, then cells, then points
  VtuBuilder out(options);
  out.xml("<UnstructuredGrid>\n<FieldData/>\n<Piece NumberOfPoints=\"" +
          std::to_string(mesh.points.size()) + "\" NumberOfCells=\"" +
          std::to_string(mesh.cells.size()) + "\">\n<PointData>\n");
  out.array("material", "Float64", x, "NumberOfComponents=\"3\"");
  out.xml("</PointData>\n<CellData Scalars=\"a > b\">\n");
  out.array("quality", "Float64", std::vector<double>(mesh.cells.size(), 0.5));
  out.array("region", "Int16", std::vector<int16_t>(mesh.regions.begin(), mesh.regions.end()));
  out.xml("</CellData>\n<Cells>\n");
  out.array("connectivity", "Int32", corners);
  out.array("offsets", "Int64", ends);
  out.array("types", "UInt8", std::vector<uint8_t>(mesh.types.begin(), mesh.types.end()));
  out.xml("</Cells>\n<Points>\n");
  out.array("Points", "Float64", x, "NumberOfComponents=\"3\"");
  out.xml("</Points>\n</Piece>\n</UnstructuredGrid>\n");
  return out.file();
}

struct NamedFile {
  std::string name, bytes;
};

/// The cells in every format and encoding.
inline std::vector<NamedFile> all_files(const TetCells& mesh) {
  constexpr std::endian kBig = std::endian::big;
  std::vector<NamedFile> files = {{"msh 2.2", msh2_file(mesh, false)},
                                  {"msh 2.2 binary", msh2_file(mesh, true)},
                                  {"msh 2.2 binary big", msh2_file(mesh, true, kBig)},
                                  {"msh 4.1", msh4_file(mesh, false)},
                                  {"msh 4.1 binary", msh4_file(mesh, true)},
                                  {"msh 4.1 binary big", msh4_file(mesh, true, kBig)},
                                  {"vtk 3", vtk_file(mesh, false, 3)},
                                  {"vtk 3 binary", vtk_file(mesh, true, 3)},
                                  {"vtk 5", vtk_file(mesh, false, 5)},
                                  {"vtk 5 binary", vtk_file(mesh, true, 5)},
                                  {"vtu ascii", vtu_file(mesh, {})}};
  for (const char* format : {"binary", "raw", "base64"})
    for (const bool packed : {false, true})
      for (const bool wide : {false, true})
        files.push_back(
            {std::string("vtu ") + format + (packed ? " packed" : "") + (wide ? " wide" : ""),
             vtu_file(mesh, {format, packed, wide, wide ? kBig : std::endian::little})});
  return files;
}

}  // namespace elastogen::test
