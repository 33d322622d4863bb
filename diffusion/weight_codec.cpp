// SPDX-License-Identifier: Apache-2.0
#include "diffusion/weight_codec.hpp"

#include "core/error.hpp"
#include "diffusion/double_tensors.hpp"
#include "training/last_layer_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kWidth = kMtlWidthOfLast;
// share of the trace added to the diagonal: directions that no stress depends on stay as they are
constexpr double kRidge = 1e-14;

using Square = Eigen::Matrix<double, kWidth, kWidth>;
using CodeRows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

CodeRows doubles(In<float> layers) {
  return Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
             layers.data, layers.rows, layers.cols)
      .cast<double>();
}

Eigen::Map<const CodeRows> map(const Array<double>& array) {
  return {array.data(), array.rows(), array.cols()};
}

Array<double> array(const CodeRows& rows) {
  Array<double> result(rows.rows(), int(rows.cols()));
  std::copy_n(rows.data(), rows.size(), result.data());
  return result;
}

}  // namespace

WeightCodec::WeightCodec(In<float> layers, In<double> metric, int components) {
  // two layers at least, and a metric of their size
  ELASTOGEN_CHECK(layers.rows > 1 && layers.cols == kWidth, "a codec needs two last layers of ",
                  kWidth, " weights, got ", layers);
  ELASTOGEN_CHECK(metric.is(kWidth, kWidth) && components > 0,
                  "the metric must be (128, 128) and components positive, got ", metric, " and ",
                  components);
  // the factor L of the metric
  Square M = Eigen::Map<const CodeRows>(metric.data, kWidth, kWidth);
  M.diagonal().array() += kRidge * M.trace();
  const Eigen::LLT<Square> factor(M);
  ELASTOGEN_CHECK(factor.info() == Eigen::Success, "the metric is not positive");
  // principal components of z = L^T (w - mean w)
  CodeRows w = doubles(layers);
  const Eigen::RowVectorXd mean = w.colwise().mean();
  w.rowwise() -= mean;
  const Square L = factor.matrixL();
  const CodeRows z = w * L;
  const Square covariance = z.transpose() * z / double(layers.rows);
  const Eigen::SelfAdjointEigenSolver<Square> solved(covariance);  // the smallest eigenvalue first
  const auto kept = int(std::min<int64_t>({components, kWidth, layers.rows - 1}));
  const CodeRows P = solved.eigenvectors().rightCols(kept).rowwise().reverse();
  // maps to codes and back
  mean_ = array(mean);
  to_ = array(P.transpose() * L.transpose());
  from_ = array(factor.matrixU().solve(P));
  // spread of the kept components, and what the others lose
  for (int k = 0; k < kWidth; ++k) {
    const double variance = std::max(solved.eigenvalues()[kWidth - 1 - k], 0.0);
    if (k < kept)
      scale_.push_back(std::sqrt(variance));
    else
      lost_ += variance;
  }
  lost_ = std::sqrt(lost_);
}

WeightCodec::WeightCodec(const TensorFile& file) {
  const auto count = int(get_count(file, "codec.components", 1, kWidth));
  mean_ = get_doubles(file, "codec.mean", 1, kWidth);
  to_ = get_doubles(file, "codec.to", count, kWidth);
  from_ = get_doubles(file, "codec.from", kWidth, count);
  const std::vector<float>& scale = file.get("codec.scale", {count}).values;
  scale_.assign(scale.begin(), scale.end());
  ELASTOGEN_CHECK_ASSET(std::all_of(scale.begin(), scale.end(), [](float s) { return s >= 0; }),
                        "'codec.scale' has a negative number");
  lost_ = file.get("codec.lost", {1}).values[0];
}

void WeightCodec::write(TensorFile& file) const {
  file.text["codec.components"] = std::to_string(components());
  add_doubles(file, "codec.mean", mean_);
  add_doubles(file, "codec.to", to_);
  add_doubles(file, "codec.from", from_);
  file.tensors.push_back({"codec.scale", {components()}, {scale_.begin(), scale_.end()}});
  file.tensors.push_back({"codec.lost", {1}, {float(lost_)}});
}

Array<double> WeightCodec::encode(In<float> layers) const {
  ELASTOGEN_CHECK(layers.cols == kWidth, "a last layer has ", kWidth, " weights, got ", layers);
  CodeRows w = doubles(layers);
  w.rowwise() -= Eigen::RowVectorXd(map(mean_));
  return array(w * map(to_).transpose());
}

std::vector<float> WeightCodec::decode(std::span<const double> code) const {
  ELASTOGEN_CHECK(int(code.size()) == components(), "a code has ", components(), " numbers, not ",
                  code.size());
  const Eigen::Map<const Eigen::VectorXd> c(code.data(), components());
  const Eigen::VectorXd w = map(mean_).transpose() + map(from_) * c;
  std::vector<float> layer(kWidth);
  for (int k = 0; k < kWidth; ++k) layer[size_t(k)] = float(w[k]);
  return layer;
}

std::optional<WeightCodec> make_codec(const WeightDataset& data, int components,
                                      const FitHooks& hooks) {
  const LastLayer layer(data.hidden);
  Array<double> mean(kWidth, kWidth);
  for (int64_t n = 0; n < data.count(); ++n) {
    if (hooks.stopped()) return std::nullopt;
    const float* const w = data.layers.row(n);
    const Array<double> metric =
        layer.stress_metric(data.materials[size_t(n)], std::vector<double>(w, w + kWidth));
    for (int64_t k = 0; k < mean.size(); ++k)
      mean.data()[k] += metric.data()[k] / double(data.count());
  }
  WeightCodec codec(data.layers, mean, components);
  hooks.say(concat("codec: ", codec.components(), " components, root mean square of the rest ",
                   codec.lost()));
  return codec;
}

}  // namespace elastogen
