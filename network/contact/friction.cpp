// SPDX-License-Identifier: Apache-2.0
// Friction as a bond of each point to each collider, elastic and ideally plastic: a force k_t s up
// to mu N, s the slip from where the point would hold without force, then mu N. At the end of a
// step what is beyond mu N / k_t is let go. So a body at rest does not creep, and the kink between
// holding and sliding is no sharper in short steps.
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "network/contact/contact.hpp"

namespace elastogen {

/// Sets the lag of friction from displacements u at a time, and what the bonds hold by it.
void Contact::set_lag(const double* u, double time) {
  find_places(u, place_);
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    Obstacle& obstacle = obstacles_[w];
    find_distances(obstacle, offset_at(obstacle.core, time));
    const size_t first = w * size_t(points_);
    for_each(points_, [&](int64_t p) {
      const size_t k = first + size_t(p);
      lags_[k] = contact_lag(near_[size_t(p)], stiffness_[size_t(p)], obstacle.core.friction,
                             lengths_.layer);
      slip_[k] = bonded_slip(lengths_, stiffness_[size_t(p)], lags_[k], held_[k]);
    });
    obstacle.rubs =
        std::any_of(lags_.begin() + int64_t(first), lags_.begin() + int64_t(first) + points_,
                    [](const ContactLag& l) { return l.limit > 0; });
  }
}

void Contact::begin_stage(const double* u, double time, double dt, const double* of_lag,
                          double lag_time) {
  if (!exists()) return;
  begin_step(u, time, dt);
  lengths_.bond = kBond / (lengths_.layer * lengths_.layer);
  held_.resize(lags_.size());
  slip_.resize(lags_.size());
  set_lag(of_lag, lag_time);
}

bool Contact::renew_lag(const double* u) {
  const auto rubs = [this] {
    return std::any_of(obstacles_.begin(), obstacles_.end(),
                       [](const Obstacle& obstacle) { return obstacle.rubs; });
  };
  const bool rubbed = rubs();
  last_lags_ = lags_;
  if (exists()) set_lag(u, start_time_ + dt_);
  return rubbed || rubs();
}

void Contact::relax_lag(double share) {
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    const size_t first = w * size_t(points_);
    for_each(points_, [&](int64_t p) {
      const size_t k = first + size_t(p);
      lags_[k] = relaxed_lag(last_lags_[k], lags_[k], share);
      slip_[k] = bonded_slip(lengths_, stiffness_[size_t(p)], lags_[k], held_[k]);
    });
    obstacles_[w].rubs =
        std::any_of(lags_.begin() + int64_t(first), lags_.begin() + int64_t(first) + points_,
                    [](const ContactLag& l) { return l.limit > 0; });
  }
}

void Contact::keep_bonds(const double* u) {
  if (!exists()) return;
  find_places(u, place_);
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    const Obstacle& obstacle = obstacles_[w];
    find_distances(obstacle, obstacle.to);
    for_each(points_, [&](int64_t p) {
      const size_t k = w * size_t(points_) + size_t(p);
      held_[k] = kept_slip(lengths_, point(w, p), obstacle, lags_[k], near_[size_t(p)],
                           obstacle.core.friction);
    });
  }
}

Span<const double> Contact::bonds() const {
  return {held_.empty() ? nullptr : held_[0].data(), int64_t(held_.size()), 3};
}

}  // namespace elastogen
