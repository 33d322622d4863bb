// SPDX-License-Identifier: Apache-2.0
#include "diffusion/weight_regression.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "diffusion/double_tensors.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr double kLeastRidge = 1e-12, kLargestRidge = 1e-4;
constexpr int64_t kMostSearched = 1024, kMostKnown = 1 << 16;
constexpr double kFirstLength = 2, kFloor = 1e-8;  // least squared error in a logarithm

using FeatureRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

double distance(const double* x, const double* y, const std::vector<double>& lengths) {
  double sum = 0;
  for (int k = 0; k < kMaterialFeatures; ++k) {
    const double d = (x[k] - y[k]) / lengths[size_t(k)];
    sum += d * d;
  }
  return sum;
}

double matern(double squared) {
  const double r = std::sqrt(5 * squared);
  return (1 + r + r * r / 3) * std::exp(-r);
}

/// Kernel matrix K of two sets of features.
Eigen::MatrixXd kernel(In<double> x, In<double> y, const std::vector<double>& lengths) {
  Eigen::MatrixXd K(x.rows, y.rows);
  for_each(
      y.rows,
      [&](int64_t j) {
        for (int64_t i = 0; i < x.rows; ++i)
          K(i, j) = matern(distance(x.row(i), y.row(j), lengths));
      },
      16);
  return K;
}

/// The solution of (K + ridge) A = B with the least ridge that allows a factorisation.
Eigen::MatrixXd solve(const Eigen::MatrixXd& K, const FeatureRows& B) {
  for (double ridge = kLeastRidge; ridge <= kLargestRidge; ridge *= 10) {
    Eigen::MatrixXd damped = K;
    damped.diagonal().array() += ridge;
    const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(damped);
    if (factor.info() == Eigen::Success) return factor.solve(B);
  }
  throw Error("the kernel matrix of the regression is not positive: a material is there twice");
}

/// The rows of an array that `taken` selects.
Array<double> rows(In<double> from, int64_t count, bool (*taken)(int64_t)) {
  std::vector<int64_t> numbers;
  for (int64_t n = 0; n < count; ++n)
    if (taken(n)) numbers.push_back(n);
  Array<double> result(int64_t(numbers.size()), from.cols);
  for (size_t k = 0; k < numbers.size(); ++k)
    std::copy_n(from.row(numbers[k]), from.cols, result.row(int64_t(k)));
  return result;
}

Eigen::Map<const FeatureRows> mapped(const Array<double>& array) {
  return {array.data(), array.rows(), array.cols()};
}

/// Finds the lengths, coordinate by coordinate.
class LengthSearch {
 public:
  LengthSearch(In<double> features, In<double> codes) {
    const int64_t count = std::min(features.rows, kMostSearched);
    const auto known = [](int64_t n) { return n % 4 != 3; };
    const auto held = [](int64_t n) { return n % 4 == 3; };
    x_ = rows(features, count, known), c_ = rows(codes, count, known);
    held_x_ = rows(features, count, held), held_c_ = rows(codes, count, held);
  }

  std::vector<double> lengths() {
    std::vector<double> best(kMaterialFeatures, kFirstLength);
    if (held_x_.rows() < 4) return best;
    take_best(best, {0.25, 0.5, 1, 2, 4, 8}, [](std::vector<double>& l, double factor) {
      for (double& one : l) one *= factor;
    });
    for (const double factor : {2.0, 1.6, 1.25})
      for (size_t k = 0; k < best.size(); ++k)
        take_best(best, {1 / factor, factor},
                  [k](std::vector<double>& l, double by) { l[k] *= by; });
    return best;
  }

 private:
  /// Replaces the lengths by the best of those that the factors make of them, if it is better.
  template <class Change>
  void take_best(std::vector<double>& best, const std::vector<double>& factors,
                 const Change& change) {
    std::vector<std::vector<double>> all(factors.size(), best);
    std::vector<double> scores(factors.size());
    run_tasks(int64_t(all.size()), [&](int64_t k) {
      change(all[size_t(k)], factors[size_t(k)]);
      scores[size_t(k)] = score(all[size_t(k)]);
    });
    const auto least = size_t(std::min_element(scores.begin(), scores.end()) - scores.begin());
    if (scores[least] >= score_) return;
    best = all[least], score_ = scores[least];
  }

