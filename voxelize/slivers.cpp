// SPDX-License-Identifier: Apache-2.0
#include "voxelize/slivers.hpp"

#include "core/bricks/index.hpp"
#include "core/error.hpp"
#include "voxelize/fill_fraction.hpp"

#include <algorithm>
#include <bit>
#include <functional>
#include <queue>
#include <utility>

namespace elastogen {
namespace {

/// Sets of places in a 3x3x3 block as bits, x fastest. The centre is the voxel that is examined.
using Places = uint32_t;
constexpr int kPlaces = 27;
constexpr int kCentre = 13;

constexpr int offset(int place, int d) {
  constexpr int kStride[3] = {1, 3, 9};
  return place / kStride[d] % 3 - 1;
}

/// Places that differ from this one by one step along at least one and at most `axes` axes.
constexpr Places adjacent(int place, int axes) {
  Places result = 0;
  for (int other = 0; other < kPlaces; ++other) {
    int differing = 0, farthest = 0;
    for (int d = 0; d < 3; ++d) {
      const int step = offset(other, d) - offset(place, d);
      differing += step != 0;
      farthest = std::max(farthest, step < 0 ? -step : step);
    }
    if (other != place && differing <= axes && farthest <= 1) result |= Places{1} << other;
  }
  return result;
}

constexpr std::array<Places, kPlaces> adjacent_each(int axes) {
  std::array<Places, kPlaces> result = {};
  for (int place = 0; place < kPlaces; ++place) result[place] = adjacent(place, axes);
  return result;
}

constexpr std::array<Places, kPlaces> kShareFace = adjacent_each(1), kShareNode = adjacent_each(3);
constexpr Places kFaces = adjacent(kCentre, 1), kFacesAndEdges = adjacent(kCentre, 2);

/// The places adjacent to those of a set.
Places grown(Places set, const std::array<Places, kPlaces>& near) {
  Places result = 0;
  for (; set; set &= set - 1) result |= near[std::countr_zero(set)];
  return result;
}

/// Whether all places of a part of `set` are connected within `set`.
bool connected(Places part, Places set, const std::array<Places, kPlaces>& near) {
  Places reached = part & (~part + 1), front = reached;
  while (front) {
    front = grown(front, near) & set & ~reached;
    reached |= front;
  }
  return !(part & ~reached);
}

/// Fill is counted in steps of 1e-4, up to the fill of a thick voxel.
constexpr double kSteps = 1e4;
constexpr auto kEmpty = static_cast<int16_t>(kMinFill * kSteps);
constexpr auto kThick = static_cast<int16_t>(0.1 * kSteps);

int16_t level_of(double fill) {
  return static_cast<int16_t>(std::clamp(fill * kSteps, 0.0, double{kThick}));
}

/// Rules 2 and 3 of the header for one kind of voxels around the centre.
bool holds_without_centre(Places set) {
  return connected(set, set, kShareNode) &&
         connected(set & kFaces, set & kFacesAndEdges, kShareFace);
}

class Filter {
 public:
  Filter(In<int32_t> coords, In<double> fill) : index_(coords), points_(index_.points()) {
    kind_.resize(points_.rows());
    level_.resize(points_.rows());
    for (int64_t row = 0; row < coords.rows; ++row)
      level_[number(coords, row)] = level_of(fill(row));
  }

  void run() {
    while (round()) {
    }
  }

  /// Whether a voxel was removed.
  bool gone(In<int32_t> coords, int64_t row) const { return kind_[number(coords, row)] == kGone; }

 private:
  enum Kind : uint8_t {
    kBody,     // not a sliver
    kSliver,   // a sliver that stays for now
    kQueued,   // the body allows its removal; to be examined
    kWaiting,  // kept because of other slivers
    kGone,
  };
  using Block = std::array<int64_t, kPlaces>;  // voxel in each place, -1 for none

  /// Removes slivers until none may be removed. @return whether one was.
  bool round() {
    for (int64_t v = 0; v < points_.rows(); ++v)
      if (level_[v] < kThick && kind_[v] != kGone) kind_[v] = is_sliver(v) ? kSliver : kBody;
    for (int64_t v = 0; v < points_.rows(); ++v)
      if (kind_[v] == kSliver && hangs_on_body_alone(around(v))) push(v);
    bool any = false;
    while (!queue_.empty()) {
      const int64_t v = queue_.top().second;
      queue_.pop();
      kind_[v] = kWaiting;
      const Block block = around(v);
      if (!holds_without_centre(places(block, is_left))) continue;
      kind_[v] = kGone;
      any = true;
      // its neighbours may have lost the reason that kept them
      for (const int64_t n : block)
        if (n >= 0 && kind_[n] == kWaiting) push(n);
    }
    return any;
  }

  static bool is_left(Kind kind) { return kind != kGone; }
  static bool is_body(Kind kind) { return kind == kBody; }

  bool is_sliver(int64_t v) const {
    if (level_[v] < kEmpty) return true;
    const Block block = around(v);
    const auto is_thick = [&](int64_t n) { return n >= 0 && level_[n] == kThick; };
    return std::popcount(places(block, is_left) & kFaces) <= 1 &&
           std::any_of(block.begin(), block.end(), is_thick);
  }

  int64_t number(In<int32_t> coords, int64_t row) const {
    return index_.find({coords(row, 0), coords(row, 1), coords(row, 2)});
  }

  void push(int64_t v) {
    kind_[v] = kQueued;
    queue_.push({level_[v], v});
  }

  Block around(int64_t v) const {
    Block block;
    for (int place = 0; place < kPlaces; ++place) {
      Coord other;
      for (int d = 0; d < 3; ++d) other[d] = points_(v, d) + offset(place, d);
      block[place] = place == kCentre ? -1 : index_.find(other);
    }
    return block;
  }

  template <class Is>
  Places places(const Block& block, const Is& is) const {
    Places result = 0;
    for (int place = 0; place < kPlaces; ++place)
      if (block[place] >= 0 && is(kind_[block[place]])) result |= Places{1} << place;
    return result;
  }

  /// Rule 1, and rules 2 and 3 for the body.
  bool hangs_on_body_alone(const Block& block) const {
    const Places body = places(block, is_body), slivers = places(block, is_left) & ~body;
    return body && !(slivers & ~grown(body, kShareNode)) && holds_without_centre(body);
  }

  using Entry = std::pair<int16_t, int64_t>;

  BrickIndex index_;
  Array<int32_t> points_;       // voxels in the order of the index, (voxels, 3)
  std::vector<Kind> kind_;      // kind of each voxel
  std::vector<int16_t> level_;  // fill of each voxel in steps
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue_;
};

}  // namespace

std::vector<uint8_t> find_slivers(In<int32_t> coords, In<double> fill) {
  ELASTOGEN_CHECK(coords.cols == 3, "coords must be (voxels, 3), got ", coords);
  ELASTOGEN_CHECK(fill.is(coords.rows, 1), "fill must be (voxels, 1), got ", fill);
  for (int64_t i = 0; i < coords.size(); ++i)
    ELASTOGEN_CHECK(coords.data[i] >= -kLatticeLimit && coords.data[i] < kLatticeLimit,
                    "coordinates must lie within +-2^20, voxel ", i / 3, " has ", coords.data[i]);
  Filter filter(coords, fill);
  filter.run();
  std::vector<uint8_t> result(coords.rows);
  for (int64_t row = 0; row < coords.rows; ++row)
    result[row] = level_of(fill(row)) < kThick && filter.gone(coords, row);
  return result;
}

}  // namespace elastogen
