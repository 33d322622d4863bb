// SPDX-License-Identifier: Apache-2.0
#include "io/ply_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/ply_splats.hpp"
#include "io/ply_values.hpp"
#include "io/polygon.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <filesystem>

namespace elastogen {
namespace {

class PlyParser {
 public:
  PlyParser(std::string_view bytes, const std::string& path, const ReadOptions& options)
      : options_(options),
        header_(read_ply_header(bytes, path)),
        values_(bytes.substr(header_.bytes), header_, path) {
    asset_.path = path;
    asset_.format = "ply";
  }

  Asset parse() {
    const bool has_faces = check_faces();
    if (!has_faces && is_splats(header_)) {
      asset_.splats = read_splats(header_, values_, options_.splat_scales, asset_);
      return std::move(asset_);
    }
    Mesh& mesh = asset_.meshes.emplace_back();
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex" && mesh.position.empty()) {
        if (!has_faces) begin_own_columns(element);
        read_vertices(element, mesh);
      } else if (element.name == "face") {
        read_faces(element);
      } else {
        values_.skip(element);
      }
    }
    return has_faces ? as_mesh(mesh) : as_points(mesh);
  }

 private:
  Asset as_mesh(Mesh& mesh) {
    build_triangles(mesh);
    mesh.name = std::filesystem::path(asset_.path).stem().string();
    asset_.nodes.push_back({mesh.name, -1, kIdentity4, 0});
    return std::move(asset_);
  }

  Asset as_points(Mesh& mesh) {
    asset_.points.emplace();
    asset_.points->position.swap(mesh.position);
    asset_.points->normal.swap(mesh.normal);
    asset_.points->colour.swap(mesh.colour);
    asset_.points->own = std::move(own_values_);
    asset_.meshes.clear();
    return std::move(asset_);
  }

  bool check_faces() const {
    for (const PlyElement& element : header_.elements) {
      if (element.name == "face" && element.count > 0) return true;
      ELASTOGEN_CHECK_ASSET(element.name != "tristrips", asset_.path,
                            ": triangle strips are not read; save it with faces");
    }
    return false;
  }

  /// Where the known properties of a vertex stand in its row, -1 for none.
  struct Columns {
    int position[3], normal[3], uv[2], colour[4];
  };

  Columns columns_of(const PlyElement& vertex) const {
    const Columns c = {{vertex.find({"x"}), vertex.find({"y"}), vertex.find({"z"})},
                       {vertex.find({"nx"}), vertex.find({"ny"}), vertex.find({"nz"})},
                       {vertex.find({"s", "u", "texture_u", "texture_s"}),
                        vertex.find({"t", "v", "texture_v", "texture_t"})},
                       {vertex.find({"red", "r"}), vertex.find({"green", "g"}),
                        vertex.find({"blue", "b"}), vertex.find({"alpha", "a"})}};
    for (const int k : c.position)
      ELASTOGEN_CHECK_ASSET(k >= 0, asset_.path, ": its vertices have no x, y, z");
    for (const PlyProperty& p : vertex.properties)
      ELASTOGEN_CHECK_ASSET(!p.is_list || (p.name != "x" && p.name != "y" && p.name != "z"),
                            asset_.path, ": the property ", p.name, " of a vertex is a list");
    return c;
  }

  void read_vertices(const PlyElement& vertex, Mesh& mesh) {
    const Columns c = columns_of(vertex);
    const auto all = [](const int* column, int n) {
      return std::all_of(column, column + n, [](int k) { return k >= 0; });
    };
    std::vector<double> row;
    for (int64_t i = 0; i < vertex.count; ++i) {
      values_.next_row(vertex, row);
      const auto at = [&](int k) { return row[size_t(k)]; };
      mesh.position.push_back({at(c.position[0]), at(c.position[1]), at(c.position[2])});
      mesh.position_of.push_back(int32_t(i));
      if (all(c.normal, 3))
        mesh.normal.push_back(
            {float(at(c.normal[0])), float(at(c.normal[1])), float(at(c.normal[2]))});
      if (all(c.uv, 2)) mesh.uv.push_back({float(at(c.uv[0])), 1 - float(at(c.uv[1]))});
      if (all(c.colour, 3)) mesh.colour.push_back(colour_of(vertex, c.colour, row));
      for (size_t k = 0; k < own_.size(); ++k) own_values_.add(k, row[own_[k]]);
    }
  }

