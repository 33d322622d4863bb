// SPDX-License-Identifier: Apache-2.0
#include "network/paper/paper_solver.hpp"

#include "core/error.hpp"
#include "network/paper/paper_loop.hpp"
#include "network/paper/paper_operator.hpp"
#include "network/precondition/smooth_modes.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr size_t kFields = 15;  // NN and rest of a voxel
constexpr int kMostModes = 192;

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// The lagged stress of a row of voxels. @param lagged  NN and rest of the row.
template <bool kAffine>
void row_stress(const VoxelData<Pack<double>>& data, const double* lagged, const Pack<double> dF[9],
                Pack<double> dP[9]) {
  Pack<double> NN[6], rest[9];
  for (int k = 0; k < 6; ++k) NN[k] = load(lagged + k * kLanes);
  if constexpr (kAffine)
    for (int k = 0; k < 9; ++k) rest[k] = load(lagged + (6 + k) * kLanes);
  lagged_stress<kAffine>(data.h, lagged_weight(data.law), NN, rest, dF, dP);
}

}  // namespace

void check_paper_scene(const PotentialTerms& terms, const PaperLoops& loops) {
  ELASTOGEN_CHECK(loops.outer >= 1 && loops.inner >= 1,
                  "the paper solver needs one loop at least, ", "got ", loops.outer, " outer and ",
                  loops.inner, " inner");
  ELASTOGEN_CHECK(loops.modes >= 0 && loops.modes <= kMostModes && loops.modes % 3 == 0,
                  "modes must be a multiple of 3 from 0 to ", kMostModes, ", got ", loops.modes);
  ELASTOGEN_CHECK(terms.scene().hourglass != Hourglass::kFull,
                  "the paper solver relaxes x, y and z apart: it needs hourglass variance or off");
  ELASTOGEN_CHECK(!terms.contact().exists(), "the paper solver has no contact: no floor and no ",
                  "colliders with it");
}

std::vector<double> paper_modes(const Scene& scene, int waves) {
  if (waves == 0) return {};
  const Array<double>& X = scene.grid.rest;
  const int64_t nodes = X.rows();
  Box box;
  for (int64_t n = 0; n < nodes; ++n) box.add({X(n, 0), X(n, 1), X(n, 2)});
  const double size = std::max({box.extent(0), box.extent(1), box.extent(2)});
  std::vector<int32_t> all(static_cast<size_t>(nodes));
  std::iota(all.begin(), all.end(), 0);
  const PlaneCosines planes(scene.grid.h, lattice_box(scene.grid, all), lowest_waves(box, waves),
                            box);
  const CosineTables cosines = planes.tables();
  const Zeroed<double> distance = pin_distance(scene, PinTrees(scene), all);
  std::vector<double> modes(size_t(waves) * size_t(nodes));
  for_each(nodes, [&](int64_t n) {
    const double d = distance[size_t(n)];
    for (int k = 0; k < waves; ++k)
      modes[size_t(k * nodes + n)] = d / (d + size / 8) * cosines(k, scene.grid.node_coord.row(n));
  });
  return modes;
}

void solve_reduced(int waves, const double* A_r, double* right) {
  RowMajor A = Eigen::Map<const RowMajor>(A_r, waves, waves);
  A.diagonal().array() += 1e-12 * A.trace() / waves;
  Eigen::Map<RowMajor> y(right, waves, 3);
  y = A.ldlt().solve(y).eval();
}

PaperSolver::PaperSolver(IncrementalPotential& potential, const PaperLoops& loops)
    : potential_(potential), loops_(loops), scratch_(potential.rows()) {
  check_paper_scene(potential, loops);
  const Scene& scene = potential.scene();
  const size_t rows = size_t(potential.rows().row_count()), nodes = size_t(scene.grid.node_count());
  lagged_.resize(rows * kFields * kLanes);
  slope_.resize(rows * kLanes);
  corner_.resize(8 * size_t(scene.grid.voxel_count()));
  diagonal_.resize(nodes);
  force_.resize(3 * nodes);
  waves_ = loops.modes / 3;
  modes_ = paper_modes(scene, waves_);
  column_.resize(waves_ > 0 ? 3 * nodes : 0);
}

