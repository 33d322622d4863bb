// SPDX-License-Identifier: Apache-2.0
#include "io/ply_faces.hpp"

#include "io/polygon.hpp"

#include <algorithm>

namespace elastogen {
namespace {

class PlyFaceReader {
 public:
  PlyFaceReader(const PlyElement& face, size_t textures, PlyValues& values, const std::string& path)
      : face_(face),
        textures_(textures),
        values_(values),
        path_(path),
        index_(face.find({"vertex_indices", "vertex_index"})),
        uv_(face.find({"texcoord"})),
        texture_(face.find({"texnumber"})),
        colour_(face) {
    ELASTOGEN_CHECK_ASSET(index_ >= 0 && is_list(index_), path,
                          ": its faces have no list vertex_indices");
    if (uv_ >= 0 && !is_list(uv_)) uv_ = -1;
    if (texture_ >= 0 && is_list(texture_)) texture_ = -1;
  }

  FaceList read() {
    for (int64_t f = 0; f < face_.count; ++f) read_face(f);
    // drop uv if no face has coordinates
    if (std::ranges::find(faces_.has_uv, 1) == faces_.has_uv.end()) {
      faces_.uv.clear();
      faces_.has_uv.clear();
    }
    return std::move(faces_);
  }

  bool knows(int column) const {
    return column == index_ || column == uv_ || column == texture_ || colour_.has(column);
  }

 private:
  bool is_list(int column) const { return face_.properties[size_t(column)].is_list; }

  void read_face(int64_t f) {
    std::vector<double>& row = row_;
    row.assign(face_.properties.size(), 0);
    coordinates_.clear();
    values_.begin_item(face_);
    for (int k = 0; k < int(row.size()); ++k) {
      const PlyProperty& property = face_.properties[size_t(k)];
      if (k == index_)
        read_indices(property, f);
      else if (k == uv_)
        read_coordinates(property, f);
      else if (property.is_list)
        values_.skip(property);
      else
        row[size_t(k)] = values_.next(property.type);
    }
    values_.end_item();
    if (uv_ >= 0) add_coordinates(f);
    if (textures_ > 0) faces_.material.push_back(material_of(row));
    if (colour_.is_there()) faces_.colour.push_back(colour_.of(row));
  }

  void read_indices(const PlyProperty& list, int64_t f) {
    const int64_t n = values_.next_length(list);
    ELASTOGEN_CHECK_ASSET(n <= kMaxPolygonCorners, path_, ": face ", f, " has ", n,
                          " corners, at most ", kMaxPolygonCorners,
                          " are read; save it as triangles");
    for (int64_t c = 0; c < n; ++c) {
      const double index = values_.next(list.type);
      ELASTOGEN_CHECK_ASSET(index >= 0 && index < 0x1p31 && index == std::floor(index), path_,
                            ": face ", f, " has the vertex index ", index);
      faces_.corner.push_back(int32_t(index));
    }
    faces_.length.push_back(int32_t(n));
  }

  void read_coordinates(const PlyProperty& list, int64_t f) {
    const int64_t n = values_.next_length(list);
    ELASTOGEN_CHECK_ASSET(n <= 2 * kMaxPolygonCorners, path_, ": face ", f, " has ", n,
                          " texture coordinates");
    for (int64_t c = 0; c < n; ++c) coordinates_.push_back(float(values_.next(list.type)));
  }

  void add_coordinates(int64_t f) {
    const size_t n = size_t(faces_.length.back());
    ELASTOGEN_CHECK_ASSET(coordinates_.empty() || coordinates_.size() == 2 * n, path_, ": face ", f,
                          " has ", coordinates_.size(), " texture coordinates, ", 2 * n,
                          " are expected: two a corner");
    faces_.has_uv.push_back(!coordinates_.empty());
    for (size_t c = 0; c < n; ++c)
      faces_.uv.push_back(coordinates_.empty() ? std::array<float, 2>{}
                                               : std::array<float, 2>{coordinates_[2 * c],
                                                                      1 - coordinates_[2 * c + 1]});
  }

  int32_t material_of(const std::vector<double>& row) const {
    if (texture_ < 0) return 0;
    const double number = row[size_t(texture_)];
    return number >= 0 && number < double(textures_) ? int32_t(number) : -1;
  }

  const PlyElement& face_;
  size_t textures_;
  PlyValues& values_;
  const std::string& path_;
  int index_, uv_, texture_;
  PlyColour colour_;
  FaceList faces_;
  std::vector<double> row_;
  std::vector<float> coordinates_;
};

}  // namespace

PlyColour::PlyColour(const PlyElement& element)
    : column_{element.find({"red", "r"}), element.find({"green", "g"}), element.find({"blue", "b"}),
              element.find({"alpha", "a"})} {
  for (size_t k = 0; k < 4; ++k) {
    if (column_[k] < 0) continue;
    const PlyProperty& property = element.properties[size_t(column_[k])];
    range_[k] = colour_range(property.type);
    if (property.is_list) column_[k] = -1;
  }
}

bool PlyColour::has(int column) const {
  return is_there() && std::ranges::find(column_, column) != column_.end();
}

std::array<float, 4> PlyColour::of(const std::vector<double>& row) const {
  std::array<float, 4> colour = {0, 0, 0, 1};
  for (size_t k = 0; k < 4; ++k) {
    if (column_[k] < 0) continue;
    const double value = row[size_t(column_[k])];
    const double share = std::clamp(range_[k] > 0 ? value / range_[k] : value, 0., 1.);
    colour[k] = range_[k] > 0 && k < 3 ? linear_from_srgb(share) : float(share);
  }
  return colour;
}

FaceList read_ply_faces(const PlyElement& face, size_t textures, PlyValues& values,
                        const std::string& path, std::vector<std::string>& left_out) {
  PlyFaceReader reader(face, textures, values, path);
  for (int k = 0; k < int(face.properties.size()); ++k)
    if (!reader.knows(k)) left_out.push_back("face." + face.properties[size_t(k)].name);
  return reader.read();
}

}  // namespace elastogen
