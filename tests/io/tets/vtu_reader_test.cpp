// SPDX-License-Identifier: Apache-2.0
#include "io/tets/tet_reader.hpp"
#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_checks.hpp"
#include "tests/io/tets/tet_files.hpp"

namespace elastogen::tets {
namespace {

using test::error_of, test::expect_says;

/// One tetrahedron as text.
const std::string kFile = R"(<VTKFile type="UnstructuredGrid">
<UnstructuredGrid>
<Piece NumberOfPoints="4" NumberOfCells="1">
<Points>
<DataArray type="Float64" NumberOfComponents="3">0 0 0 1 0 0 0 1 0 0 0 1</DataArray>
</Points>
<Cells>
<DataArray type="Int32" Name="connectivity">0 1 2 3</DataArray>
<DataArray type="Int32" Name="offsets">4</DataArray>
<DataArray type="UInt8" Name="types">10</DataArray>
</Cells>
</Piece>
</UnstructuredGrid>
</VTKFile>
)";

std::string vtu_message(const std::string& bytes) {
  return error_of([&] { parse_tets(bytes, "file"); });
}

/// kFile with one part in place of another, which it must have.
std::string with(const std::string& part, const std::string& other) {
  std::string file = kFile;
  const size_t at = file.find(part);
  EXPECT_NE(at, file.npos) << part;
  return file.replace(at, part.size(), other);
}

TEST(VtuReader, ReadsWhatAnotherProgramPacked) {
  // test::two_tets, written by meshio 5.3.5 with zlib
  const TetFile file = parse_tets(
      R"(<?xml version="1.0"?>
<VTKFile type="UnstructuredGrid" version="0.1" byte_order="LittleEndian" compressor="vtkZLibDataCompressor">
<!--This file was created by meshio v5.3.5-->
<UnstructuredGrid>
<Piece NumberOfPoints="6" NumberOfCells="3">
<Points>
<DataArray type="Float64" Name="Points" NumberOfComponents="3" format="binary">
AQAAAACAAACQAAAAIQAAAA==eJxjYMAHPtjjlcaQV3KA0gcg9AEc+mH60Okf9gCmgAlm
</DataArray>
</Points>
<Cells>
<DataArray type="Int64" Name="connectivity" format="binary">
AQAAAACAAABYAAAAHAAAAA==eJxjYIAARijNxIAK0MVZ0PiMaOKsUBoAAzAAFw==
</DataArray>
<DataArray type="Int64" Name="offsets" format="binary">
AQAAAACAAAAYAAAAEAAAAA==eJxjZoAAdijNDaUBASgAFg==
</DataArray>
<DataArray type="Int64" Name="types" format="binary">
AQAAAACAAAAYAAAADgAAAA==eJxjZYAALjQaAAGAABo=
</DataArray>
</Cells>
<CellData>
<DataArray type="Int32" Name="gmsh:physical" format="binary">
AQAAAACAAAAMAAAAEQAAAA==eJxjYWBg4ARidiAGAACgABU=
</DataArray>
</CellData>
</Piece>
</UnstructuredGrid>
</VTKFile>
)",
      "file");
  EXPECT_EQ(file.rest.rows(), 5);
  EXPECT_EQ(test::place(file.rest, 4), (Vec3{1, 1, 1.5}));
  EXPECT_EQ(test::determinants(file).sum, 3.5);  // 1 + 2.5
  EXPECT_EQ(file.region_ids, (std::vector<int64_t>{7, 9}));
  EXPECT_EQ(file.turned + file.skipped + file.unused, 3);
}

TEST(VtuReader, TakesXmlAsItMayBeWritten) {
  for (const std::string& file :
       {kFile, "<!-- > --><?a?>" + kFile, with("<Cells>", "<!-- <Cells> -->\n<Cells>"),
        with("<Points>", "<Points  a = 'x\"y>' >"), with("</Points>", "</Points >"),
        with("10</", "10<InformationKey name=\"a\" location=\"b\"/></")})
    EXPECT_EQ(parse_tets(file, "file").elements.rows(), 1) << file;
}

