// SPDX-License-Identifier: Apache-2.0
#include "io/tets/tet_reader.hpp"

#include "core/vec3.hpp"
#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"
#include "io/tets/tet_soup.hpp"

#include <algorithm>

namespace elastogen::tets {
namespace {

TetSoup parse(std::string_view bytes, const std::string& path) {
  if (bytes.starts_with('$')) return parse_msh(bytes, path);
  if (bytes.starts_with("# vtk DataFile")) return parse_vtk(bytes, path);
  if (bytes.starts_with('<')) return parse_vtu(bytes, path);
  throw Error(path + ": begins neither like a Gmsh MSH nor like a VTK or VTU file",
              ErrorKind::kAsset);
}

/// Six times the volume between the corners, 0 where rounding decides its sign.
double determinant(const std::vector<Vec3>& points, const int32_t* corner) {
  constexpr double kRounding = 1e-14;
  Vec3 edge[3];
  double size = 1;
  for (int k = 0; k < 3; ++k) {
    edge[k] = minus(points[size_t(corner[k + 1])], points[size_t(corner[0])]);
    size *= norm(edge[k]);
  }
  const double determinant = dot(edge[0], cross(edge[1], edge[2]));
  return std::abs(determinant) > kRounding * size ? determinant : 0;
}

/// Gives all tetrahedra positive volumes. @return how many were turned.
int64_t turn_tets(TetSoup& soup, const std::string& path) {
  int64_t turned = 0;
  for (size_t e = 0; e < soup.region.size(); ++e) {
    int32_t* corner = soup.corners.data() + e * size_t(soup.nodes);
    const double volume = determinant(soup.points, corner);
    ELASTOGEN_CHECK_ASSET(volume != 0 && std::isfinite(volume), path, ": tetrahedron ", e,
                          " (counted from 0) is flat, or its volume out of range");
    if (volume > 0) continue;
    ++turned;
    std::swap(corner[2], corner[3]);
    if (soup.nodes == 10) {  // also the middles of 01, 12, 02, 03, 13, 23
      std::swap(corner[5], corner[8]);
      std::swap(corner[6], corner[7]);
    }
  }
  return turned;
}

/// Twice the area, 0 where rounding decides its sign.
double plane_determinant(const std::vector<Vec3>& points, const int32_t* corner) {
  constexpr double kRounding = 1e-14;
  const Vec3 a = minus(points[size_t(corner[1])], points[size_t(corner[0])]);
  const Vec3 b = minus(points[size_t(corner[2])], points[size_t(corner[0])]);
  const double determinant = a[0] * b[1] - a[1] * b[0];
  return std::abs(determinant) > kRounding * norm(a) * norm(b) ? determinant : 0;
}

/// Makes the triangles the elements where there are no tetrahedra. @return how many were turned.
int64_t take_triangles(TetSoup& soup, const std::string& path) {
  ELASTOGEN_CHECK_ASSET(!soup.triangles.empty(), path,
                        ": it has no tetrahedra, nor linear triangles");
  soup.nodes = 3;
  soup.corners = std::move(soup.triangles);
  soup.region = std::move(soup.triangle_region);
  soup.skipped -= int64_t(soup.region.size());
  int64_t turned = 0;
  for (size_t e = 0; e < soup.region.size(); ++e) {
    int32_t* corner = soup.corners.data() + 3 * e;
    for (int c = 0; c < 3; ++c)
      ELASTOGEN_CHECK_ASSET(soup.points[size_t(corner[c])][2] == 0, path,
                            ": it has no tetrahedra, and triangle ", e,
                            " (counted from 0) does not lie in the plane z = 0");
    const double area = plane_determinant(soup.points, corner);
    ELASTOGEN_CHECK_ASSET(area != 0 && std::isfinite(area), path, ": triangle ", e,
                          " (counted from 0) has no area, or one out of range");
    if (area > 0) continue;
    ++turned;
    std::swap(corner[1], corner[2]);
  }
  return turned;
}

/// Makes the used points the nodes, in their order. @return how many are unused.
int64_t take_nodes(const TetSoup& soup, TetFile& file) {
  std::vector<int32_t> node_of(soup.points.size(), -1);
  for (const int32_t point : soup.corners) node_of[size_t(point)] = 0;
  int32_t nodes = 0;
  for (int32_t& node : node_of)
    if (node == 0) node = nodes++;
  file.rest = Array<double>(nodes, 3);
  for (size_t p = 0; p < node_of.size(); ++p)
    if (node_of[p] >= 0) std::copy_n(soup.points[p].begin(), 3, file.rest.row(node_of[p]));
  file.elements = Array<int32_t>(int64_t(soup.region.size()), soup.nodes);
  std::transform(soup.corners.begin(), soup.corners.end(), file.elements.data(),
                 [&](int32_t point) { return node_of[size_t(point)]; });
  return int64_t(soup.points.size()) - nodes;
}

void take_regions(const TetSoup& soup, TetFile& file) {
  std::vector<int64_t>& ids = file.region_ids;
  ids = soup.region;
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  file.region = Array<int32_t>(int64_t(soup.region.size()));
  for (int64_t e = 0; e < file.region.rows(); ++e)
    file.region(e) =
        int32_t(std::lower_bound(ids.begin(), ids.end(), soup.region[size_t(e)]) - ids.begin());
}

}  // namespace

TetFile parse_tets(std::string_view bytes, const std::string& path) {
  TetSoup soup = parse(without_mark(bytes), path);
  TetFile file;
  file.turned = soup.region.empty() ? take_triangles(soup, path) : turn_tets(soup, path);
  file.skipped = soup.skipped;
  file.unused = take_nodes(soup, file);
  take_regions(soup, file);
  return file;
}

TetFile read_tets(const std::string& path) {
  return parse_tets(read_file(path), path);
}

}  // namespace elastogen::tets