  double score(const std::vector<double>& lengths) const {
    const Eigen::MatrixXd A = solve(kernel(x_, x_, lengths), mapped(c_));
    const FeatureRows miss = kernel(held_x_, x_, lengths) * A - mapped(held_c_);
    return (miss.rowwise().squaredNorm().array() + kFloor).log().mean();
  }

  Array<double> x_, c_, held_x_, held_c_;
  double score_ = std::numeric_limits<double>::infinity();
};

}  // namespace

WeightRegression::WeightRegression(In<double> features, In<double> codes,
                                   std::vector<double> lengths)
    : features_(features.rows, kMaterialFeatures), coefficients_(codes.rows, codes.cols) {
  ELASTOGEN_CHECK(features.rows > 0 && features.rows <= kMostKnown &&
                      features.cols == kMaterialFeatures && codes.rows == features.rows,
                  "a regression needs features (n, ", kMaterialFeatures, ") and n codes, got ",
                  features, " and ", codes);
  for (int64_t k = 0; k < features.size(); ++k) features_.data()[k] = float(features.data[k]);
  lengths_ = lengths.empty() ? LengthSearch(features_, codes).lengths() : std::move(lengths);
  ELASTOGEN_CHECK(lengths_.size() == size_t(kMaterialFeatures) &&
                      std::all_of(lengths_.begin(), lengths_.end(), [](double l) { return l > 0; }),
                  "a regression needs ", kMaterialFeatures, " positive lengths");
  for (double& length : lengths_) length = float(length);
  const FeatureRows B = Eigen::Map<const FeatureRows>(codes.data, codes.rows, codes.cols);
  const FeatureRows A = solve(kernel(features_, features_, lengths_), B);
  std::copy_n(A.data(), A.size(), coefficients_.data());
}

WeightRegression::WeightRegression(const TensorFile& file, int components) {
  const int64_t n = get_count(file, "regression.materials", 1, kMostKnown);
  const std::vector<float>& x = file.get("regression.features", {n, kMaterialFeatures}).values;
  features_ = Array<double>(n, kMaterialFeatures);
  std::copy(x.begin(), x.end(), features_.data());
  const std::vector<float>& l = file.get("regression.lengths", {kMaterialFeatures}).values;
  ELASTOGEN_CHECK_ASSET(std::all_of(l.begin(), l.end(), [](float one) { return one > 0; }),
                        "'regression.lengths' has a number that is not positive");
  lengths_.assign(l.begin(), l.end());
  coefficients_ = get_doubles(file, "regression.coefficients", n, components);
}

void WeightRegression::write(TensorFile& file) const {
  file.text["regression.materials"] = std::to_string(count());
  file.tensors.push_back({"regression.features",
                          {count(), kMaterialFeatures},
                          {features_.data(), features_.data() + features_.size()}});
  file.tensors.push_back(
      {"regression.lengths", {kMaterialFeatures}, {lengths_.begin(), lengths_.end()}});
  add_doubles(file, "regression.coefficients", coefficients_);
}

std::vector<double> WeightRegression::distances(const double* x) const {
  std::vector<double> squared;
  for (int64_t n = 0; n < count(); ++n) squared.push_back(distance(x, features_.row(n), lengths_));
  return squared;
}

std::vector<double> WeightRegression::code(const double* x) const {
  std::vector<double> sum(size_t(coefficients_.cols()));
  const std::vector<double> squared = distances(x);
  for (int64_t n = 0; n < count(); ++n) {
    const double k = matern(squared[size_t(n)]);
    for (size_t c = 0; c < sum.size(); ++c) sum[c] += k * coefficients_(n, int(c));
  }
  return sum;
}

}  // namespace elastogen
