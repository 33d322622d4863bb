// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/smooth_corners.hpp"

#include "core/parallel_sort.hpp"
#include "core/vec3.hpp"
#include "io/weld.hpp"

#include <numeric>

namespace elastogen {
namespace {

const double kSmooth = std::cos(40 * 3.14159265358979 / 180);     // between faces
const double kAgreed = std::cos(80 * 3.14159265358979 / 180);     // where normals agree
const double kAgreement = std::cos(10 * 3.14159265358979 / 180);  // of normals
constexpr size_t kMostFaces = 8;                                  // of one edge that are compared

/// An edge as a triangle runs along it, from `corner` to the next one.
struct Edge {
  std::array<int32_t, 2> vertices;  ///< welded, ascending
  int32_t corner;                   ///< 3 triangle + 0 ... 2
  bool turned;                      ///< it runs from the second to the first

  friend bool operator<(const Edge& a, const Edge& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.corner < b.corner;
  }
};

int32_t next_corner(int32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

class Joining {
 public:
  Joining(const Surface& surface, const std::vector<std::array<float, 3>>& file_normals)
      : file_normals_(file_normals), parent_(size_t(surface.triangles.size())) {
    std::iota(parent_.begin(), parent_.end(), 0);
    face_.resize(size_t(surface.triangles.rows()));
    for (size_t t = 0; t < face_.size(); ++t) {
      Vec3 x[3];
      for (int c = 0; c < 3; ++c)
        std::copy_n(surface.vertices.row(surface.triangles(int64_t(t), c)), 3, x[c].begin());
      face_[t] = cross(minus(x[1], x[0]), minus(x[2], x[0]));
      face_[t] = scaled(face_[t], 1 / std::max(norm(face_[t]), 1e-290));
    }
  }

  void join(const Edge& a, const Edge& b) {
    if (a.turned == b.turned) return;
    // where a begins b ends
    const int32_t from[2] = {a.corner, next_corner(b.corner)};
    const int32_t to[2] = {next_corner(a.corner), b.corner};
    const double facing = dot(face_[size_t(a.corner / 3)], face_[size_t(b.corner / 3)]);
    if (!(facing > (agree(from) && agree(to) ? kAgreed : limit(a.corner, b.corner)))) return;
    unite(from[0], from[1]);
    unite(to[0], to[1]);
  }

  int32_t root(int32_t corner) {
    while (parent_[size_t(corner)] != corner) {
      int32_t& up = parent_[size_t(corner)];
      corner = up = parent_[size_t(up)];
    }
    return corner;
  }

 private:
  bool has_normal(int32_t corner) const {
    return !file_normals_.empty() && file_normals_[size_t(corner)] != std::array<float, 3>{};
  }
  bool agree(const int32_t (&corners)[2]) const {
    if (!has_normal(corners[0]) || !has_normal(corners[1])) return false;
    double sum = 0;
    for (size_t d = 0; d < 3; ++d)
      sum += double(file_normals_[size_t(corners[0])][d]) *
             double(file_normals_[size_t(corners[1])][d]);
    return sum > kAgreement;
  }
  /// Normals that differ are an edge.
  double limit(int32_t a, int32_t b) const { return has_normal(a) && has_normal(b) ? 2 : kSmooth; }
  void unite(int32_t a, int32_t b) {
    a = root(a), b = root(b);
    parent_[size_t(std::max(a, b))] = std::min(a, b);
  }

  const std::vector<std::array<float, 3>>& file_normals_;
  std::vector<Vec3> face_;
  std::vector<int32_t> parent_;
};

std::vector<Edge> sorted_edges(const Surface& surface) {
  const std::vector<int32_t> welded_of = weld(surface).welded_of;
  std::vector<Edge> edges;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t)
    for (int c = 0; c < 3; ++c) {
      const int32_t a = welded_of[size_t(surface.triangles(t, c))];
      const int32_t b = welded_of[size_t(surface.triangles(t, (c + 1) % 3))];
      edges.push_back({{std::min(a, b), std::max(a, b)}, int32_t(3 * t + c), a > b});
    }
  parallel_sort(edges.begin(), edges.end());
  return edges;
}

}  // namespace

SmoothCorners smooth_corners(const Surface& surface,
                             const std::vector<std::array<float, 3>>& file_normals) {
  Joining joining(surface, file_normals);
  const std::vector<Edge> edges = sorted_edges(surface);
  for (size_t first = 0, end; first < edges.size(); first = end) {
    for (end = first + 1; end < edges.size() && edges[end].vertices == edges[first].vertices;)
      ++end;
    const size_t last = std::min(end, first + kMostFaces);
    for (size_t a = first; a < last; ++a)
      for (size_t b = a + 1; b < last; ++b) joining.join(edges[a], edges[b]);
  }
  SmoothCorners result{Array<int32_t>(surface.triangles.rows(), 3), 0};
  for (int32_t corner = 0; corner < surface.triangles.size(); ++corner) {
    const int32_t root = joining.root(corner);
    result.normal_of.data()[corner] =
        root == corner ? int32_t(result.normals++) : result.normal_of.data()[root];
  }
  return result;
}

}  // namespace elastogen
