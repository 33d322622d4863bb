// SPDX-License-Identifier: Apache-2.0
#include "core/polar.hpp"
#include "network/device_potential.hpp"
#include "network/device_rows.cuh"

namespace elastogen::cuda {
namespace {

/// A material, as kernels take it.
struct DeviceMaterial {
  LawParameters<double> law;
  MtlTableView table = {};  ///< without coefficients: the law itself
};

/// Response of a material to stretches.
template <class T>
struct Respond {
  LawParameters<T> law;
  MtlTableView table;

  __device__ Response<T> operator()(const T sigma[3], T& outside) const {
    outside = 0;
    if (!table.coefficients) return elastic_response<false>(law, sigma);
    const auto difference = [&](const T e[3]) { return table.evaluate<false>(e); };
    return corrected_response<false>(law, sigma, difference, outside);
  }
};

/// What voxels have, each [row][field][lane].
template <class T>
struct VoxelTables {
  const T *weights, *border, *rotation;
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
    if (hourglass == Hourglass::kFull)
      for (int k = 0; k < 9; ++k) v.R[k] = rotation[(r * 9 + k) * kLanes + lane];
    return v;
  }
};

/// A voxel of the grid that is filled to its corners.
template <class T>
__device__ bool is_full(const VoxelData<T>& v) {
  for (int p = 1; p < 7; ++p)
    if (v.M[p] != 0) return false;
  return true;
}

/// What a brick adds to the value of the potential.
struct VoxelSums {
  double elastic = 0, hourglass = 0, outside = 0, min_j = 1e300, min_corner_j = 1e300;
  __device__ void add(const VoxelSums& o) {
    elastic += o.elastic, hourglass += o.hourglass, outside += o.outside;
    min_j = o.min_j < min_j ? o.min_j : min_j;
    min_corner_j = o.min_corner_j < min_corner_j ? o.min_corner_j : min_corner_j;
  }
};

/// The numbers of a PotentialValue, where kernels leave them for the host.
struct DeviceValue {
  VoxelSums voxels;
  double inertia = 0;
};

std::vector<float> in_float(const std::vector<double>& values) {
  return {values.begin(), values.end()};
}

}  // namespace

struct DevicePotential::Impl {
  explicit Impl(const IncrementalPotential& potential)
      : host(potential),
        rows(potential.rows()),
        weights_double(potential.voxel_weights()),
        border_double(potential.rows().border),
        weights_float(in_float(potential.voxel_weights())),
        border_float(in_float(potential.rows().border)),
        rotation_double(
            potential.scene().hourglass == Hourglass::kFull ? rows.row_count() * 9 * kLanes : 0),
        rotation_float(rotation_double.size()),
        inertia(nodes()),
        predictor(3 * nodes()),
        u_now(3 * nodes()),
        nodal_rotation(9 * nodes()),
        pinned(nodes()),
        parts(3 * rows.parts()),
        brick_sums(rows.bricks()),
        inertia_sums(1),
        value(1) {
    pinned.upload(potential.scene().pinned.data());
    std::vector<DeviceMaterial> list;
    for (size_t m = 0; m < potential.scene().materials.size(); ++m) {
      const Material& material = potential.scene().materials[m];
      list.push_back({{material.law, material.mu(), material.lambda()}, {}});
      const LearnedLaw* learned = potential.learned(m);
      if (!learned) continue;
      ELASTOGEN_CHECK(learned->evaluation() == Evaluation::kTable,
                      "the device evaluates nets by their tables only");
      tables.emplace_back(learned->table().coefficients());
      list.back().table = learned->table().view();
      list.back().table.coefficients = tables.back().data();
    }
    materials = DeviceArray<DeviceMaterial>(list);
  }

  int64_t nodes() const { return host.scene().grid.node_count(); }

  template <class T>
  VoxelTables<T> voxels() const {
    VoxelTables<T> tables;
    if constexpr (sizeof(T) == 4)
      tables.weights = weights_float.data(), tables.border = border_float.data(),
      tables.rotation = rotation_float.data();
    else
      tables.weights = weights_double.data(), tables.border = border_double.data(),
      tables.rotation = rotation_double.data();
    tables.materials = materials.data();
    tables.h = T(host.scene().grid.h);
    tables.hourglass = host.scene().hourglass;
    return tables;
  }

