// SPDX-License-Identifier: Apache-2.0
#include "scene/shape.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/units.hpp"
#include "voxelize/regions.hpp"

#include <cmath>
#include <map>
#include <numbers>

namespace elastogen {
namespace {

using Kind = BodyShape::Kind;

constexpr const char* kKinds[] = {"box", "sphere", "rectangle", "disk"};
constexpr int kParts = 32;     // into which edges of the octahedron are divided
constexpr int kCorners = 256;  // corners of a disk

BodyShape parsed(std::string_view text) {
  const std::string bare = without_blanks(text);
  const auto parts = split(bare, '(');
  ELASTOGEN_CHECK(parts.size() == 2 && parts[1].ends_with(')'), "a bracket is missing");
  BodyShape shape;
  int kind = 0;
  while (kind < 4 && parts[0] != kKinds[kind]) ++kind;
  ELASTOGEN_CHECK(kind < 4, "'", parts[0], "' is none of the known shapes");
  shape.kind = Kind(kind);
  const auto numbers = split(parts[1].substr(0, parts[1].size() - 1), ',');
  const size_t wanted = shape.is_round() ? 4 : 6;
  ELASTOGEN_CHECK(numbers.size() == wanted, "it needs ", wanted, " numbers, got ", numbers.size());
  for (size_t a = 0; a < 3; ++a) {
    (shape.is_round() ? shape.centre : shape.lower)[a] = parse_length(numbers[a]);
    if (!shape.is_round()) shape.upper[a] = parse_length(numbers[3 + a]);
  }
  if (shape.is_round()) shape.radius = parse_length(numbers[3]);
  return shape;
}

void check(const BodyShape& s) {
  if (s.in_plane())
    ELASTOGEN_CHECK(s.centre[2] == 0 && s.lower[2] == 0 && s.upper[2] == 0,
                    "it lies in the plane z = 0");
  if (s.is_round()) {
    ELASTOGEN_CHECK(s.radius > 0, "its radius must be positive, got ", s.radius, " m");
    return;
  }
  for (size_t a = 0; a < (s.in_plane() ? 2 : 3); ++a)
    ELASTOGEN_CHECK(s.lower[a] < s.upper[a], "its lower corner comes first, and along ", "xyz"[a],
                    " it runs from ", s.lower[a], " to ", s.upper[a], " m");
}

/// Adds a triangle.
void add(Mesh& mesh, int a, int b, int c) {
  for (const int corner : {a, b, c}) mesh.groups[0].corner.push_back(corner);
}

void add_box(const BodyShape& s, Mesh& mesh) {
  for (int c = 0; c < 8; ++c)
    mesh.position.push_back({c & 1 ? s.upper[0] : s.lower[0], c & 2 ? s.upper[1] : s.lower[1],
                             c & 4 ? s.upper[2] : s.lower[2]});
  for (const auto& q : {std::array{0, 2, 3, 1},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 6, 7, 3},
                        {0, 4, 6, 2},
                        {1, 3, 7, 5}}) {
    add(mesh, q[0], q[1], q[2]);
    add(mesh, q[0], q[2], q[3]);
  }
}

/// The points i + j + k = kParts of each octant, projected to the sphere.
void add_sphere(const BodyShape& s, Mesh& mesh) {
  // neighbouring octants share vertices
  std::map<std::array<int, 3>, int> number;
  const auto vertex = [&](const std::array<int, 3>& at) {
    const auto [entry, is_new] = number.try_emplace(at, int(mesh.position.size()));
    if (is_new) {
      const double share = s.radius / std::hypot(at[0], at[1], at[2]);
      mesh.position.push_back(plus(s.centre, {share * at[0], share * at[1], share * at[2]}));
    }
    return entry->second;
  };
  // each octant is a face of an octahedron; mirrored ones have the opposite winding
  for (int octant = 0; octant < 8; ++octant) {
    const int x = octant & 1 ? -1 : 1, y = octant & 2 ? -1 : 1, z = octant & 4 ? -1 : 1;
    const auto at = [&](int i, int j) { return vertex({x * i, y * j, z * (kParts - i - j)}); };
    const auto triangle = [&](int a, int b, int c) {
      if (x * y * z > 0)
        add(mesh, a, b, c);
      else
        add(mesh, a, c, b);
    };
    // two triangles for each pair (i, j), one at the rim
    for (int i = 0; i < kParts; ++i)
      for (int j = 0; i + j < kParts; ++j) {
        triangle(at(i, j), at(i + 1, j), at(i, j + 1));
        if (i + j + 1 < kParts) triangle(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
      }
  }
}

void add_rectangle(const BodyShape& s, Mesh& mesh) {
  mesh.position = {s.lower, {s.upper[0], s.lower[1], 0}, s.upper, {s.lower[0], s.upper[1], 0}};
  add(mesh, 0, 1, 2);
  add(mesh, 0, 2, 3);
}

void add_disk(const BodyShape& s, Mesh& mesh) {
  for (int k = 0; k < kCorners; ++k) {
    const double angle = 2 * std::numbers::pi * k / kCorners;
    mesh.position.push_back(
        plus(s.centre, {s.radius * std::cos(angle), s.radius * std::sin(angle), 0}));
  }
  for (int k = 1; k + 1 < kCorners; ++k) add(mesh, 0, k, k + 1);
}

}  // namespace

bool BodyShape::contains(const Vec3& x) const {
  if (is_round()) return norm(minus(x, centre)) < radius;
  for (size_t a = 0; a < (in_plane() ? 2 : 3); ++a)
    if (x[a] < lower[a] || x[a] >= upper[a]) return false;
  return true;
}

const char* kind_name(Kind kind) {
  return kKinds[int(kind)];
}

BodyShape parse_shape(std::string_view text) {
  try {
    const BodyShape shape = parsed(text);
    check(shape);
    return shape;
  } catch (const Error& error) {
    throw Error(concat("--shape '", text, "': ", error.what(),
                       "; it reads: box(x0,y0,z0, x1,y1,z1), sphere(x,y,z, r), "
                       "rectangle(x0,y0,0, x1,y1,0) or disk(x,y,0, r)"));
  }
}

Asset shape_asset(const BodyShape& shape) {
  // an asset in metres with y up
  Asset asset;
  asset.path = kind_name(shape.kind);
  asset.format = "shape";
  asset.up = 2;
  asset.unit = 1;
  Mesh& mesh = asset.meshes.emplace_back();
  mesh.name = kind_name(shape.kind);
  mesh.groups.emplace_back().has_uv = false;
  // the mesh of the shape
  switch (shape.kind) {
    case Kind::kBox:
      add_box(shape, mesh);
      break;
    case Kind::kSphere:
      add_sphere(shape, mesh);
      break;
    case Kind::kRectangle:
      add_rectangle(shape, mesh);
      break;
    case Kind::kDisk:
      add_disk(shape, mesh);
      break;
  }
  // one node shows it
  for (size_t k = 0; k < mesh.position.size(); ++k) mesh.position_of.push_back(int32_t(k));
  asset.nodes.push_back({mesh.name, -1, kIdentity4, 0});
  return asset;
}

}  // namespace elastogen
