// SPDX-License-Identifier: Apache-2.0
#include "io/ply_mesh.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "io/normal_deltas.hpp"
#include "io/turned_normal.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <type_traits>

namespace elastogen {
namespace {

constexpr const char* kTypes[] = {"char", "uchar", "short", "ushort",
                                  "int",  "uint",  "float", "double"};

/// Text may hold numbers beyond the range of their type: they become the nearest of the type.
void append_colour(std::string& bytes, const std::array<float, 4>& linear) {
  for (size_t c = 0; c < 4; ++c) {
    const float share = std::clamp(linear[c], 0.0f, 1.0f);
    append(bytes, uint8_t(std::lround(255 * (c < 3 ? srgb_from_linear(share) : share))));
  }
}

/// The normal of a mesh in the axes of the root.
std::array<float, 3> at_root(const Matrix4& world, const std::array<float, 3>& normal) {
  const double A[9] = {world[0], world[4], world[8], world[1], world[5],
                       world[9], world[2], world[6], world[10]};
  const double det = A[0] * (A[4] * A[8] - A[5] * A[7]) - A[1] * (A[3] * A[8] - A[5] * A[6]) +
                     A[2] * (A[3] * A[7] - A[4] * A[6]);
  std::array<float, 3> n = turned_normal(A, normal);
  for (float& x : n) x = det < 0 ? -x : x;
  return n;
}

}  // namespace

PlyMesh::PlyMesh(const std::string& path, const Asset& asset, const Surface& surface,
                 const FileOrder& order)
    : asset_(asset), surface_(surface), order_(order), is_double_(is_float32_coarse(order.rest)) {
  flat_.position = order.rest;
  flat_.groups.emplace_back();
  for (const SurfaceInstance& instance : surface.instances) add_instance(instance);
  find_vertices();
  choose();
  choose_textures(path);
  fill_faces();
  moved_ = Array<double>(int64_t(order.rest.size()), 3);
  if (!normals_) flat_.normal.clear();
  turned_ = Array<float>(int64_t(flat_.normal.size()), 3);
}

void PlyMesh::add_instance(const SurfaceInstance& instance) {
  const Mesh& mesh = asset_.meshes[size_t(instance.mesh)];
  const Matrix4 world = world_matrix(asset_, instance.node);
  const auto first = int32_t(flat_.position_of.size());
  for (size_t v = 0; v < mesh.position_of.size(); ++v) {
    const auto point = size_t(instance.first_vertex + mesh.position_of[v]);
    flat_.position_of.push_back(order_.vertex[point]);
    const std::array<float, 3> none = {};  // for primitives of a glTF mesh without normals
    has_normal_.push_back(!mesh.normal.empty() && mesh.normal[v] != none);
    has_uv_.push_back(!mesh.uv.empty());
    flat_.normal.push_back(mesh.normal.empty() ? std::array<float, 3>{0, 0, 1}
                                               : at_root(world, mesh.normal[v]));
    flat_.uv.push_back(mesh.uv.empty() ? std::array<float, 2>{} : mesh.uv[v]);
    flat_.colour.push_back(mesh.colour.empty() ? std::array<float, 4>{1, 1, 1, 1} : mesh.colour[v]);
  }
  int64_t t = instance.first_triangle;
  for (const TriangleGroup& group : mesh.groups)
    for (size_t k = 0; k + 2 < group.corner.size(); k += 3, ++t) {
      std::array<int32_t, 3> drawn = {group.corner[k], group.corner[k + 1], group.corner[k + 2]};
      // the surface reverses the triangles of mirrored instances
      if (surface_.triangles(t, 1) != instance.first_vertex + mesh.position_of[size_t(drawn[1])])
        std::swap(drawn[1], drawn[2]);
      for (const int32_t d : drawn) flat_.groups[0].corner.push_back(first + d);
      textured_.push_back(group.has_uv && !mesh.uv.empty());
    }
}

/// The drawn vertex that stands for each vertex of the file: the first in a triangle, else any.
void PlyMesh::find_vertices() {
  vertex_.assign(order_.rest.size(), -1);
  const auto take = [&](int32_t drawn) {
    int32_t& v = vertex_[size_t(flat_.position_of[size_t(drawn)])];
    if (v < 0) v = drawn;
  };
  for (const int32_t drawn : flat_.groups[0].corner) take(drawn);
  for (size_t drawn = 0; drawn < flat_.position_of.size(); ++drawn) take(int32_t(drawn));
}

/// Decides which attributes are written, and whether vertices, corners or faces have them.
void PlyMesh::choose() {
  // compare each corner with the first drawn vertex at its position
  std::vector<uint8_t> several(order_.rest.size(), 0);
  bool uv = false, several_uv = false, several_colour = false;
  const auto of = [&](int32_t drawn) {
    return size_t(vertex_[size_t(flat_.position_of[size_t(drawn)])]);
  };
  for (size_t k = 0; k < flat_.groups[0].corner.size(); ++k) {
    const int32_t drawn = flat_.groups[0].corner[k];
    const auto d = size_t(drawn), one = of(drawn);
    normals_ |= has_normal_[d] != 0;
    uv |= textured_[k / 3] != 0;
    if (!has_normal_[d] || flat_.normal[d] != flat_.normal[one])
      several[size_t(flat_.position_of[d])] = 1;
    several_uv |= textured_[k / 3] != has_uv_[one] || flat_.uv[d] != flat_.uv[one];
    several_colour |= flat_.colour[d] != flat_.colour[one];
  }
  // normals: for vertices, or not at all
  if (normals_) without_normal_ = std::ranges::count(several, 1);
  normals_ = normals_ && without_normal_ == 0;
  // uv: for vertices if corners agree, else for corners
  vertex_uv_ = uv && !several_uv;
  corner_uv_ = uv && several_uv;
  // colours: for vertices if corners agree, else for faces
  const bool coloured =
      std::ranges::any_of(asset_.meshes, [](const Mesh& mesh) { return !mesh.colour.empty(); });
  vertex_colour_ = coloured && !several_colour;
  face_colour_ = coloured && several_colour;
}

void PlyMesh::choose_textures(const std::string& path) {
  const std::filesystem::path folder = std::filesystem::absolute(path).parent_path();
  texture_of_.assign(asset_.materials.size(), -1);
  bool all = true;
  for (int64_t t = 0; t < surface_.triangles.rows() && (vertex_uv_ || corner_uv_); ++t) {
    const int32_t m = surface_.material(t);
    const std::string texture = m < 0 ? "" : asset_.materials[size_t(m)].texture;
    all &= !texture.empty();
    if (texture.empty() || texture_of_[size_t(m)] >= 0) continue;
    const std::string name =
        std::filesystem::absolute(texture).lexically_proximate(folder).generic_string();
    const auto found = std::ranges::find(textures_, name);
    texture_of_[size_t(m)] = int32_t(found - textures_.begin());
    if (found == textures_.end()) textures_.push_back(name);
  }
  numbers_ = textures_.size() > 1 || (!textures_.empty() && !all);
}

std::array<float, 4> PlyMesh::face_colour(const int32_t* corner) const {
  std::array<float, 4> mean = {};
  for (size_t c = 0; c < 3; ++c)
    for (size_t k = 0; k < 4; ++k) mean[k] += flat_.colour[size_t(corner[c])][k] / 3;
  return mean;
}

void PlyMesh::fill_faces() {
  const std::vector<int32_t>& corner = flat_.groups[0].corner;
  for (size_t k = 0; k + 2 < corner.size(); k += 3) {
    append(faces_, uint8_t(3));
    for (size_t c = 0; c < 3; ++c) append(faces_, flat_.position_of[size_t(corner[k + c])]);
    if (corner_uv_) {
      append(faces_, uint8_t(textured_[k / 3] ? 6 : 0));
      for (size_t c = 0; c < 3 && textured_[k / 3]; ++c) {
        const auto& uv = flat_.uv[size_t(corner[k + c])];
        append(faces_, std::array<float, 2>{uv[0], 1 - uv[1]});
      }
    }
    if (numbers_) {
      const int32_t m = surface_.material(int64_t(k / 3));
      append(faces_, m < 0 ? -1 : texture_of_[size_t(m)]);
    }
    if (face_colour_) append_colour(faces_, face_colour(&corner[k]));
  }
}

std::string PlyMesh::header() const {
  const std::string number = is_double_ ? "double" : "float";
  std::string text;
  const auto declare = [&](const std::string& type, std::initializer_list<const char*> names) {
    for (const char* name : names) text += concat("property ", type, ' ', name, '\n');
  };
  for (const std::string& name : textures_) text += concat("comment TextureFile ", name, '\n');
  text += concat("element vertex ", order_.rest.size(), '\n');
  declare(number, {"x", "y", "z"});
  if (normals_) declare("float", {"nx", "ny", "nz"});
  if (vertex_uv_) declare("float", {"s", "t"});
  if (vertex_colour_) declare("uchar", {"red", "green", "blue", "alpha"});
  if (asset_.meshes.size() == 1)
    for (const OwnColumn& own : asset_.meshes[0].own)
      declare(kTypes[int(own.type)], {own.name.c_str()});
  text += concat("element face ", surface_.triangles.rows(), '\n');
  text += "property list uchar int vertex_indices\n";
  if (corner_uv_) text += "property list uchar float texcoord\n";
  if (numbers_) text += "property int texnumber\n";
  if (face_colour_) declare("uchar", {"red", "green", "blue", "alpha"});
  return text;
}

void PlyMesh::append_vertex(size_t v, const Vec3& x, std::string& bytes) const {
  for (const double value : x) {
    if (is_double_)
      append(bytes, value);
    else
      append(bytes, float(value));
  }
  const auto drawn = size_t(std::max(vertex_[v], 0));
  if (normals_) {
    std::array<float, 3> n = flat_.normal[drawn];
    for (size_t d = 0; d < 3; ++d) n[d] += turned_(int64_t(drawn), int(d));
    append(bytes, n);
  }
  if (vertex_uv_) append(bytes, std::array<float, 2>{flat_.uv[drawn][0], 1 - flat_.uv[drawn][1]});
  if (vertex_colour_) append_colour(bytes, flat_.colour[drawn]);
  if (asset_.meshes.size() == 1)
    for (const OwnColumn& own : asset_.meshes[0].own) append_number(bytes, own.type, own.value[v]);
}

std::string PlyMesh::body(const Span<const double>& displacement) {
  const auto vertices = int64_t(order_.rest.size());
  for (int64_t v = 0; v < vertices; ++v)
    for (int d = 0; d < 3; ++d)
      moved_(v, d) = displacement(order_.point[size_t(v)], d) / surface_.scale;
  if (normals_) normal_deltas(flat_, moved_, turned_);
  std::string bytes;
  for (int64_t v = 0; v < vertices; ++v) {
    Vec3 x = order_.rest[size_t(v)];
    for (int d = 0; d < 3; ++d) x[size_t(d)] += moved_(v, d);
    append_vertex(size_t(v), x, bytes);
  }
  return bytes + faces_;
}

}  // namespace elastogen
