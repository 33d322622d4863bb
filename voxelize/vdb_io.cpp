// SPDX-License-Identifier: Apache-2.0
#include "voxelize/vdb_io.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/asset_check.hpp"
#include "io/safe_file.hpp"
#include "voxelize/vdb_check.hpp"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointCount.h>
#include <openvdb/points/PointDataGrid.h>
#include <openvdb/tools/ChangeBackground.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr float kOutside = 1e-3f;     ///< least depth of a continued value over the largest value
constexpr double kSharpShare = 0.55;  ///< VdbBorder::second_share above which the border is sharp

/// Largest and smallest value of the active voxels and tiles.
struct Range {
  float low = 0, high = 0;
};

Range range_of(const openvdb::FloatGrid& grid) {
  auto value = grid.cbeginValueOn();
  Range range = {*value, *value};
  for (; value; ++value) {
    range.low = std::min(range.low, *value);
    range.high = std::max(range.high, *value);
  }
  return range;
}

/// Mean value of the second voxel behind the border of a density, over the largest value. If it is
/// low, the density is a ramp that starts at 0 on the surface, as in fog volumes that OpenVDB makes
/// from level sets. If it is high, the values are filled shares.
struct VdbBorder {
  openvdb::FloatGrid::Ptr outside;  ///< voxels outside the border, with linearly continued values
  double second_share = 1;
};

VdbBorder border_of(const openvdb::FloatGrid& grid, float high) {
  VdbBorder border = {openvdb::FloatGrid::create(-high), 1};
  auto values = grid.getConstAccessor();
  auto outside = border.outside->getAccessor();
  double sum = 0;
  int64_t count = 0;
  for (auto at = grid.cbeginValueOn(); at; ++at) {
    if (!at.isVoxelValue()) continue;
    for (int d = 0; d < 6; ++d) {
      openvdb::Coord step(0);
      step[d / 2] = d % 2 == 0 ? 1 : -1;
      const openvdb::Coord next = at.getCoord() + step;
      if (values.isValueOn(next)) continue;
      const float second = values.getValue(at.getCoord() - step);
      const float continued = std::min(2 * *at - second, -kOutside * high);
      outside.setValue(next, std::max(continued, outside.getValue(next)));
      sum += double(second) / high;
      ++count;
    }
  }
  if (count > 0) border.second_share = sum / double(count);
  return border;
}

/// The value of a density on the surface. A ramp gets values beyond its border, so that its surface
/// is at 0.
double density_surface(openvdb::FloatGrid& grid, const std::string& place) {
  grid.setGridClass(openvdb::GRID_FOG_VOLUME);
  const float high = range_of(grid).high;
  ELASTOGEN_CHECK_ASSET(high > 0 && std::isfinite(high), place, "its largest value is ", high,
                        ", no density");
  const VdbBorder border = border_of(grid, high);
  if (border.second_share > kSharpShare) return high / 2.0;
  openvdb::tools::changeBackground(grid.tree(), -high);
  auto values = grid.getAccessor();
  for (auto at = border.outside->cbeginValueOn(); at; ++at) values.setValue(at.getCoord(), *at);
  return 0;
}

/// The value of a grid on the surface. Sets the class of the grid, which decides which side is
/// inside.
double surface_value(openvdb::FloatGrid& grid, const std::string& place) {
  const bool signed_values = grid.getGridClass() == openvdb::GRID_UNKNOWN && range_of(grid).low < 0;
  if (grid.getGridClass() != openvdb::GRID_LEVEL_SET && !signed_values)
    return density_surface(grid, place);
  grid.setGridClass(openvdb::GRID_LEVEL_SET);
  return 0;
}

/// The mesh of a grid: one quadrilateral for each cell of the surface.
Mesh mesh_of(openvdb::FloatGrid& grid, const std::string& place) {
  // size and memory
  const auto active = int64_t(grid.activeVoxelCount());
  ELASTOGEN_CHECK_ASSET(active > 0, place, "it has no active voxel");
  ELASTOGEN_CHECK_ASSET(active <= kMaxVdbVoxels, place, "it has ", active,
                        " active voxels, at most ", kMaxVdbVoxels, " are read; resample it");
  // extract the surface
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, triangles, quads, surface_value(grid, place));

  Mesh mesh;
  mesh.name = grid.getName();
  for (const openvdb::Vec3s& p : points) {
    mesh.position_of.push_back(int32_t(mesh.position.size()));
    mesh.position.push_back({p[0], p[1], p[2]});
  }
  // faces are turned, as OpenVDB winds them clockwise as seen from outside
  std::vector<int32_t>& corner = mesh.groups.emplace_back().corner;
  const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
    corner.insert(corner.end(), {int32_t(a), int32_t(b), int32_t(c)});
  };
  for (const openvdb::Vec3I& t : triangles) add(t[0], t[2], t[1]);
  for (const openvdb::Vec4I& q : quads) {
    add(q[0], q[2], q[1]);
    add(q[0], q[3], q[2]);
  }
  ELASTOGEN_CHECK_ASSET(!corner.empty(), place, "no surface lies in it");
  return mesh;
}

