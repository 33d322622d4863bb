// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/wide.cuh"
#include "core/polar.hpp"
#include "network/potential/incremental_potential.cuh"
#include "network/potential/nodal_sums.cuh"

namespace elastogen::cuda {
namespace {

/// The weights of a net, with those of the second layer column by column.
std::vector<float> by_columns(const std::vector<float>& weights) {
  constexpr size_t kWidth = NeuralMtl::kWidth, kSecond = 4 * kWidth;
  std::vector<float> result = weights;
  for (size_t k = 0; k < kWidth; ++k)
    for (size_t m = 0; m < kWidth; ++m)
      result[kSecond + kWidth * m + k] = weights[kSecond + kWidth * k + m];
  return result;
}

}  // namespace

/// Uploads laws, and tables or weights of nets.
void DevicePotential::Impl::take_materials() {
  // laws, each with its net
  std::vector<DeviceMaterial> list;
  bool asked = false;
  for (size_t m = 0; m < terms.scene().materials.size(); ++m) {
    const Material& material = terms.scene().materials[m];
    list.push_back(
        {{material.law, material.mu(), material.lambda()}, {}, {}, viscous_time(material)});
    const LearnedLaw* net = terms.learned(m);
    if (!net) continue;
    if (net->evaluation() == Evaluation::kTable) {
      learned.emplace_back(net->table().coefficients());
      list.back().table = net->table().view();
      list.back().table.coefficients = learned.back().data();
    } else {
      learned.emplace_back(by_columns(net->weights()));
      list.back().net = {learned.back().data(), net->net().terms(), net->net().mu(),
                         net->net().lambda()};
      asked = true;
    }
  }
  materials = DeviceArray<DeviceMaterial>(list);
  if (!asked) return;
  logs = DeviceArray<double>(rows.row_count() * 3 * kLanes);
  results = DeviceArray<double>(rows.row_count() * kNetFields * kLanes);
}

/// R_v of every voxel, where the hourglass term needs it.
void DevicePotential::Impl::freeze_rotations(const double* u) {
  if (rotation_double.size() == 0) return;
  Quaternion<double>* to = rotation_double.data();
  float* to_float = rotation_float.data();
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
        const Mat3<double> R = unique_rotation(deformation_gradient<true>(data, corner));
        double size = 0;
        for (int k = 0; k < 9; ++k) size += fabs(R.m[k]);
        to[r * kLanes + lane] = size > 0 ? quaternion_of(R) : Quaternion<double>{};
        for (int k = 0; k < 9; ++k) to_float[(r * 9 + k) * kLanes + lane] = float(R.m[k]);
      },
      NoFinish{});
}

DevicePotential::DevicePotential(const PotentialTerms& terms, int64_t dense)
    : impl_(std::make_unique<Impl>(terms, dense)) {}

DevicePotential::~DevicePotential() = default;

void DevicePotential::begin_step(const IncrementalPotential& host) {
  Impl& s = *impl_;
  const DeviceArray<double> now(host.now());
  s.held.set_time(host.held().time());
  s.predictor.upload(host.predictor().data());
  if (s.load.size() > 0) s.load.upload(host.loads().data());
  s.inertia.upload(host.inertia().data());
  s.freeze_rotations(now.data());
  s.rate = rate_of(host.scheme());
  if (s.terms.has_damping()) s.strain_before.upload(host.strain_before().data());
  if (s.contact) s.contact->begin_step(now.data(), host.contact().start_time());
}

void DevicePotential::Impl::set_scheme(const StepScheme& scheme) {
  const double *from = mass.data(), a0 = scheme.a0, dt2 = scheme.dt * scheme.dt;
  double* const to = inertia.data();
  rate = rate_of(scheme);
  cuda::for_each(nodes(), [=] __device__(int64_t n) { to[n] = a0 * from[n] / dt2; });
}
void DevicePotential::set_scheme(const StepScheme& scheme) {
  impl_->set_scheme(scheme);
}

