// SPDX-License-Identifier: Apache-2.0
#include "voxelize/lattice_mesh.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>

namespace elastogen {
namespace {

constexpr double kSnap = 1e-9;    // of coordinates to lattice planes [voxel edges]
constexpr double kSheetLoop = 2;  // length of a border loop / sqrt(area) that makes a sheet
constexpr double kSheetSize = 3;  // [voxel edges]

/// Two triangles that share an edge; turned where both run the same way along it.
struct Link {
  int32_t triangle[2];
  bool turned;
};

struct HalfEdge {
  int32_t lower, upper, triangle;
  bool forward;
  bool operator<(const HalfEdge& other) const {
    return std::tie(lower, upper, triangle) < std::tie(other.lower, other.upper, other.triangle);
  }
};

struct Edges {
  std::vector<Link> manifold;    ///< edges of two triangles
  std::vector<Link> branching;   ///< first and each further triangle of edges of three or more
  std::vector<HalfEdge> border;  ///< edges of one triangle
};

Edges find_edges(const std::vector<Coord>& triangles) {
  std::vector<HalfEdge> half;
  half.reserve(3 * triangles.size());
  for (size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const int32_t a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      half.push_back({std::min(a, b), std::max(a, b), static_cast<int32_t>(t), a < b});
    }
  std::sort(half.begin(), half.end());

  Edges edges;
  for (size_t first = 0, last; first < half.size(); first = last) {
    for (last = first; last < half.size() && half[last].lower == half[first].lower &&
                       half[last].upper == half[first].upper;)
      ++last;
    if (last - first == 1) edges.border.push_back(half[first]);
    for (size_t i = first + 1; i < last; ++i)
      (last - first == 2 ? edges.manifold : edges.branching)
          .push_back(
              {{half[first].triangle, half[i].triangle}, half[first].forward == half[i].forward});
  }
  return edges;
}

/// Union-find whose sets also know whether each member is turned against the set's root.
class OrientedSets {
 public:
  explicit OrientedSets(size_t n) : parent_(n), turned_(n, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }
  int32_t root(int32_t n) {
    // two passes: find the root and the parity, then shorten the path
    int32_t top = n;
    uint8_t parity = 0;
    for (; parent_[top] != top; top = parent_[top]) parity ^= turned_[top];
    while (parent_[n] != n) {
      const int32_t next = parent_[n];
      const uint8_t rest = parity ^ turned_[n];
      parent_[n] = top;
      turned_[n] = parity;
      parity = rest;
      n = next;
    }
    return top;
  }
  bool turned(int32_t n) {
    root(n);
    return turned_[n];
  }
  /// @return false if the two are in one set already with another parity.
  bool join(int32_t a, int32_t b, bool turned) {
    const int32_t ra = root(a), rb = root(b);
    const uint8_t parity = turned_[a] ^ turned_[b] ^ static_cast<uint8_t>(turned);
    if (ra == rb) return parity == 0;
    parent_[rb] = ra;
    turned_[rb] = parity;
    return true;
  }

 private:
  std::vector<int32_t> parent_;
  std::vector<uint8_t> turned_;
};

Vec3 area_vector(const LatticeMesh& mesh, size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Vec3& p = mesh.vertices[a];
  return scaled(cross(minus(mesh.vertices[b], p), minus(mesh.vertices[c], p)), 0.5);
}

/// Turns triangles so that a piece is wound one way. @return triangles of pieces with no such way.
std::vector<int32_t> orient(LatticeMesh& mesh, const Edges& edges) {
  const size_t n = mesh.triangles.size();
  OrientedSets sets(n);
  std::vector<int32_t> conflicts;
  for (const Link& edge : edges.manifold)
    if (!sets.join(edge.triangle[0], edge.triangle[1], edge.turned))
      conflicts.push_back(edge.triangle[0]);
  std::vector<double> balance(n, 0);  // area that agrees with the root, less the other
  for (size_t t = 0; t < n; ++t) {
    const auto i = static_cast<int32_t>(t);
    balance[sets.root(i)] += (sets.turned(i) ? -1 : 1) * norm(area_vector(mesh, t));
  }
  for (size_t t = 0; t < n; ++t) {
    const auto i = static_cast<int32_t>(t);
    if (sets.turned(i) == (balance[sets.root(i)] < 0)) continue;
    std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
    ++mesh.turned;
  }
  return conflicts;
}

/// What decides whether a piece is a sheet.
struct PieceShape {
  Box box;
  double area = 0;
  double longest_loop = 0;  ///< of its border
  bool unorientable = false;

