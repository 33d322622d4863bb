// SPDX-License-Identifier: Apache-2.0
#include "network/potential/incremental_potential.cuh"
#include "network/precondition/dense.cuh"
#include "network/precondition/held_diagonal.hpp"
#include "network/precondition/multigrid.cuh"
#include "network/precondition/multigrid_grid.cuh"
#include "network/precondition/stencil_folded.cuh"

#include <bit>

namespace elastogen::cuda {
namespace {

/// Largest of two kinds of values.
struct Maxima {
  double value[2] = {};
  __device__ void add(const Maxima& o) {
    for (int k = 0; k < 2; ++k) value[k] = o.value[k] > value[k] ? o.value[k] : value[k];
  }
};

/// Makes a level. Data that only the making needs are freed with the maker.
template <class T>
class LevelMaker {
 public:
  explicit LevelMaker(const BrickLevel& bricks)
      : bricks_(bricks), slots_(kSlots * bricks.brick_count()) {
    made.slot = DeviceArray<int32_t>(bricks.nodes.point_count());
    made.row = DeviceArray<int32_t>(slots_);
    if (MemoryCount::present()) return;
    moduli_ = DeviceArray<double>(6 * slots_);
    inertia_ = DeviceArray<double>(slots_);
    pinned_ = DeviceArray<uint8_t>(slots_);
  }

  void take_scene(DevicePotential::Impl& potential, const BrickLevel& bricks);
  void take_folded(const PotentialTerms& terms);
  void average(LevelMaker& finer);
  Maxima maxima();
  void find_lambda();
  void number_rows(double h, double unit, uint64_t hash_bits);
  DeviceArray<double> dense_operators();

  /// Moves the finished level out.
  HierarchyLevel<T> take() {
    made.links = std::move(bricks_.links);
    made.begin = std::move(bricks_.begin);
    return std::move(made);
  }

  HierarchyLevel<T> made;

 private:
  SlotTables tables() {
    return {bricks_.tables(), moduli_.data(), inertia_.data(), pinned_.data(),
            border_.data(),   moments_,       folded_.data()};
  }