void PaperSolver::freeze(const double* u) {
  const BrickRows& rows = potential_.rows();
  for_each_row(
      rows, scratch_, sums_,
      [&](int64_t n, int64_t reference, double value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [&](int64_t r, Pack<double> corner[3][8], Pack<double> f[3][8], NoSums&) {
        // F of a row of voxels
        VoxelData<Pack<double>> data;
        potential_.read_voxel_data<double>(r, data);
        for (int i = 0; i < 3; ++i) {
          hex8::to_patterns(corner[i]);
          for (int c = 0; c < 8; ++c) f[i][c] = Pack<double>{};
        }
        const Mat3<Pack<double>> F = rows.rows[size_t(r)].border >= 0
                                         ? deformation_gradient<true>(data, corner)
                                         : deformation_gradient<false>(data, corner);
        // the target of the lagged quadratic, N and R
        const auto respond = [&](const Pack<double> sigma[3], Pack<double>& outside) {
          return material_response<false>(data.learned, data.law, sigma, outside);
        };
        const LaggedTarget<Pack<double>> target = lagged_target(respond, data.law, F);
        double* to = lagged_.data() + size_t(r) * kFields * kLanes;
        for (int k = 0; k < 6; ++k) store(to + k * kLanes, target.NN[k]);
        for (int k = 0; k < 9; ++k) store(to + (6 + k) * kLanes, target.rest[k]);
        store(slope_.data() + size_t(r) * kLanes, target.largest_slope);
      },
      [](int64_t, const double*) {});
  set_diagonal();
}

void PaperSolver::corner_diagonal(int64_t row, int lane, double share[8]) const {
  VoxelData<Pack<double>> data;
  potential_.read_voxel_data<double>(row, data);
  VoxelData<double> voxel{data.law,       data.learned, data.h, data.hourglass,
                          data.phi[lane], {},           {},     {}};
  for (int k = 0; k < 4; ++k) voxel.c[k] = data.c[k][lane];
  for (int p = 1; p < 7 && potential_.rows().rows[size_t(row)].border >= 0; ++p)
    voxel.M[p] = data.M[p][lane];
  const bool border = std::any_of(voxel.M, voxel.M + 7, [](double m) { return m != 0; });
  const double* lagged = lagged_.data() + size_t(row) * kFields * kLanes + lane;
  double NN[6];
  for (int k = 0; k < 6; ++k) NN[k] = lagged[k * kLanes];
  diagonal_shares(voxel, border, NN, slope_[size_t(row) * kLanes + size_t(lane)], share);
}

void PaperSolver::set_diagonal() {
  const Scene& scene = potential_.scene();
  const BrickRows& rows = potential_.rows();
  for_each(scene.grid.voxel_count(), [&](int64_t v) {
    const int32_t slot = rows.slot[size_t(v)];
    corner_diagonal(slot / kLanes, slot % kLanes, corner_.data() + 8 * v);
  });
  for_each(scene.grid.node_count(), [&](int64_t n) {
    double sum = potential_.inertia(n);
    for (int c = 0; c < 8; ++c) {
      const int32_t v = scene.grid.voxels(n, c);
      if (v >= 0) sum += corner_[size_t(8 * int64_t(v) + c)];
    }
    diagonal_[size_t(n)] = sum;
  });
}

/// f = A p, or with kAffine the gradient A u - b of the lagged quadratic.
template <bool kAffine>
void PaperSolver::apply(const double* p, double* f) {
  const BrickRows& rows = potential_.rows();
  const Scene& scene = potential_.scene();
  const auto row = [&](int64_t r, const Pack<double> corner[3][8], Pack<double> force[3][8],
                       NoSums&) {
    VoxelData<Pack<double>> data;
    potential_.read_voxel_data<double>(r, data);
    const double* lagged = lagged_.data() + size_t(r) * kFields * kLanes;
    const auto stress = [&](const Pack<double> dF[9], Pack<double> dP[9]) {
      row_stress<kAffine>(data, lagged, dF, dP);
    };
    if (rows.rows[size_t(r)].border >= 0)
      hessian_product<true>(data, stress, corner, force);
    else
      hessian_product<false>(data, stress, corner, force);
  };
  // voxels give elastic forces, nodes add their inertia
  const Zeroed<double>& predictor = potential_.predictor();
  for_each_row(
      rows, scratch_, sums_,
      [&](int64_t n, int64_t reference, double value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = p[3 * n + i] - p[3 * reference + i];
      },
      row,
      [&](int64_t n, const double sum[3]) {
        for (int i = 0; i < 3; ++i) {
          const size_t k = size_t(3 * n + i);
          const double away = kAffine ? p[k] - predictor[k] : p[k];
          f[k] = scene.pinned(n) ? 0 : sum[i] + potential_.inertia(n) * away;
        }
      });
}

void PaperSolver::product(const double* p, double* f) {
  apply<false>(p, f);
}

/// Galerkin step over the modes: A_r = B^T A B is one matrix for x, y and z.
void PaperSolver::project(double* u) {
  const int64_t nodes = int64_t(diagonal_.size());
  const auto dot = [&](const double* mode, const double* field, int i) {
    return ordered_sum(nodes, [&](int64_t begin, int64_t end) {
      double sum = 0;
      for (int64_t n = begin; n < end; ++n) sum += mode[n] * field[3 * n + i];
      return sum;
    });
  };
  RowMajor A(waves_, waves_), y(waves_, 3);
  apply<true>(u, force_.data());
  for (int k = 0; k < waves_; ++k)
    for (int i = 0; i < 3; ++i) y(k, i) = dot(modes_.data() + k * nodes, force_.data(), i);
  // three modes at a time stand in for the three components
  for (int first = 0; first < waves_; first += 3) {
    const int count = std::min(3, waves_ - first);
    std::fill(column_.begin(), column_.end(), 0.0);
    for (int64_t n = 0; n < nodes; ++n)
      for (int i = 0; i < count; ++i)
        column_[size_t(3 * n + i)] = modes_[size_t((first + i) * nodes + n)];
    product(column_.data(), force_.data());
    for (int k = 0; k < waves_; ++k)
      for (int i = 0; i < count; ++i)
        A(k, first + i) = dot(modes_.data() + k * nodes, force_.data(), i);
  }
  solve_reduced(waves_, A.data(), y.data());
  for_each(nodes, [&](int64_t n) {
    for (int k = 0; k < waves_; ++k)
      for (int i = 0; i < 3; ++i) u[3 * n + i] -= modes_[size_t(k * nodes + n)] * y(k, i);
  });
}

/// x += D^-1 (b - A x)
void PaperSolver::sweep(double* u) {
  apply<true>(u, force_.data());
  for_each(int64_t(diagonal_.size()), [&](int64_t n) {
    if (potential_.scene().pinned(n)) return;
    for (int i = 0; i < 3; ++i) u[3 * n + i] -= force_[size_t(3 * n + i)] / diagonal_[size_t(n)];
  });
}

/// PaperWork of the host.
struct PaperSolver::Work {
  void begin() {
    const Zeroed<double>& predictor = of.potential_.predictor();
    std::copy(predictor.begin(), predictor.end(), u);
  }
  void freeze() { of.freeze(u); }
  void project() { of.project(u); }
  void sweep() { of.sweep(u); }
  void wait() {}

  PaperSolver& of;
  double* u;
};

IterationResult PaperSolver::solve(double* u, const Interrupted& interrupted) {
  Work work{*this, u};
  return paper_loop(work, loops_, interrupted);
}

}  // namespace elastogen
