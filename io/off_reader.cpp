// SPDX-License-Identifier: Apache-2.0
#include "io/off_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/face_list.hpp"
#include "io/polygon.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <filesystem>

namespace elastogen {
namespace {

constexpr std::array<float, 4> kNoColour = {-1, -1, -1, -1};
constexpr int64_t kMaxOffCount = std::numeric_limits<int32_t>::max();

class OffParser {
 public:
  OffParser(std::string_view bytes, const std::string& path)
      : rest_(without_mark(bytes)), path_(path) {
    asset_.path = path;
    asset_.format = "off";
  }

  Asset parse() {
    read_keyword();
    if (current_.empty()) begin_line("counts");
    const int64_t vertices = integer("the number of vertices", kMaxOffCount);
    const int64_t faces = integer("the number of faces", kMaxOffCount);
    const int64_t left = int64_t(rest_.size()) + 1;  // the last line may lack its end
    check(vertices <= left / 6 && faces <= left / 2, vertices, " vertices and ", faces,
          " faces are claimed but only ", rest_.size(), " bytes follow");

    Mesh& mesh = asset_.meshes.emplace_back();
    for (int64_t i = 0; i < vertices; ++i) read_vertex(mesh);
    for (int64_t i = 0; i < faces; ++i) read_face(mesh);
    mesh.colour = linear(std::move(vertex_colours_));
    if (std::ranges::find(coloured_, 1) != coloured_.end())
      faces_.colour = linear(std::move(face_colours_));
    add_faces(faces_, mesh, asset_);
    mesh.name = std::filesystem::path(path_).stem().string();
    asset_.nodes.push_back({mesh.name, -1, kIdentity4, 0});
    return std::move(asset_);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, path_, ':', line_, ": ", parts...);
  }

  /// Goes to the next line that has more than a comment.
  void begin_line(const char* expected) {
    do {
      check(!rest_.empty(), "the file ends where ", expected, " should be");
      ++line_;
      const std::string_view line = next_line(rest_);
      current_ = trimmed(line.substr(0, line.find('#')));
    } while (current_.empty());
  }

  /// Reads the keyword; counts may follow it without a blank.
  void read_keyword() {
    begin_line("OFF");
    std::string_view rest = current_;
    const auto take = [&](std::string_view prefix) {
      const bool found = rest.starts_with(prefix);
      if (found) rest.remove_prefix(prefix.size());
      return found;
    };
    has_uv_ = take("ST");
    has_colour_ = take("C");
    has_normal_ = take("N");
    check(!rest.starts_with('4') && !rest.starts_with('n'),
          "points of another dimension than three are not read");
    check(take("OFF"), "an OFF file begins with OFF or [ST][C][N]OFF");
    current_ = trimmed(rest);
    check(!current_.starts_with("BINARY"), "binary OFF is not read; save it as text");
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

  void read_vertex(Mesh& mesh) {
    begin_line("a vertex");
    // position and normal always have three numbers
    const double x = number(), y = number(), z = number();
    mesh.position.push_back({x, y, z});
    if (has_normal_) {
      const double nx = number(), ny = number(), nz = number();
      mesh.normal.push_back({float(nx), float(ny), float(nz)});
    }
    // of the numbers left the last two are the texture's, those before them the colour
    std::vector<double> left;
    while (!current_.empty()) left.push_back(number()), current_ = trimmed(current_);
    const size_t uvs = has_uv_ && !left.empty() ? 2 : 0;
    const size_t colours = left.size() - std::min(uvs, left.size());
    check(left.size() >= uvs && (!has_colour_ || colours == 0 || colours == 3 || colours == 4),
          "a vertex has ", left.size(), " numbers behind position and normal, ",
          has_colour_ ? "three or four of a colour" : "", has_colour_ && has_uv_ ? " and " : "",
          has_uv_ ? "two of a texture" : "", " are expected");
    // colours wait until the range of all is known
    if (has_colour_)
      vertex_colours_.push_back(colours > 0 ? colour_of(left.data(), colours) : kNoColour);
    if (has_uv_) {
      const double* uv = left.data() + left.size() - uvs;
      mesh.uv.push_back(uvs > 0 ? std::array{float(uv[0]), 1 - float(uv[1])}
                                : std::array<float, 2>{});
    }
    if (!has_colour_ && colours > 0)
      add_finding(asset_, "left-out-properties", 1,
                  "vertices have more numbers than the keyword of the file says");
  }

  static std::array<float, 4> colour_of(const double* value, size_t count) {
    std::array<float, 4> colour = {0, 0, 0, -1};  // -1: opaque, whatever the range is
    for (size_t k = 0; k < count; ++k) colour[k] = float(std::max(value[k], 0.));
    return colour;
  }

  void read_face(const Mesh& mesh) {
    begin_line("a face");
    const int64_t n = integer("the number of corners", kMaxPolygonCorners + 1);
    for (int64_t c = 0; c < n; ++c)
      faces_.corner.push_back(
          int32_t(integer("an index of a vertex", int64_t(mesh.position.size()))));
    faces_.length.push_back(int32_t(n));
    double value[4];
    size_t count = 0;
    for (std::string_view word = next_word(current_); !word.empty(); word = next_word(current_)) {
      const std::optional<double> v = to_double(word);
      check(v.has_value() && std::isfinite(*v) && count < 4,
            "a face's colour of up to four numbers is expected, not \"", word.substr(0, 40), '"');
      value[count++] = *v;
    }
    coloured_.push_back(count >= 3);
    face_colours_.push_back(count >= 3 ? colour_of(value, count) : kNoColour);
    if (count == 1 || count == 2)
      add_finding(asset_, "left-out-properties", 1,
                  "faces name a colour by its number in a table that is not in the file");
  }

  /// Turns sRGB into linear RGBA. The range is 0 ... 255, or 0 ... 1 if none of these numbers is
  /// larger. Vertices or faces without a colour become white.
  static std::vector<std::array<float, 4>> linear(std::vector<std::array<float, 4>> colours) {
    float largest = 0;
    for (const auto& c : colours) largest = std::max(largest, *std::ranges::max_element(c));
    const double range = largest > 1 ? 255 : 1;
    for (auto& c : colours)
      for (size_t k = 0; k < 4; ++k) {
        const double share = c[k] < 0 ? 1 : std::min(double(c[k]) / range, 1.);
        c[k] = k < 3 ? linear_from_srgb(share) : float(share);
      }
    return colours;
  }

  std::string_view rest_, current_;  ///< lines that follow, rest of the current one
  const std::string& path_;
  int64_t line_ = 0;
  Asset asset_;
  bool has_uv_ = false, has_colour_ = false, has_normal_ = false;
  FaceList faces_;
  std::vector<uint8_t> coloured_;  ///< of each face: 1 if it has a colour
  std::vector<std::array<float, 4>> vertex_colours_, face_colours_;  ///< as the file has them
};

}  // namespace

Asset parse_off(std::string_view bytes, const std::string& path) {
  return OffParser(bytes, path).parse();
}

Asset read_off(const std::string& path) {
  return parse_off(read_file(path), path);
}

}  // namespace elastogen
