// SPDX-License-Identifier: Apache-2.0
#include "scene/asset_part.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "scene/name_pattern.hpp"
#include "scene/paint.hpp"
#include "scene/set_up.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/labels.hpp"
#include "voxelize/particle_surface.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace elastogen {
namespace {

using Kind = Selection::Kind;

constexpr double kCarries = 1e-6;  // least weight of a node that carries a point

Vec3 row(In<double> x, int64_t k) {
  return {x(k, 0), x(k, 1), x(k, 2)};
}

Vec3 centre_of(const VoxelGrid& grid, int64_t voxel) {
  return plus(row(grid.rest, grid.corners(voxel, 0)), {grid.h / 2, grid.h / 2, grid.h / 2});
}

std::vector<std::string> names_of(const std::vector<AssetMaterial>& materials) {
  std::vector<std::string> names;
  for (const AssetMaterial& material : materials) names.push_back(material.name);
  return names;
}

/// Names of nodes; one without a name has that of its mesh.
std::vector<std::string> node_names(const Asset& asset) {
  std::vector<std::string> names;
  for (const AssetNode& node : asset.nodes)
    names.push_back(node.name.empty() && node.mesh >= 0 ? asset.meshes[size_t(node.mesh)].name
                                                        : node.name);
  return names;
}

/// 1 for each name that matches. @throws Error (usage) if none does.
std::vector<uint8_t> named(const std::vector<std::string>& names, const Selection& selection) {
  std::vector<uint8_t> result(names.size());
  bool any = false;
  for (size_t k = 0; k < names.size(); ++k) {
    result[k] = matches(selection.name, names[k]);
    any |= result[k] != 0;
  }
  ELASTOGEN_CHECK(any, "the asset has no ", selection.kind == Kind::kNode ? "node" : "material",
                  " '", selection.name, "'; it has ", quoted_names({names.begin(), names.end()}));
  return result;
}

/// Adds the points at the very places of those that are there already.
void add_same_places(In<double> x, Array<uint8_t>& points) {
  std::vector<Vec3> places;
  for (int64_t p = 0; p < points.rows(); ++p)
    if (points(p)) places.push_back(row(x, p));
  std::ranges::sort(places);
  for (int64_t p = 0; p < points.rows(); ++p)
    points(p) = std::ranges::binary_search(places, row(x, p));
}

/// Finds the voxels and points of parts; what they have in common is made once.
class PartFinder {
 public:
  PartFinder(const Asset& asset, const Body& body, const VoxelGrid& grid)
      : asset_(asset), body_(body), surface_(body.surface), grid_(grid) {}

  AssetPart find(const Selection& selection) {
    AssetPart part;
    part.selection = selection;
    part.elements = Array<uint8_t>(grid_.voxel_count());
    part.points = Array<uint8_t>(body_.carried.rows());
    const bool painted = selection.kind == Kind::kColour || selection.kind == Kind::kAttribute;
    ELASTOGEN_CHECK(painted || body_.is_asset,
                    "an asset of points has no nodes and materials; select by place, colour or "
                    "attribute");
    if (!body_.is_asset)
      find_painted_points(part);
    else
      painted ? find_painted(part) : find_named(part);
    add_same_places(body_.carried, part.points);
    add_nodes(part);
    return part;
  }

 private:
  const Array<int32_t>& nearest() {
    if (nearest_.empty()) nearest_ = nearest_triangles(grid_, surface_);
    return nearest_;
  }

  /// Triangles of materials or nodes, and their vertices; of nodes also those without a triangle.
  void find_named(AssetPart& part) {
    std::vector<uint8_t> triangles(size_t(surface_.triangles.rows()));
    if (part.selection.kind == Kind::kMaterial) {
      const std::vector<uint8_t> wanted = named(names_of(asset_.materials), part.selection);
      for (size_t t = 0; t < triangles.size(); ++t) {
        const int32_t m = surface_.material(int64_t(t));
        triangles[t] = m >= 0 && wanted[size_t(m)];
      }
    } else {
      add_instances(named(node_names(asset_), part.selection), triangles, part.points);
    }
    for (size_t t = 0; t < triangles.size(); ++t)
      for (int c = 0; c < 3 && triangles[t]; ++c)
        part.points(surface_.triangles(int64_t(t), c)) = 1;
    for (int64_t v = 0; v < part.elements.rows(); ++v)
      part.elements(v) = triangles[size_t(nearest()(v))];
  }

