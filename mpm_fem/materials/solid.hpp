// SPDX-License-Identifier: Apache-2.0
// The material of a body, elastic or yielding, and its law at a point.

#pragma once

#include "core/constitutive.hpp"
#include "mpm_fem/materials/associative_neo_von_mises.hpp"
#include "mpm_fem/materials/cam_clay.hpp"
#include "mpm_fem/materials/drucker_prager.hpp"
#include "mpm_fem/materials/von_mises.hpp"

#include <variant>

namespace elastogen {

/// When a solid yields; none: it is elastic.
using Yield = std::variant<std::monostate, MetalYield, SandYield, SnowYield>;

/// The elastic law of sand and metal is Hencky's, that of snow the decoupled neo-Hookean one of
/// cam_clay.hpp, for any law of `elastic`; a metal with Law::kNeoHookean has that law.
struct Solid {
  Material elastic;
  Yield yield = {};

  bool is_plastic() const { return yield.index() != 0; }
};

namespace detail {
template <int d>
using NeoHookeanMetal =
    std::conditional_t<d == 3, AssociativeNeoVonMises<double>, NeoVonMises<double, d>>;
}

/// Each has a history of one number, or none.
template <int d>
using PointLaw = std::variant<ElasticLaw<double>, VonMises<double, d>, detail::NeoHookeanMetal<d>,
                              DruckerPrager<double, d>, CamClay<double, d>>;

/// @throws Error as check_material and check_yield.
template <int d>
PointLaw<d> point_law(const Solid& solid) {
  check_material(solid.elastic);
  if (const auto* sand = std::get_if<SandYield>(&solid.yield))
    return drucker_prager<double, d>(solid.elastic, *sand);
  if (const auto* snow = std::get_if<SnowYield>(&solid.yield))
    return cam_clay<double, d>(solid.elastic, *snow);
  const auto* metal = std::get_if<MetalYield>(&solid.yield);
  if (!metal)
    return ElasticLaw<double>{{solid.elastic.law, solid.elastic.mu(), solid.elastic.lambda()}};
  if (solid.elastic.law != Law::kNeoHookean) return von_mises<double, d>(solid.elastic, *metal);
  if constexpr (d == 3)
    return AssociativeNeoVonMises<double>{neo_von_mises<double>(solid.elastic, *metal)};
  else
    return neo_von_mises<double, d>(solid.elastic, *metal);
}

/// A law in space or, with plane strain and a flow that stays in the plane, in the plane.
using AnyLaw =
    std::variant<ElasticLaw<double>, VonMises<double, 3>, detail::NeoHookeanMetal<3>,
                 DruckerPrager<double, 3>, CamClay<double, 3>, VonMises<double, 2>,
                 detail::NeoHookeanMetal<2>, DruckerPrager<double, 2>, CamClay<double, 2>>;

/// point_law in the plane or in space. @throws Error as point_law.
inline AnyLaw any_law(const Solid& solid, bool plane) {
  const auto any = [](const auto& law) -> AnyLaw { return law; };
  return plane ? std::visit(any, point_law<2>(solid)) : std::visit(any, point_law<3>(solid));
}

/// The dimension of the flow of a law, 2 where it stays in the plane.
template <class L>
inline constexpr int dimension = 3;
template <template <class, int> class L, class T>
inline constexpr int dimension<L<T, 2>> = 2;

/// Whether a law's tangent is symmetric: then it has an energy, and steps are minima.
template <class L>
inline constexpr bool has_energy =
    std::is_same_v<decltype(std::declval<const L&>().template response<true>(
                       static_cast<const typename L::Real*>(nullptr), typename L::History{})),
                   Response<typename L::Real>>;

/// The history of a law as the number that is stored, and back.
template <class L>
typename L::History history_of(const L&, double memory) {
  if constexpr (std::is_empty_v<typename L::History>)
    return {};
  else
    return {memory};
}
template <class History>
double memory_of(const History& history) {
  if constexpr (std::is_empty_v<History>) {
    return 0;
  } else {
    const auto& [memory] = history;
    return memory;
  }
}

}  // namespace elastogen
