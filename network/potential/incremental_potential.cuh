// SPDX-License-Identifier: Apache-2.0
// The tables of DevicePotential, and the data of a voxel that its passes read there. The passes are
// in incremental_potential.cu (energy and gradient), tangent.cu (Hessian), learned_law.cu (nets).

#pragma once

#include "core/cuda/held_nodes.cuh"
#include "core/cuda/signal.cuh"
#include "network/law/learned_law.cuh"
#include "network/potential/incremental_potential_device.hpp"
#include "network/precondition/stencil_bricks.hpp"

#include <optional>

namespace elastogen::cuda {

/// Frozen rotations of voxels, 0 where there is no unique one: in double as quaternions, 32 B of
/// 72; in float, which most evaluations use, as matrices, which load faster than they are made.
template <class T>
struct FrozenRotations;
template <>
struct FrozenRotations<double> {
  const Quaternion<double>* of;  ///< [row][lane]
  __device__ Mat3<double> at(int64_t r, int lane) const {
    return rotation_or_zero(of[r * kLanes + lane]);
  }
};
template <>
struct FrozenRotations<float> {
  const float* of;  ///< [row][field][lane]
  __device__ Mat3<float> at(int64_t r, int lane) const {
    Mat3<float> R;
    for (int k = 0; k < 9; ++k) R.m[k] = of[(r * 9 + k) * kLanes + lane];
    return R;
  }
};

/// Tables of voxels, each [row][field][lane].
template <class T>
struct VoxelTables {
  const T *weights, *border;
  FrozenRotations<T> rotation;
  const DeviceMaterial* materials;
  T h;
  Hourglass hourglass;

  __device__ VoxelData<T> data(const VoxelRow& row, int64_t r, int lane) const {
    VoxelData<T> v;
    const LawParameters<double>& law = materials[row.material].law;
    v.law = {law.law, T(law.mu), T(law.lambda)};
    v.h = h;
    v.hourglass = hourglass;
    v.phi = weights[(r * 5) * kLanes + lane];
    for (int k = 0; k < 4; ++k) v.c[k] = weights[(r * 5 + k + 1) * kLanes + lane];
    for (int p = 0; p < 7; ++p)
      v.M[p] = row.border < 0 ? T(0) : border[(int64_t(row.border) * 7 + p) * kLanes + lane];
    if (hourglass == Hourglass::kFull) {
      const Mat3<T> R = rotation.at(r, lane);
      for (int k = 0; k < 9; ++k) v.R[k] = R.m[k];
    }
    return v;
  }
};

/// Whether a voxel is filled to its corners.
template <class T>
__device__ bool is_full(const VoxelData<T>& v) {
  for (int p = 1; p < 7; ++p)
    if (v.M[p] != 0) return false;
  return true;
}

/// Sums over the voxels of a brick, which add up to the value of the potential.
struct VoxelSums {
  double elastic = 0, hourglass = 0, outside = 0, min_j = 1e300, min_corner_j = 1e300;
  __device__ void add(const VoxelSums& o) {
    elastic += o.elastic, hourglass += o.hourglass, outside += o.outside;
    min_j = o.min_j < min_j ? o.min_j : min_j;
    min_corner_j = o.min_corner_j < min_corner_j ? o.min_corner_j : min_corner_j;
  }
};

/// Numbers of a PotentialValue, which kernels write for the host.
struct DeviceValue {
  VoxelSums voxels;
  double inertia = 0, viscous = 0;
};

/// The values, rounded to float.
inline DeviceArray<float> in_float(const DeviceArray<double>& values) {
  DeviceArray<float> result(values.size());
  const double* from = values.data();
  float* to = result.data();
  if (to) cuda::for_each(values.size(), [=] __device__(int64_t k) { to[k] = float(from[k]); });
  return result;
}

/// Which values of nets a pass over the voxels needs: those of the energy, which asks by strains if
/// its law does; those at stretches; or those at stretches with second derivatives, for a tangent.
enum class NetPass { kEnergy, kStretches, kTangent };

struct DevicePotential::Impl {
  Impl(const PotentialTerms& potential, int64_t most_dense)
      : terms(potential),
        dense(operators_change(terms.scene()) ? kMostChangedNodes : most_dense),
        levels(make_stencil_levels(grid(), dense)),
        rows(terms.scene(), levels[0]),
        weights_float(in_float(rows.weights())),
        border_float(in_float(rows.border())),
        rotation_double(terms.scene().hourglass == Hourglass::kFull ? rows.row_count() * kLanes
                                                                    : 0),
        rotation_float(9 * rotation_double.size()),
        rest(grid().rest.data(), grid().rest.size()),
        mass(terms.scene().mass.data(), nodes()),
        load(NodeLoads(terms.scene()).data(), has_loads(terms.scene()) ? 3 * nodes() : 0),
        inertia(nodes()),
        predictor(3 * nodes()),
        nodal_rotation(nodes()),
        pinned(terms.scene().pinned.data(), nodes()),
        held(terms.scene()),
        parts((9 * rows.parts() + 1) / 2),
        brick_sums(rows.bricks()),
        inertia_sums(1),
        value(kEnergies),
        strain_before(terms.has_damping() ? rows.row_count() * kStrains * kLanes : 0),
        strains(strain_before.size()) {
    // what needs more than memory
    take_materials();
    if (terms.contact().exists()) contact.emplace(terms);
    if (terms.scheme().dt > 0 && !MemoryCount::present()) set_scheme(terms.scheme());
  }

