// SPDX-License-Identifier: Apache-2.0
#include "io/off_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/polygon.hpp"
#include "io/safe_file.hpp"

#include <filesystem>

namespace elastogen {
namespace {

constexpr int64_t kMaxOffCount = std::numeric_limits<int32_t>::max();

class OffParser {
 public:
  OffParser(std::string_view bytes, const std::string& path)
      : rest_(without_mark(bytes)), path_(path) {
    asset_.path = path;
    asset_.format = "off";
  }

  Asset parse() {
    const bool has_normals = read_keyword();
    if (current_.empty()) begin_line("counts");
    const int64_t vertices = integer("the number of vertices", kMaxOffCount);
    const int64_t faces = integer("the number of faces", kMaxOffCount);
    const int64_t left = int64_t(rest_.size()) + 1;  // the last line may lack its end
    check(vertices <= left / 6 && faces <= left / 2, vertices, " vertices and ", faces,
          " faces are claimed but only ", rest_.size(), " bytes follow");

    Mesh& mesh = asset_.meshes.emplace_back();
    for (int64_t i = 0; i < vertices; ++i) read_vertex(mesh, int32_t(i), has_normals);
    TriangleGroup& group = mesh.groups.emplace_back();
    for (int64_t i = 0; i < faces; ++i) read_face(mesh, group);
    mesh.name = std::filesystem::path(path_).stem().string();
    asset_.nodes.push_back({mesh.name, -1, kIdentity4, 0});
    return std::move(asset_);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ':', line_, ": ", parts...);
  }

  /// Goes to the next line that is more than a comment.
  void begin_line(const char* expected) {
    do {
      check(!rest_.empty(), "the file ends where ", expected, " should be");
      ++line_;
      const std::string_view line = next_line(rest_);
      current_ = trimmed(line.substr(0, line.find('#')));
    } while (current_.empty());
  }

  /// Takes the keyword; counts may be glued to it. @return whether vertices have normals.
  bool read_keyword() {
    begin_line("OFF");
    std::string_view rest = current_;
    const auto take = [&](std::string_view prefix) {
      const bool found = rest.starts_with(prefix);
      if (found) rest.remove_prefix(prefix.size());
      return found;
    };
    take("ST");
    take("C");
    const bool has_normals = take("N");
    check(!rest.starts_with('4') && !rest.starts_with('n'),
          "points of another dimension than three are not read");
    check(take("OFF"), "an OFF file begins with OFF, COFF, NOFF or CNOFF");
    current_ = trimmed(rest);
    check(!current_.starts_with("BINARY"), "binary OFF is not read; save it as text");
    return has_normals;
  }

  int64_t integer(const char* what, int64_t limit) {
    const std::string_view word = next_word(current_);
    const std::optional<int64_t> value = to_integer(word);
    check(value && *value >= 0 && *value < limit, what, " must be an integer from 0 to ", limit - 1,
          ", not \"", word.substr(0, 40), '"');
    return *value;
  }

  double number() {
    const std::string_view word = next_word(current_);
    const std::optional<double> value = to_double(word);
    check(value.has_value(), "a number is expected, not \"", word.substr(0, 40), '"');
    return *value;
  }

  void read_vertex(Mesh& mesh, int32_t index, bool has_normal) {
    begin_line("a vertex");
    const double x = number(), y = number(), z = number();
    mesh.position.push_back({x, y, z});
    mesh.position_of.push_back(index);
    if (!has_normal) return;
    const double nx = number(), ny = number(), nz = number();
    mesh.normal.push_back({float(nx), float(ny), float(nz)});
  }

  void read_face(const Mesh& mesh, TriangleGroup& group) {
    begin_line("a face");
    const int64_t n = integer("the number of corners", kMaxPolygonCorners + 1);
    std::vector<int32_t> corner;
    std::vector<Vec3> polygon;
    for (int64_t c = 0; c < n; ++c) {
      corner.push_back(int32_t(integer("an index of a vertex", int64_t(mesh.position.size()))));
      polygon.push_back(mesh.position[size_t(corner.back())]);
    }
    if (n < 3) add_finding(asset_, "short-face", 1, "faces have fewer than three corners");
    for (const int c : triangulate(polygon)) group.corner.push_back(corner[size_t(c)]);
  }

  std::string_view rest_, current_;  ///< lines to come, what is left of this one
  const std::string& path_;
  int64_t line_ = 0;
  Asset asset_;
};

}  // namespace

Asset parse_off(std::string_view bytes, const std::string& path) {
  return OffParser(bytes, path).parse();
}

Asset read_off(const std::string& path) {
  return parse_off(read_file(path), path);
}

}  // namespace elastogen
