// SPDX-License-Identifier: Apache-2.0
#include "network/potential/incremental_potential.hpp"

#include "core/polar.hpp"
#include "core/reduce.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

template <class T>
Pack<T> convert(const double* from) {
  return __builtin_convertvector(load(from), Pack<T>);
}

/// Sum over the lanes; weights of lanes without a voxel are 0.
double lane_sum(const Pack<double>& values) {
  double sum = 0;
  for (int l = 0; l < kLanes; ++l) sum += values[l];
  return sum;
}

double lane_min(const Pack<double>& values) {
  double least = values[0];
  for (int l = 1; l < kLanes; ++l) least = std::min(least, values[l]);
  return least;
}

template <class P>
Pack<double> in_double(const P& values) {
  return __builtin_convertvector(values, Pack<double>);
}

/// The values of the lanes in a mask, a large number in the others.
template <class P>
Pack<double> in_mask(const P& values, uint32_t mask) {
  Pack<double> result = in_double(values);
  for (int l = 0; l < kLanes; ++l)
    if (!(mask >> l & 1)) result[l] = 1e300;
  return result;
}

/// Energies of the voxels and the smallest J, over the sums of the bricks in order.
template <class Sums>
PotentialValue total(const std::vector<Sums>& sums) {
  PotentialValue value;
  for (const Sums& s : sums) {
    value.elastic += lane_sum(s.elastic);
    value.hourglass += lane_sum(s.hourglass);
    value.viscous += lane_sum(s.viscous);
    value.min_j = std::min(value.min_j, lane_min(s.min_j));
    value.min_corner_j = std::min(value.min_corner_j, lane_min(s.min_corner_j));
    value.outside += int64_t(lane_sum(s.outside));
  }
  return value;
}

}  // namespace

IncrementalPotential::IncrementalPotential(PotentialTerms&& terms)
    : PotentialTerms(std::move(terms)),
      rows_(std::make_shared<const BrickRows>(make_brick_rows(scene_))),
      scratch_float_(*rows_),
      scratch_double_(*rows_),
      held_(scene_),
      loads_(scene_) {
  fill_weights();
  const size_t nodes = size_t(scene_.grid.node_count());
  rotation_.resize(size_t(rows_->row_count()) * 9 * kLanes);
  gradients_.resize(rotation_.size());
  nodal_rotation_.resize(9 * nodes);
  for_each(int64_t(nodes), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) nodal_rotation_[size_t(9 * n + 4 * d)] = 1;
  });
  predictor_.resize(3 * nodes);
  now_.resize(3 * nodes);
  inertia_.resize(nodes);
  if (scheme_.dt > 0) set_scheme(scheme_);
}

void IncrementalPotential::fill_weights() {
  const VoxelGrid& grid = scene_.grid;
  weights_.resize(size_t(rows_->row_count()) * 5 * kLanes);
  for_each(grid.voxel_count(), [&](int64_t v) {
    const size_t slot = size_t(rows_->slot[size_t(v)]), lane = slot % kLanes;
    double* w = weights_.data() + (slot - lane) * 5 + lane;
    w[0] = grid.fill(v);
    for (int k = 0; k < 4; ++k) w[(k + 1) * kLanes] = scene_.variance(v, k);
  });
}

template <class T>
void IncrementalPotential::read_voxel_data(int64_t row, VoxelData<Pack<T>>& data) const {
  const VoxelRow& r = rows_->rows[size_t(row)];
  const Material& m = scene_.materials[size_t(r.material)];
  data.law = {m.law, T(m.mu()), T(m.lambda())};
  data.learned = learned_[size_t(r.material)].get();
  data.h = T(scene_.grid.h);
  data.hourglass = scene_.hourglass;
  const double* w = weights_.data() + size_t(row) * 5 * kLanes;
  data.phi = convert<T>(w);
  for (int k = 0; k < 4; ++k) data.c[k] = convert<T>(w + (k + 1) * kLanes);
  if (r.border >= 0)
    for (int p = 0; p < 7; ++p)
      data.M[p] = convert<T>(rows_->border.data() + (size_t(r.border) * 7 + size_t(p)) * kLanes);
  if (data.hourglass == Hourglass::kFull)
    for (int k = 0; k < 9; ++k)
      data.R[k] = convert<T>(rotation_.data() + (size_t(row) * 9 + size_t(k)) * kLanes);
}

