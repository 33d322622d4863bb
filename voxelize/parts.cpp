// SPDX-License-Identifier: Apache-2.0
#include "voxelize/parts.hpp"

#include "core/vec3.hpp"
#include "voxelize/triangle_gap.hpp"
#include "voxelize/winding_number.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

namespace elastogen {
namespace {

constexpr int32_t kSeveral = -1;

double box_gap2(const Box& a, const Box& b) {
  double sum = 0;
  for (size_t d = 0; d < 3; ++d) {
    const double gap = std::max({a.lower[d] - b.upper[d], b.lower[d] - a.upper[d], 0.0});
    sum += gap * gap;
  }
  return sum;
}

bool holds(const Box& outer, const Box& inner) {
  for (size_t d = 0; d < 3; ++d)
    if (inner.lower[d] < outer.lower[d] || inner.upper[d] > outer.upper[d]) return false;
  return true;
}

class PartFinder {
 public:
  explicit PartFinder(const CutBody& body)
      : mesh_(body.mesh), cells_(body.cells), kept_(body.kept), sets_(mesh_.triangles.size()) {
    const double touch = body.welded.tolerance / body.lattice.h;
    touch2_ = touch * touch;
    std::vector<int32_t> first(size_t(body.welded.vertices.rows()), -1);
    for (int32_t t = 0; t < int32_t(mesh_.triangles.size()); ++t) {
      const int32_t* corner = body.welded.triangles.row(body.welded_triangle(t));
      for (int k = 0; k < 3; ++k) {
        int32_t& one = first[size_t(corner[k])];
        if (one < 0) one = t;
        sets_.join(one, t, false);
      }
    }
  }

  Parts find(bool all) {
    if (single()) return numbered();
    boxes_.resize(mesh_.triangles.size());
    for (size_t t = 0; t < boxes_.size(); ++t)
      for (const Vec3& p : corners(int32_t(t))) boxes_[t].add(p);
    visit_neighbours();
    join_contained(all);
    return numbered();
  }

 private:
  using Pair = std::pair<int32_t, int32_t>;

  /// The smallest gap of two sets, squared, and whether voxels of theirs share a node.
  struct Near {
    PartGap gap;
    bool joined = false;
    void take(const Near& other) {
      joined |= other.joined;
      if (other.gap.distance < gap.distance) gap = other.gap;
    }
  };

  bool single() {
    const int32_t root = sets_.root(0);
    for (size_t t = 1; t < mesh_.triangles.size(); ++t)
      if (sets_.root(int32_t(t)) != root) return false;
    return true;
  }

  std::array<Vec3, 3> corners(int32_t t) const {
    const Coord& c = mesh_.triangles[size_t(t)];
    return {mesh_.vertices[size_t(c[0])], mesh_.vertices[size_t(c[1])],
            mesh_.vertices[size_t(c[2])]};
  }

  /// The set of all triangles in a cell, kSeveral if there are several.
  int32_t set_of(int64_t cell) {
    const int32_t root = sets_.root(cells_.triangle[size_t(cells_.first[size_t(cell)])]);
    for (int64_t i = cells_.first[size_t(cell)]; i < cells_.first[size_t(cell) + 1]; ++i)
      if (sets_.root(cells_.triangle[size_t(i)]) != root) return kSeveral;
    return root;
  }

  /// Compares each cell with itself and those that share a node with it.
  void visit_neighbours() {
    const auto key = [](const Coord& c) {
      constexpr uint64_t kOffset = uint64_t{1} << 20;
      return (uint64_t(c[2]) + kOffset) << 42 | (uint64_t(c[1]) + kOffset) << 21 |
             (uint64_t(c[0]) + kOffset);
    };
    std::unordered_map<uint64_t, int64_t> place;
    std::vector<int32_t> set;
    for (int64_t c = 0; c < cells_.count(); ++c) {
      place.emplace(key(cells_.coord[size_t(c)]), c);
      set.push_back(set_of(c));
    }
    for (int64_t c = 0; c < cells_.count(); ++c)
      for (int k = 13; k < 27; ++k) {  // this cell and those behind it
        const Coord& at = cells_.coord[size_t(c)];
        const auto found =
            place.find(key({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1}));
        if (found == place.end()) continue;
        const int64_t other = found->second;
        for (const int64_t cell : {c, other})
          if (set[size_t(cell)] == kSeveral) set[size_t(cell)] = set_of(cell);
        const bool one = set[size_t(c)] != kSeveral && set[size_t(other)] != kSeveral &&
                         sets_.root(set[size_t(c)]) == sets_.root(set[size_t(other)]);
        if (!one) compare(c, other);
      }
  }

  void compare(int64_t a, int64_t b) {
    const bool joined = kept_[size_t(a)] && kept_[size_t(b)];
    for (int64_t i = cells_.first[size_t(a)]; i < cells_.first[size_t(a) + 1]; ++i)
      for (int64_t j = cells_.first[size_t(b)]; j < cells_.first[size_t(b) + 1]; ++j)
        compare(cells_.triangle[size_t(i)], cells_.triangle[size_t(j)], joined);
  }

