// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/multigrid.hpp"

#include "core/error.hpp"
#include "core/hex8.hpp"
#include "core/reduce.hpp"
#include "network/precondition/held_diagonal.hpp"
#include "network/precondition/multigrid_element.hpp"
#include "network/precondition/multigrid_grid.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

namespace elastogen {
namespace {

constexpr size_t kMostInverses = 16;

/// Largest eigenvalue of D^-1 K over the voxels, a bound for the whole.
double largest_eigenvalue(const LevelGrid& level) {
  return kBorderExcess * largest(int64_t(level.moduli.size() / 6), [&](int64_t v) {
           return element_bound(level.moduli.data() + 6 * v);
         });
}

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& A) {
  const Eigen::MatrixXd result = A.llt().solve(Eigen::MatrixXd::Identity(A.rows(), A.cols()));
  return (result + result.transpose()) / 2;
}

}  // namespace

template <class T>
struct Multigrid<T>::Level {
  explicit Level(LevelGrid&& g)
      : grid(std::move(g)), scratch(*grid.rows), lambda_max(largest_eigenvalue(grid)) {
    const size_t size = 3 * size_t(grid.nodes);
    for (Zeroed<T>* vector : {&r, &z, &d, &inverse_diagonal}) vector->resize(size);
    moduli.resize(size_t(grid.rows->row_count()) * 6 * kLanes);
    for_each(int64_t(grid.rows->slot.size()), [&](int64_t v) {
      const size_t slot = size_t(grid.rows->slot[size_t(v)]), lane = slot % kLanes;
      for (size_t k = 0; k < 6; ++k)
        moduli[(slot - lane) * 6 + k * kLanes + lane] =
            T(grid.moduli[6 * size_t(v) + k] * grid.h / grid.unit);
    });
    set_diagonal();
  }

  /// Runs finish(node, (A p)_node) over the nodes; p is 0 on pinned nodes, and rows of pinned nodes
  /// are not cleared.
  template <class Finish>
  void product(const T* p, const Finish& finish) {
    for_each_row(
        *grid.rows, scratch, no_sums,
        [=](int64_t n, int64_t, T value[3]) {
          for (int i = 0; i < 3; ++i) value[i] = p[3 * n + i];
        },
        [&](int64_t r, const Pack<T> u[3][8], Pack<T> f[3][8], NoSums&) {
          Pack<T> k[6], M[7];
          for (int j = 0; j < 6; ++j) k[j] = load(moduli.data() + (r * 6 + j) * kLanes);
          const bool border = load_moments<T>(r, M);
          for (int i = 0; i < 3; ++i)
            border ? scalar_element<true>(k, M, i, u[i], f[i])
                   : scalar_element<false>(k, M, i, u[i], f[i]);
        },
        [&](int64_t n, const T force[3]) {
          T sum[3];
          for (int i = 0; i < 3; ++i) sum[i] = force[i] + added[size_t(3 * n + i)] * p[3 * n + i];
          finish(n, sum);
        });
  }

  /// Sums the diagonal in double, and rounds it once.
  void set_diagonal() {
    const size_t size = 3 * size_t(grid.nodes);
    elastic_diagonal.resize(size);
    BrickScratch<double> scratch(*grid.rows);
    for_each_row(
        *grid.rows, scratch, no_sums,
        [](int64_t, int64_t, double value[3]) { std::fill_n(value, 3, 0.0); },
        [&](int64_t r, const Pack<double>[3][8], Pack<double> f[3][8], NoSums&) {
          corner_diagonal(r, f);
        },
        [&](int64_t n, const double sum[3]) {
          for (int i = 0; i < 3; ++i) elastic_diagonal[size_t(3 * n + i)] = T(sum[i]);
        });
    set_added(Zeroed<T>(size));
  }

