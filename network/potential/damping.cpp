// SPDX-License-Identifier: Apache-2.0
// Damping in the incremental potential: the strain that a stage's rate is measured from.
#include "network/potential/incremental_potential.hpp"

namespace elastogen {

/// Strains of every row at displacement u.
void IncrementalPotential::find_strains(const double* u, Zeroed<double>& strains) {
  constexpr int64_t kCount = VoxelStrain<double>::kCount;
  strains.resize(size_t(rows_->row_count() * kCount * kLanes));
  for_each_row(
      *rows_, scratch_double_, no_sums_,
      [&](int64_t n, int64_t reference, double value[3]) {
        for (int i = 0; i < 3; ++i) value[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [&](int64_t r, const Pack<double> corner[3][8], Pack<double> f[3][8], NoSums&) {
        for (int i = 0; i < 3; ++i)
          for (int c = 0; c < 8; ++c) f[i][c] = Pack<double>{};
        VoxelData<Pack<double>> data;
        read_voxel_data<double>(r, data);
        const VoxelStrain<Pack<double>> strain = rows_->rows[size_t(r)].border >= 0
                                                     ? voxel_strain<true>(data, corner)
                                                     : voxel_strain<false>(data, corner);
        double* to = strains.data() + r * kCount * kLanes;
        for (int k = 0; k < 6; ++k) store(to + k * kLanes, strain.E[k]);
        for (int k = 0; k < 12; ++k) store(to + (6 + k) * kLanes, strain.A[k / 4][k % 4]);
      },
      [](int64_t, const double*) {});
}

/// E_b and A_b of a step or stage, whose rate is that of time_stage.hpp:
///
///     E' = (E - E_0 - w (E_other - E_0)) / k.
///
/// @param weight  w.
/// @param other   displacement at the other point; null: that of the step before.
void IncrementalPotential::begin_damping(const State& state, double weight, const double* other) {
  if (!has_damping()) return;
  find_strains(now_.data(), strain_before_);
  if (weight == 0) return;
  Zeroed<double> before;
  if (!other) {
    const Array<double>& X = scene_.grid.rest;
    before.resize(size_t(X.size()));
    for_each(X.size(),
             [&](int64_t k) { before[size_t(k)] = state.x_before.data()[k] - X.data()[k]; });
    other = before.data();
  }
  find_strains(other, strains_);
  for_each(int64_t(strains_.size()), [&](int64_t k) {
    double& strain = strain_before_[size_t(k)];
    strain += weight * (strains_[size_t(k)] - strain);
  });
}

/// The damping of a row; false where its material has none.
template <class T>
bool IncrementalPotential::read_damping(int64_t row, VoxelDamping<Pack<T>>& damping) const {
  damping.beta = T(beta_of(rows_->rows[size_t(row)].material));
  if (!(damping.beta > 0) || strain_before_.empty()) return false;
  constexpr int64_t kCount = VoxelStrain<T>::kCount;
  const double* from = strain_before_.data() + row * kCount * kLanes;
  const auto at = [&](int k) { return __builtin_convertvector(load(from + k * kLanes), Pack<T>); };
  for (int k = 0; k < 6; ++k) damping.before.E[k] = at(k);
  for (int k = 0; k < 12; ++k) damping.before.A[k / 4][k % 4] = at(6 + k);
  return true;
}

template bool IncrementalPotential::read_damping<float>(int64_t, VoxelDamping<Pack<float>>&) const;
template bool IncrementalPotential::read_damping<double>(int64_t,
                                                         VoxelDamping<Pack<double>>&) const;

}  // namespace elastogen
