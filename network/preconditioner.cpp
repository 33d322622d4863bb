// SPDX-License-Identifier: Apache-2.0
#include "network/preconditioner.hpp"

#include "core/reduce.hpp"

#include <cmath>

namespace elastogen {

template <class T>
Preconditioner<T>::Preconditioner(IncrementalPotential& potential, bool with_encoder)
    : potential_(potential), multigrid_(potential.scene(), potential.scheme().a0) {
  if (with_encoder) encoder_.emplace(potential);
  const size_t size = 3 * size_t(potential.scene().grid.node_count());
  r_.resize(size);
  z_.resize(size);
}

template <class T>
void Preconditioner<T>::update_contact() {
  along_.clear();
  across_.clear();
  const Contact& contact = potential_.contact();
  if (!contact.exists() || contact.stiff_nodes().empty()) return;
  along_.assign(size_t(potential_.scene().grid.node_count()), 1);
  across_ = along_;
  for (const int32_t n : contact.stiff_nodes()) {
    const double D = multigrid_.diagonal(n);
    if (D <= 0) continue;
    along_[size_t(n)] = float(1 / std::sqrt(1 + contact.nodal_stiffness()[2 * size_t(n)] / D));
    across_[size_t(n)] = float(1 / std::sqrt(1 + contact.nodal_stiffness()[2 * size_t(n) + 1] / D));
  }
}

template <class T>
template <class In>
void Preconditioner<T>::apply(const In* r, In* z) {
  const int64_t nodes = potential_.scene().grid.node_count();
  const float* rotation = potential_.nodal_rotation().data();
  const Vec3 normal = potential_.contact().normal();
  const auto scaled = [&](int64_t n, const In v[3], T result[3]) {
    for (int i = 0; i < 3; ++i) result[i] = T(v[i]);
    if (along_.empty()) return;
    T dot = 0;
    for (int i = 0; i < 3; ++i) dot += T(normal[size_t(i)]) * result[i];
    const T across = T(across_[size_t(n)]), along = T(along_[size_t(n)]) - across;
    for (int i = 0; i < 3; ++i) result[i] = across * result[i] + along * dot * T(normal[size_t(i)]);
  };
  for_each(nodes, [&](int64_t n) {
    const float* R = rotation + 9 * n;
    T v[3];
    scaled(n, r + 3 * n, v);
    for (int i = 0; i < 3; ++i)
      r_[size_t(3 * n + i)] = T(R[i]) * v[0] + T(R[3 + i]) * v[1] + T(R[6 + i]) * v[2];
  });
  multigrid_.apply(r_.data(), z_.data());
  if (encoder_) encoder_->add(r_.data(), z_.data());
  for_each(nodes, [&](int64_t n) {
    const float* R = rotation + 9 * n;
    const T* w = z_.data() + 3 * n;
    In v[3];
    for (int i = 0; i < 3; ++i)
      v[i] = In(T(R[3 * i]) * w[0] + T(R[3 * i + 1]) * w[1] + T(R[3 * i + 2]) * w[2]);
    T result[3];
    scaled(n, v, result);
    for (int i = 0; i < 3; ++i) z[3 * n + i] = potential_.scene().pinned(n) ? In(0) : In(result[i]);
  });
}

template class Preconditioner<float>;
template class Preconditioner<double>;
template void Preconditioner<float>::apply(const float*, float*);
template void Preconditioner<float>::apply(const double*, double*);
template void Preconditioner<double>::apply(const double*, double*);
template void Preconditioner<double>::apply(const float*, float*);

}  // namespace elastogen
