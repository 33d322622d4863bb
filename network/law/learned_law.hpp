// SPDX-License-Identifier: Apache-2.0
// The material of a voxel as the solvers see it: an analytic law, or a net that stands for it
// inside the box that it was fitted in.
//
//     psi = w psi_theta + (1 - w) psi_law,     w = prod_i r(|e_i|; 0.9, 1.25) r(|tr e|; ln 2, 1.2),
//
// r falls from 1 to 0 as a polynomial of degree five, so psi is C2 everywhere: psi_theta at rest,
// and far away the law with its extension to inverted states. Gent's law is singular at a limit of
// I1 - 3; its box ends at 0.9 of the limit, by one more factor r((I1 - 3)/limit; 0.9, 1.5).

#pragma once

#include "core/elastic_law.hpp"
#include "core/spectrum3.hpp"
#include "network/law/mtl_table.hpp"
#include "network/law/neural_mtl.hpp"

#include <memory>
#include <span>
#include <string>

namespace elastogen {

/// Bounds of |e_i| and |tr e|: of the box that nets are fitted in, and where only the law is left.
inline constexpr double kFittedStretch = 0.9, kFittedTrace = 0.69314718055994530942;
inline constexpr double kBlendedStretch = MtlTable::kReach, kBlendedTrace = 1.2;
/// These bounds for I1 - 3 over the limit of Gent's law.
inline constexpr double kFittedShare = 0.9, kBlendedShare = 1.5;

/// How psi_theta is evaluated: by a table of its difference to the law, or by the net in float64.
enum class Evaluation : uint8_t { kTable, kNet };

/// A net and the law that it is blended with; shared by materials that differ only in E.
class LearnedLaw {
 public:
  /// @param weights  of the net; @param law, poisson  that it was fitted to.
  /// @param hash     of its file, in hexadecimal.
  /// @throws Error (asset) as NeuralMtl.
  LearnedLaw(std::span<const float> weights, Law law, double poisson, std::string hash,
             Evaluation evaluation = Evaluation::kTable);

  const NeuralMtl& net() const { return net_; }
  const MtlTable& table() const { return table_; }
  Evaluation evaluation() const { return evaluation_; }
  Law law() const { return law_; }
  double poisson() const { return poisson_; }
  const std::string& hash() const { return hash_; }
  const std::vector<float>& weights() const { return weights_; }

  /// (psi - psi_law)/E and its derivatives at n log stretches, (n, 3), in float64 by the net.
  template <bool kHessian>
  void difference(const double* e, int64_t n, LogJet* result) const;
  /// Values alone, as the table needs them: a quarter of the work.
  void difference(const double* e, int64_t n, double* psi) const;

