// SPDX-License-Identifier: Apache-2.0
#include "training/fit_report.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "network/law/neural_mtl.hpp"
#include "training/law_targets.hpp"
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

/// |H|_F from six entries.
double matrix_norm(const double H[6]) {
  double sum = 0;
  for (int c = 0; c < 6; ++c) sum += (c < 3 ? 1 : 2) * H[c] * H[c];
  return std::sqrt(sum);
}

double finite(double error) {
  return std::isfinite(error) ? error : std::numeric_limits<double>::infinity();
}

/// Errors of a net, from its jet at log stretches e, with M = 2 mu + lambda.
void write_errors(const LogJet& jet, const TargetLaw& law, const double* e, double modulus,
                  size_t s, StrainErrors& to) {
  constexpr int kFirst[6] = {0, 1, 2, 0, 1, 2}, kSecond[6] = {0, 1, 2, 1, 2, 0};
  const Response<double> exact = target_response(law, e);
  double dt = 0, t = 0, dH[6];
  for (int m = 0; m < 3; ++m) {
    const double difference = jet.w[m] * std::exp(-e[m]) - exact.t[m];
    dt += difference * difference, t += exact.t[m] * exact.t[m];
  }
  for (int c = 0; c < 6; ++c) {
    const double h = (jet.ww[c] - (c < 3 ? jet.w[c] : 0)) * std::exp(-e[kFirst[c]] - e[kSecond[c]]);
    dH[c] = h - exact.H[c];
  }
  to.stress[s] = finite(std::sqrt(dt) / (std::sqrt(t) + 1e-4 * modulus));
  to.tangent[s] = finite(matrix_norm(dH) / matrix_norm(exact.H));
  to.energy[s] = finite(std::abs(jet.psi - exact.psi) / (exact.psi + 1e-6 * modulus));
}

/// The smallest entry that a share of all entries do not exceed.
double at_share(std::vector<double>& values, double share) {
  const auto n = int64_t(values.size());
  const int64_t rank = std::clamp<int64_t>(int64_t(std::ceil(share * double(n))), 1, n);
  std::nth_element(values.begin(), values.begin() + (rank - 1), values.end());
  return values[size_t(rank - 1)];
}

}  // namespace

StrainErrors strain_errors(const FitMaterial& material, std::span<const float> weights,
                           const Array<double>& e) {
  const NeuralMtl net(weights, material.poisson);
  const TargetLaw law = target_law(material);
  const double modulus = 2 * material.mu() + material.lambda();
  const auto strains = size_t(e.rows());
  StrainErrors errors{std::vector<double>(strains), std::vector<double>(strains),
                      std::vector<double>(strains)};
  for_blocks(
      e.rows(),
      [&](int64_t begin, int64_t end) {
        std::vector<LogJet> jets(size_t(end - begin));
        net.evaluate<true>(e.row(begin), end - begin, jets.data());
        for (int64_t s = begin; s < end; ++s)
          write_errors(jets[size_t(s - begin)], law, e.row(s), modulus, size_t(s), errors);
      },
      256);
  return errors;
}

FitReport report_of(StrainErrors errors) {
  FitReport report;
  report.strains = int64_t(errors.stress.size());
  report.stress_median = at_share(errors.stress, 0.5);
  report.stress_p99 = at_share(errors.stress, 0.99);
  report.stress_max = at_share(errors.stress, 1);
  report.tangent_p99 = at_share(errors.tangent, 0.99);
  report.energy_max = at_share(errors.energy, 1);
  return report;
}

FitReport fit_report(const FitMaterial& material, std::span<const float> weights,
                     const ReportOptions& options) {
  ELASTOGEN_CHECK(options.strains > 0, "strains must be positive, got ", options.strains);
  if (!std::all_of(weights.begin(), weights.end(), [](float w) { return std::isfinite(w); })) {
    const double infinity = std::numeric_limits<double>::infinity();
    FitReport report{infinity, infinity, infinity, infinity, infinity};
    report.strains = options.strains;
    return report;
  }
  return report_of(strain_errors(
      material, weights, sample_strains(declared_box(material), options.seed, 0, options.strains)));
}

}  // namespace elastogen
