// SPDX-License-Identifier: Apache-2.0
// The frozen potential that replaces a law without a potential.

#pragma once

#include "mpm_fem/materials/frozen_cam_clay.hpp"
#include "mpm_fem/materials/frozen_potential.hpp"

#include <variant>

namespace elastogen {
namespace detail {

template <class L>
struct FrozenOf;
template <int d>
struct FrozenOf<DruckerPrager<double, d>> {
  using Law = FrozenDruckerPrager<double, d>;
};
template <int d>
struct FrozenOf<CamClay<double, d>> {
  using Law = FrozenCamClay<double, d>;
};

}  // namespace detail

/// The frozen law of a law without an energy (has_energy).
template <class L>
using FrozenLaw = typename detail::FrozenOf<L>::Law;

/// Frozen data of a point whose law is one of PointLaw<d>; empty if that has an energy.
template <int d>
using FrozenPoint = std::variant<std::monostate, typename FrozenDruckerPrager<double, d>::History,
                                 typename FrozenCamClay<double, d>::History>;

}  // namespace elastogen
