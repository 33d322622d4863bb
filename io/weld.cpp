// SPDX-License-Identifier: Apache-2.0
#include "io/weld.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>
#include <unordered_map>
#include <utility>

namespace elastogen {
namespace {

/// Finds the nearest earlier vertex within a distance. Vertices are sorted into cubic cells, wide
/// enough that most balls of that radius lie in one cell.
class NearVertices {
 public:
  NearVertices(const Vec3& origin, double tolerance, const WeldedMesh& mesh)
      : origin_(origin), tolerance_(tolerance), inverse_edge_(1 / (16 * tolerance)), mesh_(mesh) {}

  /// -1 if there is none.
  int32_t find(const Vec3& x) const {
    int64_t low[3], high[3];
    for (int d = 0; d < 3; ++d) {
      low[d] = cell(x[d] - tolerance_, d);
      high[d] = cell(x[d] + tolerance_, d);
    }
    int32_t nearest = -1;
    double best = tolerance_ * tolerance_;
    for (int64_t i = low[0]; i <= high[0]; ++i)
      for (int64_t j = low[1]; j <= high[1]; ++j)
        for (int64_t k = low[2]; k <= high[2]; ++k) {
          const auto head = head_.find(key(i, j, k));
          for (int32_t v = head == head_.end() ? -1 : head->second; v >= 0; v = next_[size_t(v)]) {
            const double distance = squared_distance(x, v);
            if (distance > best || (distance == best && nearest >= 0 && nearest < v)) continue;
            best = distance;
            nearest = v;
          }
        }
    return nearest;
  }

  /// Adds the vertex whose index is the number of those added before.
  void add(const Vec3& x) {
    const auto v = int32_t(next_.size());
    const auto [entry, is_new] =
        head_.try_emplace(key(cell(x[0], 0), cell(x[1], 1), cell(x[2], 2)), v);
    next_.push_back(is_new ? -1 : entry->second);
    entry->second = v;
  }

 private:
  int64_t cell(double x, int d) const {
    return int64_t(std::floor((x - origin_[d]) * inverse_edge_)) + 1;  // 0 is below the box
  }
  static uint64_t key(int64_t i, int64_t j, int64_t k) {
    return uint64_t(i) << 42 | uint64_t(j) << 21 | uint64_t(k);
  }
  double squared_distance(const Vec3& x, int32_t v) const {
    const double* y = mesh_.vertices.row(v);
    return (x[0] - y[0]) * (x[0] - y[0]) + (x[1] - y[1]) * (x[1] - y[1]) +
           (x[2] - y[2]) * (x[2] - y[2]);
  }

