// SPDX-License-Identifier: Apache-2.0
// Low-frequency modes of the encoder: cosines over a body's box that vanish smoothly at its pins.

#pragma once

#include "core/base.hpp"
#include "core/scene.hpp"

#include <array>
#include <vector>

namespace elastogen {

/// Wave numbers k_x, k_y, k_z of a cosine mode.
using Wave = std::array<int, 3>;

/// The `count` waves of smallest sum (k_d/L_d)^2 in a box of extents L; ties by wave number.
std::vector<Wave> lowest_waves(const Box& box, int count);

/// Coordinates on the lattice.
struct LatticePlace {
  int32_t at[3];
};

ELASTOGEN_HD inline int64_t square_between(const LatticePlace& a, const LatticePlace& b) {
  int64_t sum = 0;
  for (int d = 0; d < 3; ++d) {
    const int64_t away = int64_t(a.at[d]) - b.at[d];
    sum += away * away;
  }
  return sum;
}

struct LatticeBox {
  LatticePlace lower, upper;

  ELASTOGEN_HD void add(const LatticeBox& o) {
    for (int d = 0; d < 3; ++d) {
      if (o.lower.at[d] < lower.at[d]) lower.at[d] = o.lower.at[d];
      if (o.upper.at[d] > upper.at[d]) upper.at[d] = o.upper.at[d];
    }
  }
  ELASTOGEN_HD int64_t square_to(const LatticePlace& place) const {
    int64_t sum = 0;
    for (int d = 0; d < 3; ++d) {
      const int64_t below = int64_t(lower.at[d]) - place.at[d];
      const int64_t above = int64_t(place.at[d]) - upper.at[d];
      const int64_t away = below > above ? below : above;
      if (away > 0) sum += away * away;
    }
    return sum;
  }
};

/// Box of the listed nodes; without any, lower is 0 and upper -1.
LatticeBox lattice_box(const VoxelGrid& grid, const std::vector<int32_t>& nodes);

/// prod_d cos(pi k_d (X_d - X_d,min)/L_d) of some waves at the nodes of a grid, from tables over
/// the planes of its lattice.
struct CosineTables {
  const double* table[3];  ///< of each axis, (planes, waves)
  int32_t first[3];        ///< first plane of each axis
  int waves;

  /// Value of wave w at a node with lattice coordinates `at`.
  ELASTOGEN_HD double operator()(int w, const int32_t at[3]) const {
    double value = 1;
    for (int d = 0; d < 3; ++d) value *= table[d][int64_t(at[d] - first[d]) * waves + w];
    return value;
  }
};

class PlaneCosines {
 public:
  /// @param planes  lattice coordinates of the nodes; box holds their rest positions.
  PlaneCosines(double h, const LatticeBox& planes, const std::vector<Wave>& waves, const Box& box);
  CosineTables tables() const {
    return {{table_[0].data(), table_[1].data(), table_[2].data()},
            {first_.at[0], first_.at[1], first_.at[2]},
            waves_};
  }
  const std::vector<double>& table(int axis) const { return table_[axis]; }

 private:
  LatticePlace first_;
  int waves_;
  std::vector<double> table_[3];
};

/// A tree of boxes over the outer pins of a piece: a lowest box has a few pins that are close to
/// each other, any other box has two of the level below.
struct PinTree {
  static constexpr int kMostLevels = 32, kLeaf = 8;  ///< pins in a lowest box

  int32_t first = 0, count = 0;     ///< its pins in PinTrees::places
  int32_t levels = 0;               ///< the last one has one box
  int32_t begin[kMostLevels] = {};  ///< first box of each level in PinTrees::boxes
  int32_t boxes[kMostLevels] = {};  ///< count of the boxes of each level
};

/// The trees of a grid's pieces, as kernels read them.
struct PinTreesView {
  const LatticePlace* places;
  const LatticeBox* boxes;
  const PinTree* trees;

  /// The pin of a piece that is nearest to `at`, or `known` where none is nearer.
  ELASTOGEN_HD LatticePlace nearest(int32_t piece, const LatticePlace& at,
                                    const LatticePlace& known) const {
    const PinTree& tree = trees[piece];
    LatticePlace found = known;
    int64_t least = square_between(at, known);
    struct {
      int32_t level, box;
    } left[PinTree::kMostLevels + 1] = {{tree.levels - 1, 0}};
    for (int size = 1; size > 0;) {
      const auto [level, k] = left[--size];
      if (boxes[tree.begin[level] + k].square_to(at) >= least) continue;
      // the pins of a lowest box
      if (level == 0) {
        for (int32_t p = PinTree::kLeaf * k; p < PinTree::kLeaf * (k + 1) && p < tree.count; ++p) {
          const int64_t square = square_between(at, places[tree.first + p]);
          if (square < least) least = square, found = places[tree.first + p];
        }
        continue;
      }
      // the boxes below
      const LatticeBox* below = boxes + tree.begin[level - 1];
      const int32_t a = 2 * k, b = 2 * k + 1;
      if (b == tree.boxes[level - 1]) {
        left[size++] = {level - 1, a};
        continue;
      }
      const bool turn = below[b].square_to(at) < below[a].square_to(at);
      left[size++] = {level - 1, turn ? a : b};
      left[size++] = {level - 1, turn ? b : a};  // the nearer one first
    }
    return found;
  }
};

struct PinTrees {
  explicit PinTrees(const Scene& scene);
  PinTreesView view() const { return {places.data(), boxes.data(), trees.data()}; }

  std::vector<LatticePlace> places;
  std::vector<LatticeBox> boxes;
  std::vector<PinTree> trees;  ///< of each piece of the grid; without pins they have no levels
};

/// Distance of each listed node to the nearest pin of its piece [m], 1e300 if there is none.
Zeroed<double> pin_distance(const Scene& scene, const PinTrees& pins,
                            const std::vector<int32_t>& nodes);

}  // namespace elastogen
