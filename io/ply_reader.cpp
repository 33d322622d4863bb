// SPDX-License-Identifier: Apache-2.0
#include "io/ply_reader.hpp"

#include "io/asset_check.hpp"
#include "io/byte_reader.hpp"
#include "io/flat_stream.hpp"
#include "io/ply_faces.hpp"
#include "io/ply_splats.hpp"
#include "io/ply_values.hpp"
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
    // what the header says
    const bool has_faces = check_faces();
    if (!header_.skipped.empty())
      add_finding(asset_, "header-lines", int64_t(header_.skipped.size()),
                  "lines of the header begin with no word of a header, the first with " +
                      shown_line(header_.skipped[0]));
    // splats are told by their columns
    if (!has_faces && is_splats(header_)) {
      asset_.splats = read_splats(header_, values_, options_.splat_scales, asset_);
      return std::move(asset_);
    }
    // the first elements vertex and face count, others are passed over
    Mesh& mesh = asset_.meshes.emplace_back();
    FaceList faces;
    for (const PlyElement& element : header_.elements) {
      if (element.name == "vertex" && mesh.position.empty()) {
        read_vertices(element, mesh, has_faces);
      } else if (element.name == "face" && faces.length.empty()) {
        faces = read_ply_faces(element, header_.textures.size(), values_, asset_.path, left_out_);
      } else {
        values_.skip(element);
        if (element.count > 0) left_out_.push_back(element.name);
      }
    }
    // vertices without faces are a point cloud
    if (has_faces) return as_mesh(mesh, faces);
    return as_points(mesh);
  }

 private:
  Asset as_mesh(Mesh& mesh, const FaceList& faces) {
    for (const std::string& texture : header_.textures) add_material(texture);
    add_faces(faces, mesh, asset_);
    mesh.name = std::filesystem::path(asset_.path).stem().string();
    asset_.nodes.push_back({mesh.name, -1, kIdentity4, 0});
    add_finding(asset_, "left-out-properties", int64_t(left_out_.size()),
                "properties or elements of the file mean nothing here: " + list_of(left_out_));
    add_finding(asset_, "extra-bytes", values_.left(), "bytes follow the last element of the file");
    return std::move(asset_);
  }

  Asset as_points(Mesh& mesh) {
    asset_.points.emplace();
    asset_.points->position.swap(mesh.position);
    asset_.points->normal.swap(mesh.normal);
    asset_.points->colour.swap(mesh.colour);
    take_own_columns(mesh, asset_.points->own);
    asset_.meshes.clear();
    note_own_columns(asset_, asset_.points->own);
    note_lost_columns(asset_, left_out_);
    return std::move(asset_);
  }

  static void take_own_columns(const Mesh& mesh, OwnColumns& own) {
    for (const OwnColumn& column : mesh.own) own.columns.push_back({column.name, column.type});
    for (size_t p = 0; !mesh.own.empty() && p < mesh.own[0].value.size(); ++p)
      for (size_t k = 0; k < mesh.own.size(); ++k) own.add(k, mesh.own[k].value[p]);
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
    int position[3], normal[3], uv[2];
  };

  Columns columns_of(const PlyElement& vertex) const {
    const Columns c = {{vertex.find({"x"}), vertex.find({"y"}), vertex.find({"z"})},
                       {vertex.find({"nx"}), vertex.find({"ny"}), vertex.find({"nz"})},
                       {vertex.find({"s", "u", "texture_u", "texture_s"}),
                        vertex.find({"t", "v", "texture_v", "texture_t"})}};
    for (const int k : c.position)
      ELASTOGEN_CHECK_ASSET(k >= 0, asset_.path, ": its vertices have no x, y, z");
    for (const PlyProperty& p : vertex.properties)
      ELASTOGEN_CHECK_ASSET(!p.is_list || (p.name != "x" && p.name != "y" && p.name != "z"),
                            asset_.path, ": the property ", p.name, " of a vertex is a list");
    return c;
  }

  void read_vertices(const PlyElement& vertex, Mesh& mesh, bool is_mesh) {
    const Columns c = columns_of(vertex);
    const auto all = [](const int* column, int n) {
      return std::all_of(column, column + n, [](int k) { return k >= 0; });
    };
    const bool normals = all(c.normal, 3), uvs = all(c.uv, 2);
    const PlyColour colour(vertex);
    const std::vector<int> own = own_columns(vertex, c, is_mesh, mesh);
    std::vector<double> row;
    for (int64_t i = 0; i < vertex.count; ++i) {
      values_.next_row(vertex, row);
      const auto at = [&](int k) { return row[size_t(k)]; };
      mesh.position.push_back({at(c.position[0]), at(c.position[1]), at(c.position[2])});
      if (normals)
        mesh.normal.push_back(
            {float(at(c.normal[0])), float(at(c.normal[1])), float(at(c.normal[2]))});
      if (uvs) mesh.uv.push_back({float(at(c.uv[0])), 1 - float(at(c.uv[1]))});
      if (colour.is_there()) mesh.colour.push_back(colour.of(row));
      for (size_t k = 0; k < own.size(); ++k) mesh.own[k].value.push_back(at(own[k]));
    }
  }

  /// Columns of numbers that mean nothing here and are carried; lists are left out.
  std::vector<int> own_columns(const PlyElement& vertex, const Columns& c, bool is_mesh,
                               Mesh& mesh) {
    std::vector<int> own;
    const PlyColour colour(vertex);
    const auto is_in = [](const auto& columns, int k) {
      return std::ranges::find(columns, k) != std::end(columns) &&
             std::ranges::find(columns, -1) == std::end(columns);
    };
    for (int k = 0; k < int(vertex.properties.size()); ++k) {
      const PlyProperty& property = vertex.properties[size_t(k)];
      if (is_in(c.position, k) || is_in(c.normal, k) || colour.has(k)) continue;
      if (is_mesh && is_in(c.uv, k)) continue;
      if (property.is_list) {
        left_out_.push_back(is_mesh ? "vertex." + property.name : property.name);
        continue;
      }
      own.push_back(k);
      mesh.own.push_back({property.name, property.type, {}});
    }
    return own;
  }

  void add_material(const std::string& texture) {
    AssetMaterial& material = asset_.materials.emplace_back();
    material.name = texture;
    material.base_colour = {1, 1, 1, 1};
    material.texture = resolve_beside(asset_.path, texture);
    if (material.texture.empty())
      add_finding(asset_, "missing-texture", 1,
                  "the texture " + texture + " is not beside the asset");
  }

  static std::string list_of(const std::vector<std::string>& names) {
    std::string list;
    for (const std::string& name : names) list += (list.empty() ? "" : ", ") + shown_line(name);
    return list;
  }

  const ReadOptions& options_;
  PlyHeader header_;
  Asset asset_;
  PlyValues values_;
  std::vector<std::string> left_out_;
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