using PointGrid = openvdb::points::PointDataGrid;

/// A vector attribute of the points of a leaf; null if it has none of that type.
using Vectors = openvdb::points::AttributeHandle<openvdb::Vec3f>;
Vectors::Ptr vectors_of(const PointGrid::TreeType::LeafNodeType& leaf, const char* name) {
  const openvdb::points::AttributeArray* array =
      leaf.hasAttribute(name) ? &leaf.constAttributeArray(name) : nullptr;
  const bool fits = array && array->valueType() == "vec3s" && array->stride() == 1;
  return fits ? Vectors::create(*array) : nullptr;
}

/// Names of the attributes that a cloud cannot hold.
std::vector<std::string> lost_attributes(const PointGrid& grid) {
  std::vector<std::string> names;
  const auto leaf = grid.tree().cbeginLeaf();
  if (!leaf) return names;
  for (const auto& [name, place] : leaf->attributeSet().descriptor().map())
    if (name != "P" && name != "N" && name != "Cd" &&
        !openvdb::points::isGroup(*leaf->attributeSet().getConst(place)))
      names.push_back(name);
  return names;
}

/// The points of a grid, leaf by leaf.
PointCloud points_of(const PointGrid& grid, const std::string& place) {
  const auto count = int64_t(openvdb::points::pointCount(grid.tree()));
  ELASTOGEN_CHECK_ASSET(count > 0, place, "it has no points");
  ELASTOGEN_CHECK_ASSET(count <= kMaxVdbVoxels, place, "it has ", count, " points, at most ",
                        kMaxVdbVoxels, " are read");
  // attributes are kept only if every leaf has them
  PointCloud cloud;
  bool all_normal = true, all_coloured = true;
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    const auto position = vectors_of(*leaf, "P"), normal = vectors_of(*leaf, "N"),
               colour = vectors_of(*leaf, "Cd");
    ELASTOGEN_CHECK_ASSET(position, place, "its points have no positions P");
    all_normal = all_normal && normal;
    all_coloured = all_coloured && colour;
    // positions in the world, normals and colours as they are
    for (auto at = leaf->beginIndexOn(); at; ++at) {
      const openvdb::Vec3d p =
          grid.indexToWorld(openvdb::Vec3d(position->get(*at)) + at.getCoord().asVec3d());
      cloud.position.push_back({p[0], p[1], p[2]});
      const auto row = [&](const Vectors::Ptr& from) {
        const openvdb::Vec3f v = from->get(*at);
        return std::array<float, 3>{v[0], v[1], v[2]};
      };
      if (all_normal) cloud.normal.push_back(row(normal));
      if (!all_coloured) continue;
      const auto [r, g, b] = row(colour);
      cloud.colour.push_back({r, g, b, 1});
    }
  }
  if (!all_normal) cloud.normal.clear();
  if (!all_coloured) cloud.colour.clear();
  return cloud;
}

std::string type_of(const openvdb::GridBase& grid) {
  return grid.isType<PointGrid>() ? "points" : grid.valueType();
}

bool is_readable(const openvdb::GridBase& grid) {
  return grid.isType<openvdb::FloatGrid>() || grid.isType<PointGrid>();
}

std::string list_of(openvdb::io::File& file, const std::string& but = "") {
  std::string text;
  for (auto at = file.beginName(); at != file.endName(); ++at)
    if (at.gridName() != but)
      text += concat(text.empty() ? "" : ", ", '"', at.gridName(), "\" (",
                     type_of(*file.readGridMetadata(at.gridName())), ')');
  return text;
}

