// SPDX-License-Identifier: Apache-2.0
#include "voxelize/sheets.hpp"

#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "voxelize/winding_number.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kSheetLoop = 2;    // length of a border loop / sqrt(area) that makes a sheet
constexpr double kSheetSize = 3;    // [voxel edges]
constexpr double kBounding = 0.25;  // winding number from 1/2, 3/2, ... on what bounds a solid
constexpr double kHelp = 0.05;      // of it from other pieces where a piece bounds one with them
constexpr double kFree = 0.15;      // and from a whole number on what does not
constexpr double kFreeScrap = 0.05;
constexpr int64_t kSamples = 256;  // triangles of a piece that are asked
constexpr double kOff = 1e-4;      // sides of a triangle are asked this far from it [voxel edges]

/// Triangles joined by edges of two faces.
struct Piece {
  Box box;
  double area = 0;
  double longest_loop = 0;  ///< of its border
  bool unorientable = false;
  bool ends = false;  ///< it has an edge with one face, or with three or more
  std::vector<int32_t> triangles;
  double sampled = 0, free = 0, scrap = 0;  ///< area of the samples of each kind
  double bounding = 0;  ///< of those that bound a solid with other pieces, with the sign of w
  bool outside = true;  ///< the free ones lie in no solid

  double size() const { return std::max({box.extent(0), box.extent(1), box.extent(2)}); }
  bool looks_like_sheet() const {
    return unorientable || longest_loop > kSheetLoop * std::sqrt(area);
  }
  /// @param sign  of the winding number in solids, 0 where pieces do not agree on it.
  Role role(double sign) const {
    if (size() <= kSheetSize) return scrap > 0.5 * sampled ? Role::kScrap : Role::kSolid;
    if (free > 0.5 * sampled) return outside ? Role::kSheet : Role::kScrap;
    return looks_like_sheet() && !bounds_jointly(sign) ? Role::kSheet : Role::kSolid;
  }
  /// Most of it bounds a solid together with other pieces.
  bool bounds_jointly(double sign) const { return sign * bounding > 0.5 * sampled; }
};

/// Calls visit(triangle, length of its border loop) for each border edge; edges that share a
/// vertex are of one loop.
template <class Visit>
void for_each_loop(const LatticeMesh& mesh, const Edges& edges, const Visit& visit) {
  OrientedSets loops(mesh.vertices.size());
  for (const HalfEdge& edge : edges.border) loops.join(edge.lower, edge.upper, false);
  std::vector<double> length(mesh.vertices.size(), 0);
  for (const HalfEdge& edge : edges.border)
    length[size_t(loops.root(edge.lower))] +=
        norm(minus(mesh.vertices[size_t(edge.lower)], mesh.vertices[size_t(edge.upper)]));
  for (const HalfEdge& edge : edges.border)
    visit(edge.triangle, length[size_t(loops.root(edge.lower))]);
}

/// Pieces in the order of their first triangles.
std::vector<Piece> find_pieces(const LatticeMesh& mesh, const Edges& edges,
                               const std::vector<int32_t>& conflicts) {
  const size_t n = mesh.triangles.size();
  OrientedSets sets(n);
  for (const Link& edge : edges.manifold) sets.join(edge.triangle[0], edge.triangle[1], false);
  std::vector<Piece> pieces;
  std::vector<int32_t> number(n, -1);  // of the piece of each root
  for (size_t t = 0; t < n; ++t) {
    int32_t& piece = number[size_t(sets.root(int32_t(t)))];
    if (piece < 0) {
      piece = int32_t(pieces.size());
      pieces.emplace_back();
    }
    Piece& p = pieces[size_t(piece)];
    p.triangles.push_back(int32_t(t));
    p.area += norm(area_vector(mesh, t));
    for (const int32_t v : mesh.triangles[t]) p.box.add(mesh.vertices[size_t(v)]);
  }
  const auto piece_of = [&](int32_t t) -> Piece& {
    return pieces[size_t(number[size_t(sets.root(t))])];
  };
  for_each_loop(mesh, edges, [&](int32_t t, double length) {
    Piece& piece = piece_of(t);
    piece.longest_loop = std::max(piece.longest_loop, length);
    piece.ends = true;
  });
  for (const Link& edge : edges.branching)
    for (const int32_t t : edge.triangle) piece_of(t).ends = true;
  for (const int32_t t : conflicts) piece_of(t).unorientable = true;
  return pieces;
}