  /// Numbers of points that are neither places nor whole normals and colours.
  void begin_own_columns(const PlyElement& vertex) {
    const Columns c = columns_of(vertex);
    std::vector<int> known(c.position, c.position + 3);
    if (std::ranges::min(c.normal) >= 0) known.insert(known.end(), c.normal, c.normal + 3);
    if (std::min({c.colour[0], c.colour[1], c.colour[2]}) >= 0)
      known.insert(known.end(), c.colour, c.colour + 4);
    std::vector<std::string> lists;
    for (size_t k = 0; k < vertex.properties.size(); ++k) {
      const PlyProperty& property = vertex.properties[k];
      if (std::ranges::count(known, int(k)) > 0) continue;
      if (property.is_list) {
        lists.push_back(property.name);
      } else {
        own_.push_back(k);
        own_values_.columns.push_back({property.name, property.type});
      }
    }
    note_own_columns(asset_, own_values_);
    note_lost_columns(asset_, lists);
  }

  static std::array<float, 4> colour_of(const PlyElement& vertex, const int* column,
                                        const std::vector<double>& row) {
    std::array<float, 4> colour = {0, 0, 0, 1};
    for (int k = 0; k < 4; ++k) {
      if (column[k] < 0) continue;
      const double value = row[size_t(column[k])];
      const double range = colour_range(vertex.properties[size_t(column[k])].type);
      const double share = std::clamp(range > 0 ? value / range : value, 0., 1.);
      colour[size_t(k)] = range > 0 && k < 3 ? linear_from_srgb(share) : float(share);
    }
    return colour;
  }

  void read_faces(const PlyElement& face) {
    const int column = face.find({"vertex_indices", "vertex_index"});
    ELASTOGEN_CHECK_ASSET(column >= 0 && face.properties[size_t(column)].is_list, asset_.path,
                          ": its faces have no list vertex_indices");
    for (int64_t i = 0; i < face.count; ++i)
      for (int k = 0; k < int(face.properties.size()); ++k) {
        const PlyProperty& property = face.properties[size_t(k)];
        k == column ? read_face(property, i) : values_.skip(property);
      }
  }

  void read_face(const PlyProperty& list, int64_t face) {
    const int64_t n = values_.next_length(list);
    ELASTOGEN_CHECK_ASSET(n <= kMaxPolygonCorners, asset_.path, ": face ", face, " has ", n,
                          " corners, at most ", kMaxPolygonCorners,
                          " are read; save it as triangles");
    for (int64_t c = 0; c < n; ++c) {
      const double index = values_.next(list.type);
      ELASTOGEN_CHECK_ASSET(index >= 0 && index < 0x1p31 && index == std::floor(index), asset_.path,
                            ": face ", face, " has the vertex index ", index);
      corners_.push_back(int32_t(index));
    }
    lengths_.push_back(n);
  }

  /// After all elements, because faces may come before vertices.
  void build_triangles(Mesh& mesh) {
    TriangleGroup& group = mesh.groups.emplace_back();
    if (!header_.texture.empty()) add_material(group);
    std::vector<Vec3> polygon;
    const int32_t* corner = corners_.data();
    for (size_t face = 0; face < lengths_.size(); corner += lengths_[face++]) {
      const int64_t n = lengths_[face];
      for (int64_t c = 0; c < n; ++c)
        ELASTOGEN_CHECK_ASSET(corner[c] < int64_t(mesh.position.size()), asset_.path, ": face ",
                              face, " has the vertex index ", corner[c], ", the file has ",
                              mesh.position.size(), " vertices");
      if (n < 3) add_finding(asset_, "short-face", 1, "faces have fewer than three corners");
      polygon.clear();
      for (int64_t c = 0; c < n; ++c) polygon.push_back(mesh.position[size_t(corner[c])]);
      for (const int c : triangulate(polygon)) group.corner.push_back(corner[c]);
    }
  }

  void add_material(TriangleGroup& group) {
    group.material = 0;
    AssetMaterial& material = asset_.materials.emplace_back();
    material.name = header_.texture;
    material.base_colour = {1, 1, 1, 1};
    material.texture = resolve_beside(asset_.path, header_.texture);
    if (material.texture.empty())
      add_finding(asset_, "missing-texture", 1,
                  "the texture " + header_.texture + " is not beside the asset");
  }

  const ReadOptions& options_;
  PlyHeader header_;
  Asset asset_;
  PlyValues values_;
  std::vector<size_t> own_;  ///< columns of own_values_
  OwnColumns own_values_;
  std::vector<int32_t> corners_;
  std::vector<int64_t> lengths_;
};

}  // namespace

Asset parse_ply(std::string_view bytes, const std::string& path, const ReadOptions& options) {
  return PlyParser(without_mark(bytes), path, options).parse();
}

Asset parse_ply(std::string_view bytes, const std::string& path) {
  return parse_ply(bytes, path, {});
}

Asset read_ply(const std::string& path, const ReadOptions& options) {
  return parse_ply(read_file(path), path, options);
}

Asset read_ply(const std::string& path) {
  return read_ply(path, {});
}

}  // namespace elastogen