  Vec3 origin_;
  double tolerance_, inverse_edge_;
  const WeldedMesh& mesh_;
  std::unordered_map<uint64_t, int32_t> head_;
  std::vector<int32_t> next_;
};

double longest_edge(const Box& box) {
  return std::max({box.extent(0), box.extent(1), box.extent(2)});
}

double absolute_tolerance(const PlacedBox& box, double share) {
  double largest = 0;
  for (size_t d = 0; d < 3; ++d)
    largest = std::max(
        {largest, std::abs(box.lower[d] + box.origin[d]), std::abs(box.upper[d] + box.origin[d])});
  return std::max(share * longest_edge(box), 4 * std::numeric_limits<double>::epsilon() * largest);
}

void weld_vertices(const Surface& surface, WeldedMesh& mesh) {
  const int64_t count = surface.vertices.rows();
  // vertices that a triangle uses
  std::vector<uint8_t> used(size_t(count), 0);
  for (int64_t k = 0; k < surface.triangles.size(); ++k)
    used[size_t(surface.triangles.data()[k])] = 1;
  const int64_t used_count = std::count(used.begin(), used.end(), 1);
  mesh.unreferenced = count - used_count;
  mesh.welded_of.assign(size_t(count), -1);
  mesh.vertices = Array<double>(used_count, 3);

  // each joins the nearest earlier one within the tolerance, or starts a new one
  NearVertices near(surface.box.lower, mesh.tolerance, mesh);
  int32_t welded = 0;
  for (int64_t i = 0; i < count; ++i) {
    if (!used[size_t(i)]) continue;
    const double* x = surface.vertices.row(i);
    const Vec3 p = {x[0], x[1], x[2]};
    int32_t& w = mesh.welded_of[size_t(i)];
    w = near.find(p);
    if (w >= 0) continue;
    w = welded++;
    std::copy(p.begin(), p.end(), mesh.vertices.row(w));
    near.add(p);
  }
  // cut the array to the welded vertices
  mesh.merged = used_count - welded;
  Array<double> vertices(welded, 3);
  std::copy(mesh.vertices.data(), mesh.vertices.data() + 3 * int64_t(welded), vertices.data());
  mesh.vertices = std::move(vertices);
}

/// Whether the height of a triangle over its longest edge is at most the tolerance.
bool is_flat(const WeldedMesh& mesh, const std::array<int32_t, 3>& t) {
  Vec3 edge[3];
  double longest = 0;
  for (int c = 0; c < 3; ++c) {
    const double *a = mesh.vertices.row(t[size_t(c)]),
                 *b = mesh.vertices.row(t[size_t((c + 1) % 3)]);
    for (int d = 0; d < 3; ++d) edge[c][d] = b[d] - a[d];
    longest = std::max(longest, std::hypot(edge[c][0], edge[c][1], edge[c][2]));
  }
  const Vec3 &a = edge[0], &b = edge[1];
  const double area2 =
      std::hypot(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]);
  return area2 <= mesh.tolerance * longest;
}

/// A surface triangle of three different welded vertices.
struct Candidate {
  std::array<int32_t, 3> sorted;
  int64_t source;
  bool forward;  ///< wound as its sorted vertices
  bool operator<(const Candidate& other) const {
    return sorted != other.sorted ? sorted < other.sorted : source < other.source;
  }
};

std::array<int32_t, 3> welded_corners(const Surface& surface, const WeldedMesh& mesh, int64_t t) {
  std::array<int32_t, 3> welded;
  for (int c = 0; c < 3; ++c) welded[size_t(c)] = mesh.welded_of[size_t(surface.triangles(t, c))];
  return welded;
}

/// All candidates, sorted so that those of equal vertices are together; counts those without area.
std::vector<Candidate> candidates_of(const Surface& surface, WeldedMesh& mesh) {
  std::vector<Candidate> candidates;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    const std::array<int32_t, 3> w = welded_corners(surface, mesh, t);
    const bool collapsed = w[0] == w[1] || w[1] == w[2] || w[2] == w[0];
    if (collapsed || is_flat(mesh, w)) ++mesh.zero_area;
    if (collapsed) continue;
    const int rises = (w[0] < w[1]) + (w[1] < w[2]) + (w[2] < w[0]);
    candidates.push_back({w, t, rises == 2});
    std::sort(candidates.back().sorted.begin(), candidates.back().sorted.end());
  }
  std::sort(candidates.begin(), candidates.end());
  return candidates;
}

/// Keeps one triangle for each set of vertices, the first with the winding that prevails. If none
/// does it keeps the first, with `keep_pairs` also the first of the other winding.
void keep_triangles(const Surface& surface, const std::vector<Candidate>& candidates,
                    bool keep_pairs, WeldedMesh& mesh) {
  for (auto begin = candidates.begin(), end = begin; begin != candidates.end(); begin = end) {
    int64_t net = 0;
    for (; end != candidates.end() && end->sorted == begin->sorted; ++end)
      net += end->forward ? 1 : -1;
    const auto first_of = [&](bool forward) {
      return std::find_if(begin, end, [&](const Candidate& c) { return c.forward == forward; });
    };
    mesh.opposite_pairs += net == 0;
    mesh.source.push_back(net == 0 ? begin->source : first_of(net > 0)->source);
    if (net == 0 && keep_pairs) mesh.source.push_back(first_of(!begin->forward)->source);
  }
  mesh.duplicate_faces = int64_t(candidates.size() - mesh.source.size());
  std::sort(mesh.source.begin(), mesh.source.end());
  mesh.triangles = Array<int32_t>(int64_t(mesh.source.size()), 3);
  for (size_t k = 0; k < mesh.source.size(); ++k) {
    const std::array<int32_t, 3> w = welded_corners(surface, mesh, mesh.source[k]);
    std::copy(w.begin(), w.end(), mesh.triangles.row(int64_t(k)));
  }
}