  template <class T, bool kQuality>
  void start_gradient(const double* u, T* gradient);
  InertiaTerms inertia_terms() {
    return {inertia.data(), predictor.data(), pinned.data(), &value.data()->inertia};
  }
  void sum_inertia(const double* u);
  void freeze_rotations();
  void add_gradients(const double* u, int component);

  const IncrementalPotential& host;
  DeviceRows rows;
  DeviceArray<double> weights_double, border_double;
  DeviceArray<float> weights_float, border_float;
  DeviceArray<double> rotation_double;
  DeviceArray<float> rotation_float;
  DeviceArray<double> inertia, predictor, u_now;
  DeviceArray<float> nodal_rotation;
  DeviceArray<uint8_t> pinned;
  DeviceArray<double> parts;  // floats take the first half
  DeviceArray<VoxelSums> brick_sums;
  DeviceArray<SumRoom<Sums<1>>> inertia_sums;
  PinnedArray<DeviceValue> value;
  std::vector<DeviceArray<float>> tables;
  DeviceArray<DeviceMaterial> materials;
};

/// R_v of every voxel at u_now, where the hourglass term needs it.
void DevicePotential::Impl::freeze_rotations() {
  if (rotation_double.size() == 0) return;
  const double* u = u_now.data();
  double* R = rotation_double.data();
  float* R_float = rotation_float.data();
  const VoxelTables<double> table = voxels<double>();
  for_each_voxel<double>(
      rows, parts.data(), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, double v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, double corner[3][8], double[3][8],
                     NoSums&) {
        const VoxelData<double> data = table.data(row, r, lane);
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<double> rotation = unique_rotation(deformation_gradient<true>(data, corner));
        for (int k = 0; k < 9; ++k) {
          R[(r * 9 + k) * kLanes + lane] = rotation.m[k];
          R_float[(r * 9 + k) * kLanes + lane] = float(rotation.m[k]);
        }
      },
      [=] __device__(int64_t, const double*) {});
}

/// Row `component` of the fill-weighted sums of F_v over the voxels of each node, into
/// nodal_rotation.
void DevicePotential::Impl::add_gradients(const double* u, int component) {
  float* sums = nodal_rotation.data() + 3 * component;
  const VoxelTables<float> table = voxels<float>();
  for_each_voxel<float>(
      rows, reinterpret_cast<float*>(parts.data()), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, float corner[3][8], float f[3][8],
                     NoSums&) {
        const VoxelData<float> data = table.data(row, r, lane);
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<float> F = deformation_gradient<true>(data, corner);
        for (int j = 0; j < 3; ++j)
          for (int c = 0; c < 8; ++c) f[j][c] = data.phi * F(component, j);
      },
      [=] __device__(int64_t n, const float sum[3]) {
        for (int j = 0; j < 3; ++j) sums[9 * n + j] = sum[j];
      });
}

DevicePotential::DevicePotential(const IncrementalPotential& host) {
  ELASTOGEN_CHECK(!host.contact().exists(), "colliders are not on the device yet");
  impl_ = std::make_unique<Impl>(host);
}

DevicePotential::~DevicePotential() = default;

void DevicePotential::begin_step() {
  Impl& s = *impl_;
  s.u_now.upload(s.host.now().data());
  s.predictor.upload(s.host.predictor().data());
  s.inertia.upload(s.host.inertia().data());
  s.freeze_rotations();
}

double* DevicePotential::inertia() {
  return impl_->inertia.data();
}
double* DevicePotential::predictor() {
  return impl_->predictor.data();
}
double* DevicePotential::now() {
  return impl_->u_now.data();
}
void DevicePotential::freeze_rotations() {
  impl_->freeze_rotations();
}

void DevicePotential::set_nodal_rotations(const double* u) {
  for (int component = 0; component < 3; ++component) impl_->add_gradients(u, component);
  float* rotation = impl_->nodal_rotation.data();
  cuda::for_each(nodes(), [=] __device__(int64_t n) {
    Mat3<float> sum;
    for (int k = 0; k < 9; ++k) sum.m[k] = rotation[9 * n + k];
    const Mat3<float> R = polar_rotation(sum);
    for (int k = 0; k < 9; ++k) rotation[9 * n + k] = R.m[k];
  });
}

