// SPDX-License-Identifier: Apache-2.0
#include "voxelize/particle_surface.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/safe_file.hpp"

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/ParticlesToLevelSet.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kCell = 2.0 / 3;    // edge of a cell [spacings]
constexpr double kGrowth = 1;        // growth of the spheres, undone on the surface [spacings]
constexpr int kSmoothings = 2;       // smoothings by mean curvature
constexpr double kMostShift = 0.5;   // largest offset to correct the volume [spacings]
constexpr double kVelocityCell = 2;  // edge of a cell of velocities [spacings]
constexpr double kSphere = 4.0 / 3 * std::numbers::pi;

void check_cloud(const ParticleCloud& cloud) {
  ELASTOGEN_CHECK(cloud.spacing > 0 && std::isfinite(cloud.spacing),
                  "the spacing of particles must be positive, got ", cloud.spacing);
  ELASTOGEN_CHECK(cloud.x.cols == 3 && cloud.volume.is(cloud.x.rows, 1),
                  "x and volume must be (particles, 3) and (particles, 1), got ", cloud.x, " and ",
                  cloud.volume);
}

/// Grown spheres, with the members that ParticlesToLevelSet requires.
struct Spheres {
  using PosType = openvdb::Vec3R;

  size_t size() const { return size_t(cloud.x.rows); }
  void getPos(size_t k, openvdb::Vec3R& place) const {
    const double* x = cloud.x.row(int64_t(k));
    place = openvdb::Vec3R(x[0], x[1], x[2]) / unit;
  }
  void getPosRad(size_t k, openvdb::Vec3R& place, openvdb::Real& radius) const {
    getPos(k, place);
    radius = (std::cbrt(cloud.volume(int64_t(k)) / kSphere) + kGrowth * cloud.spacing) / unit;
  }

  const ParticleCloud& cloud;
  double unit;
};

/// Triangles of a level set. @param unit  unit of its lengths [m].
ParticleSurface triangles_of(const openvdb::FloatGrid& grid, double unit) {
  ParticleSurface surface;
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, points, triangles, quads, 0);
  for (const openvdb::Vec3s& p : points)
    surface.position.push_back({unit * p[0], unit * p[1], unit * p[2]});
  // OpenVDB winds faces clockwise as seen from outside
  const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
    surface.triangle.push_back({int32_t(a), int32_t(c), int32_t(b)});
  };
  for (const openvdb::Vec3I& t : triangles) add(t[0], t[1], t[2]);
  for (const openvdb::Vec4I& q : quads) {
    const bool first_is_short =
        (points[q[0]] - points[q[2]]).lengthSqr() <= (points[q[1]] - points[q[3]]).lengthSqr();
    const int k = first_is_short ? 0 : 1;
    add(q[k], q[k + 1], q[k + 2]);
    add(q[k], q[k + 2], q[(k + 3) % 4]);
  }
  return surface;
}

/// Mean distance by which a surface lies outside one that encloses the volume [m].
double excess(const ParticleSurface& surface, double volume) {
  double enclosed = 0, area = 0;
  const Vec3 origin = surface.position.empty() ? Vec3{} : surface.position[0];
  for (const auto& t : surface.triangle) {
    Vec3 x[3];
    for (size_t k = 0; k < 3; ++k) x[k] = minus(surface.position[size_t(t[k])], origin);
    enclosed += dot(x[0], cross(x[1], x[2])) / 6;
    area += norm(cross(minus(x[1], x[0]), minus(x[2], x[0]))) / 2;
  }
  return area > 0 ? (enclosed - volume) / area : 0;
}