  /// Joins two triangles that touch; keeps their distance where their voxels are joined.
  void compare(int32_t s, int32_t t, bool joined) {
    const int32_t root_s = sets_.root(s), root_t = sets_.root(t);
    if (root_s == root_t) return;
    if (!mesh_.joint.empty() && mesh_.joint[size_t(s)] && mesh_.joint[size_t(t)]) {
      sets_.join(s, t, false);
      return;
    }
    Near& near = gaps_.try_emplace(std::minmax(root_s, root_t), Near{{{s, t}, kFar}}).first->second;
    near.joined |= joined;
    if (box_gap2(boxes_[size_t(s)], boxes_[size_t(t)]) > near.gap.distance) return;
    const double gap2 = triangle_gap2(corners(s).data(), corners(t).data());
    near.take({{{s, t}, gap2}});
    if (gap2 <= touch2_) sets_.join(s, t, false);
  }

  /// A set as it is before those within others join these.
  struct Member {
    Box box;
    std::vector<int32_t> triangles;
    std::optional<WindingNumber> winding_number;  ///< of its solids, once it is asked
  };

  std::vector<Member> members() {
    std::vector<Member> list;
    std::vector<int32_t> number(mesh_.triangles.size(), -1);
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      int32_t& n = number[size_t(sets_.root(int32_t(t)))];
      if (n < 0) {
        n = int32_t(list.size());
        list.emplace_back();
      }
      Member& member = list[size_t(n)];
      member.box.add(boxes_[t].lower);
      member.box.add(boxes_[t].upper);
      member.triangles.push_back(int32_t(t));
    }
    return list;
  }

  bool is_within(Member& outer, const Member& inner) {
    const int32_t first = inner.triangles[0];
    if (!holds(outer.box, inner.box) || sets_.root(outer.triangles[0]) == sets_.root(first))
      return false;
    if (!outer.winding_number) {
      std::vector<WindingNumber::Triangle> solid;
      for (const int32_t t : outer.triangles) {
        const auto c = corners(t);
        if (mesh_.role[size_t(t)] == Role::kSolid) solid.push_back({{c[0], c[1], c[2]}});
      }
      outer.winding_number.emplace(std::move(solid));
    }
    return std::abs((*outer.winding_number)(corners(first)[0])) > 0.5;
  }

  /// Joins what lies within another set to it.
  /// @param all  also where the two have no gap that was measured.
  void join_contained(bool all) {
    std::vector<Member> list = members();
    std::vector<int32_t> number(mesh_.triangles.size());
    for (size_t n = 0; n < list.size(); ++n)
      for (const int32_t t : list[n].triangles) number[size_t(t)] = int32_t(n);
    std::vector<Pair> pairs;
    for (const auto& [pair, near] : gaps_) {
      const int32_t a = number[size_t(pair.first)], b = number[size_t(pair.second)];
      if (!all) pairs.insert(pairs.end(), {{a, b}, {b, a}});
    }
    for (int32_t a = 0; all && a < int32_t(list.size()); ++a)
      for (int32_t b = 0; b < int32_t(list.size()); ++b)
        if (holds(list[size_t(a)].box, list[size_t(b)].box)) pairs.emplace_back(a, b);
    for (const auto& [a, b] : pairs) {
      Member &outer = list[size_t(a)], &inner = list[size_t(b)];
      if (is_within(outer, inner)) sets_.join(outer.triangles[0], inner.triangles[0], false);
    }
  }

  Parts numbered() {
    Parts parts;
    std::vector<int32_t> number(mesh_.triangles.size(), -1);
    for (size_t t = 0; t < number.size(); ++t) {
      int32_t& n = number[size_t(sets_.root(int32_t(t)))];
      if (n < 0) n = parts.count++;
      parts.of.push_back(n);
    }
    std::map<Pair, Near> of_parts;
    for (const auto& [pair, near] : gaps_) {
      const int32_t a = parts.of[size_t(near.gap.triangle[0])];
      const int32_t b = parts.of[size_t(near.gap.triangle[1])];
      if (a != b) of_parts.try_emplace(std::minmax(a, b), near).first->second.take(near);
    }
    for (auto& [pair, near] : of_parts) {
      near.gap.distance = std::sqrt(near.gap.distance);
      if (near.joined) parts.gaps.push_back(near.gap);
    }
    return parts;
  }

  static constexpr double kFar = 12;  // squared; what lies farther apart has no common node
  const LatticeMesh& mesh_;
  const SurfaceCells& cells_;
  const std::vector<uint8_t>& kept_;
  double touch2_ = 0;  // squared distance that counts as none
  OrientedSets sets_;
  std::vector<Box> boxes_;     // of the triangles
  std::map<Pair, Near> gaps_;  // of the sets at the time
};

}  // namespace

Parts find_parts(const CutBody& body, bool all) {
  return PartFinder(body).find(all);
}

}  // namespace elastogen
