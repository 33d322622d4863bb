// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/fill.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::mpm {
namespace {

/// The next of a sequence of pseudo-random numbers (splitmix64 of Steele et al. 2014), in [0, 1).
double next_number(uint64_t& state) {
  uint64_t z = state += 0x9e3779b97f4a7c15u;
  z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
  z = (z ^ z >> 27) * 0x94d049bb133111ebu;
  return double((z ^ z >> 31) >> 11) * 0x1p-53;
}

/// Middle of a voxel's fill from corner 0, over the edge.
Vec3 middle_of_fill(const VoxelGrid& grid, int64_t voxel) {
  Vec3 middle = {};
  for (int c = 0; c < 8; ++c)
    for (int a = 0; a < 3; ++a)
      if (c >> a & 1) middle[size_t(a)] += grid.shape_mean(voxel, c);
  return middle;
}

/// The parts of a voxel, sorted by their distance from a place.
std::vector<Vec3> parts_from(const Vec3& place, int per_edge) {
  std::vector<Vec3> parts;
  for (int k = 0; k < per_edge * per_edge * per_edge; ++k)
    parts.push_back({(k % per_edge + 0.5) / per_edge, (k / per_edge % per_edge + 0.5) / per_edge,
                     (k / (per_edge * per_edge) + 0.5) / per_edge});
  const auto away = [&](const Vec3& part) {
    double square = 0;
    for (size_t a = 0; a < 3; ++a) square += (part[a] - place[a]) * (part[a] - place[a]);
    return square;
  };
  std::stable_sort(parts.begin(), parts.end(),
                   [&](const Vec3& a, const Vec3& b) { return away(a) < away(b) - 1e-12; });
  return parts;
}

int64_t particles_of(const VoxelGrid& grid, int64_t voxel, int per_edge) {
  const int full = per_edge * per_edge * per_edge;
  return std::clamp<int64_t>(std::llround(full * grid.fill(voxel)), 1, full);
}

void check_options(const FillOptions& options) {
  ELASTOGEN_CHECK(options.per_edge >= 1 && options.per_edge <= 8,
                  "per_edge must lie in 1 ... 8, got ", options.per_edge);
  ELASTOGEN_CHECK(options.jitter >= 0 && options.jitter <= 1, "jitter must lie in [0, 1], got ",
                  options.jitter);
}

}  // namespace

Filled fill_body(const VoxelGrid& grid, In<int32_t> material, const std::vector<Solid>& solids,
                 const FillOptions& options) {
  check_options(options);
  const double cube = grid.h * grid.h * grid.h;
  // count of particles of each voxel
  double volume = 0;
  std::vector<int64_t> first(size_t(grid.voxel_count()) + 1);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    volume += grid.fill(v) * cube;
    first[size_t(v) + 1] = first[size_t(v)] + particles_of(grid, v, options.per_edge);
  }
  const double scale = grid.volume > 0 ? grid.volume / volume : 1;
  Filled result{particles_at(Array<double>(first.back(), 3), 1, 0, 1),
                Array<int32_t>(first.back())};
  Particles& p = result.particles;
  // parts next to the middle of the fill
  for_each(grid.voxel_count(), [&](int64_t v) {
    const int64_t count = first[size_t(v) + 1] - first[size_t(v)];
    const std::vector<Vec3> parts = parts_from(middle_of_fill(grid, v), options.per_edge);
    uint64_t random = options.seed;
    for (int a = 0; a < 3; ++a)
      random = random * 0x100000001b3u + uint64_t(uint32_t(grid.voxel_coord(v, a)));
    // at random in their parts, with equal shares of the volume
    for (int64_t k = 0; k < count; ++k) {
      const int64_t at = first[size_t(v)] + k;
      for (int a = 0; a < 3; ++a) {
        const double off = options.jitter * (next_number(random) - 0.5) / options.per_edge;
        p.x(at, a) = grid.h * (grid.voxel_coord(v, a) + parts[size_t(k)][size_t(a)] + off);
      }
      p.solid(at) = material(v);
      result.voxel(at) = int32_t(v);
      p.volume(at) = scale * grid.fill(v) * cube / double(count);
      p.mass(at) = solids[size_t(material(v))].elastic.density * p.volume(at);
    }
  });
  return result;
}

Particles fill_plane(const Vec3& lower, const Vec3& upper, double h, const Solid& solid,
                     const std::function<bool(const Vec3&)>& inside, const FillOptions& options) {
  check_options(options);
  const double edge = h / options.per_edge;
  std::vector<Vec3> places;
  uint64_t random = options.seed;
  for (auto j = int64_t(std::floor(lower[1] / edge)); double(j) * edge < upper[1]; ++j)
    for (auto i = int64_t(std::floor(lower[0] / edge)); double(i) * edge < upper[0]; ++i) {
      const Vec3 middle = {(double(i) + 0.5) * edge, (double(j) + 0.5) * edge, 0};
      if (!inside(middle)) continue;
      Vec3& place = places.emplace_back(middle);
      for (size_t a = 0; a < 2; ++a)
        place[a] += options.jitter * (next_number(random) - 0.5) * edge;
    }
  Array<double> x(int64_t(places.size()), 3);
  for (size_t k = 0; k < places.size(); ++k)
    std::copy(places[k].begin(), places[k].end(), x.row(int64_t(k)));
  return particles_at(x, edge * edge, 0, solid.elastic.density);
}

}  // namespace elastogen::mpm