/// Mean of the winding numbers on both sides of a triangle.
double winding_on(const WindingNumber& winding_number, const Vec3& middle, const Vec3& off) {
  return (winding_number(plus(middle, off)) + winding_number(minus(middle, off))) / 2;
}

WindingNumber winding_number_of(const LatticeMesh& mesh, const std::vector<int32_t>& triangles) {
  std::vector<WindingNumber::Triangle> list;
  list.reserve(triangles.size());
  for (const int32_t t : triangles) {
    const Coord& corner = mesh.triangles[size_t(t)];
    list.push_back({mesh.vertices[size_t(corner[0])], mesh.vertices[size_t(corner[1])],
                    mesh.vertices[size_t(corner[2])]});
  }
  return WindingNumber(std::move(list));
}

/// Asks the winding number on both sides of some triangles of a piece.
void sample(const LatticeMesh& mesh, const WindingNumber& whole, Piece& piece) {
  const WindingNumber alone =
      winding_number_of(mesh, piece.unorientable ? std::vector<int32_t>() : piece.triangles);
  const auto count = int64_t(piece.triangles.size());
  const int64_t stride = (count + kSamples - 1) / kSamples;
  for (int64_t i = 0; i < count; i += stride) {
    const auto t = size_t(piece.triangles[size_t(i)]);
    const Vec3 normal = area_vector(mesh, t);
    const double area = norm(normal);
    if (!(area > 0)) continue;
    Vec3 middle = {};
    for (const int32_t v : mesh.triangles[t])
      middle = plus(middle, scaled(mesh.vertices[size_t(v)], 1.0 / 3));
    const Vec3 off = scaled(normal, kOff / area);
    const double w = winding_on(whole, middle, off);
    const double help = std::abs(w - winding_on(alone, middle, off));
    const double from_whole = std::abs(w - std::round(w));
    piece.sampled += area;
    if (0.5 - from_whole < kBounding && help > kHelp) piece.bounding += w > 0 ? area : -area;
    if (from_whole < kFree) {
      piece.free += area;
      piece.outside &= std::abs(w) < 0.5;
    }
    if (from_whole < kFreeScrap) piece.scrap += area;
  }
}

/// +-1 where the pieces that bound solids together are wound one way, else 0.
double common_sign(const std::vector<Piece>& pieces) {
  double sum = 0, size = 0;
  for (const Piece& piece : pieces) {
    sum += piece.bounding;
    size += std::abs(piece.bounding);
  }
  return std::abs(sum) > 0.5 * size ? std::copysign(1.0, sum) : 0;
}

}  // namespace

Vec3 area_vector(const LatticeMesh& mesh, size_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  const Vec3& p = mesh.vertices[size_t(a)];
  return scaled(cross(minus(mesh.vertices[size_t(b)], p), minus(mesh.vertices[size_t(c)], p)), 0.5);
}

void find_sheets(LatticeMesh& mesh, const Edges& edges, const std::vector<int32_t>& conflicts) {
  std::vector<Piece> pieces = find_pieces(mesh, edges, conflicts);
  const auto is_closed = [](const Piece& piece) { return !piece.ends && !piece.unorientable; };
  if (std::ranges::all_of(pieces, is_closed)) return;
  std::vector<int32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  const WindingNumber whole = winding_number_of(mesh, all);
  for_each(int64_t(pieces.size()), [&](int64_t i) {
    if (!is_closed(pieces[size_t(i)])) sample(mesh, whole, pieces[size_t(i)]);
  });
  const double sign = common_sign(pieces);
  mesh.joint.assign(mesh.triangles.size(), 0);
  for (const Piece& piece : pieces)
    for (const int32_t t : piece.triangles)
      if (!is_closed(piece)) {
        mesh.role[size_t(t)] = piece.role(sign);
        mesh.joint[size_t(t)] = piece.bounds_jointly(sign);
      }
  mesh.sheets = std::ranges::count(mesh.role, Role::kSheet);
}

}  // namespace elastogen