/// The level set of a cloud. @param unit  unit of its lengths [m].
openvdb::FloatGrid::Ptr level_set(const ParticleCloud& cloud, double unit) {
  const double cell = kCell * cloud.spacing / unit;
  const openvdb::FloatGrid::Ptr grid = openvdb::createLevelSet<openvdb::FloatGrid>(cell);
  openvdb::tools::ParticlesToLevelSet<openvdb::FloatGrid> spheres(*grid);
  // one thread: inside several spheres the result depends on their order
  spheres.setGrainSize(0);
  spheres.rasterizeSpheres(Spheres{cloud, unit});
  spheres.finalize(true);
  if (grid->activeVoxelCount() == 0) return grid;
  openvdb::tools::LevelSetFilter<openvdb::FloatGrid> filter(*grid);
  for (int k = 0; k < kSmoothings; ++k) filter.meanCurvature();
  filter.offset(float(kGrowth * cloud.spacing / unit));
  // correct the volume, which smoothing, cells and closed gaps have changed
  double volume = 0;
  for (int64_t k = 0; k < cloud.x.rows; ++k) volume += cloud.volume(k);
  const double most = kMostShift * cloud.spacing;
  const double shift = std::clamp(excess(triangles_of(*grid, unit), volume), -most, most);
  filter.offset(float(shift / unit));
  return grid;
}

/// Mean velocities, weighted by volume.
openvdb::Vec3SGrid::Ptr velocity_grid(const ParticleCloud& cloud, In<double> v) {
  const double cell = kVelocityCell * cloud.spacing;
  const auto transform = openvdb::math::Transform::createLinearTransform(cell);
  const auto velocity = openvdb::Vec3SGrid::create();
  const auto volume = openvdb::FloatGrid::create();
  velocity->setTransform(transform);
  velocity->setName("velocity");
  velocity->setVectorType(openvdb::VEC_CONTRAVARIANT_RELATIVE);
  auto sums = velocity->getAccessor();
  auto weights = volume->getAccessor();
  for (int64_t k = 0; k < cloud.x.rows; ++k) {
    const double *x = cloud.x.row(k), *u = v.row(k);
    const auto at = transform->worldToIndexCellCentered(openvdb::Vec3d(x[0], x[1], x[2]));
    const auto w = float(cloud.volume(k));
    weights.setValue(at, weights.getValue(at) + w);
    sums.setValue(at, sums.getValue(at) + w * openvdb::Vec3f(openvdb::Vec3d(u[0], u[1], u[2])));
  }
  for (auto at = velocity->beginValueOn(); at; ++at)
    at.setValue(*at / weights.getValue(at.getCoord()));
  return velocity;
}

}  // namespace

ParticleSurface particle_surface(const ParticleCloud& cloud) {
  check_cloud(cloud);
  openvdb::initialize();
  if (cloud.x.rows == 0) return {};
  // lengths in cells, so that the numbers are neither too small nor too large for OpenVDB
  const double cell = kCell * cloud.spacing;
  return triangles_of(*level_set(cloud, cell), cell);
}

void write_particle_vdb(const std::string& path, const ParticleCloud& cloud, In<double> v,
                        const Vec3& place) {
  check_cloud(cloud);
  ELASTOGEN_CHECK(v.is(cloud.x.rows, 3), "v must be (", cloud.x.rows, ", 3), got ", v);
  openvdb::initialize();
  SafeFile safe(path);
  try {
    // three grids: distance, fog, velocity
    const openvdb::FloatGrid::Ptr surface = level_set(cloud, 1), density = surface->deepCopy();
    surface->setName("surface");
    openvdb::tools::sdfToFogVolume(*density);
    density->setName("density");
    const openvdb::GridPtrVec grids = {density, surface, velocity_grid(cloud, v)};
    // moved into the asset's coordinates, stored in 16 bits
    for (const openvdb::GridBase::Ptr& grid : grids) {
      grid->transform().postTranslate(openvdb::Vec3d(place[0], place[1], place[2]));
      grid->setSaveFloatAsHalf(true);
    }
    // write; a library error becomes one about the size or the disk
    openvdb::io::File file(safe.temporary());
    file.write(grids);
    file.close();
  } catch (const openvdb::ArithmeticError&) {
    throw Error(concat(path, ": OpenVDB holds no cells as small as ", kCell * cloud.spacing,
                       " m; give --size"),
                ErrorKind::kUsage);
  } catch (const openvdb::Exception& error) {
    throw Error(concat("cannot write ", path, ": ", error.what()), ErrorKind::kResources);
  }
  safe.commit();
}

}  // namespace elastogen