DeviceContact* DevicePotential::contact() {
  return impl_->contact ? &*impl_->contact : nullptr;
}

double* DevicePotential::inertia() {
  return impl_->inertia.data();
}
double* DevicePotential::predictor() {
  return impl_->predictor.data();
}
double* DevicePotential::load() {
  return impl_->load.data();
}
void DevicePotential::freeze_rotations(const double* u) {
  impl_->freeze_rotations(u);
}

/// The nodal rotations are those of the fill-weighted sums of F_v over the voxels of each node.
void DevicePotential::set_nodal_rotations(const double* u) {
  const VoxelTables<float> table = impl_->voxels<float>();
  Quaternion<float>* rotation = impl_->nodal_rotation.data();
  const uint8_t* axes = impl_->held.fixed_axes();
  sum_at_nodes<float, 9>(
      impl_->rows, reinterpret_cast<float*>(impl_->parts.data()),
      [=] __device__(int64_t n, int64_t reference, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, float corner[3][8], float sum[9]) {
        const VoxelData<float> data = table.data(row, r, lane);
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<float> F = deformation_gradient<true>(data, corner);
        for (int k = 0; k < 9; ++k) sum[k] = data.phi * F.m[k];
      },
      [=] __device__(int64_t n, const float sum[9]) {
        Mat3<float> F;
        for (int k = 0; k < 9; ++k) F.m[k] = sum[k];
        rotation[n] = quaternion_of(polar_rotation_about(axes ? axes[n] : 0, F));
      });
}

template <class T, bool kQuality, class Nets>
void DevicePotential::Impl::gradient_pass(const double* u, T* gradient, const Nets& nets,
                                          int place) {
  const VoxelTables<T> table = voxels<T>();
  const double *mass = inertia.data(), *aim = predictor.data();
  const uint8_t* kind = pinned.data();
  const bool reacts = held.has_reactions();
  DeviceValue* to = value.data() + place;
  const auto read = [=] __device__(int64_t n, int64_t reference, T v[3]) {
    for (int i = 0; i < 3; ++i) v[i] = T(u[3 * n + i] - u[3 * reference + i]);
  };
  const auto voxel = [=] __device__(const VoxelRow& row, int64_t r, int lane, const T corner[3][8],
                                    T f[3][8], VoxelSums& sums) {
    const VoxelData<T> data = table.data(row, r, lane);
    const auto respond = response_of<false>(data.law, nets(row, r, lane));
    const VoxelEnergy<T> e = voxel_energy<true>(data, respond, corner, f);
    VoxelSums mine{double(e.elastic), double(e.hourglass), double(e.outside), double(e.J)};
    // corners of border voxels may lie outside the body
    if (kQuality && is_full(data)) mine.min_corner_j = corner_jacobian(corner, data.h);
    sums.add(mine);
  };
  const auto finish = [=] __device__(int64_t n, const NodeSum<T>& given) {
    const bool moves = kind[n] != kPinnedNode;
    const double weight = mass[n];
    double away[3];
    T force[3];
    for (int i = 0; i < 3; ++i) away[i] = u[3 * n + i] - aim[3 * n + i];
    given.get(force);
    for (int i = 0; i < 3; ++i)
      gradient[3 * n + i] = moves                ? T(weight * away[i] + double(force[i]))
                            : kQuality && reacts ? force[i]
                                                 : T(0);
  };
  const auto then = [=] __device__(const VoxelSums& sum) { to->voxels = sum; };
  T* const scratch = reinterpret_cast<T*>(parts.data());
  if (gradient == nullptr)
    for_each_voxel<T>(rows, scratch, brick_sums.data(), read, voxel, NoFinish{}, then);
  else
    for_each_voxel<T>(rows, scratch, brick_sums.data(), read, voxel, finish, then);
}

