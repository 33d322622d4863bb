// SPDX-License-Identifier: Apache-2.0
#include "io/obj_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/mtl_reader.hpp"
#include "io/obj_nodes.hpp"
#include "io/polygon.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <unordered_map>

namespace elastogen {
namespace {

constexpr size_t kMaxLibraryLine = 4096, kMaxLibraries = 1000;

constexpr const char* kIndexNames[3] = {"vertex", "texture", "normal"};
constexpr int64_t kMaxObjCount = std::numeric_limits<int32_t>::max();

class ObjParser {
 public:
  ObjParser(std::string_view text, const std::string& path) : text_(without_mark(text)) {
    asset_.path = path;
    asset_.format = "obj";
  }

  Asset parse() {
    std::string_view line;
    while (next_statement(line)) read_statement(line);
    for (const ObjFace& face : shape_.faces) check_indices(face);
    if (shape_.faces.empty()) nodes_.node();
    build_obj_meshes(std::move(shape_), asset_);
    read_materials();
    return std::move(asset_);
  }

 private:
  // --- lines

  /// The next line with its continuations; line_ is the number of its first.
  bool next_statement(std::string_view& line) {
    if (text_.empty()) return false;
    line_ = ++lines_;
    line = next_line(text_);
    if (!line.ends_with('\\')) return true;
    joined_.clear();
    while (line.ends_with('\\')) {
      joined_.append(line.substr(0, line.size() - 1)) += ' ';
      line = next_line(text_);
      ++lines_;
    }
    line = joined_.append(line);
    return true;
  }

  template <class... Parts>
  void check(bool condition, int64_t line, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, asset_.path, ':', line, ": ", parts...);
  }

  void read_statement(std::string_view line) {
    check(line.find('\0') == line.npos, line_, "a zero byte: this is no text");
    const std::string_view keyword = next_word(line);
    // attributes of vertices; textures run down here
    if (keyword == "v") {
      read_position(line);
    } else if (keyword == "vt") {
      const auto [v, n] = read_numbers(line, 1);
      shape_.uv.push_back({float(v[0]), 1 - float(v[1])});
    } else if (keyword == "vn") {
      const auto [v, n] = read_numbers(line, 3);
      shape_.normal.push_back({float(v[0]), float(v[1]), float(v[2])});
    } else if (keyword == "f" || keyword == "fo") {
      // faces
      read_face(line);
    } else if (keyword == "usemtl") {
      // materials, objects and groups
      use_material(std::string(trimmed(line)));
    } else if (keyword == "mtllib") {
      add_library(trimmed(line));
    } else if (keyword == "o") {
      nodes_.begin_object(trimmed(line));
    } else if (keyword == "g") {
      nodes_.begin_group(trimmed(line));
    } else if (keyword == "surf" || keyword == "curv") {
      // free-form geometry is only noticed, other keywords are ignored
      add_finding(asset_, "free-form", 1, "curves and surfaces are no polygons");
    }
  }

  /// Reads up to seven numbers; returns them and their count.
  std::pair<std::array<double, 7>, int> read_numbers(std::string_view line, int least) const {
    std::array<double, 7> value = {};
    int n = 0;
    for (std::string_view w = next_word(line); n < 7 && !w.empty() && w[0] != '#';
         w = next_word(line)) {
      const std::optional<double> number = to_double(w);
      check(number.has_value(), line_, "a number is expected, not \"", w.substr(0, 40), '"');
      value[n++] = *number;
    }
    check(n >= least, line_, least, " numbers are expected, there are ", n);
    return {value, n};
  }

  // --- statements

  void read_position(std::string_view line) {
    const auto [v, n] = read_numbers(line, 3);
    check(int64_t(shape_.position.size()) < kMaxObjCount, line_, "too many vertices");
    shape_.position.push_back({v[0], v[1], v[2]});
    if (n < 6) return;
    // colours behind positions: white up to here
    shape_.colour.resize(shape_.position.size() - 1, {1, 1, 1, 1});
    std::array<float, 4> c = {0, 0, 0, 1};
    for (int k = 0; k < 3; ++k) c[k] = linear_from_srgb(std::clamp(v[3 + k], 0., 1.));
    shape_.colour.push_back(c);
  }

