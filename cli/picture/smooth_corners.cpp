// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/smooth_corners.hpp"

#include "core/parallel_sort.hpp"
#include "core/vec3.hpp"
#include "io/weld.hpp"

#include <numbers>
#include <numeric>

namespace elastogen {
namespace {

double cosine(double degrees) {
  return std::cos(degrees * std::numbers::pi / 180);
}

const double kSmooth = cosine(40);     // largest angle between faces
const double kRough = cosine(70);      // between faces of scans, where no sharp edge continues
const double kAgreed = cosine(80);     // between faces if normals agree
const double kAgreement = cosine(10);  // angle within which normals agree
const double kStraight = cosine(35);   // angle within which an edge continues another
constexpr size_t kMostFaces = 8;       // faces of one edge that are compared

/// An edge in the direction of a triangle, from `corner` to the next corner.
struct Edge {
  std::array<int32_t, 2> vertices;  ///< welded, ascending
  int32_t corner;                   ///< 3 triangle + 0 ... 2
  bool turned;                      ///< it runs from the second vertex to the first

  friend bool operator<(const Edge& a, const Edge& b) {
    return a.vertices != b.vertices ? a.vertices < b.vertices : a.corner < b.corner;
  }
};

int32_t next_corner(int32_t corner) {
  return corner % 3 == 2 ? corner - 2 : corner + 1;
}

class Joining {
 public:
  Joining(const Surface& surface, const std::vector<std::array<float, 3>>& file_normals,
          size_t welded)
      : surface_(surface),
        file_normals_(file_normals),
        sharp_(welded),
        parent_(size_t(surface.triangles.size())) {
    std::iota(parent_.begin(), parent_.end(), 0);
    face_.resize(size_t(surface.triangles.rows()));
    for (size_t t = 0; t < face_.size(); ++t) {
      const auto corner = int32_t(3 * t);
      face_[t] = unit(cross(along(corner), along(corner + 1)));
    }
  }

  /// Remembers an edge whose faces meet at 40 degrees or more.
  void note_sharp(const Edge& a, const Edge& b) {
    if (facing(a, b) > kSmooth) return;
    const Vec3 direction = unit(scaled(along(a.corner), a.turned ? -1 : 1));
    sharp_[size_t(a.vertices[0])].push_back(direction);
    sharp_[size_t(a.vertices[1])].push_back(scaled(direction, -1));
  }

  void join(const Edge& a, const Edge& b) {
    if (a.turned == b.turned || !is_smooth(a, b)) return;
    // the triangles use the edge in opposite directions: where a begins, b ends
    unite(a.corner, next_corner(b.corner));
    unite(next_corner(a.corner), b.corner);
  }

  int32_t root(int32_t corner) {
    while (parent_[size_t(corner)] != corner) {
      int32_t& up = parent_[size_t(corner)];
      corner = up = parent_[size_t(up)];
    }
    return corner;
  }

 private:
  static Vec3 unit(const Vec3& a) { return scaled(a, 1 / std::max(norm(a), 1e-290)); }
  Vec3 place(int32_t corner) const {
    const double* x = surface_.vertices.row(surface_.triangles.data()[corner]);
    return {x[0], x[1], x[2]};
  }
  Vec3 along(int32_t corner) const { return minus(place(next_corner(corner)), place(corner)); }
  double facing(const Edge& a, const Edge& b) const {
    return dot(face_[size_t(a.corner / 3)], face_[size_t(b.corner / 3)]);
  }

  bool is_smooth(const Edge& a, const Edge& b) const {
    const int32_t from[2] = {a.corner, next_corner(b.corner)};
    const int32_t to[2] = {next_corner(a.corner), b.corner};
    const double cosine = facing(a, b);
    if (has_normals(from) && has_normals(to)) return agree(from) && agree(to) && cosine > kAgreed;
    return cosine > kSmooth || (cosine > kRough && !(goes_on(a, 0) && goes_on(a, 1)));
  }

  /// Whether another sharp edge continues this one beyond an end; on noisy scans none does.
  bool goes_on(const Edge& edge, size_t end) const {
    const Vec3 direction = unit(scaled(along(edge.corner), edge.turned == (end == 1) ? 1 : -1));
    const auto& others = sharp_[size_t(edge.vertices[end])];
    return std::any_of(others.begin(), others.end(),
                       [&](const Vec3& other) { return dot(other, direction) > kStraight; });
  }

  bool has_normals(const int32_t (&corners)[2]) const {
    const std::array<float, 3> none = {};
    return !file_normals_.empty() && file_normals_[size_t(corners[0])] != none &&
           file_normals_[size_t(corners[1])] != none;
  }
  bool agree(const int32_t (&corners)[2]) const {
    double sum = 0;
    for (size_t d = 0; d < 3; ++d)
      sum += double(file_normals_[size_t(corners[0])][d]) *
             double(file_normals_[size_t(corners[1])][d]);
    return sum > kAgreement;
  }
  void unite(int32_t a, int32_t b) {
    a = root(a), b = root(b);
    parent_[size_t(std::max(a, b))] = std::min(a, b);
  }

  const Surface& surface_;
  const std::vector<std::array<float, 3>>& file_normals_;
  std::vector<Vec3> face_;                ///< unit normals of triangles
  std::vector<std::vector<Vec3>> sharp_;  ///< unit vectors along sharp edges away from each vertex
  std::vector<int32_t> parent_;
};

std::vector<Edge> sorted_edges(const Surface& surface, const std::vector<int32_t>& welded_of) {
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

/// Calls visit(a, b) for each pair of triangles at one edge.
template <class Visit>
void for_pairs(const std::vector<Edge>& edges, const Visit& visit) {
  for (size_t first = 0, end; first < edges.size(); first = end) {
    for (end = first + 1; end < edges.size() && edges[end].vertices == edges[first].vertices;)
      ++end;
    const size_t last = std::min(end, first + kMostFaces);
    for (size_t a = first; a < last; ++a)
      for (size_t b = a + 1; b < last; ++b) visit(edges[a], edges[b]);
  }
}

}  // namespace

SmoothCorners smooth_corners(const Surface& surface,
                             const std::vector<std::array<float, 3>>& file_normals) {
  const WeldedMesh welded = weld(surface);
  Joining joining(surface, file_normals, size_t(welded.vertices.rows()));
  const std::vector<Edge> edges = sorted_edges(surface, welded.welded_of);
  for_pairs(edges, [&](const Edge& a, const Edge& b) { joining.note_sharp(a, b); });
  for_pairs(edges, [&](const Edge& a, const Edge& b) { joining.join(a, b); });
  SmoothCorners result{Array<int32_t>(surface.triangles.rows(), 3), 0};
  for (int32_t corner = 0; corner < surface.triangles.size(); ++corner) {
    const int32_t root = joining.root(corner);
    result.normal_of.data()[corner] =
        root == corner ? int32_t(result.normals++) : result.normal_of.data()[root];
  }
  return result;
}

}  // namespace elastogen
