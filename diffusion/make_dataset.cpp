// SPDX-License-Identifier: Apache-2.0
#include "diffusion/make_dataset.hpp"

#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "diffusion/hidden_hash.hpp"
#include "diffusion/material_family.hpp"
#include "diffusion/material_features.hpp"
#include "io/safe_file.hpp"
#include "training/last_layer_fit.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <numeric>

namespace elastogen {
namespace {

constexpr int64_t kNeighbours = 8, kStarts = 3;
constexpr double kMuchHigher = 3, kLeast = 1e-6;  // errors below need no second fit
constexpr int64_t kFitsOfLine = 16;

std::vector<FitMaterial> family(const MakeDatasetOptions& options) {
  std::vector<FitMaterial> materials;
  for (int64_t n = 0; n < options.count; ++n)
    materials.push_back(family_material(options.seed, uint64_t(n)));
  return materials;
}

class Run {
 public:
  Run(const std::vector<float>& hidden, const MakeDatasetOptions& options, const FitHooks& hooks)
      : options_(options),
        hooks_(hooks),
        layer_(hidden, layer_options(options)),
        data_(empty_dataset(hidden, family(options))),
        tree_(tree_order(data_.features)) {
    if (options.resume) load();
  }

  MadeDataset run() {
    begin_ = fits_;
    while (fits_ < options_.count && !hooks_.stopped()) {
      fit_next();
      const bool last = fits_ == options_.count;
      if (last || fits_ % kFitsOfLine == 0) say_progress();
      if (last || fits_ % options_.checkpoint_fits == 0) save();
    }
    if (fits_ < options_.count) {
      save();
      return {{}, fits_, 0};
    }
    const int64_t again = fit_again();
    if (again < 0) return {{}, fits_, 0};
    return {std::move(data_), fits_, again};
  }

 private:
  static LastLayerOptions layer_options(const MakeDatasetOptions& options) {
    LastLayerOptions result;
    result.iterations = options.iterations;
    result.strains = options.strains;
    return result;
  }

  std::span<const float> layer_of(const Array<float>& layers, int64_t n) const {
    return {layers.row(n), size_t(layers.cols())};
  }

  /// Stores a fit of material n and its report.
  void keep(int64_t n, const LastLayerFit& fit) {
    ReportOptions judged;
    judged.strains = options_.judged;
    const FitReport report = fit_report(data_.materials[size_t(n)], fit.weights, judged);
    std::copy_n(fit.weights.end() - kMtlLast, kMtlWidthOfLast, data_.layers.row(n));
    double* const errors = data_.errors.row(n);
    errors[0] = report.stress_median, errors[1] = report.stress_p99;
    errors[2] = report.stress_max, errors[3] = report.tangent_p99;
    data_.rms[size_t(n)] = fit.error;
    data_.iterations[size_t(n)] = fit.iterations;
  }

  void fit_next() {
    const int64_t n = tree_.order[size_t(fits_)], parent = tree_.parent[size_t(fits_)];
    const FitMaterial& material = data_.materials[size_t(n)];
    keep(n,
         parent < 0 ? layer_.fit(material) : layer_.fit(material, layer_of(data_.layers, parent)));
    ++fits_;
  }

  /// Materials with an error much above the median error of their neighbours.
  std::vector<int64_t> too_high() const {
    std::vector<int64_t> numbers;
    for (int64_t n = 0; n < options_.count; ++n) {
      std::vector<double> errors;
      for (const int64_t k : nearest_rows(data_.features, data_.features.row(n), kNeighbours, n))
        errors.push_back(data_.rms[size_t(k)]);
      if (errors.empty()) continue;
      std::nth_element(errors.begin(), errors.begin() + int64_t(errors.size()) / 2, errors.end());
      const double limit = std::max(kMuchHigher * errors[errors.size() / 2], kLeast);
      if (data_.rms[size_t(n)] > limit) numbers.push_back(n);
    }
    return numbers;
  }

  /// Fits these materials again, starting from their neighbours' layers of the first pass.
  /// @return how many ended lower, -1 if stopped.
  int64_t fit_again() {
    const Array<float> first = data_.layers;
    const std::vector<int64_t> numbers = too_high();
    int64_t lower = 0;
    for (const int64_t n : numbers) {
      if (hooks_.stopped()) return -1;
      bool better = false;
      for (const int64_t k : nearest_rows(data_.features, data_.features.row(n), kStarts, n)) {
        const LastLayerFit fit = layer_.fit(data_.materials[size_t(n)], layer_of(first, k));
        if (fit.error >= data_.rms[size_t(n)]) continue;
        keep(n, fit);
        better = true;
      }
      lower += better;
    }
    hooks_.say(
        concat(numbers.size(), " fitted again from their neighbours, ", lower, " ended lower"));
    return lower;
  }