/// Root of a triangle's piece; shortens the path to it.
int32_t root_of(std::vector<int32_t>& parent, int32_t t) {
  while (parent[size_t(t)] != t) t = parent[size_t(t)] = parent[size_t(parent[size_t(t)])];
  return t;
}

void count_edges(WeldedMesh& mesh) {
  // edges of all triangles, those between the same vertices next to each other
  struct Edge {
    int32_t a, b, triangle;
    bool forward;  ///< the triangle runs from a to b, a < b
  };
  std::vector<Edge> edges;
  edges.reserve(size_t(mesh.triangles.size()));
  for (int32_t t = 0; t < int32_t(mesh.triangles.rows()); ++t)
    for (int c = 0; c < 3; ++c) {
      const int32_t a = mesh.triangles(t, c), b = mesh.triangles(t, (c + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), t, a < b});
    }
  std::sort(edges.begin(), edges.end(), [](const Edge& p, const Edge& q) {
    return std::tie(p.a, p.b, p.triangle) < std::tie(q.a, q.b, q.triangle);
  });

  // triangles that share an edge are one piece (union-find)
  std::vector<int32_t> parent(size_t(mesh.triangles.rows()));
  std::iota(parent.begin(), parent.end(), 0);
  mesh.pieces = mesh.triangles.rows();
  for (size_t begin = 0, end = 0; begin < edges.size(); begin = end) {
    int64_t balance = 0;
    for (; end < edges.size() && edges[end].a == edges[begin].a && edges[end].b == edges[begin].b;
         ++end) {
      balance += edges[end].forward ? 1 : -1;
      const int32_t p = root_of(parent, edges[begin].triangle),
                    q = root_of(parent, edges[end].triangle);
      mesh.pieces -= p != q;
      parent[size_t(std::max(p, q))] = std::min(p, q);
    }
    // what the number and directions of its triangles say of an edge
    mesh.border_edges += end - begin == 1;
    mesh.nonmanifold_edges += end - begin > 2;
    mesh.turned_edges += end - begin == 2 && balance != 0;
    mesh.unbalanced_edges += balance != 0;
  }
}

/// V = sum of (a - o) . ((b - o) x (c - o)) / 6 about the box's centre o.
double signed_volume(const WeldedMesh& mesh, const Box& box) {
  double volume = 0;
  for (int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    Vec3 p[3];
    for (int c = 0; c < 3; ++c)
      for (int d = 0; d < 3; ++d)
        p[c][d] = mesh.vertices(mesh.triangles(t, c), d) -
                  (box.lower[d] + 0.5 * (box.upper[d] - box.lower[d]));
    volume += p[0][0] * (p[1][1] * p[2][2] - p[1][2] * p[2][1]) +
              p[0][1] * (p[1][2] * p[2][0] - p[1][0] * p[2][2]) +
              p[0][2] * (p[1][0] * p[2][1] - p[1][1] * p[2][0]);
  }
  return volume / 6;
}

}  // namespace

WeldedMesh weld(const Surface& surface, double tolerance) {
  WeldedMesh mesh;
  if (surface.triangles.rows() == 0) {
    mesh.unreferenced = surface.vertices.rows();
    mesh.welded_of.assign(size_t(surface.vertices.rows()), -1);
    return mesh;
  }
  mesh.tolerance = absolute_tolerance(surface.box, tolerance);
  weld_vertices(surface, mesh);
  const std::vector<Candidate> candidates = candidates_of(surface, mesh);
  const WeldedMesh vertices = mesh;
  keep_triangles(surface, candidates, false, mesh);
  count_edges(mesh);
  if (mesh.opposite_pairs > 0 && !mesh.balanced()) {
    WeldedMesh paired = vertices;
    keep_triangles(surface, candidates, true, paired);
    count_edges(paired);
    if (paired.unbalanced_edges < mesh.unbalanced_edges) mesh = std::move(paired);
  }
  mesh.volume = signed_volume(mesh, surface.box);
  return mesh;
}

}  // namespace elastogen