  /// Shares of the voxels of a row in the diagonal at their corners.
  void corner_diagonal(int64_t r, Pack<double> f[3][8]) const {
    Pack<double> k[6] = {}, M[7];
    for (int lane = 0; lane < kLanes; ++lane) {
      const int32_t v = grid.rows->voxel[size_t(r * kLanes + lane)];
      for (int j = 0; j < 6 && v >= 0; ++j)
        k[j][lane] = grid.moduli[size_t(6 * v + j)] * grid.h / grid.unit;
    }
    const bool border = load_moments<double>(r, M);
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 8; ++c) {
        if (border) {
          Pack<double> unit[8] = {}, force[8];
          unit[c] += 1;
          scalar_element<true>(k, M, i, unit, force);
          f[i][c] = force[c];
        } else {
          f[i][c] = (4 * k[0] + k[1]) / 16 + (k[2] + k[3] + k[4]) / 24 + k[5] / 48;
        }
      }
  }

  /// Loads the moments of the fill of a row; false if it has no border voxels.
  template <class S>
  bool load_moments(int64_t r, Pack<S> M[7]) const {
    const int32_t border = grid.rows->rows[size_t(r)].border;
    for (int m = 0; m < 7 && border >= 0; ++m)
      M[m] = __builtin_convertvector(
          load(grid.rows->border.data() + (size_t(border) * 7 + size_t(m)) * kLanes), Pack<S>);
    return border >= 0;
  }

  /// Sets inertia plus an additional stiffness of each node and component, in units of the level.
  void set_added(Zeroed<T>&& stiffness) {
    added = std::move(stiffness);
    for_each(3 * grid.nodes, [&](int64_t i) {
      const size_t k = size_t(i);
      added[k] += T(inertia_factor * grid.inertia[k / 3] / grid.unit);
      const T sum = elastic_diagonal[k] + added[k];
      inverse_diagonal[k] = grid.pinned[k / 3] || sum <= 0 ? T(0) : 1 / sum;
    });
  }

  /// Computes the dense inverses of the three operators.
  void invert() {
    run_tasks(3, [&](int64_t i) {
      inverse[size_t(i)] = inverse_of(dense_operator(int(i))).template cast<T>();
    });
  }

  /// The operator of a component, 1 on the diagonal of pinned nodes.
  Eigen::MatrixXd dense_operator(int i) const {
    const Eigen::Index n = grid.nodes;
    Eigen::MatrixXd A = elastic[i];
    for (Eigen::Index k = 0; k < n; ++k) A(k, k) += double(added[size_t(3 * k + i)]);
    for (Eigen::Index k = 0; k < n; ++k) {
      if (!grid.pinned[size_t(k)]) continue;
      A.row(k).setZero();
      A.col(k).setZero();
      A(k, k) = 1;
    }
    return A;
  }

  /// Makes the elastic parts of the three operators as dense matrices.
  void assemble() {
    const Eigen::Index n = grid.nodes;
    for (auto& A : elastic) A = Eigen::MatrixXd::Zero(n, n);
    std::vector<T> unit(3 * size_t(n));
    for (Eigen::Index column = 0; column < n; ++column) {
      for (size_t i = 0; i < 3; ++i) unit[3 * size_t(column) + i] = 1;
      product(unit.data(), [&](int64_t row, const T sum[3]) {
        for (int i = 0; i < 3; ++i) {
          elastic[i](row, column) = double(sum[i]);
          if (row == column) elastic[i](row, row) -= double(added[size_t(3 * row + i)]);
        }
      });
      for (size_t i = 0; i < 3; ++i) unit[3 * size_t(column) + i] = 0;
    }
    for (auto& A : elastic) A = (A + A.transpose()).eval() / 2;
  }

  LevelGrid grid;
  BrickScratch<T> scratch;
  std::vector<NoSums> no_sums;
  double lambda_max;
  double inertia_factor = 1;  // of what the grid has
  Zeroed<T> moduli, elastic_diagonal, added, inverse_diagonal;
  Zeroed<T> r, z, d;           // use no memory until a cycle runs here
  Eigen::MatrixXd elastic[3];  // coarsest level only, as its inverse
  using Inverse = std::array<Eigen::Matrix<T, Eigen::Dynamic, Eigen::Dynamic>, 3>;
  Inverse inverse;
  std::map<double, Inverse> inverses;  // by the factor of the inertia
};

template <class T>
Multigrid<T>::Multigrid(const Scene& scene, double a0, std::shared_ptr<const BrickRows> rows,
                        std::optional<int64_t> most_dense)
    : folded_(held_diagonal(scene, a0 / (scene.dt * scene.dt))) {
  const int64_t dense = most_dense.value_or(dense_nodes(scene));
  if (!rows) rows = std::make_shared<const BrickRows>(make_brick_rows(scene.grid, scene.material));
  levels_.push_back(std::make_unique<Level>(finest_level(scene, a0, std::move(rows))));
  while (levels_.back()->grid.nodes > dense && int(levels_.size()) < kMostLevels) {
    LevelGrid coarse = coarser_level(levels_.back()->grid);
    if (!is_worthwhile(coarse.nodes, levels_.back()->grid.nodes)) break;
    levels_.push_back(std::make_unique<Level>(std::move(coarse)));
  }

  for (const auto& level : levels_) release_setup(level->grid);
  Level& last = *levels_.back();
  if (last.grid.nodes <= dense) {
    last.assemble();
    last.invert();
  }
  if (!folded_.empty()) set_nodal_stiffness({});
}

template <class T>
void Multigrid<T>::set_nodal_stiffness(const std::vector<double>& stiffness) {
  for (size_t l = 0; l < levels_.size(); ++l) {
    Level& level = *levels_[l];
    Zeroed<T> added(3 * size_t(level.grid.nodes));
    if (l == 0)
      for (size_t k = 0; k < added.size(); ++k)
        added[k] = T(((stiffness.empty() ? 0 : stiffness[k]) + (folded_.empty() ? 0 : folded_[k])) /
                     level.grid.unit);
    else
      restrict_residual(level.grid, levels_[l - 1]->d.data(), added.data());
    std::copy(added.begin(), added.end(), level.d.begin());
    level.set_added(std::move(added));
  }
  if (levels_.back()->inverse[0].size() > 0) levels_.back()->invert();
}

