// SPDX-License-Identifier: Apache-2.0
#include "voxelize/parts.hpp"

#include "core/vec3.hpp"
#include "voxelize/mesh_edges.hpp"
#include "voxelize/triangle_gap.hpp"
#include "voxelize/winding_number.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <unordered_map>

namespace elastogen {
namespace {

bool holds(const Box& outer, const Box& inner) {
  for (size_t d = 0; d < 3; ++d)
    if (inner.lower[d] < outer.lower[d] || inner.upper[d] > outer.upper[d]) return false;
  return true;
}

/// Triangles that are known to belong to one part, while parts are found.
struct Member {
  std::vector<int32_t> triangles;
  std::optional<TriangleBoxes> boxes;           ///< made when first needed
  std::optional<WindingNumber> winding_number;  ///< of its solids, made when first needed
};

class PartFinder {
 public:
  explicit PartFinder(const CutBody& body)
      : mesh_(body.mesh), cells_(body.cells), kept_(body.kept), sets_(mesh_.triangles.size()) {
    touch_ = body.welded.tolerance / body.lattice.h;
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
    visit_neighbours([this](int64_t a, int64_t b) { join_joint(a, b); });
    collect_members();
    visit_neighbours([this](int64_t a, int64_t b) { note_pairs(a, b); });
    for (auto& [pair, gap] : near_) judge(pair, gap);
    if (all) join_contained();
    return numbered();
  }

 private:
  using Pair = std::pair<int32_t, int32_t>;  // indices of members

  struct Near {
    bool joined = false;         ///< some of their voxels share a node
    std::optional<PartGap> gap;  ///< unless they are one part
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

  /// Calls visit(a, b) for each cell with itself and with later cells that share a node with it.
  template <class Visit>
  void visit_neighbours(const Visit& visit) {
    const auto key = [](const Coord& c) {
      constexpr uint64_t kOffset = uint64_t{1} << 20;
      return (uint64_t(c[2]) + kOffset) << 42 | (uint64_t(c[1]) + kOffset) << 21 |
             (uint64_t(c[0]) + kOffset);
    };
    if (place_.empty())
      for (int64_t c = 0; c < cells_.count(); ++c) place_.emplace(key(cells_.coord[size_t(c)]), c);
    for (int64_t c = 0; c < cells_.count(); ++c)
      for (int k = 13; k < 27; ++k) {
        const Coord& at = cells_.coord[size_t(c)];
        const auto found =
            place_.find(key({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1}));
        if (found != place_.end()) visit(c, found->second);
      }
  }

  /// Joins triangles of neighbouring cells that bound a solid only together.
  void join_joint(int64_t a, int64_t b) {
    if (mesh_.joint.empty()) return;
    int32_t one = -1;
    for (const int64_t c : {a, b})
      for (int64_t i = cells_.first[size_t(c)]; i < cells_.first[size_t(c) + 1]; ++i) {
        const int32_t t = cells_.triangle[size_t(i)];
        if (!mesh_.joint[size_t(t)]) continue;
        if (one < 0) one = t;
        sets_.join(one, t, false);
      }
  }

  void collect_members() {
    member_of_.assign(mesh_.triangles.size(), -1);
    std::vector<int32_t> number(mesh_.triangles.size(), -1);
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      int32_t& n = number[size_t(sets_.root(int32_t(t)))];
      if (n < 0) {
        n = int32_t(members_.size());
        members_.emplace_back();
      }
      member_of_[t] = n;
      members_[size_t(n)].triangles.push_back(int32_t(t));
    }
    for (int64_t c = 0; c < cells_.count(); ++c) {
      std::vector<int32_t>& in = members_in_.emplace_back();
      for (int64_t i = cells_.first[size_t(c)]; i < cells_.first[size_t(c) + 1]; ++i)
        in.push_back(member_of_[size_t(cells_.triangle[size_t(i)])]);
      std::ranges::sort(in);
      in.erase(std::unique(in.begin(), in.end()), in.end());
    }
  }

  void note_pairs(int64_t a, int64_t b) {
    const bool joined = kept_[size_t(a)] && kept_[size_t(b)];
    for (const int32_t m : members_in_[size_t(a)])
      for (const int32_t n : members_in_[size_t(b)])
        if (m != n) near_[std::minmax(m, n)].joined |= joined;
  }

  const TriangleBoxes& boxes(Member& member) {
    if (!member.boxes) {
      std::vector<std::array<Vec3, 3>> triangles;
      for (const int32_t t : member.triangles) triangles.push_back(corners(t));
      member.boxes.emplace(std::move(triangles));
    }
    return *member.boxes;
  }

  /// Whether a part of `inner` lies within the solids of `outer`.
  bool is_within(Member& outer, Member& inner) {
    if (!holds(boxes(outer).whole(), boxes(inner).whole())) return false;
    if (!outer.winding_number) {
      std::vector<WindingNumber::Triangle> solid;
      for (const int32_t t : outer.triangles) {
        const auto c = corners(t);
        if (mesh_.role[size_t(t)] == Role::kSolid) solid.push_back({{c[0], c[1], c[2]}});
      }
      outer.winding_number.emplace(std::move(solid));
    }
    return std::abs((*outer.winding_number)(corners(inner.triangles[0])[0])) > 0.5;
  }

  /// Joins two members, or records the gap between them.
  void judge(const Pair& pair, Near& near) {
    Member &a = members_[size_t(pair.first)], &b = members_[size_t(pair.second)];
    if (sets_.root(a.triangles[0]) == sets_.root(b.triangles[0])) return;
    bool one = is_within(a, b) || is_within(b, a);
    if (!one) {
      const TriangleGap gap = nearest(boxes(a), boxes(b), touch_);
      one = gap.distance <= touch_;
      near.gap = {{a.triangles[size_t(gap.first)], b.triangles[size_t(gap.second)]}, gap.distance};
    }
    if (one) sets_.join(a.triangles[0], b.triangles[0], false);
  }

  /// Joins members that lie within another one, however far from its surface.
  void join_contained() {
    for (Member& outer : members_)
      for (Member& inner : members_)
        if (&outer != &inner && sets_.root(outer.triangles[0]) != sets_.root(inner.triangles[0]) &&
            is_within(outer, inner))
          sets_.join(outer.triangles[0], inner.triangles[0], false);
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
    for (const auto& [pair, near] : near_) {
      if (!near.gap) continue;
      const int32_t a = parts.of[size_t(near.gap->triangle[0])];
      const int32_t b = parts.of[size_t(near.gap->triangle[1])];
      if (a == b) continue;
      Near& least = of_parts.try_emplace(std::minmax(a, b), near).first->second;
      least.joined |= near.joined;
      if (near.gap->distance < least.gap->distance) least.gap = near.gap;
    }
    for (const auto& [pair, near] : of_parts)
      if (near.joined) parts.gaps.push_back(*near.gap);
    return parts;
  }

  const LatticeMesh& mesh_;
  const SurfaceCells& cells_;
  const std::vector<uint8_t>& kept_;
  double touch_ = 0;  // distance at which parts count as touching
  OrientedSets sets_;
  std::unordered_map<uint64_t, int64_t> place_;  // index of each cell by its coordinates
  std::vector<Member> members_;
  std::vector<int32_t> member_of_;                // member of each triangle
  std::vector<std::vector<int32_t>> members_in_;  // members in each cell
  std::map<Pair, Near> near_;                     // pairs of members with cells that share a node
};

}  // namespace

Parts find_parts(const CutBody& body, bool all) {
  return PartFinder(body).find(all);
}

}  // namespace elastogen