 private:
  std::vector<float> weights_;
  NeuralMtl net_;
  Law law_;
  double poisson_;
  std::string hash_;
  Evaluation evaluation_;
  MtlTable table_;
};

/// Laws of the scene's materials by their index; null or missing: analytic.
using LearnedLaws = std::vector<std::shared_ptr<const LearnedLaw>>;

/// Whether log stretches lie in the box that nets of a law are fitted in.
template <class T>
ELASTOGEN_HD inline auto in_fitted_box(const Law& law, const T e[3]) {
  using S = Scalar<T>;
  const T largest = larger(larger(absolute(e[0]), absolute(e[1])), absolute(e[2]));
  const T trace = e[0] + e[1] + e[2];
  auto inside = (largest <= S(kFittedStretch)) & (absolute(trace) <= S(kFittedTrace));
  if (law.kind == Law::Kind::kGent) {
    T excess{};  // I1 - 3 = sum exp(2 e'_i) - 1 - 2 e'_i
    for (int i = 0; i < 3; ++i) excess += law::continued_exp(T(2 * (e[i] - trace / 3))).value;
    inside = inside & (excess <= S(kFittedShare * law.shape));
  }
  return decltype(largest < S(1))(inside);
}

/// E = mu (3 lambda + 2 mu)/(lambda + mu).
template <class S>
ELASTOGEN_HD inline S young_of(const LawParameters<S>& law) {
  return law.mu * (3 * law.lambda + 2 * law.mu) / (law.lambda + law.mu);
}

/// Response of a law plus the correction by a net, E times `difference(e)` in the log stretches e:
///
///     t_i = w_i/s_i,     H_ij = (w_ij - d_ij w_i)/(s_i s_j).
///
/// @param outside  gets 1 where the stretches are out of the fitted box, else 0.
template <bool kHessian, class T, class Difference>
ELASTOGEN_HD inline Response<T> corrected_response(const LawParameters<Scalar<T>>& law,
                                                   const T s[3], const Difference& difference,
                                                   T& outside) {
  using S = Scalar<T>;
  constexpr S kSmallest = S(0.1), kLargest = S(10);  // there the difference is 0
  // log stretches, of stretches within these bounds
  T e[3], safe[3], inverse[3];
  for (int i = 0; i < 3; ++i) {
    safe[i] = smaller(larger(s[i], constant<T>(kSmallest)), constant<T>(kLargest));
    e[i] = log_1p(T(safe[i] - 1));
  }
  outside = in_fitted_box(law.law, e) ? T{} : constant<T>(1);
  const S young = young_of(law);
  // the law, then the difference in terms of stretches
  Response<T> r = elastic_response<kHessian>(law, s);
  const LogResponse<T> d = difference(e);
  r.psi += young * d.psi;
  for (int i = 0; i < 3; ++i) {
    inverse[i] = 1 / safe[i];
    r.t[i] += young * d.w[i] * inverse[i];
  }
  if constexpr (kHessian)
    for (int c = 0; c < 6; ++c) {  // 00, 11, 22, 01, 12, 20
      const T curvature = c < 3 ? T(d.ww[c] - d.w[c]) : d.ww[c];
      r.H[c] += young * curvature * (inverse[c % 3] * inverse[c < 3 ? c : (c + 1) % 3]);
    }
  return r;
}

/// Adds the correction by a net to energy and second Piola stress of its law at Green's strain
/// E = sum_i E_i v_i v_i^T:
///
///     psi += E D(e),     S += sum_i E w_i/s_i^2 v_i v_i^T,     s_i^2 = 1 + 2 E_i,  e_i = ln s_i.
///
/// @param outside  as above.
template <class T, class Difference>
ELASTOGEN_HD inline void add_difference(const LawParameters<Scalar<T>>& law, const Symmetric3<T>& E,
                                        const Difference& difference, T& psi, Symmetric3<T>& S,
                                        T& outside) {
  const Spectrum3<T> spectrum = spectrum3(E);
  T e[3], square[3], stress[3];
  for (int i = 0; i < 3; ++i) {
    const T twice = 2 * spectrum.value(i);
    square[i] = 1 + twice;
    e[i] = log_1p(twice) / 2;
  }
  outside = in_fitted_box(law.law, e) ? T{} : constant<T>(1);
  const auto young = young_of(law);
  const LogResponse<T> d = difference(e);
  psi += young * d.psi;
  const T scale = young / (square[0] * square[1] * square[2]);
  for (int i = 0; i < 3; ++i)
    stress[i] = scale * d.w[i] * (square[(i + 1) % 3] * square[(i + 2) % 3]);
  const Symmetric3<T> more = spectrum.isotropic(stress);
  for (int k = 0; k < 6; ++k) S.m[k] += more.m[k];
}

/// D of a net with its slope, evaluated as learned.evaluation() says.
template <class T>
LogResponse<T> learned_difference(const LearnedLaw& learned, const T e[3]);

/// corrected_response with a net, evaluated as learned.evaluation() says.
template <bool kHessian, class T>
Response<T> learned_response(const LearnedLaw& learned, const LawParameters<Scalar<T>>& law,
                             const T s[3], T& outside);

/// Response of a material: that of its net, or of its law.
template <bool kHessian, class T>
inline Response<T> material_response(const LearnedLaw* learned, const LawParameters<Scalar<T>>& law,
                                     const T s[3], T& outside) {
  if (learned) return learned_response<kHessian>(*learned, law, s, outside);
  outside = T{};
  return elastic_response<kHessian>(law, s);
}

}  // namespace elastogen