TEST(VtuReader, RefusesBrokenXml) {
  // elements too deep, attributes too many
  std::string deep = "<VTKFile type=\"UnstructuredGrid\">";
  for (int k = 0; k < 100000; ++k) deep += "<a>";
  std::string wide = "<VTKFile type=\"UnstructuredGrid\"";
  for (int k = 0; k < 100000; ++k) wide += " a" + std::to_string(k) + "=\"\"";
  const std::pair<std::string, std::string> cases[] = {
      {"<", "file:1: a name is expected"},
      {"<VTKFile", "file:1: a name is expected"},
      {"<VTKFile a", "an attribute has no value"},
      {'<' + std::string(65, 'a') + "/>", "file:1: a name is expected"},
      {"<!-- ", "file:1: a tag does not end"},
      {"<?xml", "a tag does not end"},
      {"<!DOCTYPE x [<!ENTITY a \"b\">]>", "document types and CDATA are not read"},
      {with("10</", "<![CDATA[10]]></"), "file:10: document types and CDATA"},
      {deep, "elements are nested too deep"},
      {wide, "an attribute twice, or too many"},
      {with("<Points>", "<Points a=\"1\" a=\"2\">"), "file:4: an attribute twice"},
      {with("<Points>", "<Points a=1>"), "file:4: a value is not in quotes"},
      {with("</VTKFile>", "</VTKFile"), "the end of another element"},
      {with("</Points>", "</Cells>"), "file:6: the end of another element than that which began"},
      {"</VTKFile>", "file:1: the end of another element"},
      {with("</VTKFile>", ""), "the file ends within an element"},
      // the root element
      {"<html></html>", "file:1: VTKFile of the type UnstructuredGrid is expected"},
      {with("\"UnstructuredGrid\"", "\"PolyData\""), "VTKFile of the type UnstructuredGrid is"},
      {"<VTKFile type=\"UnstructuredGrid\"/>", "file: it has no array Points"}};
  for (const auto& [bytes, message] : cases) expect_says(vtu_message(bytes), message);
}

TEST(VtuReader, RefusesBrokenArrays) {
  const std::string type = "type=\"UnstructuredGrid\"";
  const std::pair<std::string, std::string> cases[] = {
      // attributes of the root
      {with(type, type + " byte_order=\"x\""), "file:1: byte_order is unknown"},
      {with(type, type + " header_type=\"UInt16\""), "file:1: header_type is unknown"},
      {with(type, type + " compressor=\"vtkLZ4DataCompressor\""), "packed by vtkLZ4DataCompressor"},
      // counts
      {with("=\"4\"", "=\"-4\""), "file:3: NumberOfPoints must be an integer from 0 to 2147483646"},
      {with("=\"4\"", "=\"2147483647\""), "NumberOfPoints must be an integer from 0"},
      {with("=\"4\"", "=\"2000000000\""), "6000000000 numbers of Points are claimed"},
      {with("NumberOfCells=\"1\"", ""), "NumberOfCells must be an integer"},
      {with("NumberOfCells=\"1\"", "NumberOfCells=\"2000000000\""), "numbers of offsets are"},
      {with("=\"4\"", "=\"3\""), "file:5: more than 9 numbers of Points"},
      {with("</Piece>", "</Piece><Piece NumberOfPoints=\"0\" NumberOfCells=\"0\"/>"),
       "file:12: more than one piece is not read"},
      // arrays
      {with("</Points>", "<DataArray type=\"Int8\"/></Points>"), "file:6: a second array Points"},
      {with("Float64", "Bit"), "file:5: numbers of type \"Bit\" are not read"},
      {with("Components=\"3\"", "Components=\"2\""), "file:5: it has 2 components"},
      {with("Name=\"types\"", "Name=\"kinds\""), "file: it has no array types"},
      {with("Name=\"types\"", "Name=\"types\" format=\"x\""),
       "file:10: format must be ascii, binary"},
      // values
      {with("0 0 1<", "0 0 nan<"), "file:5: a coordinate of a point is not finite"},
      {with("0 0 1<", "0 0 -1e400<"), "a coordinate of a point is not finite"},
      {with("0 0 1<", "0 0 one<"), "must be a number, not \"one\""},
      {with("0 0 1<", "0 0<"),
       "file:5: 12 numbers of Points are claimed but only 21 bytes are left"},
      {with("0 0 1<", "0.000 0<"), "file:5: the file ends where a coordinate of a point should be"},
      {with("0 1 2 3<", "0 1 2 4<"), "file:8: the point of a cell must be from 0 to 3, not 4"},
      {with("0 1 2 3<", "0 1 2 -1<"), "must be from 0 to 3, not -1"},
      {with(">4<", ">-4<"), "-4 numbers of connectivity are claimed"},
      {with(">4<", ">3<"), "file:8: more than 3 numbers of connectivity"},
      {with(">4<", ">4000000000000<"), "4000000000000 numbers of connectivity are claimed"},
      {with(">10<", ">72<"), "cell 0 (counted from 0) is of type 72 (unknown)"},
      {with(">10<", ">24<"), "is a tetrahedron of 10 points, but has 4"}};
  for (const auto& [bytes, message] : cases) expect_says(vtu_message(bytes), message);
}