  DeviceBricks bricks_;
  DeviceArray<double> moduli_, inertia_;
  DeviceArray<uint8_t> pinned_;
  DeviceArray<int32_t> border_;
  const double* moments_ = nullptr;
  DeviceArray<double> folded_;
  int64_t slots_;
};

/// Fills the finest level. A first pass writes moduli and border indices of voxels: each brick has
/// 512 threads, eight to a row, which go through its rows 64 at a time. A second pass over the
/// slots writes inertia, pins and the slot of each node.
template <class T>
void LevelMaker<T>::take_scene(DevicePotential::Impl& potential, const BrickLevel& bricks) {
  border_ = DeviceArray<int32_t>(slots_);
  moments_ = potential.rows.border().data();
  const DeviceArray<int32_t> node_brick(bricks.node_brick);
  const int32_t* const brick_at = node_brick.data();
  const VoxelTables<double> of = potential.voxels<double>();
  const RowsView rows = potential.rows.view();
  const SlotTables to = tables();
  int32_t* const border = border_.data();
  const auto take = [=] __device__(int64_t brick, int64_t r, int lane) {
    const VoxelRow row = rows.rows[r];
    if (!(row.mask >> lane & 1)) return;
    const int line = row.offset / ::elastogen::bricks::kTileWidth;
    const int64_t slot = int64_t(kSlots) * brick + lane + 8 * (line % 9) + 64 * (line / 9);
    const LawParameters<double>& law = of.materials[row.material].law;
    const double* weight = of.weights + 5 * kLanes * r + lane;
    const auto set = [&](int j, double modulus) {
      to.moduli[j * to.slots() + slot] = weight[0] * modulus;
    };
    set(0, law.mu);
    set(1, law.lambda);
    // without a variance term twelve modes of a voxel would have no energy in the cycle: it uses mu
    for (int j = 0; j < 4; ++j)
      set(2 + j, of.hourglass == Hourglass::kOff ? law.mu : weight[(1 + j) * kLanes]);
    border[slot] = row.border < 0 ? -1 : kLanes * row.border + lane;
  };
  cuda::for_each(kSlots * rows.bricks, [=] __device__(int64_t k) {
    const int64_t b = k / kSlots, first = rows.row_begin[b] + k % kSlots / kLanes;
    for (int64_t r = first; r < rows.row_begin[b + 1]; r += kSlots / kLanes)
      take(brick_at[b], r, int(k % kLanes));
  });
  const double* const inertia = potential.inertia.data();
  const uint8_t* const pinned = potential.pinned.data();
  int32_t* const slot_of = made.slot.data();
  cuda::for_each(slots_, [=] __device__(int64_t slot) {
    if (!to.has_node(slot)) return;
    const int32_t n = to.node(slot);
    to.inertia[slot] = inertia[n];
    to.pinned[slot] = pinned[n];
    slot_of[n] = int32_t(slot);
  });
}

/// Takes what dependent nodes add at the finest level, whose slots are known.
template <class T>
void LevelMaker<T>::take_folded(const PotentialTerms& terms) {
  const StepScheme& scheme = terms.scheme();
  folded_ = folded_by_slot(held_diagonal(terms.scene(), scheme.a0 / (scheme.dt * scheme.dt)),
                           made.slot, slots_);
}

/// Fills a level from the finer one, one thread for each slot. Moduli are means over the eight
/// children, of which missing ones count as 0, with one variance weight for all patterns. Masses
/// are P^T of the finer masses. A node on a pinned node is pinned.
template <class T>
void LevelMaker<T>::average(LevelMaker& finer) {
  const SlotTables fine = finer.tables(), coarse = tables();
  int32_t* const slot_of = made.slot.data();
  cuda::for_each(slots_, [=] __device__(int64_t slot) {
    if (!coarse.has_node(slot)) return;
    const Place at(slot);
    const int32_t* around = coarse.links[slot / kSlots].fine;
    // inertia and pin of a node, from the finer nodes around it
    double inertia = 0;
    for (int k = 0; k < 27; ++k) {
      const int dx = k % 3 - 1, dy = k / 3 % 3 - 1, dz = k / 9 - 1;
      const int64_t child = fine.slot_at(around, 2 * at.x + dx, 2 * at.y + dy, 2 * at.z + dz);
      if (child < 0 || !fine.has_node(child)) continue;
      const int odd = (dx != 0) + (dy != 0) + (dz != 0);
      if (odd == 0) coarse.pinned[slot] = fine.pinned[child];
      inertia += fine.inertia[child] / double(1 << odd);
    }
    coarse.inertia[slot] = inertia;
    slot_of[coarse.node(slot)] = int32_t(slot);
    if (!coarse.has_voxel(slot)) return;
    // moduli of the voxel whose corner 0 it is, from its children
    double sum[6] = {};
    for (int c = 0; c < 8; ++c) {
      const int64_t child =
          fine.slot_at(around, 2 * at.x + (c & 1), 2 * at.y + (c >> 1 & 1), 2 * at.z + (c >> 2));
      if (child < 0 || !fine.has_voxel(child)) continue;
      double k[6];
      for (int j = 0; j < 6; ++j) k[j] = fine.moduli[j * fine.slots() + child];
      sum[0] += k[0] / 8;
      sum[1] += k[1] / 8;
      const double variance = (k[2] + k[3] + k[4] + k[5]) / 4;
      for (int j = 2; j < 6; ++j) sum[j] += variance / 8;
    }
    for (int j = 0; j < 6; ++j) coarse.moduli[j * coarse.slots() + slot] = sum[j];
  });
  folded_ = folded_of_coarser(fine, coarse, slots_);
}

/// Calls body(slot, maxima) for all slots, and gives the largest values. Waits for the device.
template <class Body>
Maxima largest_of(int64_t slots, const Body& body) {
  DeviceArray<SumScratch<Maxima>> scratch(1);
  PinnedArray<Maxima> result(1);
  Maxima* const to = result.data();
  ordered_sum(slots, scratch.data(), body, [=] __device__(const Maxima& found) { *to = found; });
  synchronise();
  return result[0];
}

/// Largest inertia and largest modulus.
template <class T>
Maxima LevelMaker<T>::maxima() {
  const SlotTables of = tables();
  return largest_of(slots_, [=] __device__(int64_t slot, Maxima & sum) {
    double most = 0;
    for (int j = 0; j < 6; ++j) most = fmax(most, of.moduli[j * of.slots() + slot]);
    sum.add({{of.inertia[slot], most}});
  });
}

template <class T>
void LevelMaker<T>::find_lambda() {
  const SlotTables of = tables();
  made.lambda_max = kBorderExcess * largest_of(slots_, [=] __device__(int64_t slot, Maxima & sum) {
                                      if (!of.has_voxel(slot)) return;
                                      double k[6];
                                      for (int j = 0; j < 6; ++j)
                                        k[j] = of.moduli[j * of.slots() + slot];
                                      sum.add({{element_bound(k), 0}});
                                    }).value[0];
}

/// Finds the distinct rows, numbers them and writes them, in rounds. In a round each slot that has
/// no row yet enters the hash of its row into a table, which keeps the first slot of each hash.
/// These first slots are counted brick by brick, the host adds the counts up, and they write their
/// rows. Then every other slot compares its row with that of its first slot, and shares it if both
/// are equal. The few that only have an equal hash go into the next round. Numbers follow the order
/// of slots, so every run gives the same ones.
template <class T>
void LevelMaker<T>::number_rows(double h, double unit, uint64_t hash_bits) {
  const int32_t bricks = int32_t(slots_ / kSlots);
  const RowSource<T> source{tables(), h / unit, unit};
  const int64_t entries = int64_t(std::bit_ceil(uint64_t(2 * made.slot.size())));
  DeviceArray<unsigned long long> keys(entries);
  DeviceArray<int32_t> first(entries), counts(bricks), base(bricks);
  DeviceArray<uint64_t> entry(slots_);
  PinnedArray<int32_t> left(1);
  const FirstSlots of{keys.data(), first.data(), uint64_t(entries - 1)};
  int32_t *const row = made.row.data(), *const waiting = left.data();
  uint64_t* const entry_of = entry.data();
  const auto is_pending = [=] __device__(int64_t slot) {
    return source.level.is_free(slot) && row[slot] == 0;
  };
  std::vector<int32_t> number(static_cast<size_t>(bricks));
  int32_t count = 1;  // row 0 belongs to slots without a free node
  do {
    check(cudaMemsetAsync(keys.data(), 0, size_t(entries) * sizeof(uint64_t), cudaStreamPerThread));
    check(cudaMemsetAsync(first.data(), 0x7f, size_t(entries) * sizeof(int32_t),
                          cudaStreamPerThread));
    // the first slot of each hash among those that have no row yet
    cuda::for_each(slots_, [=] __device__(int64_t slot) {
      if (is_pending(slot)) entry_of[slot] = of.take(source.hash(slot, hash_bits), int32_t(slot));
    });
    // these get new rows, numbered brick by brick
    launch(number_kernel<T>, unsigned(bricks), kSlots, 0, source, of, entry_of,
           static_cast<const int32_t*>(nullptr), counts.data(), row, static_cast<T*>(nullptr));
    counts.download(number.data());
    const int32_t before = count;
    for (int32_t& k : number) std::swap(k, count), count += k;
    base.upload(number.data());
    DeviceArray<T> rows(int64_t(kRow) * count);
    check(cudaMemcpyAsync(rows.data(), made.rows.data(), size_t(made.rows.size()) * sizeof(T),
                          cudaMemcpyDeviceToDevice, cudaStreamPerThread));
    launch(number_kernel<T>, unsigned(bricks), kSlots, 0, source, of, entry_of, base.data(),
           counts.data(), row, rows.data());
    made.rows = std::move(rows);
    // slots of the same hash and numbers share them; the others wait for the next turn
    const T* const all = made.rows.data();
    left[0] = 0;
    cuda::for_each(slots_, [=] __device__(int64_t slot) {
      if (!is_pending(slot)) return;
      const int32_t like = row[of.first[entry_of[slot]]];
      bool same = true;
      source.for_numbers(slot, [&](int k, T value) {
        same &= source.bits_of(value) == source.bits_of(all[int64_t(kRow) * like + k]);
      });
      if (same)
        row[slot] = like;
      else
        *waiting = 1;
    });
    synchronise();
    ELASTOGEN_CHECK(count > before, "rows of stencils cannot be told apart");
  } while (left[0] > 0);
}

/// The dense operators of this level, one thread for each row. Both stencils of a pair of nodes
/// have its entry, equal to rounding; their mean makes the matrices symmetric.
template <class T>
DeviceArray<double> LevelMaker<T>::dense_operators() {
  const int64_t n = made.slot.size(), pitch = dense_pitch(n);
  DeviceArray<double> operators(3 * pitch * pitch);
  if (MemoryCount::present()) return operators;
  const SlotTables level = tables();
  const int32_t *const slot_of = made.slot.data(), *const row_of = made.row.data();
  const T* const rows = made.rows.data();
  double* const to = operators.data();
  cuda::for_each(pitch, [=] __device__(int64_t a) {
    const auto entry = [=](int i, int64_t b) { return to + (i * pitch + a) * pitch + b; };
    const int32_t slot = a < n ? slot_of[a] : 0, row = a < n ? row_of[slot] : 0;
    // the identity for pinned nodes and beyond the last node
    if (row == 0) {
      for (int i = 0; i < 3; ++i) *entry(i, a) = 1;
      return;
    }
    const Place at(slot);
    const int32_t* around = level.links[slot / kSlots].neighbour;
    // entries with the nodes around this one
    for (int j = 0; j < 27; ++j) {
      const int64_t there =
          level.slot_at(around, at.x + j % 3 - 1, at.y + j / 3 % 3 - 1, at.z + j / 9 - 1);
      if (there < 0 || row_of[there] == 0) continue;
      for (int i = 0; i < 3; ++i) {
        const T* weights = rows + int64_t(i) * kComponent;
        *entry(i, level.node(there)) = (double(weights[int64_t(kRow) * row + j]) +
                                        double(weights[int64_t(kRow) * row_of[there] + 26 - j])) /
                                       2;
      }
    }
  });
  return operators;
}

/// Estimated count of a scene's rows: 27 on each level, one for each node of a border voxel and for
/// each parent node on the finest level, and a third more on the coarser ones.
int64_t row_estimate(const DevicePotential::Impl& potential) {
  const int64_t border_voxels = potential.rows.border().size() / 7;
  const auto parents = int64_t(potential.terms.scene().dependent.folded().nodes.size());
  return 27 * kMostLevels + (border_voxels + parents) * 4 / 3;
}

}  // namespace

template <class T>
Hierarchy<T> make_hierarchy(DevicePotential& potential, int hash_bits) {
  const std::vector<BrickLevel>& bricks = potential.impl().levels;
  const uint64_t bits = hash_bits < 64 ? (uint64_t{1} << hash_bits) - 1 : ~uint64_t{0};
  const bool counts = MemoryCount::present() != nullptr;
  Hierarchy<T> result;
  std::unique_ptr<LevelMaker<T>> finer;
  double h = potential.terms().scene().grid.h;
  // from the finest level down; a level moves out when the next one has been averaged from it
  for (const BrickLevel& level : bricks) {
    auto maker = std::make_unique<LevelMaker<T>>(level);
    if (!counts) {
      if (finer) {
        maker->average(*finer);
      } else {
        maker->take_scene(potential.impl(), level);
        maker->take_folded(potential.terms());
        // the unit of the operators, from their largest numbers
        const Maxima largest = maker->maxima();
        result.unit = largest.value[0] + largest.value[1] * h;
      }
      maker->find_lambda();
      maker->number_rows(h, result.unit, bits);
    }
    if (finer) result.levels.push_back(finer->take());
    finer = std::move(maker);
    h *= 2;
  }
  // a coarsest level that is small enough is solved
  if (bricks.back().nodes.point_count() <= potential.impl().dense)
    result.operators = finer->dense_operators();
  result.levels.push_back(finer->take());
  if (counts) result.levels[0].rows = DeviceArray<T>(kRow * row_estimate(potential.impl()));
  return result;
}

template <class T>
std::vector<LevelRows<T>> hierarchy_rows(DevicePotential& potential, int hash_bits) {
  const auto on_host = [](const auto& array) {
    std::vector<std::remove_cvref_t<decltype(*array.data())>> values(size_t(array.size()));
    array.download(values.data());
    return values;
  };
  std::vector<LevelRows<T>> result;
  for (const HierarchyLevel<T>& level : make_hierarchy<T>(potential, hash_bits).levels) {
    const std::vector<int32_t> slot = on_host(level.slot), row = on_host(level.row);
    const std::vector<T> rows = on_host(level.rows);
    LevelRows<T>& to = result.emplace_back();
    to.distinct = int64_t(rows.size()) / stencil::kRow;
    for (const int32_t s : slot) {
      const auto from = rows.begin() + int64_t(row[size_t(s)]) * stencil::kRow;
      to.by_node.insert(to.by_node.end(), from, from + stencil::kRow);
    }
  }
  return result;
}

template Hierarchy<float> make_hierarchy(DevicePotential&, int);
template Hierarchy<double> make_hierarchy(DevicePotential&, int);
template std::vector<LevelRows<float>> hierarchy_rows(DevicePotential&, int);
template std::vector<LevelRows<double>> hierarchy_rows(DevicePotential&, int);

}  // namespace elastogen::cuda
