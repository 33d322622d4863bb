// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/preconditioner.cuh"

#include <cmath>

namespace elastogen::cuda {
namespace {

double inertia_over_mass(const StepScheme& scheme) {
  return scheme.a0 / (scheme.dt * scheme.dt);
}

}  // namespace

DevicePreconditioner::DevicePreconditioner(DevicePotential& potential, const EncoderChoice& choice)
    : potential_(potential),
      multigrid_(potential),
      z_(3 * potential.nodes()),
      share_(std::vector<double>{1}),
      built_with_(inertia_over_mass(potential.terms().scheme())),
      used_(built_with_) {
  const Scene& scene = potential.terms().scene();
  const DeviceContact* contact = potential.contact();
  const bool stages = has_stages(scene.scheme);
  if (contact || stages) multigrid_.expect_stiffness(stages ? potential.mass() : nullptr);
  if (!choice.wanted) return;
  const std::vector<std::vector<int32_t>> pieces = encoder_pieces(scene.grid);
  encoder_.emplace(potential, pieces);
  if (encoder_->softness() < choice.least_softness) {
    encoder_.reset();
    return;
  }
  // what the encoder works in, and what may be added to its operator
  turned_ = DeviceArray<float>(z_.size());
  encoded_ = DeviceArray<float>(z_.size());
  const std::vector<int32_t> none;
  if (contact || stages)
    encoder_->expect_stiffness(pieces, contact ? contact->surface_nodes() : none);
  if (stages) encoder_->expect_inertia(potential);
}

/// Whether cycles use what is added to the operators that they were built with.
void DevicePreconditioner::use_added() {
  multigrid_.use_stiffness(has_added());
  if (encoder_) encoder_->use_stiffness(has_added());
}

void DevicePreconditioner::add(const NodalStiffness& stiffness) {
  multigrid_.set_nodal_stiffness(stiffness);
  if (encoder_) encoder_->set_nodal_stiffness(stiffness);
}

void DevicePreconditioner::take_contact() {
  DeviceContact* contact = potential_.contact();
  if (!contact || !(contact->is_stiff() || in_contact_)) return;
  in_contact_ = contact->is_stiff();
  use_added();
  if (in_contact_)
    update_graph_.run([&] {
      add(contact->nodal_stiffness(potential_.nodal_rotation(), potential_.pinned(),
                                   share_.data()));
    });
  else if (other_inertia_)
    add({});
}

void DevicePreconditioner::update_inertia(const StepScheme& scheme) {
  constexpr double kNear = 0.1;  // enough for a preconditioner
  // damping: as Preconditioner::update_inertia
  const double stiffer = 1 + potential_.terms().beta(rate_of(scheme)), share = 1 / stiffer;
  if (float(share) != scale_) share_.upload(&share);
  scale_ = float(share);
  const double wanted = inertia_over_mass(scheme) / stiffer;
  if (std::abs(wanted / used_ - 1) < kNear) return;
  used_ = std::abs(wanted / built_with_ - 1) < kNear ? built_with_ : wanted;
  other_inertia_ = used_ != built_with_;
  in_contact_ = false;
  multigrid_.add_inertia(used_ - built_with_);
  if (encoder_) encoder_->scale_inertia(used_ / built_with_);
  use_added();
  if (other_inertia_) add({});
}

void DevicePreconditioner::cycle() {
  multigrid_.start();  // while the host launches the rest
  (has_added() ? added_graph_ : graph_).run([&] {
    Companion<float> encoder;
    if (encoder_) {
      encoder.begin = [this] {
        branch_.begin([this](cudaStream_t stream) {
          encoder_->apply(turned_.data(), encoded_.data(), stream);
        });
      };
      encoder.end = [this] { branch_.end(); };
      encoder.result = encoded_.data();
    }
    multigrid_.cycle(z_.data(), encoder);
  });
}

}  // namespace elastogen::cuda