template <class T, bool kQuality>
void DevicePotential::Impl::start_gradient(const double* u, T* gradient, int place) {
  const bool reacts = kQuality && held.has_reactions();
  with_nets<T, NetPass::kEnergy>(
      u, [&](const auto& nets) { gradient_pass<T, kQuality>(u, gradient, nets, place); });
  if (terms.has_damping()) viscous_pass<T>(u, gradient, place, reacts);
  if (contact) contact->start_evaluation(u, gradient);
  // reactions, from a gradient that is not folded; then it is 0 at pinned nodes
  if constexpr (kQuality) {
    if (reacts && contact) contact->add_pinned_forces(gradient);
    if (reacts) held.start_reactions(rest.data(), load.data(), u, gradient);
  }
  if (gradient) held.fold(gradient);
}

void DevicePotential::Impl::sum_inertia(const double* u, int place, Signal::Raise raise) {
  const InertiaTerms terms = inertia_terms(place);
  ordered_wide_sum<4>(
      3 * nodes(), inertia_sums.data(),
      [=] __device__(const auto& at, Sums<1>& sum) {
        constexpr int kCount = std::decay_t<decltype(at)>::kCount;
        double place[kCount], aim[kCount];
        at.load(u, place), at.load(terms.predictor, aim);
        sum.value[0] += terms.energy<kCount>(at.first, place, aim);
      },
      [=] __device__(const Sums<1>& sum) {
        *terms.total = sum.value[0];
        raise();
      });
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

std::vector<Reaction> DevicePotential::reactions() const {
  return impl_->held.reactions();
}

void DevicePotential::start_energy(const double* u, int place) {
  impl_->start_gradient<float, false>(u, nullptr, place);
  impl_->sum_inertia(u, place, impl_->signal.next());
}

void DevicePotential::wait_for_energy() {
  impl_->signal.wait();
}

PotentialValue DevicePotential::value(int place) const {
  const DeviceValue& found = impl_->value[place];
  PotentialValue result;
  result.inertia = found.inertia;
  result.elastic = found.voxels.elastic;
  result.hourglass = found.voxels.hourglass;
  result.viscous = found.viscous;
  result.beta = impl_->terms.beta(impl_->rate);
  result.min_j = found.voxels.min_j;
  result.min_corner_j = found.voxels.min_corner_j;
  result.outside = int64_t(found.voxels.outside);
  if (impl_->contact) {
    result.contact = impl_->contact->energy();
    result.deepest_overlap = impl_->contact->deepest_overlap();
  }
  return result;
}

template <class T>
PotentialValue DevicePotential::evaluate(const double* u, T* gradient) {
  start_gradient(u, gradient);
  impl_->sum_inertia(u, 0, impl_->signal.next());
  impl_->signal.wait();
  return value();
}

template void DevicePotential::start_gradient<float>(const double*, float*);
template void DevicePotential::start_gradient<double>(const double*, double*);
template void DevicePotential::start_evaluation<float>(const double*, float*);
template void DevicePotential::start_evaluation<double>(const double*, double*);
template PotentialValue DevicePotential::evaluate<float>(const double*, float*);
template PotentialValue DevicePotential::evaluate<double>(const double*, double*);

BrickRows DevicePotential::download_rows() const {
  return impl_->rows.download();
}
std::vector<double> DevicePotential::download_weights() const {
  std::vector<double> weights(size_t(impl_->rows.weights().size()));
  impl_->rows.weights().download(weights.data());
  return weights;
}

int64_t DevicePotential::nodes() const {
  return impl_->nodes();
}
const uint8_t* DevicePotential::pinned() const {
  return impl_->pinned.data();
}
DeviceHeldNodes& DevicePotential::held() {
  return impl_->held;
}
const DeviceHeldNodes& DevicePotential::held() const {
  return impl_->held;
}
const Quaternion<float>* DevicePotential::nodal_rotation() const {
  return impl_->nodal_rotation.data();
}
const PotentialTerms& DevicePotential::terms() const {
  return impl_->terms;
}
const double* DevicePotential::rest() const {
  return impl_->rest.data();
}
const double* DevicePotential::mass() const {
  return impl_->mass.data();
}
const double* DevicePotential::load() const {
  return impl_->load.data();
}

}  // namespace elastogen::cuda
