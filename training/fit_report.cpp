// SPDX-License-Identifier: Apache-2.0
#include "training/fit_report.hpp"

#include "core/error.hpp"
#include "training/fit_problem_torch.hpp"
#include "training/strain_sampler.hpp"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr int64_t kChunk = 1000;  // strains at once

/// Rows (nets, strains) on the host, each sorted; what is no number counts as infinite.
at::Tensor sorted_rows(const std::vector<at::Tensor>& chunks) {
  const at::Tensor rows = at::cat(chunks, 1);
  const double infinity = std::numeric_limits<double>::infinity();
  return std::get<0>(rows.nan_to_num(infinity, infinity).sort(1)).to(at::kCPU, at::kDouble);
}

/// Smallest entry of a sorted row that a share of the row does not exceed.
double at_share(const at::Tensor& row, double share) {
  const int64_t n = row.size(0);
  const auto rank = int64_t(std::ceil(share * double(n)));
  return row.data_ptr<double>()[std::clamp<int64_t>(rank - 1, 0, n - 1)];
}

}  // namespace

std::vector<FitReport> fit_reports(const std::vector<FitMaterial>& materials,
                                   const Array<float>& weights, const ReportOptions& options) {
  ELASTOGEN_CHECK(!materials.empty() && weights.rows() == int64_t(materials.size()),
                  "one row of weights is needed a material, got ", weights.rows(), " for ",
                  materials.size());
  ELASTOGEN_CHECK(options.strains > 0, "strains must be positive, got ", options.strains);
  const c10::NoGradGuard no_gradients;
  at::globalContext().setFloat32MatmulPrecision("highest");
  const at::Device device = fit_device(options.device);
  const FitProblem problem(materials, device);
  const MtlNets nets = nets_of_block(block_of_weights(weights, device));

  std::vector<at::Tensor> stress, tangent, energy;
  for (int64_t begin = 0; begin < options.strains; begin += kChunk) {
    const int64_t count = std::min(kChunk, options.strains - begin);
    const Array<double> e = sample_strains(kDeclaredBox, options.seed, uint64_t(begin), count);
    const StrainErrors errors = problem.errors(nets, e, count);
    stress.push_back(errors.stress.sqrt());
    tangent.push_back(errors.tangent.sqrt());
    energy.push_back(errors.energy.abs());
  }

  const at::Tensor stresses = sorted_rows(stress), tangents = sorted_rows(tangent),
                   energies = sorted_rows(energy);
  std::vector<FitReport> reports;
  for (int64_t n = 0; n < weights.rows(); ++n)
    reports.push_back({at_share(stresses[n], 0.5), at_share(stresses[n], 0.99),
                       at_share(stresses[n], 1), at_share(tangents[n], 0.99),
                       at_share(energies[n], 1), options.strains});
  return reports;
}

}  // namespace elastogen