/// The types as bytes, inline or appended.
std::string with_types(const std::string& root, const std::string& attributes,
                       const std::string& text, const std::string& appended = "") {
  std::string file = with(">10</DataArray>", ' ' + attributes + '>' + text + "</DataArray>");
  file.insert(8, ' ' + root + ' ');
  file.insert(file.find("</VTKFile>"), appended);
  return file;
}

TEST(VtuReader, ReadsOneArrayOfEachEncoding) {
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  const std::string raw = "<AppendedData encoding=\"raw\">_";
  const std::string inner = "format=\"binary\"", outer = "format=\"appended\" offset=\"1\"";
  const std::string header("\1\0\0\0", 4);
  const std::string good[] = {
      with_types("", inner, test::base64(header + "\n")),
      with_types("", inner, " AQ AA\nAA== Cg==\n"),  // header and bytes padded each for itself
      with_types("", outer, "", raw + "x" + header + "\n</AppendedData>")};
  for (const std::string& file : good) EXPECT_EQ(parse_tets(file, "f").elements.rows(), 1);

  // damaged base64, headers, offsets and packed blocks
  const std::pair<std::string, std::string> cases[] = {
      {with_types("", inner, test::base64(header)), "fewer bytes are there than its header claims"},
      {with_types("", inner, ""), "file:10: the array types: fewer bytes"},
      {with_types("", inner, "AQAA*AK="), "its base64 is damaged"},
      {with_types("", inner, "A=AAAAK="), "its base64 is damaged"},
      {with_types("", inner, "AQ=A AAK="), "its base64 is damaged"},
      {with_types("", inner, "//// //8="), "fewer bytes are there than its header claims"},
      {with_types("", inner, test::base64(std::string("\2\0\0\0\n\n", 6))),
       "file:10: the array types: byte 0: more than 1 numbers of types"},
      {with_types("header_type=\"UInt64\"", inner, test::base64(std::string(8, '\xff'))),
       "the header is 18446744073709551615"},
      {with_types("", outer, ""), "it begins behind the end of the appended data"},
      {with_types("", "format=\"appended\" offset=\"-1\"", ""), "offset must be an integer from 0"},
      {with_types("", "format=\"appended\"", ""), "offset must be an integer from 0"},
      {with_types("", "format=\"appended\" offset=\"9999999\"", "", raw + "</AppendedData>"),
       "it begins behind the end of the appended data"},
      {with_types("", outer, "", raw + "x"), "fewer bytes are there"},
      {with_types("", outer, "", "<AppendedData encoding=\"hex\">_"), "must be raw or base64"},
      {with_types("", outer, "", "<AppendedData encoding=\"raw\">  x"),
       "appended data begin with _"},
      {with_types(zlib, inner, test::base64(header + header)), "fewer bytes are there"},
      {with_types(zlib, inner, test::base64("\xff\xff\xff\x7f" + header + header)),
       "more blocks are claimed than the file has bytes for"},
      {with_types(zlib, inner, test::base64(header + "\xff\xff\xff\x7f" + std::string(8, '\0'))),
       "it would unpack to more than 100 times the file"},
      {with_types(zlib, inner, test::base64(header + header + std::string(4, '\0') + header + "x")),
       "a packed block is damaged"}};
  for (const auto& [bytes, message] : cases) expect_says(vtu_message(bytes), message);
}

TEST(VtuReader, RefusesBlocksThatUnpackToAnotherSize) {
  std::string packed(100, '\0');
  auto size = uLongf(packed.size());
  compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>("\n\n"),
           2);
  packed.resize(size);
  const std::string zlib = "compressor=\"vtkZLibDataCompressor\"";
  for (const char length : {1, 3}) {
    const std::string head{1, 0, 0, 0, length, 0, 0, 0, 0, 0, 0, 0, char(size), 0, 0, 0};
    expect_says(vtu_message(with_types(zlib, "format=\"binary\"", test::base64(head + packed))),
                "a packed block is damaged");
  }
}

}  // namespace
}  // namespace elastogen::tets
