// SPDX-License-Identifier: Apache-2.0
#include "voxelize/point_spacing.hpp"

#include "core/parallel.hpp"
#include "core/parallel_sort.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kNeighbours = 8;
constexpr size_t kSample = 20'000;
constexpr int64_t kTask = 64;  // points of one parallel task

/// A balanced tree of points. The middle point of each range splits it along its longest axis.
class PointTree {
 public:
  explicit PointTree(std::vector<Vec3> points) : points_(std::move(points)), axis_(points_.size()) {
    build(0, points_.size());
  }

  size_t size() const { return points_.size(); }

  /// Distance from point i to its n-th nearest neighbour.
  double distance(size_t i, int n) const {
    Nearest nearest;
    nearest.wanted = n + 1;  // the search finds the point itself too
    search(0, points_.size(), points_[i], nearest);
    return std::sqrt(nearest.distance2[n]);
  }

 private:
  struct Nearest {
    int wanted = 0, found = 0;
    double distance2[kNeighbours + 1];

    double limit() const { return found < wanted ? HUGE_VAL : distance2[wanted - 1]; }
    void add(double d2) {
      if (d2 >= limit()) return;
      if (found < wanted) ++found;
      int k = found - 1;
      for (; k > 0 && distance2[k - 1] > d2; --k) distance2[k] = distance2[k - 1];
      distance2[k] = d2;
    }
  };

  void build(size_t first, size_t last) {
    if (last - first < 2) return;
    Box box;
    for (size_t i = first; i < last; ++i) box.add(points_[i]);
    uint8_t axis = 0;
    for (uint8_t d = 1; d < 3; ++d)
      if (box.extent(d) > box.extent(axis)) axis = d;
    const size_t middle = first + (last - first) / 2;
    const auto begin = points_.begin();
    std::nth_element(begin + int64_t(first), begin + int64_t(middle), begin + int64_t(last),
                     [axis](const Vec3& a, const Vec3& b) { return a[axis] < b[axis]; });
    axis_[middle] = axis;
    build(first, middle);
    build(middle + 1, last);
  }

  void search(size_t first, size_t last, const Vec3& p, Nearest& nearest) const {
    if (first >= last) return;
    const size_t middle = first + (last - first) / 2;
    const Vec3& q = points_[middle];
    double d2 = 0;
    for (int d = 0; d < 3; ++d) d2 += (p[d] - q[d]) * (p[d] - q[d]);
    nearest.add(d2);
    const double apart = p[axis_[middle]] - q[axis_[middle]];
    const bool is_low = apart < 0;
    search(is_low ? first : middle + 1, is_low ? middle : last, p, nearest);
    if (apart * apart < nearest.limit())
      search(is_low ? middle + 1 : first, is_low ? last : middle, p, nearest);
  }

  std::vector<Vec3> points_;
  std::vector<uint8_t> axis_;  ///< along which the point in the middle of a range splits it
};

using Cell = std::array<int64_t, 3>;

/// Finds sets of cells that touch.
class CellClusters {
 public:
  explicit CellClusters(const std::vector<Cell>& cells) : cells_(cells), parent_(cells.size()) {
    std::iota(parent_.begin(), parent_.end(), size_t{0});
    for (size_t c = 0; c < cells_.size(); ++c)
      for (int64_t k = 0; k < 13; ++k)  // the neighbours before it
        join(c, {cells_[c][0] + k / 9 - 1, cells_[c][1] + k / 3 % 3 - 1, cells_[c][2] + k % 3 - 1});
  }

  size_t root(size_t c) {
    while (parent_[c] != c) c = parent_[c] = parent_[parent_[c]];
    return c;
  }

 private:
  void join(size_t c, const Cell& neighbour) {
    const auto found = std::lower_bound(cells_.begin(), cells_.end(), neighbour);
    if (found == cells_.end() || *found != neighbour) return;
    const size_t a = root(c), b = root(size_t(found - cells_.begin()));
    parent_[std::max(a, b)] = std::min(a, b);
  }

  const std::vector<Cell>& cells_;
  std::vector<size_t> parent_;
};

}  // namespace

double point_spacing(const std::vector<Vec3>& points) {
  std::vector<Vec3> places = points;
  parallel_sort(places.begin(), places.end());
  places.erase(std::unique(places.begin(), places.end()), places.end());
  if (places.size() < 2) return 0;
  const PointTree tree(std::move(places));
  const size_t count = std::min(tree.size(), kSample);
  const int n = int(std::min<size_t>(kNeighbours, tree.size() - 1));
  std::vector<double> distance(count);
  for_each(
      int64_t(count),
      [&](int64_t k) { distance[size_t(k)] = tree.distance(size_t(k) * tree.size() / count, n); },
      kTask);
  std::nth_element(distance.begin(), distance.begin() + int64_t(count / 2), distance.end());
  return distance[count / 2];
}

std::vector<Vec3> thinned(const std::vector<Vec3>& points, double edge) {
  struct Placed {
    Cell cell;
    size_t point;
    auto operator<=>(const Placed&) const = default;
  };
  std::vector<Placed> placed(points.size());
  for (size_t i = 0; i < points.size(); ++i) {
    placed[i].point = i;
    for (size_t d = 0; d < 3; ++d)
      placed[i].cell[d] = int64_t(std::clamp(std::floor(points[i][d] / edge), -0x1p61, 0x1p61));
  }
  parallel_sort(placed.begin(), placed.end());
  std::vector<Vec3> result;
  for (size_t first = 0, last = 0; first < placed.size(); first = last) {
    // relative to the cell's first point, so that no digits are lost far from the origin
    const Vec3& base = points[placed[first].point];
    Vec3 sum = {};
    for (; last < placed.size() && placed[last].cell == placed[first].cell; ++last)
      for (size_t d = 0; d < 3; ++d) sum[d] += points[placed[last].point][d] - base[d];
    for (size_t d = 0; d < 3; ++d) sum[d] = base[d] + sum[d] / double(last - first);
    result.push_back(sum);
  }
  return result;
}

std::vector<uint8_t> large_clusters(const std::vector<Vec3>& points, double reach, double share) {
  std::vector<Cell> cell_of(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    for (size_t d = 0; d < 3; ++d)  // points outside a lattice of 2^61 cells lie apart anyway
      cell_of[i][d] = int64_t(std::clamp(std::floor(points[i][d] / reach), -0x1p61, 0x1p61));
  std::vector<Cell> cells = cell_of;
  parallel_sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());

  CellClusters clusters(cells);
  std::vector<size_t> cluster(points.size());
  std::vector<int64_t> size(cells.size());
  for (size_t i = 0; i < points.size(); ++i) {
    const auto found = std::lower_bound(cells.begin(), cells.end(), cell_of[i]);
    cluster[i] = clusters.root(size_t(found - cells.begin()));
    ++size[cluster[i]];
  }
  const double least = share * double(points.size());
  const bool none = double(*std::max_element(size.begin(), size.end())) < least;
  std::vector<uint8_t> kept(points.size());
  for (size_t i = 0; i < points.size(); ++i) kept[i] = none || double(size[cluster[i]]) >= least;
  return kept;
}

}  // namespace elastogen