/// Inverses of the coarsest level are kept, because steps of few lengths take turns.
template <class T>
void Multigrid<T>::scale_inertia(double factor) {
  Level& last = *levels_.back();
  const bool is_dense = last.inverse[0].size() > 0;
  for (const auto& level : levels_) {
    level->inertia_factor = factor;
    level->set_added(Zeroed<T>(3 * size_t(level->grid.nodes)));
  }
  if (!folded_.empty()) return set_nodal_stiffness({});
  if (!is_dense) return;
  auto known = last.inverses.find(factor);
  if (known == last.inverses.end()) {
    if (last.inverses.size() >= kMostInverses) last.inverses.clear();
    last.invert();
    known = last.inverses.emplace(factor, last.inverse).first;
  }
  last.inverse = known->second;
}

template <class T>
Multigrid<T>::~Multigrid() = default;

/// z = p(D^-1 A) D^-1 r from z = 0.
template <class T>
void Multigrid<T>::smooth_from_zero(Level& level) {
  const Chebyshev c(level.lambda_max);
  const int64_t n = 3 * level.grid.nodes;
  for_each(n, [&](int64_t k) {
    level.z[size_t(k)] = T(c.first) * level.inverse_diagonal[size_t(k)] * level.r[size_t(k)];
  });
  level.product(level.z.data(), [&](int64_t node, const T Az[3]) {
    for (size_t k = 3 * size_t(node), i = 0; i < 3; ++i, ++k)
      level.d[k] =
          T(c.keep) * level.z[k] + T(c.add) * level.inverse_diagonal[k] * (level.r[k] - Az[i]);
  });
  add_scaled(T(1), level.d.data(), level.z.data(), n);
}

/// z += p(D^-1 A) D^-1 (r - A z), with the polynomial of smooth_from_zero.
template <class T>
void Multigrid<T>::smooth(Level& level) {
  const Chebyshev c(level.lambda_max);
  const int64_t n = 3 * level.grid.nodes;
  level.product(level.z.data(), [&](int64_t node, const T Az[3]) {
    for (size_t k = 3 * size_t(node), i = 0; i < 3; ++i, ++k)
      level.d[k] = T(c.first) * level.inverse_diagonal[k] * (level.r[k] - Az[i]);
  });
  add_scaled(T(1), level.d.data(), level.z.data(), n);
  level.product(level.z.data(), [&](int64_t node, const T Az[3]) {
    for (size_t k = 3 * size_t(node), i = 0; i < 3; ++i, ++k)
      level.d[k] =
          T(c.keep) * level.d[k] + T(c.add) * level.inverse_diagonal[k] * (level.r[k] - Az[i]);
  });
  add_scaled(T(1), level.d.data(), level.z.data(), n);
}

template <class T>
void Multigrid<T>::cycle(size_t l) {
  Level& level = *levels_[l];
  if (level.inverse[0].size() > 0) {
    using Vectors = Eigen::Matrix<T, 3, Eigen::Dynamic>;
    const Eigen::Index n = level.grid.nodes;
    const Eigen::Map<const Vectors> r(level.r.data(), 3, n);
    Eigen::Map<Vectors> z(level.z.data(), 3, n);
    for (int i = 0; i < 3; ++i) z.row(i).noalias() = r.row(i) * level.inverse[size_t(i)];
    return;
  }
  smooth_from_zero(level);
  if (l + 1 < levels_.size()) {
    Level& coarse = *levels_[l + 1];
    level.product(level.z.data(), [&](int64_t node, const T Az[3]) {
      for (size_t k = 3 * size_t(node), i = 0; i < 3; ++i, ++k)
        level.d[k] = level.grid.pinned[size_t(node)] ? T(0) : level.r[k] - Az[i];
    });
    restrict_residual(coarse.grid, level.d.data(), coarse.r.data());
    cycle(l + 1);
    prolong_correction(level.grid, coarse.z.data(), level.z.data());
  }
  smooth(level);
}

template <class T>
void Multigrid<T>::apply(const T* r, T* z) {
  Level& level = *levels_.front();
  const int64_t n = 3 * level.grid.nodes;
  const T scale = T(1 / level.grid.unit);
  for_each(n, [&](int64_t k) { level.r[size_t(k)] = scale * r[k]; });
  cycle(0);
  for_each(n, [&](int64_t k) { z[k] = level.z[size_t(k)]; });
}

template <class T>
void Multigrid<T>::operator_product(const T* p, T* product) {
  Level& level = *levels_.front();
  const T unit = T(level.grid.unit);
  level.product(p, [&](int64_t n, const T sum[3]) {
    for (int i = 0; i < 3; ++i)
      product[3 * n + i] = level.grid.pinned[size_t(n)] ? T(0) : unit * sum[i];
  });
}

template <class T>
MultigridLevel<T> Multigrid<T>::level(int l) const {
  const Level& from = *levels_[size_t(l)];
  const LevelGrid& grid = from.grid;
  return {*grid.rows,  from.moduli,     from.added,      from.inverse_diagonal,
          grid.pinned, grid.node_coord, from.lambda_max, grid.unit,
          grid.nodes};
}

template class Multigrid<float>;
template class Multigrid<double>;

}  // namespace elastogen