  const VoxelGrid& grid() const { return terms.scene().grid; }
  int64_t nodes() const { return grid().node_count(); }

  template <class T>
  VoxelTables<T> voxels() const {
    VoxelTables<T> tables;
    if constexpr (sizeof(T) == 4)
      tables.weights = weights_float.data(), tables.border = border_float.data(),
      tables.rotation = {rotation_float.data()};
    else
      tables.weights = rows.weights().data(), tables.border = rows.border().data(),
      tables.rotation = {rotation_double.data()};
    tables.materials = materials.data();
    tables.h = T(grid().h);
    tables.hourglass = terms.scene().hourglass;
    return tables;
  }

  void take_materials();
  void set_scheme(const StepScheme& scheme);
  // damping.cu
  void find_strains(const double* u, double* to);
  template <class T>
  void viscous_pass(const double* u, T* gradient, int place, bool at_pinned);
  void viscous_tangent_pass(const double* u, TangentKind kind);
  /// Calls pass(nets), where nets gives voxels the corrections of their nets at u.
  template <class T, NetPass kPass, class Pass>
  void with_nets(const double* u, const Pass& pass) {
    if (learned.empty()) return pass(NoNets{});
    if (results.size() == 0) return pass(NetTables{materials.data()});
    ask_nets<T, kPass>(u);
    pass(NetResults{materials.data(), results.data()});
  }
  template <class T, NetPass kPass>
  void ask_nets(const double* u);
  template <class T, bool kQuality, class Nets>
  void gradient_pass(const double* u, T* gradient, const Nets& nets, int place);
  template <class T, bool kQuality>
  void start_gradient(const double* u, T* gradient, int place = 0);
  InertiaTerms inertia_terms(int place = 0) {
    return {inertia.data(), predictor.data(), pinned.data(), &value.data()[place].inertia};
  }
  void sum_inertia(const double* u, int place = 0, Signal::Raise raise = {});
  void freeze_rotations(const double* u);
  template <class Nets>
  void tangent_pass(const double* u, TangentKind kind, const Nets& nets);
  void linearise(const double* u, TangentKind kind);
  template <bool kDamped, class T>
  void tangent_product(const T* p, T* product);
  template <class T>
  void hessian_product(const T* p, T* product);

  const PotentialTerms& terms;
  int64_t dense;  ///< most nodes of a level that is solved
  std::vector<BrickLevel> levels;
  DeviceRows rows;
  DeviceArray<float> weights_float, border_float;
  DeviceArray<Quaternion<double>> rotation_double;
  DeviceArray<float> rotation_float;
  DeviceArray<double> rest, mass, load, inertia, predictor;  // as the public functions give them
  DeviceArray<Quaternion<float>> nodal_rotation;
  DeviceArray<uint8_t> pinned;  // NodeKind
  DeviceHeldNodes held;
  DeviceArray<double> parts;  // for each partial sum three in double or nine in float
  DeviceArray<VoxelSums> brick_sums;
  DeviceArray<SumScratch<Sums<1>>> inertia_sums;
  PinnedArray<DeviceValue> value;
  static constexpr int64_t kStrains = VoxelStrain<double>::kCount;
  DeviceArray<double> strain_before, strains;  // E_b, A_b and scratch, [row][18][lane]
  double rate = 0;                             // 1/k of the present step [1/s]
  Signal signal;
  std::vector<DeviceArray<float>> learned;  // tables, or weights of nets
  DeviceArray<double> logs, results;        // of learned_law.cuh, where a net is evaluated itself
  DeviceArray<DeviceMaterial> materials;
  std::optional<DeviceContact> contact;
  DeviceArray<float> tangent;  // [row][45][lane]; from the first linearise on
};

}  // namespace elastogen::cuda
