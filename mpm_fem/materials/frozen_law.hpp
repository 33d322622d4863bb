// SPDX-License-Identifier: Apache-2.0
// Which frozen potential stands in for a law that has none.

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

/// Of a law without an energy (has_energy).
template <class L>
using FrozenLaw = typename detail::FrozenOf<L>::Law;

/// What was frozen at a point whose law is one of PointLaw<d>; empty where that has an energy.
template <int d>
using FrozenPoint = std::variant<std::monostate, typename FrozenDruckerPrager<double, d>::History,
                                 typename FrozenCamClay<double, d>::History>;

}  // namespace elastogen
