// SPDX-License-Identifier: Apache-2.0
#include "diffusion/start_fit.hpp"

#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "diffusion/weight_dataset.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// A last layer during the fit, and the time of it.
struct Moment {
  std::vector<float> layer;
  double seconds = 0;
};

}  // namespace

std::vector<StartFit> fit_from(const LastLayer& layer, std::span<const float> hidden,
                               const FitMaterial& material, std::span<const float> start,
                               std::span<const int> iterations, const ReportOptions& judged) {
  ELASTOGEN_CHECK(int(start.size()) == kMtlWidthOfLast, "a last layer has ", kMtlWidthOfLast,
                  " weights, not ", start.size());
  ELASTOGEN_CHECK(!iterations.empty() && iterations[0] == 0 &&
                      std::is_sorted(iterations.begin(), iterations.end()),
                  "iterations to report after must ascend from 0");
  std::vector<Moment> moments = {{{start.begin(), start.end()}, 0}};
  const Stopwatch watch;
  const LastLayerFit last = layer.fit(material, start, [&](int done, std::span<const double> w) {
    if (std::find(iterations.begin() + 1, iterations.end(), done) != iterations.end())
      moments.push_back({{w.begin(), w.end()}, watch.seconds()});
  });
  const double seconds = watch.seconds();
  const auto ended = last.weights.end() - kMtlLast;
  // the fit ended before the other iterations: they have its last layer
  while (moments.size() < iterations.size())
    moments.push_back({{ended, ended + kMtlWidthOfLast}, seconds});
  std::vector<StartFit> fits;
  for (size_t k = 0; k < iterations.size(); ++k) {
    fits.push_back({iterations[k], moments[k].layer, {}, moments[k].seconds, 0});
    StartFit& fit = fits.back();
    if (k > 0 && fit.layer == fits[k - 1].layer) {
      fit.report = fits[k - 1].report;
      continue;
    }
    std::vector<float> weights(hidden.begin(), hidden.end());
    std::copy(fit.layer.begin(), fit.layer.end(), weights.end() - kMtlLast);
    const Stopwatch judging;
    fit.report = fit_report(material, weights, judged);
    fit.report_seconds = judging.seconds();
  }
  return fits;
}

}  // namespace elastogen