template <class T, bool kQuality>
void DevicePotential::Impl::start_gradient(const double* u, T* gradient) {
  const VoxelTables<T> table = voxels<T>();
  const double *mass = inertia.data(), *aim = predictor.data();
  const uint8_t* held = pinned.data();
  for_each_voxel<T>(
      rows, reinterpret_cast<T*>(parts.data()), brick_sums.data(),
      [=] __device__(int64_t n, int64_t reference, T v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = T(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const T corner[3][8], T f[3][8],
                     VoxelSums& sums) {
        const VoxelData<T> data = table.data(row, r, lane);
        const Respond<T> respond{data.law, table.materials[row.material].table};
        const VoxelEnergy<T> e = voxel_energy<true>(data, respond, corner, f);
        VoxelSums mine{double(e.elastic), double(e.hourglass), double(e.outside), double(e.J)};
        // corners of border voxels may lie outside the body
        if (kQuality && is_full(data)) mine.min_corner_j = corner_jacobian(corner, data.h);
        sums.add(mine);
      },
      [=] __device__(int64_t n, const T force[3]) {
        for (int i = 0; i < 3; ++i)
          gradient[3 * n + i] =
              held[n] ? T(0) : T(mass[n] * (u[3 * n + i] - aim[3 * n + i]) + double(force[i]));
      });
  DeviceValue* to = value.data();
  sum_of(rows.bricks(), brick_sums.data(),
         [=] __device__(const VoxelSums& sum) { to->voxels = sum; });
}

void DevicePotential::Impl::sum_inertia(const double* u) {
  const InertiaTerms terms = inertia_terms();
  ordered_sum(
      3 * nodes(), inertia_sums.data(),
      [=] __device__(int64_t k, Sums<1> & sum) { sum.value[0] += terms.energy(k, u[k]); },
      [=] __device__(const Sums<1>& sum) { *terms.total = sum.value[0]; });
}

template <class T>
void DevicePotential::start_gradient(const double* u, T* gradient) {
  impl_->start_gradient<T, false>(u, gradient);
}

InertiaTerms DevicePotential::inertia_terms() {
  return impl_->inertia_terms();
}

template <class T>
void DevicePotential::start_evaluation(const double* u, T* gradient) {
  start_gradient(u, gradient);
  impl_->sum_inertia(u);
}

void DevicePotential::start_residual(const double* u, double* gradient) {
  impl_->start_gradient<double, true>(u, gradient);
  impl_->sum_inertia(u);
}

PotentialValue DevicePotential::value() const {
  const DeviceValue& found = impl_->value[0];
  PotentialValue result;
  result.inertia = found.inertia;
  result.elastic = found.voxels.elastic;
  result.hourglass = found.voxels.hourglass;
  result.min_j = found.voxels.min_j;
  result.min_corner_j = found.voxels.min_corner_j;
  result.outside = int64_t(found.voxels.outside);
  return result;
}

template <class T>
PotentialValue DevicePotential::evaluate(const double* u, T* gradient) {
  start_evaluation(u, gradient);
  synchronise();
  return value();
}

template void DevicePotential::start_gradient<float>(const double*, float*);
template void DevicePotential::start_gradient<double>(const double*, double*);
template void DevicePotential::start_evaluation<float>(const double*, float*);
template void DevicePotential::start_evaluation<double>(const double*, double*);
template PotentialValue DevicePotential::evaluate<float>(const double*, float*);
template PotentialValue DevicePotential::evaluate<double>(const double*, double*);

int64_t DevicePotential::nodes() const {
  return impl_->nodes();
}
const uint8_t* DevicePotential::pinned() const {
  return impl_->pinned.data();
}
const float* DevicePotential::nodal_rotation() const {
  return impl_->nodal_rotation.data();
}
const IncrementalPotential& DevicePotential::host() const {
  return impl_->host;
}

}  // namespace elastogen::cuda