  bool is_sheet() const {
    const double size = std::max({box.extent(0), box.extent(1), box.extent(2)});
    return unorientable || (size > kSheetSize && longest_loop > kSheetLoop * std::sqrt(area));
  }
};

/// Calls visit(triangle, length of its border loop) for each border edge; edges that share a
/// vertex are of one loop.
template <class Visit>
void for_each_loop(const LatticeMesh& mesh, const Edges& edges, const Visit& visit) {
  OrientedSets loops(mesh.vertices.size());
  for (const HalfEdge& edge : edges.border) loops.join(edge.lower, edge.upper, false);
  std::vector<double> length(mesh.vertices.size(), 0);
  for (const HalfEdge& edge : edges.border)
    length[loops.root(edge.lower)] +=
        norm(minus(mesh.vertices[edge.lower], mesh.vertices[edge.upper]));
  for (const HalfEdge& edge : edges.border) visit(edge.triangle, length[loops.root(edge.lower)]);
}

void find_sheets(LatticeMesh& mesh, const Edges& edges, const std::vector<int32_t>& conflicts) {
  const size_t n = mesh.triangles.size();
  OrientedSets pieces(n);
  for (const auto* links : {&edges.manifold, &edges.branching})
    for (const Link& edge : *links) pieces.join(edge.triangle[0], edge.triangle[1], false);
  std::vector<PieceShape> shape(n);
  const auto piece_of = [&](int32_t t) -> PieceShape& { return shape[pieces.root(t)]; };
  for (size_t t = 0; t < n; ++t) {
    PieceShape& piece = piece_of(static_cast<int32_t>(t));
    piece.area += norm(area_vector(mesh, t));
    for (const int32_t v : mesh.triangles[t]) piece.box.add(mesh.vertices[v]);
  }
  for_each_loop(mesh, edges, [&](int32_t t, double length) {
    piece_of(t).longest_loop = std::max(piece_of(t).longest_loop, length);
  });
  for (const int32_t t : conflicts) piece_of(t).unorientable = true;
  for (size_t t = 0; t < n; ++t) {
    mesh.sheet[t] = piece_of(static_cast<int32_t>(t)).is_sheet();
    mesh.sheets += mesh.sheet[t];
  }
}

}  // namespace

Vec3 Lattice::coordinates(const double* p) const {
  Vec3 result;
  for (int d = 0; d < 3; ++d) {
    const double x = (p[d] - origin[d]) / h, whole = std::round(x);
    result[d] = std::abs(x - whole) < kSnap ? whole : x;
  }
  return result;
}

Lattice choose_lattice(const Box& box, const VoxelizeOptions& options) {
  double longest = 0;
  for (int d = 0; d < 3; ++d) longest = std::max(longest, box.extent(d));
  ELASTOGEN_CHECK(options.h > 0 || options.voxels > 0, "voxels must be positive, got ",
                  options.voxels);
  ELASTOGEN_CHECK(options.h >= 0 && std::isfinite(options.h), "h must be positive, got ",
                  options.h);
  ELASTOGEN_CHECK_ASSET(longest > 0 && std::isfinite(longest), "the surface has no extent");
  ELASTOGEN_CHECK(options.h <= longest * (1 + 1e-6), "h = ", options.h,
                  " m is more than the body's longest edge, ", longest, " m");
  Lattice lattice;
  lattice.h = options.h > 0 ? options.h : longest / options.voxels;
  for (int d = 0; d < 3; ++d) {
    const double count = std::max(1.0, std::ceil(box.extent(d) / lattice.h - 1e-6));
    if (!(count < kLatticeLimit))
      throw Error(concat("h = ", lattice.h, " m gives ", count, " voxels along ", "xyz"[d],
                         "; the limit is 2^20, h >= ", box.extent(d) / (kLatticeLimit - 1), " m"),
                  ErrorKind::kResources);
    lattice.origin[d] = box.lower[d] + (box.extent(d) - count * lattice.h) / 2;
    if (!options.align[d]) continue;
    const double plane = *options.align[d];
    ELASTOGEN_CHECK(std::isfinite(plane), "a plane to align must be finite, got ", plane);
    const double place = (plane - lattice.origin[d]) / lattice.h;
    lattice.origin[d] += lattice.h * (place - std::round(place));
  }
  return lattice;
}

LatticeMesh make_lattice_mesh(const WeldedMesh& welded, const Lattice& lattice) {
  LatticeMesh mesh;
  mesh.vertices.resize(welded.vertices.rows());
  for (int64_t v = 0; v < welded.vertices.rows(); ++v)
    mesh.vertices[v] = lattice.coordinates(welded.vertices.row(v));
  mesh.triangles.resize(welded.triangles.rows());
  for (int64_t t = 0; t < welded.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) mesh.triangles[t][k] = welded.triangles(t, k);
  mesh.sheet.assign(mesh.triangles.size(), 0);

  // nothing to repair in a closed mesh that is wound one way
  if (welded.closed() && welded.turned_edges == 0) return mesh;
  const Edges edges = find_edges(mesh.triangles);
  const std::vector<int32_t> conflicts = orient(mesh, edges);
  find_sheets(mesh, edges, conflicts);
  return mesh;
}

}  // namespace elastogen
