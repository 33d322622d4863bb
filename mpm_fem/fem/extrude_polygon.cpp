// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/extrude_polygon.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>

namespace elastogen::fem {
namespace {

constexpr int kMaxRefinements = 10;

/// Twice the area of a triangle, positive counterclockwise.
double area2(const Vec2& a, const Vec2& b, const Vec2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

int sign(double x) {
  return (x > 0) - (x < 0);
}

/// Whether two segments have a point in common.
bool meet(const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& s) {
  for (size_t d = 0; d < 2; ++d)
    if (std::max(p[d], q[d]) < std::min(r[d], s[d]) || std::max(r[d], s[d]) < std::min(p[d], q[d]))
      return false;
  return sign(area2(p, q, r)) * sign(area2(p, q, s)) <= 0 &&
         sign(area2(r, s, p)) * sign(area2(r, s, q)) <= 0;
}

/// A point that two segments have in common.
Vec2 meeting(const Vec2& p, const Vec2& q, const Vec2& r, const Vec2& s) {
  const double from = area2(r, s, p), to = area2(r, s, q);
  if (from == to) return meet(p, q, r, r) ? r : meet(p, q, s, s) ? s : p;  // along each other
  const double share = from / (from - to);
  return {p[0] + share * (q[0] - p[0]), p[1] + share * (q[1] - p[1])};
}

void check_simple(const std::vector<Vec2>& corners) {
  const size_t n = corners.size();
  ELASTOGEN_CHECK(n >= 3, "a polygon has three corners or more, got ", n);
  for (size_t k = 0; k < n; ++k)
    ELASTOGEN_CHECK(std::isfinite(corners[k][0]) && std::isfinite(corners[k][1]), "corner ", k,
                    " of the polygon is not finite");
  for (size_t k = 0; k < n; ++k)
    ELASTOGEN_CHECK(corners[k] != corners[(k + 1) % n], "corners ", k, " and ", (k + 1) % n,
                    " of the polygon are one place, (", corners[k][0], ", ", corners[k][1], ")");
  for (size_t j = 0; j < n; ++j) {
    const Vec2 &p = corners[j], &q = corners[(j + 1) % n], &next = corners[(j + 2) % n];
    const bool ahead = (q[0] - p[0]) * (next[0] - q[0]) + (q[1] - p[1]) * (next[1] - q[1]) > 0;
    ELASTOGEN_CHECK(area2(p, q, next) != 0 || ahead, "the polygon turns back on itself at corner ",
                    (j + 1) % n, ", (", q[0], ", ", q[1], ")");
    for (size_t k = j + 2; k < n; ++k) {
      const Vec2 &r = corners[k], &s = corners[(k + 1) % n];
      if ((k + 1) % n == j || !meet(p, q, r, s)) continue;
      const Vec2 at = meeting(p, q, r, s);
      throw Error(concat("the polygon crosses itself: the edges from corner ", j, " and from ", k,
                         " meet at (", at[0], ", ", at[1], ")"));
    }
  }
}

/// Cosine of the least angle of a triangle.
double largest_cosine(const Vec2& a, const Vec2& b, const Vec2& c) {
  const Vec2* x[3] = {&a, &b, &c};
  double largest = -1;
  for (int k = 0; k < 3; ++k) {
    const Vec2 &o = *x[k], &p = *x[(k + 1) % 3], &q = *x[(k + 2) % 3];
    const double dot = (p[0] - o[0]) * (q[0] - o[0]) + (p[1] - o[1]) * (q[1] - o[1]);
    largest = std::max(
        largest, dot / std::hypot(p[0] - o[0], p[1] - o[1]) / std::hypot(q[0] - o[0], q[1] - o[1]));
  }
  return largest;
}

/// Corners of the ring before, at and behind its entry k.
std::array<int32_t, 3> corner_at(const std::vector<int32_t>& ring, size_t k) {
  const size_t n = ring.size();
  return {ring[(k + n - 1) % n], ring[k], ring[(k + 1) % n]};
}

/// Whether corner k sticks out and no other corner lies in its triangle or on its border.
bool is_ear(const std::vector<Vec2>& x, const std::vector<int32_t>& ring, size_t k) {
  const auto [i, j, l] = corner_at(ring, k);
  const Vec2 &a = x[size_t(i)], &b = x[size_t(j)], &c = x[size_t(l)];
  if (area2(a, b, c) <= 0) return false;
  return std::none_of(ring.begin(), ring.end(), [&, i = i, j = j, l = l](int32_t other) {
    const Vec2& q = x[size_t(other)];
    return other != i && other != j && other != l && area2(a, b, q) >= 0 && area2(b, c, q) >= 0 &&
           area2(c, a, q) >= 0;
  });
}

PolygonMesh ears(const std::vector<Vec2>& corners) {
  PolygonMesh mesh{corners, {}};
  std::vector<int32_t> ring(corners.size());
  std::iota(ring.begin(), ring.end(), 0);
  double area = 0;
  for (size_t k = 0; k < corners.size(); ++k)
    area += area2(corners[0], corners[k], corners[(k + 1) % corners.size()]);
  if (area < 0) std::reverse(ring.begin(), ring.end());
  while (ring.size() >= 3) {
    size_t best = ring.size();
    double least = 2;
    for (size_t k = 0; k < ring.size(); ++k) {
      const auto [i, j, l] = corner_at(ring, k);
      const double cosine =
          largest_cosine(corners[size_t(i)], corners[size_t(j)], corners[size_t(l)]);
      if (cosine < least && is_ear(corners, ring, k)) best = k, least = cosine;
    }
    ELASTOGEN_CHECK(best < ring.size(), "the polygon is flat but for rounding at corner ", ring[0]);
    mesh.triangles.push_back(corner_at(ring, best));
    ring.erase(ring.begin() + int64_t(best));
  }
  return mesh;
}

/// Each triangle cut into four by the middles of its edges.
PolygonMesh quartered(const PolygonMesh& mesh) {
  PolygonMesh result{mesh.points, {}};
  std::map<std::pair<int32_t, int32_t>, int32_t> middles;
  const auto middle = [&](int32_t a, int32_t b) {
    const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), int32_t(result.points.size()));
    if (is_new) {
      const Vec2 &p = mesh.points[size_t(a)], &q = mesh.points[size_t(b)];
      result.points.push_back({(p[0] + q[0]) / 2, (p[1] + q[1]) / 2});
    }
    return at->second;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    const int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    for (const std::array<int32_t, 3>& part :
         {std::array{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}})
      result.triangles.push_back(part);
  }
  return result;
}

/// The three tetrahedra of a prism between a triangle and the one with node numbers higher by `up`.
void cut_prism(std::array<int32_t, 3> low, int32_t up, int32_t* tets) {
  // sorting turns the triangle over if it needs an odd number of swaps
  bool turned = false;
  for (const auto& [i, j] : {std::pair<size_t, size_t>{0, 1}, {1, 2}, {0, 1}})
    if (low[i] > low[j]) std::swap(low[i], low[j]), turned = !turned;
  const auto [a, b, c] = low;
  const int32_t cut[3][4] = {
      {a, b, c, c + up}, {a, b, c + up, b + up}, {a, b + up, c + up, a + up}};
  for (const auto& tet : cut) {
    std::copy_n(tet, 4, tets);
    if (turned) std::swap(tets[1], tets[2]);
    tets += 4;
  }
}

/// The points in layers + 1 planes, (nodes, 3).
Array<double> stacked(const std::vector<Vec2>& points, double thickness, int layers) {
  const auto count = int64_t(points.size());
  Array<double> rest(count * (layers + 1), 3);
  for (int64_t n = 0; n < rest.rows(); ++n) {
    const Vec2& p = points[size_t(n % count)];
    rest(n, 0) = p[0];
    rest(n, 1) = p[1];
    rest(n, 2) = thickness * (double(n / count) / layers);
  }
  return rest;
}

}  // namespace