template void IncrementalPotential::read_voxel_data<float>(int64_t, VoxelData<Pack<float>>&) const;
template void IncrementalPotential::read_voxel_data<double>(int64_t,
                                                            VoxelData<Pack<double>>&) const;

PotentialValue IncrementalPotential::voxel_forces(const double* u, double* forces) {
  return evaluate_all<double, false>(u, forces);
}

/// R_v of every row.
void IncrementalPotential::rotations(const double* u, Zeroed<double>& result) {
  deformation_gradients(u, result);
  for_each(rows_->row_count(), [&](int64_t r) {
    Mat3<Pack<double>> F;
    for (int k = 0; k < 9; ++k) F.m[k] = load(result.data() + (r * 9 + k) * kLanes);
    const Mat3<Pack<double>> R = unique_rotation(F);
    for (int k = 0; k < 9; ++k) store(result.data() + (r * 9 + k) * kLanes, R.m[k]);
  });
}

/// F_v of every row.
void IncrementalPotential::deformation_gradients(const double* u, Zeroed<double>& result) {
  for_each_row(
      *rows_, scratch_double_, no_sums_,
      [&](int64_t n, int64_t reference, double value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [&](int64_t r, Pack<double> corner[3][8], Pack<double> f[3][8], NoSums&) {
        VoxelData<Pack<double>> data;
        read_voxel_data<double>(r, data);
        for (int i = 0; i < 3; ++i) {
          hex8::to_patterns(corner[i]);
          for (int c = 0; c < 8; ++c) f[i][c] = Pack<double>{};
        }
        const Mat3<Pack<double>> F = rows_->rows[size_t(r)].border >= 0
                                         ? deformation_gradient<true>(data, corner)
                                         : deformation_gradient<false>(data, corner);
        for (int k = 0; k < 9; ++k) store(result.data() + (r * 9 + k) * kLanes, F.m[k]);
      },
      [](int64_t, const double*) {});
}

void IncrementalPotential::set_nodal_rotations(const double* u) {
  const VoxelGrid& grid = scene_.grid;
  deformation_gradients(u, gradients_);
  for_each(grid.node_count(), [&](int64_t n) {
    Mat3<double> sum{};
    for (int c = 0; c < 8; ++c) {
      const int32_t v = grid.voxels(n, c);
      if (v < 0) continue;
      const size_t slot = size_t(rows_->slot[size_t(v)]), lane = slot % kLanes;
      const double* F = gradients_.data() + (slot - lane) * 9 + lane;
      for (int k = 0; k < 9; ++k) sum.m[k] += grid.fill(v) * F[k * kLanes];
    }
    const Mat3<double> R = polar_rotation_about(held_.fixed_axes(n), sum);
    for (int k = 0; k < 9; ++k) nodal_rotation_[size_t(9 * n + k)] = float(R.m[k]);
  });
}

/// The lanes of a row that hold a full voxel.
uint32_t IncrementalPotential::full_lanes(int64_t row) const {
  const VoxelRow& r = rows_->rows[size_t(row)];
  uint32_t mask = r.mask;
  if (r.border < 0) return mask;
  for (int lane = 0; lane < kLanes; ++lane)
    for (size_t p = 1; p < 7; ++p)
      if (rows_->border[(size_t(r.border) * 7 + p) * kLanes + size_t(lane)] != 0)
        mask &= ~(1u << lane);
  return mask;
}

/// Adds the energies of a row; lanes without a voxel have no fill.
template <class T>
void IncrementalPotential::add_energy(const VoxelEnergy<Pack<T>>& e, const Pack<T>& fill,
                                      Sums& sums) {
  sums.elastic += in_double(e.elastic);
  sums.hourglass += in_double(e.hourglass);
  sums.viscous += in_double(e.viscous);
  const auto there = in_double(fill) > 0;
  sums.outside += there ? in_double(e.outside) : Pack<double>{};
  sums.min_j = smaller(sums.min_j, there ? in_double(e.J) : constant<Pack<double>>(1e300));
}

template <class T, bool kQuality>
PotentialValue IncrementalPotential::evaluate_all(const double* u, T* gradient) {
  BrickScratch<T>* scratch;
  if constexpr (std::is_same_v<T, float>)
    scratch = &scratch_float_;
  else
    scratch = &scratch_double_;
  const auto read = [&](int64_t n, int64_t reference, T value[3]) {
    for (int i = 0; i < 3; ++i) value[i] = T(u[3 * n + i] - u[3 * reference + i]);
  };
  const auto row = [&](int64_t r, const Pack<T> corner[3][8], Pack<T> f[3][8], Sums& sums) {
    VoxelData<Pack<T>> data;
    read_voxel_data<T>(r, data);
    VoxelDamping<Pack<T>> of_row;
    const VoxelDamping<Pack<T>>* damping = read_damping<T>(r, of_row) ? &of_row : nullptr;
    const VoxelEnergy<Pack<T>> e = rows_->rows[size_t(r)].border >= 0
                                       ? voxel_energy<true>(data, corner, f, damping)
                                       : voxel_energy<false>(data, corner, f, damping);
    add_energy<T>(e, data.phi, sums);
    if constexpr (kQuality)  // corners of border voxels may lie outside the body
      sums.min_corner_j =
          smaller(sums.min_corner_j, in_mask(corner_jacobian(corner, data.h), full_lanes(r)));
  };
  const auto finish = [&](int64_t n, const T force[3]) {
    if (!gradient) return;
    // of pinned nodes inner forces for the reactions alone
    const double inertia = is_fixed(n) ? 0 : inertia_[size_t(n)];
    for (int i = 0; i < 3; ++i) {
      const double away = u[3 * n + i] - predictor_[size_t(3 * n + i)];
      gradient[3 * n + i] = is_fixed(n) && !kQuality ? T(0) : T(inertia * away + double(force[i]));
    }
  };
  // voxels and the force at nodes, then inertia
  for_each_row(*rows_, *scratch, sums_, read, row, finish);

  PotentialValue value = total(sums_);
  if (has_damping()) value.beta = beta(rate_of(scheme_));
  value.inertia = inertial_energy(u);
  return value;
}

/// a0/(2 dt^2) sum m |u - uhat|^2 over the nodes that move.
double IncrementalPotential::inertial_energy(const double* u) const {
  return ordered_sum(scene_.grid.node_count(), [&](int64_t begin, int64_t end) {
    double sum = 0;
    for (int64_t n = begin; n < end; ++n) {
      if (is_fixed(n)) continue;
      for (int i = 0; i < 3; ++i) {
        const double away = u[3 * n + i] - predictor_[size_t(3 * n + i)];
        sum += inertia_[size_t(n)] / 2 * away * away;
      }
    }
    return sum;
  });
}

template <>
PotentialValue IncrementalPotential::evaluate<double>(const double* u, double* gradient) {
  PotentialValue value = evaluate_all<double, false>(u, gradient);
  if (contact_.exists()) value.contact = contact_.evaluate(u, gradient);
  if (gradient) held_.fold(gradient);
  return value;
}

template <>
PotentialValue IncrementalPotential::evaluate<float>(const double* u, float* gradient) {
  PotentialValue value = evaluate_all<float, false>(u, gradient);
  if (contact_.exists()) value.contact = contact_.evaluate(u, gradient);
  if (gradient) held_.fold(gradient);
  return value;
}

PotentialValue IncrementalPotential::residual(const double* u, double* gradient) {
  PotentialValue value = evaluate_all<double, true>(u, gradient);
  if (contact_.exists()) {
    value.contact = contact_.evaluate(u, gradient, true);
    value.deepest_overlap = contact_.deepest_overlap(u);
  }
  reactions_ = held_.reactions(gradient, u, loads_.data());
  for_each(scene_.grid.node_count(), [&](int64_t n) {
    if (is_fixed(n)) std::fill_n(gradient + 3 * n, 3, 0.0);
  });
  held_.fold(gradient);
  return value;
}

void IncrementalPotential::linearise(const double* u, TangentKind kind) {
  tangent_.resize(size_t(rows_->row_count()) * 45 * kLanes);
  for_each_row(
      *rows_, scratch_float_, no_sums_,
      [&](int64_t n, int64_t reference, float value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [&](int64_t r, const Pack<float> corner[3][8], Pack<float> f[3][8], NoSums&) {
        VoxelData<Pack<float>> data;
        read_voxel_data<float>(r, data);
        VoxelDamping<Pack<float>> of_row;
        const VoxelDamping<Pack<float>>* damping =
            read_damping<float>(r, of_row) ? &of_row : nullptr;
        const Tangent<Pack<float>> t = rows_->rows[size_t(r)].border >= 0
                                           ? voxel_tangent<true>(data, corner, kind, damping)
                                           : voxel_tangent<false>(data, corner, kind, damping);
        for (int k = 0; k < 45; ++k) store(tangent_.data() + (r * 45 + k) * kLanes, t.m[k]);
        for (int i = 0; i < 3; ++i)
          for (int c = 0; c < 8; ++c) f[i][c] = Pack<float>{};
      },
      [](int64_t, const float*) {});
  if (contact_.exists()) contact_.linearise(u);
}

void IncrementalPotential::hessian_product(const float* p, float* product) {
  for_each_row(
      *rows_, scratch_float_, no_sums_,
      [&](int64_t n, int64_t, float value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = p[3 * n + i];
      },
      [&](int64_t r, const Pack<float> corner[3][8], Pack<float> f[3][8], NoSums&) {
        VoxelData<Pack<float>> data;
        read_voxel_data<float>(r, data);
        Tangent<Pack<float>> t;
        for (int k = 0; k < 45; ++k) t.m[k] = load(tangent_.data() + (r * 45 + k) * kLanes);
        const float beta = float(beta_of(rows_->rows[size_t(r)].material));
        if (rows_->rows[size_t(r)].border >= 0)
          voxel_hessian<true>(data, t, corner, f, beta);
        else
          voxel_hessian<false>(data, t, corner, f, beta);
      },
      [&](int64_t n, const float force[3]) {
        for (int i = 0; i < 3; ++i)
          product[3 * n + i] =
              is_fixed(n) ? 0.f : force[i] + float(inertia_[size_t(n)]) * p[3 * n + i];
      });
  if (contact_.exists()) contact_.add_hessian_product(p, product);
  // the part of dependent nodes, and fixed components
  held_.fold(product);
}

void IncrementalPotential::rest_hessian_product(const double* p, double* product) {
  for_each_row(
      *rows_, scratch_double_, no_sums_,
      [&](int64_t n, int64_t, double value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = p[3 * n + i];
      },
      [&](int64_t r, const Pack<double> corner[3][8], Pack<double> f[3][8], NoSums&) {
        VoxelData<Pack<double>> data;
        read_voxel_data<double>(r, data);
        for (int k = 0; k < 9; ++k) data.R[k] = constant<Pack<double>>(k % 4 == 0);
        if (rows_->rows[size_t(r)].border >= 0)
          voxel_rest_hessian<true>(data, corner, f);
        else
          voxel_rest_hessian<false>(data, corner, f);
      },
      [&](int64_t n, const double force[3]) {
        for (int i = 0; i < 3; ++i)
          product[3 * n + i] = is_fixed(n) ? 0 : force[i] + inertia_[size_t(n)] * p[3 * n + i];
      });
  held_.fold(product);
}

}  // namespace elastogen
