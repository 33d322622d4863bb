// SPDX-License-Identifier: Apache-2.0
// Nets for unseen materials after gradient steps, by where they start: the fine-tuning of the
// ElastoGen paper, to compare with the Levenberg-Marquardt iterations of bench/generation.cpp. All
// materials of a start are fitted at once (training/fit_neural_mtl.hpp, all layers, SOAP). Each
// number of steps has a run of its own, whose rate falls to 0, with each of two rates.
//
//   fine_tuning FOLDER [--count N] [--seed S] [--device cpu|cuda] [--json FILE]
//
// FOLDER has hidden.tensors and generator.tensors. Prints a Markdown table. Each row has the better
// of the two rates, by the number of nets that pass.

#include "bench/generation_arguments.hpp"
#include "core/parallel.hpp"
#include "diffusion/material_family.hpp"
#include "training/fit_neural_mtl.hpp"
#include "training/fit_report.hpp"

#include <algorithm>
#include <cstdio>
#include <sstream>

namespace elastogen::bench {
namespace {

constexpr int64_t kStrains = 4000;  // strains of a report
constexpr int64_t kSteps[] = {0, 100, 300, 1000};
constexpr double kRates[] = {3e-3, 3e-4};
constexpr double kNearIncompressible = 0.48;

constexpr const char* kUsage =
    "usage: fine_tuning FOLDER [--count N] [--seed S] [--device cpu|cuda] [--json FILE]";

/// Weights from which each net starts, (materials, 17153).
struct Beginning {
  std::string name;
  std::vector<float> weights;
};

std::vector<Beginning> beginnings(const Arguments& arguments,
                                  const std::vector<FitMaterial>& materials) {
  const std::vector<float> hidden = read_hidden(arguments.folder);
  const WeightGenerator generator = read_generator(arguments.folder + "/generator.tensors", hidden);
  const std::vector<float> drawn = initial_weights(arguments.seed);
  std::vector<Beginning> all = {{"scratch", {}}};
  for (size_t n = 0; n < materials.size(); ++n)
    all[0].weights.insert(all[0].weights.end(), drawn.begin(), drawn.end());
  for (const Start start : kStarts) {
    if (start == Start::kDiffusion && !generator.has_denoiser()) continue;
    all.push_back({name_of(start), {}});
    for (size_t n = 0; n < materials.size(); ++n) {
      std::vector<float> net = hidden;
      const std::vector<float> last = generator.last_layer(materials[n], start, n);
      std::copy(last.begin(), last.end(), net.end() - kMtlLast);
      all.back().weights.insert(all.back().weights.end(), net.begin(), net.end());
    }
  }
  return all;
}

/// Results of all nets of a start after some steps.
struct Outcome {
  double rate = 0, seconds = 0;
  int low = 0, inside_low = 0, inside = 0;  ///< low: nu up to 0.48
  double median = 0, p99 = 0;               ///< of the stress, median net
};

double middle(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + int64_t(values.size()) / 2, values.end());
  return values[values.size() / 2];
}

Outcome judged(const std::vector<FitMaterial>& materials, const float* weights) {
  std::vector<FitReport> reports(materials.size());
  run_tasks(int64_t(materials.size()), [&](int64_t n) {
    ReportOptions options;
    options.strains = kStrains;
    reports[size_t(n)] =
        fit_report(materials[size_t(n)], {weights + n * kMtlParameters, kMtlParameters}, options);
  });
  Outcome outcome;
  std::vector<double> median, p99;
  for (size_t n = 0; n < materials.size(); ++n) {
    const bool low = materials[n].poisson <= kNearIncompressible;
    outcome.low += low;
    outcome.inside += reports[n].passes();
    outcome.inside_low += low && reports[n].passes();
    median.push_back(reports[n].stress_median), p99.push_back(reports[n].stress_p99);
  }
  outcome.median = middle(median), outcome.p99 = middle(p99);
  return outcome;
}

Outcome tuned(const Arguments& arguments, const std::vector<FitMaterial>& materials,
              const Beginning& beginning, int64_t steps) {
  if (steps == 0) return judged(materials, beginning.weights.data());
  Outcome best;
  for (const double rate : kRates) {
    FitOptions options;
    options.steps = steps, options.warm_up = std::max<int64_t>(1, steps / 10);
    options.start = beginning.weights;
    options.rate = rate;
    options.device = arguments.device;
    const FitOutcome fit = fit_neural_mtl(materials, options);
    Outcome outcome = judged(materials, fit.weights.data());
    outcome.rate = rate, outcome.seconds = fit.seconds;
    if (best.rate == 0 || outcome.inside > best.inside) best = outcome;
  }
  return best;
}

void run(const Arguments& arguments) {
  // materials of the family, by number
  std::vector<FitMaterial> materials;
  for (int64_t n = 0; n < arguments.count; ++n)
    materials.push_back(family_material(arguments.seed, uint64_t(n)));
  std::printf(
      "| begins at | steps | rate | inside all limits | nu up to 0.48 | stress, median net: "
      "median [%%] | p99 [%%] | all nets at once [s] |\n|---|---|---|---|---|---|---|---|\n");
  std::ostringstream rows;
  // a row for each start and number of steps: printed, and kept for JSON
  for (const Beginning& beginning : beginnings(arguments, materials))
    for (const int64_t steps : kSteps) {
      const Outcome o = tuned(arguments, materials, beginning, steps);
      const double share = o.inside / double(materials.size()), low = o.inside_low / double(o.low);
      std::printf("| %s | %lld | %g | %.1f %% | %.1f %% | %.2g | %.2g | %.2f |\n",
                  beginning.name.c_str(), static_cast<long long>(steps), o.rate, 100 * share,
                  100 * low, 100 * o.median, 100 * o.p99, o.seconds);
      std::fflush(stdout);
      rows << (rows.tellp() ? ",\n  " : "") << R"({"start": ")" << beginning.name
           << R"(", "steps": )" << steps << R"(, "rate": )" << o.rate << R"(, "inside": )" << share
           << R"(, "inside_to_048": )" << low << R"(, "median": )" << o.median << R"(, "p99": )"
           << o.p99 << R"(, "seconds": )" << o.seconds << '}';
    }
  // the JSON file
  if (arguments.json.empty()) return;
  std::ostringstream json;
  json << R"({"seed": )" << arguments.seed << R"(, "materials": )" << materials.size()
       << R"(, "strains": )" << kStrains << ", \"rows\": [\n  " << rows.str() << "]}\n";
  write_file(arguments.json, json.str());
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  try {
    elastogen::bench::run(elastogen::bench::arguments_of(argc, argv, elastogen::bench::kUsage));
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "fine_tuning: %s\n", error.what());
    return 1;
  }
}