PolygonMesh polygon_mesh(const std::vector<Vec2>& corners, int refinements) {
  check_simple(corners);
  ELASTOGEN_CHECK(refinements >= 0 && refinements <= kMaxRefinements,
                  "refinements must lie in 0 ... ", kMaxRefinements, ", got ", refinements);
  PolygonMesh mesh = ears(corners);
  for (int k = 0; k < refinements; ++k) mesh = quartered(mesh);
  return mesh;
}

ElementMesh extruded_polygon(const std::vector<Vec2>& corners, double thickness, int refinements,
                             int layers, Element element) {
  ELASTOGEN_CHECK(thickness > 0 && std::isfinite(thickness), "the thickness must be positive, got ",
                  thickness);
  ELASTOGEN_CHECK(layers >= 1, "at least one layer is expected, got ", layers);
  ELASTOGEN_CHECK(nodes_of(element) != 8, "polygons are cut into tetrahedra, not into ",
                  element_name(element));
  const PolygonMesh flat = polygon_mesh(corners, refinements);
  const auto points = int64_t(flat.points.size()), triangles = int64_t(flat.triangles.size());
  ELASTOGEN_CHECK(double(points) * (layers + 1.) <= std::numeric_limits<int32_t>::max(), points,
                  " points in ", layers, " layers are more nodes than 32 bits count");
  // the points in planes, then three tetrahedra for each prism
  ElementMesh mesh;
  mesh.element = Element::kTet4;
  mesh.rest = stacked(flat.points, thickness, layers);
  mesh.elements = Array<int32_t>(3 * triangles * layers, 4);
  mesh.material = Array<int32_t>(mesh.elements.rows());
  for (int64_t k = 0; k < layers; ++k)
    for (int64_t t = 0; t < triangles; ++t) {
      std::array<int32_t, 3> low = flat.triangles[size_t(t)];
      for (int32_t& node : low) node += int32_t(points * k);
      cut_prism(low, int32_t(points), mesh.elements.row(3 * (triangles * k + t)));
    }
  // the middles of edges, if wanted
  if (element != Element::kTet4) mesh = quadratic(mesh);
  mesh.element = element;
  return mesh;
}

}  // namespace elastogen::fem
