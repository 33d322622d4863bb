// SPDX-License-Identifier: Apache-2.0
#include "network/paper_solver.hpp"

#include "core/error.hpp"
#include "network/smooth_modes.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr size_t kFields = 15;  // NN and RN of a voxel
constexpr int kMostModes = 192;

/// Young's modulus of a law, the paper's weight omega.
double weight_of(const Material& m) {
  return m.young;
}

/// The functional of each corner on the re-centred patterns xy, yz, zx, xyz.
void corner_patterns(const double M[7], double q[8][4]) {
  for (int c = 0; c < 8; ++c) {
    double g[8] = {};
    g[c] = 1;
    hex8::to_patterns(g);
    hex8::centred_patterns<true>(g, M, q[c]);
  }
}

/// Gradient of each corner's shape function, mean over the fill [1/m].
void corner_gradients(const double M[7], double h, double D[8][3]) {
  for (int c = 0; c < 8; ++c) {
    double g[8] = {};
    g[c] = 1;
    hex8::to_patterns(g);
    hex8::gradient<true>(g, M, D[c]);
    for (double& d : D[c]) d /= 4 * h;
  }
}

/// Stress of the lagged quadratic, omega (dF - R) N N^T, R with kAffine only; dF is the gradient of
/// the motion times 4 h, and so is the result. @param lagged  NN and RN of a row.
template <bool kAffine>
void lagged_stress(double h, double omega, const double* lagged, const Pack<double> dF[9],
                   Pack<double> dP[9]) {
  Pack<double> NN[6];
  for (int k = 0; k < 6; ++k) NN[k] = load(lagged + k * kLanes);
  for (int i = 0; i < 3; ++i) {
    Pack<double> d[3] = {dF[3 * i], dF[3 * i + 1], dF[3 * i + 2]};
    if constexpr (kAffine) d[i] += 4 * h;
    times_slope(NN, d, dP + 3 * i);
    for (int j = 0; j < 3; ++j) {
      if constexpr (kAffine) dP[3 * i + j] -= 4 * h * load(lagged + (6 + 3 * i + j) * kLanes);
      dP[3 * i + j] = omega * dP[3 * i + j];
    }
  }
}

}  // namespace

PaperSolver::PaperSolver(IncrementalPotential& potential, const PaperLoops& loops)
    : potential_(potential), loops_(loops), scratch_(potential.rows()) {
  const Scene& scene = potential.scene();
  ELASTOGEN_CHECK(loops.outer >= 1 && loops.inner >= 1,
                  "the paper solver needs one loop at least, ", "got ", loops.outer, " outer and ",
                  loops.inner, " inner");
  ELASTOGEN_CHECK(loops.modes >= 0 && loops.modes <= kMostModes && loops.modes % 3 == 0,
                  "modes must be a multiple of 3 from 0 to ", kMostModes, ", got ", loops.modes);
  ELASTOGEN_CHECK(scene.hourglass != Hourglass::kFull,
                  "the paper solver relaxes x, y and z apart: it needs hourglass variance or off");
  ELASTOGEN_CHECK(!potential.contact().exists(),
                  "the paper solver has no contact: no floor and no ", "colliders with it");
  const size_t rows = size_t(potential.rows().row_count()), nodes = size_t(scene.grid.node_count());
  lagged_.resize(rows * kFields * kLanes);
  slope_.resize(rows * kLanes);
  corner_.resize(8 * size_t(scene.grid.voxel_count()));
  diagonal_.resize(nodes);
  force_.resize(3 * nodes);
  waves_ = loops.modes / 3;
  fill_modes();
}

/// Cosines over the box of the whole grid, times d/(d + L/8), d the distance to the nearest pin.
void PaperSolver::fill_modes() {
  if (waves_ == 0) return;
  const Scene& scene = potential_.scene();
  const Array<double>& X = scene.grid.rest;
  const int64_t nodes = X.rows();
  Box box;
  for (int64_t n = 0; n < nodes; ++n) box.add({X(n, 0), X(n, 1), X(n, 2)});
  const double size = std::max({box.extent(0), box.extent(1), box.extent(2)});
  std::vector<int32_t> all(static_cast<size_t>(nodes));
  std::iota(all.begin(), all.end(), 0);
  const PlaneCosines cosines(scene.grid, all, lowest_waves(box, waves_), box);
  const std::vector<double> distance = pin_distance(scene, all);
  modes_.resize(size_t(waves_) * size_t(nodes));
  for_each(nodes, [&](int64_t n) {
    const double d = distance[size_t(n)];
    for (int k = 0; k < waves_; ++k)
      modes_[size_t(k * nodes + n)] = d / (d + size / 8) * cosines(k, scene.grid.node_coord.row(n));
  });
  column_.resize(3 * size_t(nodes));
}