  /// Adds what nodes, and those below them, show.
  void add_instances(const std::vector<uint8_t>& wanted, std::vector<uint8_t>& triangles,
                     Array<uint8_t>& points) const {
    for (const SurfaceInstance& instance : surface_.instances) {
      bool inside = false;
      for (int n = instance.node; n >= 0; n = asset_.nodes[size_t(n)].parent)
        inside |= wanted[size_t(n)] != 0;
      if (!inside) continue;
      std::fill_n(triangles.begin() + instance.first_triangle, instance.triangles, uint8_t(1));
      std::fill_n(points.row(instance.first_vertex),
                  asset_.meshes[size_t(instance.mesh)].position.size(), uint8_t(1));
    }
  }

  void find_painted(AssetPart& part) {
    const Paint paint(asset_, part.selection);
    // vertices; a drawn one is enough
    for (const SurfaceInstance& instance : surface_.instances) {
      const Mesh& mesh = asset_.meshes[size_t(instance.mesh)];
      for (size_t v = 0; v < mesh.position_of.size(); ++v)
        if (paint.at_vertex(mesh, int32_t(v)))
          part.points(instance.first_vertex + mesh.position_of[v]) = 1;
    }
    // voxels, by the place of the surface nearest to their centres
    if (corners_.empty()) corners_ = triangle_corners(asset_, surface_);
    const Array<int32_t>& triangles = nearest();
    for_each(part.elements.rows(), [&](int64_t v) {
      const int32_t t = triangles(v);
      Vec3 corner[3];
      for (int c = 0; c < 3; ++c) corner[c] = row(surface_.vertices, surface_.triangles(t, c));
      part.elements(v) =
          paint.at(corners_[size_t(t)], nearest_weights(corner, centre_of(grid_, v)));
    });
  }

  /// Points and splats; voxels by the nearest of those that do not lie far from the body.
  void find_painted_points(AssetPart& part) {
    const Paint paint(asset_, part.selection);
    for (int64_t p = 0; p < part.points.rows(); ++p) part.points(p) = paint.at_point(size_t(p));
    if (nearest_.empty()) {
      std::vector<int32_t> near;
      for (int64_t p = 0; p < body_.carried.rows(); ++p)
        if (is_near(row(body_.carried, p))) near.push_back(int32_t(p));
      Array<double> x(int64_t(near.size()), 3);
      for (int64_t k = 0; k < x.rows(); ++k)
        std::copy_n(body_.carried.row(near[size_t(k)]), 3, x.row(k));
      std::vector<Vec3> centres;
      for (int64_t v = 0; v < grid_.voxel_count(); ++v) centres.push_back(centre_of(grid_, v));
      const std::vector<int32_t> of = nearest_particles(x, grid_.h, centres);
      nearest_ = Array<int32_t>(int64_t(of.size()));
      for (size_t v = 0; v < of.size(); ++v) nearest_(int64_t(v)) = near[size_t(of[v])];
    }
    for (int64_t v = 0; v < part.elements.rows(); ++v) part.elements(v) = part.points(nearest_(v));
  }

  /// Whether a point is within two voxels of the body's box.
  bool is_near(const Vec3& x) const {
    for (size_t d = 0; d < 3; ++d)
      if (std::max(surface_.box.lower[d] - x[d], x[d] - surface_.box.upper[d]) > 2 * grid_.h)
        return false;
    return true;
  }

  /// Corners of the voxels, and nodes that carry points no farther than a voxel from theirs.
  void add_nodes(AssetPart& part) {
    part.nodes = Array<uint8_t>(grid_.node_count());
    for (int64_t v = 0; v < grid_.voxel_count(); ++v)
      for (int c = 0; c < 8 && part.elements(v); ++c) part.nodes(grid_.corners(v, c)) = 1;
    if (embedding_.voxel.empty()) embedding_ = embed(grid_, body_.carried, parts_of_carried(body_));
    for (int64_t p = 0; p < part.points.rows(); ++p) {
      const int32_t v = embedding_.voxel(p);
      const Vec3 from = minus(row(body_.carried, p), centre_of(grid_, v));
      const double far = std::max({std::abs(from[0]), std::abs(from[1]), std::abs(from[2])});
      for (int c = 0; c < 8 && part.points(p) && far < 1.5 * grid_.h; ++c)
        if (std::abs(embedding_.weights(p, c)) > kCarries) part.nodes(grid_.corners(v, c)) = 1;
    }
  }