  void read_face(std::string_view line) {
    ObjFace face{int64_t(shape_.corners.size()), 0, int32_t(line_), material_, 0};
    for (std::string_view w = next_word(line); !w.empty() && w[0] != '#'; w = next_word(line)) {
      shape_.corners.push_back(read_corner(w));
      check(++face.corners <= kMaxPolygonCorners, line_, "a face has more than ",
            kMaxPolygonCorners, " corners; save it as triangles");
    }
    check(int64_t(shape_.corners.size() + shape_.position.size()) < kMaxObjCount, line_,
          "too many corners");
    if (face.corners >= 3) {
      face.node = nodes_.node();
      shape_.faces.push_back(face);
      return;
    }
    shape_.corners.resize(size_t(face.first));
    add_finding(asset_, "short-face", 1, "faces have fewer than three corners");
  }

  /// "v", "v/t", "v//n" or "v/t/n"; counted from 1, or from the last one back if negative.
  ObjCorner read_corner(std::string_view word) const {
    ObjCorner corner = {-1, -1, -1};
    const size_t counts[3] = {shape_.position.size(), shape_.uv.size(), shape_.normal.size()};
    std::string_view rest = word;
    bool more = true;
    for (int k = 0; k < 3 && more; ++k) {
      const std::string_view part = rest.substr(0, rest.find('/'));
      more = part.size() < rest.size();
      rest.remove_prefix(part.size() + (more ? 1 : 0));
      if (part.empty() && k > 0) continue;
      const std::optional<int64_t> i = to_integer(part);
      check(i.has_value(), line_, "a corner is expected, not \"", word.substr(0, 40), '"');
      const int64_t index = *i < 0 ? int64_t(counts[k]) + *i : *i - 1;
      check(index >= 0 && index < kMaxObjCount, line_, kIndexNames[k], " index ", *i,
            " is out of range, there are ", counts[k], " so far");
      corner[k] = int32_t(index);
    }
    check(!more, line_, "a corner is expected, not \"", word.substr(0, 40), '"');
    return corner;
  }

  void use_material(const std::string& name) {
    material_ = -1;
    if (name.empty()) return;
    const auto [entry, is_new] = material_of_.try_emplace(name, int32_t(asset_.materials.size()));
    if (is_new) asset_.materials.emplace_back().name = name;
    material_ = entry->second;
  }

  // --- the mesh

  void check_indices(const ObjFace& face) const {
    const size_t counts[3] = {shape_.position.size(), shape_.uv.size(), shape_.normal.size()};
    for (int32_t c = 0; c < face.corners; ++c)
      for (int k = 0; k < 3; ++k) {
        const int32_t i = shape_.corners[size_t(face.first + c)][k];
        check(i < int64_t(counts[k]), face.line, kIndexNames[k], " index ", int64_t(i) + 1,
              " is out of range, the file has ", counts[k]);
      }
  }

  /// Limits the number of lines, because each costs a look into the file system.
  void add_library(std::string_view names) {
    check(names.size() <= kMaxLibraryLine, line_, "the names of material files take ", names.size(),
          " bytes, at most ", kMaxLibraryLine, " are read");
    if (!libraries_.empty() && libraries_.back() == names) return;
    check(libraries_.size() < kMaxLibraries, line_, "more than ", kMaxLibraries, " material files");
    libraries_.emplace_back(names);
  }

  /// The names on an mtllib line are one name with blanks, or several names.
  void read_materials() {
    for (const std::string& library : libraries_) {
      if (read_mtl(asset_, library)) continue;
      std::string_view rest = library;
      for (std::string_view w = next_word(rest); !w.empty(); w = next_word(rest))
        if (!read_mtl(asset_, std::string(w)))
          add_finding(asset_, "missing-material-file", 1,
                      "the material file " + library + " is not beside the asset");
    }
  }

  std::string_view text_;
  std::string joined_;
  int64_t lines_ = 0, line_ = 0;
  Asset asset_;
  ObjShape shape_;
  ObjNodes nodes_{asset_};
  std::vector<std::string> libraries_;
  std::unordered_map<std::string, int32_t> material_of_;
  int32_t material_ = -1;
};

}  // namespace

Asset parse_obj(std::string_view bytes, const std::string& path) {
  return ObjParser(bytes, path).parse();
}

Asset read_obj(const std::string& path) {
  return parse_obj(read_file(path), path);
}

}  // namespace elastogen
