// SPDX-License-Identifier: Apache-2.0
#include "voxelize/sheets.hpp"

#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "voxelize/winding_number.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kSheetLoop = 2;  // border loop / sqrt(area) above which a piece is a sheet
constexpr double kSheetSize = 3;  // size of the largest piece that cannot be a sheet [voxel edges]
constexpr double kBounding = 0.25;  // distance of w from 1/2, 3/2, ... on the border of a solid
constexpr double kHelp = 0.05;  // least part of w from other pieces, if they bound the solid too
constexpr double kFree = 0.15;  // largest distance of w from a whole number on other triangles
constexpr double kFreeScrap = 0.05;
constexpr int64_t kSamples = 256;  // triangles of a piece that are sampled
constexpr double kOff = 1e-4;      // distance of samples from their triangle [voxel edges]

/// Triangles connected by edges that have two faces.
struct Piece {
  Box box;
  double area = 0;
  double longest_loop = 0;  ///< longest loop of its border
  bool unorientable = false;
  bool ends = false;  ///< it has an edge with one face, or with three or more
  std::vector<int32_t> triangles;
  double sampled = 0, free = 0, scrap = 0;  ///< area of all samples, and of two kinds of them
  double bounding = 0;  ///< area that bounds a solid with other pieces, with the sign of w
  bool outside = true;  ///< no free sample lies in a solid

  double size() const { return std::max({box.extent(0), box.extent(1), box.extent(2)}); }
  bool looks_like_sheet() const {
    return unorientable || longest_loop > kSheetLoop * std::sqrt(area);
  }
  /// @param sign  sign of the winding number in solids, 0 if pieces do not agree on it.
  Role role(double sign) const {
    if (size() <= kSheetSize) return scrap > 0.5 * sampled ? Role::kScrap : Role::kSolid;
    if (free > 0.5 * sampled) return outside ? Role::kSheet : Role::kScrap;
    return looks_like_sheet() && !bounds_jointly(sign) ? Role::kSheet : Role::kSolid;
  }
  /// Whether most of its area bounds a solid together with other pieces.
  bool bounds_jointly(double sign) const { return sign * bounding > 0.5 * sampled; }
};

/// Calls visit(triangle, length of its border loop) for each border edge. Edges that share a vertex
/// belong to one loop.
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

/// The pieces in the order of their first triangles.
std::vector<Piece> find_pieces(const LatticeMesh& mesh, const Edges& edges,
                               const std::vector<int32_t>& conflicts) {
  const size_t n = mesh.triangles.size();
  OrientedSets sets(n);
  // triangles of each piece, joined over edges of two faces
  for (const Link& edge : edges.manifold) sets.join(edge.triangle[0], edge.triangle[1], false);
  std::vector<Piece> pieces;
  std::vector<int32_t> number(n, -1);  // piece of each root
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
  // borders: the longest loop of each piece
  const auto piece_of = [&](int32_t t) -> Piece& {
    return pieces[size_t(number[size_t(sets.root(t))])];
  };
  for_each_loop(mesh, edges, [&](int32_t t, double length) {
    Piece& piece = piece_of(t);
    piece.longest_loop = std::max(piece.longest_loop, length);
    piece.ends = true;
  });
  // edges of three faces, and edges where winding fails
  for (const Link& edge : edges.branching)
    for (const int32_t t : edge.triangle) piece_of(t).ends = true;
  for (const int32_t t : conflicts) piece_of(t).unorientable = true;
  return pieces;
}

/// Mean of the winding numbers on both sides of a point of a triangle.
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

/// Samples the winding number on both sides of some triangles of a piece.
void sample(const LatticeMesh& mesh, const WindingNumber& whole, Piece& piece) {
  // the piece by itself, if it has an orientation
  const WindingNumber alone =
      winding_number_of(mesh, piece.unorientable ? std::vector<int32_t>() : piece.triangles);
  // evenly spaced triangles
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
    // w on the triangle, and the part of it that other pieces add
    const Vec3 off = scaled(normal, kOff / area);
    const double w = winding_on(whole, middle, off);
    const double help = std::abs(w - winding_on(alone, middle, off));
    const double from_whole = std::abs(w - std::round(w));
    // near 1/2: it bounds a solid; near a whole number: it bounds nothing
    piece.sampled += area;
    if (0.5 - from_whole < kBounding && help > kHelp) piece.bounding += w > 0 ? area : -area;
    if (from_whole < kFree) {
      piece.free += area;
      piece.outside &= std::abs(w) < 0.5;
    }
    if (from_whole < kFreeScrap) piece.scrap += area;
  }
}

/// +-1 if the pieces that bound solids together are wound alike, else 0.
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