/// The grid with that name; without a name the first that can be read and is not empty, else the
/// first that can be read. @throws Error (asset) naming the grids if there is none.
openvdb::GridBase::Ptr chosen_grid(openvdb::io::File& file, const std::string& wanted) {
  ELASTOGEN_CHECK_ASSET(wanted.empty() || file.hasGrid(wanted), "there is no grid \"", wanted,
                        "\" in it, only ", list_of(file));
  openvdb::GridBase::Ptr first;
  for (auto at = file.beginName(); at != file.endName(); ++at) {
    if (!wanted.empty() && at.gridName() != wanted) continue;
    if (!is_readable(*file.readGridMetadata(at.gridName()))) continue;
    const openvdb::GridBase::Ptr grid = file.readGrid(at.gridName());
    if (grid->activeVoxelCount() > 0) return grid;
    if (!first) first = grid;
  }
  const std::string others = list_of(file);
  ELASTOGEN_CHECK_ASSET(first,
                        wanted.empty() ? "there is no float grid and no points in it"
                                       : concat("the grid \"", wanted, "\" is not read"),
                        others.empty() ? "" : ", only " + others);
  return first;
}

Asset read_grid(const std::string& path, const std::string& wanted) {
  // open, and choose a grid
  openvdb::initialize();
  Asset asset;
  asset.path = path;
  asset.format = "vdb";
  openvdb::io::File file(path);
  file.open(false);
  check_vdb_is_whole(path);
  const openvdb::GridBase::Ptr grid = chosen_grid(file, wanted);
  const std::string name = grid->getName(), place = concat("grid \"", name, "\": ");
  // the others are a finding
  int64_t grids = 0;
  for (auto at = file.beginName(); at != file.endName(); ++at) ++grids;
  if (wanted.empty())
    add_finding(asset, "vdb-grids", grids - 1,
                concat("grids were left out: ", list_of(file, name), "; read was \"", name, '"'));
  // a cloud, or a mesh
  if (grid->isType<PointGrid>()) {
    const auto points = openvdb::gridPtrCast<PointGrid>(grid);
    asset.points = points_of(*points, place);
    note_lost_columns(asset, lost_attributes(*points));
    return asset;
  }
  asset.meshes.push_back(mesh_of(*openvdb::gridPtrCast<openvdb::FloatGrid>(grid), place));
  asset.nodes.push_back({name, -1, kIdentity4, 0});
  return asset;
}

/// A grid of the voxels' values at their centres.
template <class Grid, class Value>
typename Grid::Ptr make_grid(const VoxelGrid& voxels, const Vec3& place, const char* name,
                             const Value& value) {
  const auto grid = Grid::create();
  grid->setName(name);
  const auto transform = openvdb::math::Transform::createLinearTransform(voxels.h);
  const Vec3 o = plus(voxels.origin, place);
  const double half = voxels.h / 2;
  transform->postTranslate(openvdb::Vec3d(o[0] + half, o[1] + half, o[2] + half));
  grid->setTransform(transform);
  auto accessor = grid->getAccessor();
  for (int64_t v = 0; v < voxels.voxel_count(); ++v) {
    const int32_t* c = voxels.voxel_coord.row(v);
    accessor.setValue({c[0] - voxels.shift_of(v), c[1], c[2]}, value(v));
  }
  return grid;
}

}  // namespace

Asset read_vdb(const std::string& path, const std::string& grid) {
  try {
    return read_grid(path, grid);
  } catch (const openvdb::Exception& error) {
    throw Error(concat(path, ": OpenVDB cannot read it: ", error.what()), ErrorKind::kAsset);
  } catch (const Error& error) {
    throw Error(path + ": " + error.what(), error.kind());
  }
}

void write_vdb(const std::string& path, const VoxelGrid& grid, const Vec3& place) {
  openvdb::initialize();
  SafeFile safe(path);
  try {
    const auto fill = make_grid<openvdb::FloatGrid>(grid, place, "fill",
                                                    [&](int64_t v) { return float(grid.fill(v)); });
    fill->setGridClass(openvdb::GRID_FOG_VOLUME);
    const auto piece = make_grid<openvdb::Int32Grid>(
        grid, place, "piece", [&](int64_t v) { return grid.piece(grid.corners(v, 0)); });
    openvdb::io::File file(safe.temporary());
    file.write(openvdb::GridCPtrVec{fill, piece});
    file.close();
  } catch (const openvdb::ArithmeticError&) {
    throw Error(concat(path, ": OpenVDB holds no voxels as small as ", grid.h, " m; give --size"),
                ErrorKind::kUsage);
  } catch (const openvdb::Exception& error) {
    throw Error(concat("cannot write ", path, ": ", error.what()), ErrorKind::kResources);
  }
  safe.commit();
}

}  // namespace elastogen
