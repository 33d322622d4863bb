// SPDX-License-Identifier: Apache-2.0
#include "training/load_path.hpp"

#include "core/error.hpp"
#include "training/law_targets.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kFurthest = 8;  // log stretch of a free side

Vec3 log_stretches(LoadPath path, double e, double side) {
  switch (path) {
    case LoadPath::kUniaxial:
      return {e, side, side};
    case LoadPath::kBiaxial:
      return {e, e, side};
    case LoadPath::kShear:
      return {e, 0, side};
    case LoadPath::kVolume:
      break;
  }
  return {e, e, e};
}

/// Kirchhoff stress b dpsi/db of the free side, and its slope in ln b. It has the sign of the
/// traction and is nearly linear for laws in log stretches.
struct SideStress {
  double value, slope;
};

SideStress side_stress(const TargetLaw& law, LoadPath path, double e, double side) {
  const Vec3 logs = log_stretches(path, e, side);
  const Response<double> r = target_response(law, logs.data());
  const double b = std::exp(side);
  const double H = r.H[2] + (path == LoadPath::kUniaxial ? r.H[4] : 0);
  return {b * r.t[2], b * r.t[2] + b * b * H};
}

/// ln b by the linear theory.
double linear_side(const TargetLaw& law, LoadPath path, double e) {
  const double mu = law.law[0].mu, lambda = law.law[0].lambda, nu = lambda / (2 * (lambda + mu));
  if (path == LoadPath::kUniaxial) return -nu * e;
  return -nu / (1 - nu) * e * (path == LoadPath::kBiaxial ? 2 : 1);
}

/// Two values of ln b between which the stress of the side changes its sign, found by following it.
std::optional<std::array<double, 2>> bracket(const TargetLaw& law, LoadPath path, double e) {
  double from = std::clamp(linear_side(law, path, e), -kFurthest, kFurthest);
  const bool pulled = side_stress(law, path, e, from).value > 0;
  for (double step = 0.05; std::abs(from) < kFurthest; step *= 2) {
    const double to = std::clamp(from + (pulled ? -step : step), -kFurthest, kFurthest);
    if ((side_stress(law, path, e, to).value > 0) != pulled)
      return std::array{std::min(from, to), std::max(from, to)};
    from = to;
  }
  return std::nullopt;
}

/// Newton's method in a shrinking bracket; its middle replaces a step that leaves it.
double root(const TargetLaw& law, LoadPath path, double e, std::array<double, 2> bounds) {
  double side = (bounds[0] + bounds[1]) / 2;
  for (int k = 0; k < 200; ++k) {
    const SideStress w = side_stress(law, path, e, side);
    bounds[w.value > 0 ? 1 : 0] = side;
    double next = side - w.value / w.slope;
    if (!(next >= bounds[0] && next <= bounds[1])) next = (bounds[0] + bounds[1]) / 2;
    if (std::abs(next - side) <= 2e-16 + 4e-15 * std::abs(e)) return next;
    side = next;
  }
  return side;
}

}  // namespace

std::string path_name(LoadPath path) {
  constexpr const char* kNames[] = {"uniaxial", "biaxial", "shear", "volume"};
  return kNames[size_t(path)];
}

std::optional<LoadState> balanced_state(const TargetLaw& law, LoadPath path, double stretch) {
  ELASTOGEN_CHECK(stretch > 0 && std::isfinite(stretch),
                  "a stretch must be positive and finite, got ", stretch);
  const double e = std::log(stretch);
  double side = 0;
  if (path != LoadPath::kVolume && e != 0) {
    const auto bounds = bracket(law, path, e);
    if (!bounds) return std::nullopt;
    side = root(law, path, e, *bounds);
  }
  LoadState state{log_stretches(path, e, side)};
  const Response<double> r = target_response(law, state.e.data());
  state.stress = r.t[0], state.energy = r.psi;
  return state;
}

}  // namespace elastogen
