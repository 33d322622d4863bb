// SPDX-License-Identifier: Apache-2.0
#include "io/face_list.hpp"

#include "core/error.hpp"
#include "io/asset_check.hpp"
#include "io/drawn_vertices.hpp"
#include "io/polygon.hpp"

#include <bit>
#include <map>
#include <numeric>
#include <optional>

namespace elastogen {
namespace {

/// Position, whether it has uv, and the bits of uv and of the face's colour.
using FaceCorner = std::array<int32_t, 8>;

int32_t bits_of(float value) {
  return std::bit_cast<int32_t>(value);
}

float value_of(int32_t bits) {
  return std::bit_cast<float>(bits);
}

/// Copies rows of values of positions to the drawn vertices beyond them.
template <class Row>
void spread(std::vector<Row>& rows, const std::vector<int32_t>& position_of) {
  if (rows.empty()) return;
  for (size_t v = rows.size(); v < position_of.size(); ++v)
    rows.push_back(rows[size_t(position_of[v])]);
}

class FaceMesh {
 public:
  FaceMesh(const FaceList& faces, Mesh& mesh, Asset& asset)
      : faces_(faces),
        mesh_(mesh),
        asset_(asset),
        with_colour_(!faces.colour.empty() && mesh.colour.empty()) {
    if (!faces.uv.empty() || with_colour_) drawn_.emplace(mesh.position.size());
  }

  void build() {
    int64_t first = 0;
    for (size_t f = 0; f < faces_.length.size(); first += faces_.length[f++]) add_face(f, first);
    if (mesh_.groups.empty()) mesh_.groups.emplace_back();
    if (!faces_.colour.empty() && !with_colour_)
      add_finding(asset_, "face-colours", int64_t(faces_.colour.size()),
                  "faces have colours beside those of the vertices");
    if (!drawn_) {
      mesh_.position_of.resize(mesh_.position.size());
      std::iota(mesh_.position_of.begin(), mesh_.position_of.end(), 0);
      return;
    }
    for (size_t v = 0; v < drawn_->size(); ++v) mesh_.position_of.push_back(drawn_->position(v));
    spread(mesh_.normal, mesh_.position_of);
    spread(mesh_.uv, mesh_.position_of);
    spread(mesh_.colour, mesh_.position_of);
    fill_corner_attributes();
  }

 private:
  void add_face(size_t face, int64_t first) {
    const int32_t n = faces_.length[face];
    const bool has_uv = faces_.uv.empty() || faces_.has_uv[face];
    vertex_.clear();
    polygon_.clear();
    for (int64_t c = first; c < first + n; ++c) {
      const int32_t p = faces_.corner[size_t(c)];
      ELASTOGEN_CHECK_ASSET(p < int64_t(mesh_.position.size()), asset_.path, ": face ", face,
                            " has the vertex index ", p, ", the file has ", mesh_.position.size(),
                            " vertices");
      polygon_.push_back(mesh_.position[size_t(p)]);
      if (n >= 3) vertex_.push_back(drawn_ ? (*drawn_)(corner_of(face, c, has_uv)) : p);
    }
    if (n < 3) return add_finding(asset_, "short-face", 1, "faces have fewer than three corners");
    const int32_t material = faces_.material.empty() ? -1 : faces_.material[face];
    const auto [entry, is_new] = group_of_.try_emplace({material, has_uv}, mesh_.groups.size());
    if (is_new) {
      mesh_.groups.push_back({.material = material, .corner = {}});
      mesh_.groups.back().has_uv = has_uv;
    }
    std::vector<int32_t>& out = mesh_.groups[entry->second].corner;
    for (const int c : triangulate(polygon_)) out.push_back(vertex_[size_t(c)]);
  }

  FaceCorner corner_of(size_t face, int64_t c, bool has_uv) const {
    FaceCorner corner = {faces_.corner[size_t(c)]};
    if (has_uv && !faces_.uv.empty()) {
      corner[1] = 1;
      for (size_t k = 0; k < 2; ++k) corner[2 + k] = bits_of(faces_.uv[size_t(c)][k]);
    }
    for (size_t k = 0; with_colour_ && k < 4; ++k) corner[4 + k] = bits_of(faces_.colour[face][k]);
    return corner;
  }

  void fill_corner_attributes() {
    const size_t count = drawn_->size();
    if (!faces_.uv.empty()) mesh_.uv.assign(count, {});
    if (with_colour_) mesh_.colour.assign(count, {1, 1, 1, 1});
    for (size_t v = 0; v < count; ++v) {
      const FaceCorner* corner = drawn_->corner(v);
      if (!corner) continue;
      if (!faces_.uv.empty()) mesh_.uv[v] = {value_of((*corner)[2]), value_of((*corner)[3])};
      for (size_t k = 0; with_colour_ && k < 4; ++k)
        mesh_.colour[v][k] = value_of((*corner)[4 + k]);
    }
  }

  const FaceList& faces_;
  Mesh& mesh_;
  Asset& asset_;
  bool with_colour_;
  std::optional<DrawnVertices<8>> drawn_;  ///< where positions may be split
  std::map<std::pair<int32_t, bool>, size_t> group_of_;
  std::vector<int32_t> vertex_;
  std::vector<Vec3> polygon_;
};

}  // namespace

void add_faces(const FaceList& faces, Mesh& mesh, Asset& asset) {
  FaceMesh(faces, mesh, asset).build();
}

}  // namespace elastogen