  const Asset& asset_;
  const Body& body_;
  const Surface& surface_;
  const VoxelGrid& grid_;
  Array<int32_t> nearest_;  ///< triangle or point of each voxel
  std::vector<TriangleCorners> corners_;
  Embedding embedding_;  ///< of all points
};

/// The part of tetrahedra in regions of the file.
AssetPart part_of_tets(const TetAsset& tets, const Selection& selection) {
  ELASTOGEN_CHECK(selection.kind == Kind::kMaterial,
                  "tetrahedra have no nodes with names, colours or attributes; select by place or "
                  "material:NUMBER");
  const std::vector<uint8_t> wanted = named(names_of(tets.regions), selection);
  const Array<int32_t>& elements = tets.mesh.elements;
  AssetPart part;
  part.selection = selection;
  part.elements = Array<uint8_t>(elements.rows());
  part.nodes = Array<uint8_t>(tets.mesh.rest.rows());
  for (int64_t e = 0; e < elements.rows(); ++e) {
    part.elements(e) = wanted[size_t(tets.region(e))];
    for (int c = 0; c < elements.cols() && part.elements(e); ++c) part.nodes(elements(e, c)) = 1;
  }
  part.points = Array<uint8_t>(tets.node_of.rows());
  for (int64_t p = 0; p < part.points.rows(); ++p) part.points(p) = part.nodes(tets.node_of(p));
  return part;
}

/// Calls found(option, text, selection) for each option that selects a part.
template <class Found>
void for_parts(const RunDescription& run, const Found& found) {
  const auto each = [&](const char* option, const auto& values) {
    for (const auto& value : values)
      if (!value.selection.is_place()) found(option, value.text, value.selection);
  };
  each("--pin", run.pins);
  each("--region", run.regions);
  each("--hold", run.holds);
  each("--traction", run.tractions);
  each("--force", run.forces);
  each("--move", run.moves);
}

/// Parts of a run, each found once. @throws Error of find with the option.
template <class Find>
std::vector<AssetPart> parts_by(const RunDescription& run, const Find& find) {
  std::vector<AssetPart> parts;
  for_parts(run, [&](const char* option, const std::string& text, const Selection& selection) {
    if (std::ranges::find(parts, selection, &AssetPart::selection) != parts.end()) return;
    try {
      parts.push_back(find(selection));
    } catch (const Error& error) {
      throw Error(concat(option, " '", text, "': ", error.what()), error.kind());
    }
  });
  return parts;
}

}  // namespace

bool asks_for_attributes(const RunDescription& run) {
  bool asks = false;
  for_parts(run, [&](const char*, const std::string&, const Selection& selection) {
    asks |= selection.kind == Kind::kAttribute;
  });
  return asks;
}

std::vector<AssetPart> asset_parts(const RunDescription& run, const Asset& asset, const Body& body,
                                   const VoxelGrid& grid) {
  PartFinder finder(asset, body, grid);
  return parts_by(run, [&](const Selection& selection) { return finder.find(selection); });
}

std::vector<AssetPart> asset_parts(const RunDescription& run, const TetAsset& tets) {
  return parts_by(run, [&](const Selection& selection) { return part_of_tets(tets, selection); });
}

const AssetPart& part_of(const std::vector<AssetPart>& parts, const Selection& selection) {
  const auto part = std::ranges::find(parts, selection, &AssetPart::selection);
  assert(part != parts.end());
  return *part;
}

Array<uint8_t> selected_nodes(const Setup& setup, const Selection& selection) {
  if (!selection.is_place()) return part_of(setup.parts, selection).nodes;
  return select_nodes(setup.scene.grid, selection, setup.body.surface.box);
}

bool has_point(const Setup& setup, const Selection& selection, int64_t point) {
  if (!selection.is_place()) return part_of(setup.parts, selection).points(point) != 0;
  return contains(selection, row(setup.body.carried, point), setup.body.surface.box);
}

}  // namespace elastogen