  void say_progress() const {
    std::vector<double> errors;
    int64_t inside = 0;
    for (int64_t k = 0; k < fits_; ++k) {
      errors.push_back(data_.rms[size_t(tree_.order[size_t(k)])]);
      inside += data_.passes(tree_.order[size_t(k)]);
    }
    std::nth_element(errors.begin(), errors.begin() + fits_ / 2, errors.end());
    char line[160];
    std::snprintf(line, sizeof line,
                  "fit %6lld of %lld: median error %.2e, %lld inside all limits, %.0f ms a fit",
                  static_cast<long long>(fits_), static_cast<long long>(options_.count),
                  errors[size_t(fits_ / 2)], static_cast<long long>(inside),
                  watch_.milliseconds() / double(fits_ - begin_));
    hooks_.say(line);
  }

  std::vector<int64_t> done() const { return {tree_.order.begin(), tree_.order.begin() + fits_}; }

  /// Writes the checkpoint: the fits so far as a dataset, in the order of the tree.
  void save() const {
    if (options_.checkpoint.empty() || fits_ == 0) return;
    write_file(options_.checkpoint, encode_dataset(dataset_rows(data_, done())));
  }

  void load() {
    if (!std::filesystem::exists(options_.checkpoint)) return;
    const WeightDataset part = decode_dataset(read_file(options_.checkpoint), options_.checkpoint);
    bool same = part.count() <= options_.count && part.hidden == data_.hidden;
    for (int64_t k = 0; same && k < part.count(); ++k)
      same = part.materials[size_t(k)].name == data_.materials[size_t(tree_.order[size_t(k)])].name;
    ELASTOGEN_CHECK_ASSET(same, options_.checkpoint,
                          ": a checkpoint of other materials or hidden layers");
    for (; fits_ < part.count(); ++fits_) {
      const int64_t n = tree_.order[size_t(fits_)];
      std::copy_n(part.layers.row(fits_), part.layers.cols(), data_.layers.row(n));
      std::copy_n(part.errors.row(fits_), part.errors.cols(), data_.errors.row(n));
      data_.rms[size_t(n)] = part.rms[size_t(fits_)];
      data_.iterations[size_t(n)] = part.iterations[size_t(fits_)];
    }
    hooks_.say(concat("resumed after ", fits_, " fits"));
  }

  const MakeDatasetOptions& options_;
  const FitHooks& hooks_;
  LastLayer layer_;
  WeightDataset data_;
  TreeOrder tree_;
  int64_t fits_ = 0, begin_ = 0;
  Stopwatch watch_;
};

}  // namespace

TreeOrder tree_order(In<double> features) {
  const int64_t n = features.rows;
  TreeOrder tree;
  const std::vector<double> root = material_features(fit_material("hencky", 0.3));
  std::vector<double> distance;  // to the nearest material in the tree; at first to the root
  for (int64_t k = 0; k < n; ++k)
    distance.push_back(feature_distance(features.row(k), root.data()));
  std::vector<int64_t> nearest(size_t(n), -1);
  for (bool first = true; int64_t(tree.order.size()) < n; first = false) {
    const int64_t next = std::min_element(distance.begin(), distance.end()) - distance.begin();
    tree.order.push_back(next);
    tree.parent.push_back(nearest[size_t(next)]);
    for (int64_t k = 0; k < n; ++k) {
      const double d = feature_distance(features.row(k), features.row(next));
      const bool inside = distance[size_t(k)] == std::numeric_limits<double>::infinity();
      if (inside || (!first && d >= distance[size_t(k)])) continue;
      distance[size_t(k)] = d, nearest[size_t(k)] = next;
    }
    distance[size_t(next)] = std::numeric_limits<double>::infinity();
  }
  return tree;
}

std::vector<int64_t> nearest_rows(In<double> features, const double* x, int64_t count,
                                  int64_t except) {
  std::vector<std::pair<double, int64_t>> all;
  for (int64_t k = 0; k < features.rows; ++k)
    if (k != except) all.emplace_back(feature_distance(features.row(k), x), k);
  const int64_t kept = std::min(count, int64_t(all.size()));
  std::partial_sort(all.begin(), all.begin() + kept, all.end());
  std::vector<int64_t> rows;
  for (int64_t k = 0; k < kept; ++k) rows.push_back(all[size_t(k)].second);
  return rows;
}

MadeDataset make_dataset(const std::vector<float>& hidden, const MakeDatasetOptions& options,
                         const FitHooks& hooks) {
  ELASTOGEN_CHECK(options.count > 0 && options.iterations > 0 && options.strains > 0 &&
                      options.judged > 0 && options.checkpoint_fits > 0,
                  "count, iterations and strains must be positive, got ", options.count, ", ",
                  options.iterations, " and ", options.strains);
  return Run(hidden, options, hooks).run();
}

}  // namespace elastogen
