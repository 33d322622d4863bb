// SPDX-License-Identifier: Apache-2.0
#include "io/obj_nodes.hpp"

#include "core/error.hpp"
#include "io/asset_check.hpp"
#include "io/drawn_vertices.hpp"
#include "io/polygon.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>

namespace elastogen {
namespace {

/// Builds the meshes one after the other; the cost of each depends on its own faces only.
class ObjMeshes {
 public:
  ObjMeshes(ObjShape shape, Asset& asset)
      : shape_(std::move(shape)), asset_(asset), place_(shape_.position.size(), -1) {
    if (!shape_.colour.empty()) shape_.colour.resize(shape_.position.size(), {1, 1, 1, 1});
    sort_faces();
  }

  void build() {
    const auto filled = std::ranges::count_if(faces_of_, [](const auto& f) { return !f.empty(); });
    bool is_first = true;
    for (size_t n = 0; n < asset_.nodes.size(); ++n) {
      if (faces_of_[n].empty() && filled > 0) continue;
      std::vector<int32_t> positions = filled > 1 ? positions_of(n, is_first) : all_positions();
      asset_.nodes[n].mesh = int(asset_.meshes.size());
      Mesh& mesh = asset_.meshes.emplace_back();
      mesh.name = asset_.nodes[n].name;
      fill(mesh, positions, faces_of_[n]);
      if (filled > 1) mesh.file_position = std::move(positions);
      is_first = false;
    }
  }

 private:
  using Faces = std::vector<size_t>;

  void sort_faces() {
    faces_of_.resize(asset_.nodes.size());
    for (size_t f = 0; f < shape_.faces.size(); ++f)
      faces_of_[size_t(shape_.faces[f].node)].push_back(f);
  }

  ObjCorner* corners_of(const ObjFace& face) { return &shape_.corners[size_t(face.first)]; }

  std::vector<int32_t> all_positions() const {
    std::vector<int32_t> all(shape_.position.size());
    std::iota(all.begin(), all.end(), 0);
    return all;
  }

  /// Positions that the faces of a node use, sorted.
  std::vector<int32_t> positions_of(size_t node, bool with_unused) {
    std::vector<int32_t> used;
    for (const size_t f : faces_of_[node])
      for (int32_t c = 0; c < shape_.faces[f].corners; ++c)
        used.push_back(corners_of(shape_.faces[f])[c][0]);
    if (with_unused) {
      std::vector<uint8_t> seen(shape_.position.size(), 0);
      for (const ObjCorner& corner : shape_.corners) seen[size_t(corner[0])] = 1;
      for (size_t p = 0; p < seen.size(); ++p)
        if (!seen[p]) used.push_back(int32_t(p));
    }
    std::ranges::sort(used);
    used.erase(std::unique(used.begin(), used.end()), used.end());
    return used;
  }

  void fill(Mesh& mesh, const std::vector<int32_t>& positions, const Faces& faces) {
    for (size_t k = 0; k < positions.size(); ++k) {
      place_[size_t(positions[k])] = int32_t(k);
      mesh.position.push_back(shape_.position[size_t(positions[k])]);
    }
    DrawnVertices<3> drawn(positions.size());
    int64_t with_uv = 0, without_normal = 0;
    for (const size_t f : faces) {
      const ObjFace& face = shape_.faces[f];
      for (int32_t c = 0; c < face.corners; ++c) {
        const ObjCorner& corner = corners_of(face)[c];
        with_uv += corner[1] >= 0;
        without_normal += corner[2] < 0;
        drawn({place_[size_t(corner[0])], corner[1], corner[2]});
      }
    }
    if (!shape_.normal.empty())
      add_finding(asset_, "missing-normals", without_normal,
                  "corners have no normal, the first in the mesh \"" + mesh.name + '"');
    fill_attributes(mesh, drawn, with_uv > 0, !shape_.normal.empty() && without_normal == 0);
    for (size_t v = 0; v < drawn.size() && !shape_.colour.empty(); ++v)
      mesh.colour.push_back(shape_.colour[size_t(positions[size_t(drawn.position(v))])]);
    fill_groups(mesh, drawn, faces);
  }

  void fill_attributes(Mesh& mesh, const DrawnVertices<3>& drawn, bool uv, bool normal) const {
    for (size_t v = 0; v < drawn.size(); ++v) {
      const ObjCorner* corner = drawn.corner(v);
      mesh.position_of.push_back(drawn.position(v));
      if (uv) {
        const bool has = corner && (*corner)[1] >= 0;
        mesh.uv.push_back(has ? shape_.uv[size_t((*corner)[1])] : std::array<float, 2>{});
      }
      if (normal)
        mesh.normal.push_back(corner ? shape_.normal[size_t((*corner)[2])]
                                     : std::array<float, 3>{0, 0, 1});
    }
  }

  void fill_groups(Mesh& mesh, DrawnVertices<3>& drawn, const Faces& faces) {
    // a group for each material, with and without coordinates of a texture
    std::map<std::pair<int32_t, bool>, size_t> group_of;
    std::vector<int32_t> vertex;
    std::vector<Vec3> polygon;
    for (const size_t f : faces) {
      const ObjFace& face = shape_.faces[f];
      // drawn vertices of the face
      vertex.clear();
      polygon.clear();
      bool has_uv = true;
      for (int32_t c = 0; c < face.corners; ++c) {
        const ObjCorner& corner = corners_of(face)[c];
        has_uv &= corner[1] >= 0;
        vertex.push_back(drawn({place_[size_t(corner[0])], corner[1], corner[2]}));
        polygon.push_back(shape_.position[size_t(corner[0])]);
      }
      const auto [entry, is_new] =
          group_of.try_emplace({face.material, has_uv}, mesh.groups.size());
      if (is_new) {
        mesh.groups.push_back({.material = face.material, .corner = {}});
        mesh.groups.back().has_uv = has_uv;
      }
      // triangles of the face
      std::vector<int32_t>& out = mesh.groups[entry->second].corner;
      if (face.corners == 3)
        out.insert(out.end(), vertex.begin(), vertex.end());
      else
        for (const int c : triangulate(polygon)) out.push_back(vertex[size_t(c)]);
    }
  }

  ObjShape shape_;
  Asset& asset_;
  std::vector<int32_t> place_;  ///< of each position of the file in the mesh being built
  std::vector<Faces> faces_of_;
};

}  // namespace

void ObjNodes::begin_object(std::string_view name) {
  object_ = name;
  group_.clear();
  node_ = -1;
}

void ObjNodes::begin_group(std::string_view name) {
  group_ = name;
  node_ = -1;
}

int32_t ObjNodes::node() {
  if (node_ >= 0) return node_;
  if (!object_.empty()) node_ = child(-1, object_);
  if (!group_.empty()) node_ = child(node_, group_);
  if (node_ < 0) node_ = child(-1, std::filesystem::path(asset_.path).stem().string());
  return node_;
}

int32_t ObjNodes::child(int32_t parent, const std::string& name) {
  const auto [entry, is_new] =
      node_of_.try_emplace(concat(parent, ' ', name), int32_t(asset_.nodes.size()));
  if (is_new) asset_.nodes.push_back({name, parent, kIdentity4, -1});
  return entry->second;
}

void build_obj_meshes(ObjShape shape, Asset& asset) {
  ObjMeshes(std::move(shape), asset).build();
}

}  // namespace elastogen
