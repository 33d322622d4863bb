// SPDX-License-Identifier: Apache-2.0
#include "network/law/mtl_weights.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <random>

namespace elastogen {
namespace {

/// A number of the model card.
double card_number(const TensorFile& file, const std::string& key, const std::string& place) {
  const auto found = file.text.find(key);
  ELASTOGEN_CHECK_ASSET(found != file.text.end(), place, ": the model card has no '", key, "'");
  double value = 0;
  const std::string& text = found->second;
  const auto read = std::from_chars(text.data(), text.data() + text.size(), value);
  ELASTOGEN_CHECK_ASSET(read.ec == std::errc() && read.ptr == text.data() + text.size(), place,
                        ": '", key, "' of the model card is no number: '", text, "'");
  return value;
}

/// Draws a strain from the box of a law; a small one from a sphere around rest.
void draw(const Law& law, std::mt19937_64& random, bool small, double e[3]) {
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  do {
    double length2 = 0;
    for (int i = 0; i < 3; ++i) {
      e[i] = small ? normal(random) : kFittedStretch * uniform(random);
      length2 += e[i] * e[i];
    }
    const double radius =
        kFittedStretch * std::pow(1e-4 / kFittedStretch, (uniform(random) + 1) / 2);
    for (int i = 0; small && i < 3; ++i) e[i] *= radius / std::sqrt(length2);
  } while (!in_fitted_box(law, e));
}

template <int kCount>
double length(const double* values) {
  double sum = 0;
  for (int k = 0; k < kCount; ++k) sum += values[k] * values[k];
  return std::sqrt(sum);
}

/// |H|_F of six entries.
double matrix_length(const double H[6]) {
  const double diagonal = length<3>(H), off = length<3>(H + 3);
  return std::sqrt(diagonal * diagonal + 2 * off * off);
}

}  // namespace

bool within(const FitErrors& e, const FitErrors& limits) {
  return e.stress_median <= limits.stress_median && e.stress_p99 <= limits.stress_p99 &&
         e.stress_max <= limits.stress_max && e.tangent_p99 <= limits.tangent_p99;
}

FitErrors fit_errors(const LearnedLaw& learned, int count, uint64_t seed) {
  const LawParameters<double> law{learned.law(), learned.net().mu(), learned.net().lambda()};
  const double floor = 1e-4 * (2 * law.mu + law.lambda);
  std::mt19937_64 random(seed);
  std::vector<double> e(3 * size_t(count)), stress(static_cast<size_t>(count)), tangent(stress);
  for (int k = 0; k < count; ++k) draw(learned.law(), random, k % 2 == 0, e.data() + 3 * k);
  for_each(count, [&](int64_t k) {
    double s[3], t[3], H[6], outside;
    for (int64_t i = 0; i < 3; ++i) s[i] = std::exp(e[size_t(3 * k + i)]);
    const Response<double> r = learned_response<true>(learned, law, s, outside);
    const Response<double> exact = elastic_response<true>(law, s);
    for (int i = 0; i < 3; ++i) t[i] = r.t[i] - exact.t[i];
    for (int c = 0; c < 6; ++c) H[c] = r.H[c] - exact.H[c];
    stress[size_t(k)] = length<3>(t) / (length<3>(exact.t) + floor);
    tangent[size_t(k)] = matrix_length(H) / matrix_length(exact.H);
  });
  std::sort(stress.begin(), stress.end());
  std::sort(tangent.begin(), tangent.end());
  const auto at = [&](const std::vector<double>& values, double share) {
    return values[size_t(share * double(count - 1))];
  };
  return {at(stress, 0.5), at(stress, 0.99), stress.back(), at(tangent, 0.99)};
}

std::string weight_file_name(Law law, double poisson) {
  char digits[32];
  const auto end = std::to_chars(digits, digits + sizeof digits, poisson).ptr;
  return concat(law_name(law), '-', std::string_view(digits, end), ".weights");
}

std::shared_ptr<const LearnedLaw> read_weights(std::string_view bytes, const std::string& place,
                                               Law law, double poisson, Evaluation evaluation) {
  const TensorFile file = decode_tensors(bytes, place);
  const auto form = file.text.find("form");
  ELASTOGEN_CHECK_ASSET(form != file.text.end() && form->second == kMtlForm, place,
                        ": the weights are of another form of NeuralMTL than '", kMtlForm, "'");
  const auto name = file.text.find("law");
  ELASTOGEN_CHECK_ASSET(name != file.text.end() && name->second == law_name(law), place,
                        ": not the weights of ", law_name(law));
  const double fitted = card_number(file, "poisson", place);
  ELASTOGEN_CHECK_ASSET(fitted == poisson, place, ": weights of Poisson ratio ", fitted, ", not ",
                        poisson);
  const FitErrors errors{
      card_number(file, "error.stress.median", place), card_number(file, "error.stress.p99", place),
      card_number(file, "error.stress.max", place), card_number(file, "error.tangent.p99", place)};
  ELASTOGEN_CHECK_ASSET(within(errors), place, ": the fit is not good enough: stress errors ",
                        errors.stress_median, " / ", errors.stress_p99, " / ", errors.stress_max,
                        ", tangent ", errors.tangent_p99);
  const Tensor& weights = file.get("neural_mtl", {NeuralMtl::kParameters});
  return std::make_shared<LearnedLaw>(weights.values, law, poisson, hex(sha256(bytes)), evaluation);
}

}  // namespace elastogen
