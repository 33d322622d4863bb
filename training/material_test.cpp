// SPDX-License-Identifier: Apache-2.0
#include "training/material_test.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <span>

namespace elastogen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Range in which the shape parameter of a family is searched, that of law_from_name.
struct ShapeRange {
  double least, most;
  int steps;  ///< of the grid
  bool log;   ///< equal ratios instead of equal differences

  /// Shape at a share of the range, 0 to 1.
  double at(double share) const {
    if (share <= 0 || share >= 1) return share <= 0 ? least : most;
    return log ? least * std::pow(most / least, share) : least + share * (most - least);
  }
};

ShapeRange shape_range(Law::Kind kind) {
  if (kind == Law::Kind::kOgden) return {-20, 20, 160, false};
  if (kind == Law::Kind::kMooneyRivlin) return {0, 1, 40, false};
  return {0.1, 1e6, 84, true};
}

/// States of the points by a law with E = 1; no value without equilibrium.
std::vector<std::optional<LoadState>> states(const Law& law, double poisson,
                                             std::span<const TestPoint> points) {
  const TargetLaw target = target_law({"", {{law, 1}}, poisson});
  std::vector<std::optional<LoadState>> result(points.size());
  for_blocks(
      int64_t(points.size()),
      [&](int64_t begin, int64_t end) {
        for (auto k = size_t(begin); k < size_t(end); ++k)
          result[k] = balanced_state(target, points[k].path, points[k].stretch);
      },
      64);
  return result;
}

double rms(const std::vector<TestPoint>& points) {
  double sum = 0;
  for (const TestPoint& point : points) sum += point.stress * point.stress;
  return std::sqrt(sum / double(points.size()));
}

/// The fit of a law in which only E is open.
TestFit fit_young(const Law& law, double poisson, const std::vector<TestPoint>& points) {
  TestFit fit{.law = law, .stress = {}, .impossible = {}};
  const auto unit = states(law, poisson, points);
  double pp = 0, pP = 0;
  for (size_t k = 0; k < points.size(); ++k) {
    if (!unit[k]) {
      fit.impossible = k, fit.error = kInfinity;
      return fit;
    }
    pp += unit[k]->stress * unit[k]->stress, pP += unit[k]->stress * points[k].stress;
  }
  fit.young = pP / pp;
  double sum = 0, largest = -1;
  for (size_t k = 0; k < points.size(); ++k) {
    fit.stress.push_back(fit.young * unit[k]->stress);
    const double miss = std::abs(fit.stress[k] - points[k].stress);
    sum += miss * miss;
    if (miss > largest) largest = miss, fit.worst = k;
  }
  const double size = rms(points);
  fit.error = std::sqrt(sum / double(points.size())) / size;
  fit.worst_error = largest / size;
  return fit;
}

/// Minimum of f between low and high by golden section, up to a width of 1e-10.
double golden_section(double low, double high, const std::function<double(double)>& f) {
  const double golden = (std::sqrt(5.0) - 1) / 2;
  double a = high - golden * (high - low), b = low + golden * (high - low);
  double fa = f(a), fb = f(b);
  while (high - low > 1e-10) {
    if (fa <= fb) {
      high = b, b = a, fb = fa;
      a = high - golden * (high - low), fa = f(a);
    } else {
      low = a, a = b, fa = fb;
      b = low + golden * (high - low), fb = f(b);
    }
  }
  return (low + high) / 2;
}

/// The fit of a family: the best point of a grid, then golden section between its neighbours.
TestFit fit_family(Law law, double poisson, const std::vector<TestPoint>& points) {
  const ShapeRange range = shape_range(law.kind);
  const auto at = [&](double share) {
    return fit_young({law.kind, range.at(share)}, poisson, points);
  };
  double best = 0, least = kInfinity;
  for (int k = 0; k <= range.steps; ++k) {
    const double share = double(k) / range.steps, error = at(share).error;
    if (error < least) least = error, best = share;
  }
  const double step = 1.0 / range.steps;
  const double share = golden_section(std::max(0.0, best - step), std::min(1.0, best + step),
                                      [&](double s) { return at(s).error; });
  // golden section approaches an end of the range but does not reach it
  TestFit fit = at(best), between = at(share);
  if (between.error < fit.error) fit = between;
  fit.at_end = fit.law.shape == range.least || fit.law.shape == range.most;
  return fit;
}

}  // namespace

TestLaw test_law(const std::string& name) {
  for (const TestLaw& law : test_laws()) {
    if (!law.family) continue;
    const std::string full = law_name(law.law);
    if (full.substr(0, full.find('=')) == name) return law;
  }
  return {law_from_name(name), false};
}

std::vector<TestLaw> test_laws() {
  return {{Law::kHencky},         {Law::kNeoHookean},   {Law::kStableNeoHookean},
          {Law::kFixedCorotated}, {Law::kStvk},         {Law::mooney_rivlin(0), true},
          {Law::gent(100), true}, {Law::ogden(2), true}};
}

TestFit fit_test(const TestLaw& law, double poisson, const std::vector<TestPoint>& points) {
  ELASTOGEN_CHECK(poisson >= 0 && poisson <= 0.499,
                  "Poisson's ratio of a fit must lie in [0, 0.499], got ", poisson);
  ELASTOGEN_CHECK(points.size() >= 2 && rms(points) > 0,
                  "a test has at least two points, and stresses other than 0");
  TestFit fit =
      law.family ? fit_family(law.law, poisson, points) : fit_young(law.law, poisson, points);
  ELASTOGEN_CHECK_ASSET(fit.impossible || fit.young > 0, "the test gives ", law_name(fit.law),
                        " a Young's modulus of ", fit.young,
                        " Pa: stresses are positive in tension and negative in compression");
  return fit;
}

std::vector<TestFit> fit_tests(const std::vector<TestLaw>& laws, double poisson,
                               const std::vector<TestPoint>& points) {
  std::vector<TestFit> fits;
  for (const TestLaw& law : laws) fits.push_back(fit_test(law, poisson, points));
  std::stable_sort(fits.begin(), fits.end(),
                   [](const TestFit& a, const TestFit& b) { return a.error < b.error; });
  return fits;
}

int64_t points_outside(const Law& law, double poisson, const std::vector<TestPoint>& points) {
  const StrainBox box = declared_box({"", {{law, 1}}, poisson});
  int64_t outside = 0;
  for (const std::optional<LoadState>& state : states(law, poisson, points)) {
    if (!state) continue;
    outside += !box.contains(state->e.data());
  }
  return outside;
}

}  // namespace elastogen