void PaperSolver::freeze(const double* u) {
  const BrickRows& rows = potential_.rows();
  for_each_row(
      rows, scratch_, sums_,
      [&](int64_t n, int64_t reference, double value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [&](int64_t r, Pack<double> corner[3][8], Pack<double> f[3][8], NoSums&) {
        VoxelData<Pack<double>> data;
        potential_.read_voxel_data<double>(r, data);
        for (int i = 0; i < 3; ++i) {
          hex8::to_patterns(corner[i]);
          for (int c = 0; c < 8; ++c) f[i][c] = Pack<double>{};
        }
        const Mat3<Pack<double>> F = rows.rows[size_t(r)].border >= 0
                                         ? deformation_gradient<true>(data, corner)
                                         : deformation_gradient<false>(data, corner);
        const LaggedTarget<Pack<double>> target = lagged_target(data.learned, data.law, F);
        double* to = lagged_.data() + size_t(r) * kFields * kLanes;
        for (int k = 0; k < 6; ++k) store(to + k * kLanes, target.NN[k]);
        for (int k = 0; k < 9; ++k) store(to + (6 + k) * kLanes, target.RN[k]);
        store(slope_.data() + size_t(r) * kLanes, target.largest_slope);
      },
      [](int64_t, const double*) {});
  set_diagonal();
}

/// Shares of a voxel's corners in the diagonal.
void PaperSolver::corner_diagonal(int64_t row, int lane, double result[8]) const {
  const VoxelRow& r = potential_.rows().rows[size_t(row)];
  VoxelData<Pack<double>> data;
  potential_.read_voxel_data<double>(row, data);
  const double h = data.h, phi = data.phi[lane];
  const double omega = weight_of(potential_.scene().materials[size_t(r.material)]);
  const double slope = slope_[size_t(row) * kLanes + size_t(lane)];
  double M[7] = {}, c_h[4], D[8][3], q[8][4];
  for (int p = 1; p < 7 && r.border >= 0; ++p) M[p] = data.M[p][lane];
  for (int k = 0; k < 4; ++k) c_h[k] = data.c[k][lane];
  const bool variance = data.hourglass != Hourglass::kOff;
  const bool full = std::all_of(M, M + 7, [](double m) { return m == 0; });
  if (full && variance) {
    const double kappa = *std::max_element(c_h, c_h + 4) / omega;
    for (int c = 0; c < 8; ++c)
      result[c] = phi * omega * h * (3.0 / 16 * slope + 7.0 / 48 * std::max(kappa, slope));
    return;
  }
  corner_gradients(M, h, D);
  corner_patterns(M, q);
  const double* lagged = lagged_.data() + size_t(row) * kFields * kLanes + lane;
  double NN[6];
  for (int k = 0; k < 6; ++k) NN[k] = lagged[k * kLanes];
  for (int c = 0; c < 8; ++c) {
    double sum = 0, along[3];
    times_slope(NN, D[c], along);
    for (int e = 0; e < 8; ++e) {
      if (!variance && e != c) continue;
      const double gradient =
          h * h * omega * (along[0] * D[e][0] + along[1] * D[e][1] + along[2] * D[e][2]);
      double patterns = 0;
      for (int k = 0; k < 4 && variance; ++k)
        patterns += c_h[k] * q[c][k] * q[e][k] / (k < 3 ? 24 : 48);
      sum += std::abs(gradient + patterns);
    }
    result[c] = phi * h * sum;
  }
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
    const double omega = weight_of(scene.materials[size_t(rows.rows[size_t(r)].material)]);
    const double* lagged = lagged_.data() + size_t(r) * kFields * kLanes;
    const auto stress = [&](const Pack<double> dF[9], Pack<double> dP[9]) {
      lagged_stress<kAffine>(data.h, omega, lagged, dF, dP);
    };
    if (rows.rows[size_t(r)].border >= 0)
      hessian_product<true>(data, stress, corner, force);
    else
      hessian_product<false>(data, stress, corner, force);
  };
  const std::vector<double>& predictor = potential_.predictor();
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
  Eigen::MatrixXd A(waves_, waves_), right(waves_, 3);
  apply<true>(u, force_.data());
  for (int k = 0; k < waves_; ++k)
    for (int i = 0; i < 3; ++i) right(k, i) = dot(modes_.data() + k * nodes, force_.data(), i);
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
  A.diagonal().array() += 1e-12 * A.trace() / waves_;
  const Eigen::MatrixXd y = A.ldlt().solve(right);
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

IterationResult PaperSolver::solve(double* u, const std::function<bool()>& interrupted) {
  std::copy(potential_.predictor().begin(), potential_.predictor().end(), u);
  IterationResult result;
  for (int k = 0; k < loops_.outer && !interrupted(); ++k) {
    freeze(u);
    if (waves_ > 0) project(u);
    for (int s = 0; s < loops_.inner && !interrupted(); ++s) sweep(u);
    ++result.outer;
    result.inner += loops_.inner;
  }
  return result;
}

}  // namespace elastogen
