// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/preconditioner.hpp"

#include "core/reduce.hpp"

#include <cmath>

namespace elastogen {
namespace {

double inertia_of(const StepScheme& scheme) {
  return scheme.a0 / (scheme.dt * scheme.dt);
}

}  // namespace

template <class T>
Preconditioner<T>::Preconditioner(IncrementalPotential& potential, const EncoderChoice& encoder,
                                  std::optional<int64_t> dense)
    : potential_(potential),
      multigrid_(potential.scene(), potential.scheme().a0, potential.shared_rows(), dense),
      encoder_(encoder.make<T>(potential)),
      built_with_(inertia_of(potential.scheme())),
      used_(built_with_) {
  const size_t size = 3 * size_t(potential.scene().grid.node_count());
  r_.resize(size);
  z_.resize(size);
}

template <class T>
void Preconditioner<T>::update_contact() {
  const Contact& contact = potential_.contact();
  const std::vector<int32_t>& nodes = contact.stiff_nodes();
  if (nodes.empty() && !in_contact_) return;
  in_contact_ = !nodes.empty();
  std::vector<double> diagonal(nodes.empty() ? 0 : r_.size()), blocks(9 * nodes.size());
  for (size_t s = 0; s < nodes.size(); ++s) {
    if (potential_.scene().pinned(nodes[s])) continue;
    // the block in the frame of the node
    Mat3<double> R, K;
    for (size_t k = 0; k < 9; ++k) {
      R.m[k] = double(potential_.nodal_rotation()[9 * size_t(nodes[s]) + k]);
      K.m[k] = contact.stiff_blocks()[9 * s + k];
    }
    Mat3<double> turned = transposed_times(R, K * R);
    for (double& entry : turned.m) entry *= scale_;
    std::copy(turned.m, turned.m + 9, blocks.begin() + int64_t(9 * s));
    for (size_t i = 0; i < 3; ++i) diagonal[3 * size_t(nodes[s]) + i] = turned.m[4 * i];
  }
  multigrid_.set_nodal_stiffness(diagonal);
  if (encoder_) encoder_->set_nodal_stiffness(nodes, blocks);
}

template <class T>
void Preconditioner<T>::update_inertia() {
  // damping: the inverse of M + (1 + beta) K is that of M / (1 + beta) + K over 1 + beta
  const double stiffer = 1 + potential_.beta(rate_of(potential_.scheme()));
  scale_ = 1 / stiffer;
  const double wanted = inertia_of(potential_.scheme()) / stiffer;
  if (std::abs(wanted / used_ - 1) < 0.1) return;  // near enough for a preconditioner
  used_ = wanted;
  in_contact_ = false;
  multigrid_.scale_inertia(wanted / built_with_);
  if (encoder_) encoder_->set_inertia(potential_.scene(), built_with_, wanted);
}

template <class T>
template <class In>
void Preconditioner<T>::apply(const In* r, In* z) {
  if (patch_.empty()) return apply_plain(r, z);
  left_.resize(r_.size()), first_.resize(r_.size());
  for_each(int64_t(r_.size()), [&](int64_t k) { left_[size_t(k)] = T(r[k]); });
  patch_.begin(left_.data(), first_.data());
  apply_plain(left_.data(), z);
  patch_.end(left_.data(), first_.data(), z);
}

/// Without the correction of folds.

template <class T>
template <class From, class In>
void Preconditioner<T>::apply_plain(const From* r, In* z) {
  const int64_t nodes = potential_.scene().grid.node_count();
  const float* rotation = potential_.nodal_rotation().data();
  const T scale = T(scale_);
  for_each(nodes, [&](int64_t n) {
    const float* R = rotation + 9 * n;
    const From* v = r + 3 * n;
    for (int i = 0; i < 3; ++i)
      r_[size_t(3 * n + i)] = T(R[i]) * T(v[0]) + T(R[3 + i]) * T(v[1]) + T(R[6 + i]) * T(v[2]);
  });
  multigrid_.apply(r_.data(), z_.data());
  if (encoder_) encoder_->add_correction(r_.data(), z_.data());
  for_each(nodes, [&](int64_t n) {
    const float* R = rotation + 9 * n;
    const T* w = z_.data() + 3 * n;
    for (int i = 0; i < 3; ++i)
      z[3 * n + i] =
          potential_.scene().pinned(n)
              ? In(0)
              : In(scale * (T(R[3 * i]) * w[0] + T(R[3 * i + 1]) * w[1] + T(R[3 * i + 2]) * w[2]));
  });
  potential_.held().fill(z);
}

template class Preconditioner<float>;
template class Preconditioner<double>;
template void Preconditioner<float>::apply(const float*, float*);
template void Preconditioner<float>::apply(const double*, double*);
template void Preconditioner<double>::apply(const double*, double*);
template void Preconditioner<double>::apply(const float*, float*);

}  // namespace elastogen
