// SPDX-License-Identifier: Apache-2.0
#include "training/last_layer_fit.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "training/law_targets.hpp"
#include "training/strain_sampler.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kWidth = 128, kJet = 30, kResiduals = 10;
constexpr int kFirst[6] = {0, 1, 2, 0, 1, 2}, kSecond[6] = {0, 1, 2, 1, 2, 0};  // channels 4..9
constexpr int64_t kStrainBlock = 64;  // strains of one parallel task

using Rows = Eigen::Matrix<double, Eigen::Dynamic, kWidth, Eigen::RowMajor>;
using Square = Eigen::Matrix<double, kWidth, kWidth>;
using Vector = Eigen::Matrix<double, kWidth, 1>;
using Coefficients = Eigen::Matrix<double, kResiduals, kJet>;
using ConstFloats =
    Eigen::Map<const Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>;

/// Both hidden layers, in double.
struct Hidden {
  explicit Hidden(std::span<const float> weights) {
    const float* next = weights.data();
    const auto take = [&](int rows, int cols) -> Eigen::MatrixXd {
      const ConstFloats part(next, rows, cols);
      next += rows * cols;
      return part.cast<double>();
    };
    W1 = take(kWidth, 3), b1 = take(1, kWidth), W2 = take(kWidth, kWidth), b2 = take(1, kWidth);
  }
  Eigen::MatrixXd W1, b1, W2, b2;
};

/// Passes jets through SiLU. Channel c is the block of `count` rows from c * count; a = act(z),
/// a_m = act' z_m, a_mn = act'' z_m z_n + act' z_mn.
void activate(Rows& z, int64_t count) {
  const auto channel = [&](int c) { return z.middleRows(c * count, count).array(); };
  const Eigen::Array<double, Eigen::Dynamic, kWidth, Eigen::RowMajor> value = channel(0),
                                                                      s = 1 / (1 + (-value).exp()),
                                                                      slope = s * (1 - s),
                                                                      first = s + value * slope,
                                                                      second =
                                                                          slope *
                                                                          (2 + value * (1 - 2 * s));
  for (int c = 0; c < 6; ++c)
    channel(4 + c) =
        second * channel(1 + kFirst[c]) * channel(1 + kSecond[c]) + first * channel(4 + c);
  for (int m = 0; m < 3; ++m) channel(1 + m) *= first;
  channel(0) = value * s;
}

/// The outputs of the second hidden layer for inputs X, (10 count, 3), in the order of the inputs.
Rows hidden_jets(const Hidden& net, const Eigen::MatrixXd& X, int64_t count) {
  Rows z = X * net.W1.transpose();
  z.topRows(count).rowwise() += Eigen::RowVectorXd(net.b1);
  activate(z, count);
  Rows next = z * net.W2.transpose();
  next.topRows(count).rowwise() += Eigen::RowVectorXd(net.b2);
  activate(next, count);
  return next;
}

/// Writes x_i = (e_i, e_j + e_k, e_j e_k) and derivatives in e to rows first, first + stride, ...
void write_input(const double e[3], int i, Eigen::MatrixXd& X, int64_t first, int64_t stride) {
  const int j = (i + 1) % 3, k = (i + 2) % 3;
  const auto at = [&](int channel, int input) -> double& {
    return X(first + channel * stride, input);
  };
  at(0, 0) = e[i], at(0, 1) = e[j] + e[k], at(0, 2) = e[j] * e[k];
  at(1 + i, 0) = at(1 + j, 1) = at(1 + k, 1) = 1;
  at(1 + j, 2) = e[k], at(1 + k, 2) = e[j];
  at(7 + j, 2) = 1;  // d2 x_2 / de_j de_k
}

/// Value at rest and slopes in the first two inputs there, which the anchor subtracts.
Eigen::Matrix<double, 3, kWidth> at_rest(const Hidden& net) {
  Eigen::MatrixXd X = Eigen::MatrixXd::Zero(10, 3);
  X(1, 0) = X(2, 1) = X(3, 2) = 1;
  return hidden_jets(net, X, 1).topRows(3);
}

/// Response of a material at a strain, and the scales of the residuals.
struct Target {
  double psi, t[3], H[6], inverse_stretch[3];
  double psi_scale, t_scale, H_scale;
};

Target target_at(const TargetLaw& law, const double e[3], double modulus) {
  const Response<double> r = target_response(law, e);
  Target target{r.psi, {}, {}, {}, 0, 0, 0};
  double stress = 0, tangent = 0;
  for (int m = 0; m < 3; ++m) {
    target.t[m] = r.t[m];
    target.inverse_stretch[m] = std::exp(-e[m]);
    stress += r.t[m] * r.t[m];
  }
  for (int c = 0; c < 6; ++c) {
    target.H[c] = r.H[c];
    tangent += (c < 3 ? 1 : 2) * r.H[c] * r.H[c];
  }
  target.t_scale = 1 / (std::sqrt(stress) + 1e-4 * modulus);
  target.H_scale = std::sqrt(0.1 / tangent);
  target.psi_scale = std::sqrt(0.1) / (r.psi + 1e-6 * modulus);
  return target;
}

/// psi of jets q, (30), and its derivatives in e that stress and tangent need.
struct LogResponse {
  double psi = 0, w[3] = {}, ww[6] = {};
};

LogResponse log_response(const double* q, double omega) {
  LogResponse r;
  for (int i = 0; i < 3; ++i) {
    r.psi += omega / 2 * q[i] * q[i];
    for (int m = 0; m < 3; ++m) r.w[m] += omega * q[i] * q[3 * (1 + m) + i];
    for (int c = 0; c < 6; ++c)
      r.ww[c] += omega * (q[3 * (1 + kFirst[c]) + i] * q[3 * (1 + kSecond[c]) + i] +
                          q[i] * q[3 * (4 + c) + i]);
  }
  return r;
}

double tangent_scale(const Target& target, int c) {
  return target.inverse_stretch[kFirst[c]] * target.inverse_stretch[kSecond[c]] * target.H_scale *
         (c < 3 ? 1 : std::sqrt(2.0));
}

Eigen::Matrix<double, kResiduals, 1> residual(const double* q, const Target& target, double omega) {
  const LogResponse r = log_response(q, omega);
  Eigen::Matrix<double, kResiduals, 1> result;
  for (int m = 0; m < 3; ++m)
    result[m] = (r.w[m] * target.inverse_stretch[m] - target.t[m]) * target.t_scale;
  for (int c = 0; c < 6; ++c) {
    const double h = r.ww[c] - (c < 3 ? r.w[c] : 0);
    const double scale = target.H_scale * (c < 3 ? 1 : std::sqrt(2.0));
    result[3 + c] = h * tangent_scale(target, c) - target.H[c] * scale;
  }
  result[9] = (r.psi - target.psi) * target.psi_scale;
  return result;
}

/// Derivatives of the residuals with respect to the jets q.
Coefficients derivatives(const double* q, const Target& target, double omega) {
  Coefficients C = Coefficients::Zero();
  for (int i = 0; i < 3; ++i) {
    const auto slope = [&](int m) { return q[3 * (1 + m) + i]; };
    const auto at = [&](int row, int channel) -> double& { return C(row, 3 * channel + i); };
    for (int m = 0; m < 3; ++m) {
      const double scale = omega * target.inverse_stretch[m] * target.t_scale;
      at(m, 0) = scale * slope(m), at(m, 1 + m) = scale * q[i];
    }
    for (int c = 0; c < 6; ++c) {
      const double scale = omega * tangent_scale(target, c);
      const int a = kFirst[c], b = kSecond[c], row = 3 + c;
      at(row, 0) = scale * (q[3 * (4 + c) + i] - (c < 3 ? slope(a) : 0));
      at(row, 1 + a) += scale * slope(b), at(row, 1 + b) += scale * slope(a);
      at(row, 4 + c) = scale * q[i];
      if (c < 3) at(row, 1 + a) -= scale * q[i];
    }
    at(9, 0) = omega * q[i] * target.psi_scale;
  }
  return C;
}

/// The least-squares problem of one material.
class Problem {
 public:
  Problem(const FitMaterial& material, const Array<double>& e, const Array<double>& inputs,
          const Array<double>& features)
      : strains_(e.rows()), inputs_(inputs), features_(features) {
    const double mu = material.mu(), lambda = material.lambda();
    omega_ = 3 * lambda + 2 * mu;
    a_ = std::sqrt(2 * mu / omega_);
    const TargetLaw law = target_law(material);
    targets_.resize(size_t(strains_));
    for_blocks(
        strains_,
        [&](int64_t begin, int64_t end) {
          for (int64_t s = begin; s < end; ++s)
            targets_[size_t(s)] = target_at(law, e.row(s), 2 * mu + lambda);
        },
        kStrainBlock);
  }

  /// Jets q at a strain, (30).
  void strain(int64_t s, const Vector& w, double* q) const {
    const double b = (1 - a_) / 3, *inputs = inputs_.row(s);
    auto jets = Eigen::Map<Eigen::Matrix<double, kJet, 1>>(q);
    jets.noalias() = features(s) * w;
    for (int k = 0; k < kJet; ++k) q[k] += (a_ + b) * inputs[2 * k] + b * inputs[2 * k + 1];
  }

  /// Mean over strains of the sum of squares of the residuals.
  double loss(const Vector& w) const {
    return sum_blocks([&](int64_t s) {
             double q[kJet];
             strain(s, w, q);
             return residual(q, targets_[size_t(s)], omega_).squaredNorm();
           }) /
           double(strains_);
  }

  /// Sums over strains of J^T J and J^T r, J = dr/dw, for `used` residuals of each strain.
  void normal_equations(const Vector& w, Square& JtJ, Vector& Jtr, int used = kResiduals) const {
    // blocks of strains side by side, each with sums of its own
    const int64_t blocks = (strains_ + kStrainBlock - 1) / kStrainBlock;
    std::vector<Square> matrices(static_cast<size_t>(blocks));
    std::vector<Vector> vectors(static_cast<size_t>(blocks));
    run_tasks(blocks, [&](int64_t block) {
      const int64_t begin = block * kStrainBlock, count = std::min(kStrainBlock, strains_ - begin);
      Rows J(kResiduals * count, kWidth);
      Eigen::VectorXd r(kResiduals * count);
      // r, and J = dr/dq dq/dw
      for (int64_t s = 0; s < count; ++s) {
        double q[kJet];
        strain(begin + s, w, q);
        const Target& target = targets_[size_t(begin + s)];
        Coefficients C = derivatives(q, target, omega_);
        C.bottomRows(kResiduals - used).setZero();
        r.segment<kResiduals>(kResiduals * s) = residual(q, target, omega_);
        J.middleRows<kResiduals>(kResiduals * s).noalias() = C * features(begin + s);
      }
      // only the lower triangle of J^T J
      Square& matrix = matrices[size_t(block)];
      matrix.setZero();
      matrix.selfadjointView<Eigen::Lower>().rankUpdate(J.transpose());
      vectors[size_t(block)].noalias() = J.transpose() * r;
    });
    // add the blocks in their order
    JtJ.setZero(), Jtr.setZero();
    for (size_t block = 0; block < size_t(blocks); ++block)
      JtJ += matrices[block], Jtr += vectors[block];
  }

 private:
  Eigen::Map<const Eigen::Matrix<double, kJet, kWidth, Eigen::RowMajor>> features(int64_t s) const {
    return Eigen::Map<const Eigen::Matrix<double, kJet, kWidth, Eigen::RowMajor>>(
        features_.row(kJet * s));
  }

  /// Sum of term(s) over the strains, block by block.
  template <class Term>
  double sum_blocks(const Term& term) const {
    const int64_t blocks = (strains_ + kStrainBlock - 1) / kStrainBlock;
    std::vector<double> sums(static_cast<size_t>(blocks));
    run_tasks(blocks, [&](int64_t block) {
      const int64_t end = std::min((block + 1) * kStrainBlock, strains_);
      for (int64_t s = block * kStrainBlock; s < end; ++s) sums[size_t(block)] += term(s);
    });
    double sum = 0;
    for (const double part : sums) sum += part;
    return sum;
  }

  int64_t strains_;
  const Array<double>&inputs_, &features_;
  double omega_, a_;
  std::vector<Target> targets_;
};

/// Levenberg-Marquardt with Marquardt's scaling: (J^T J + damping diag) step = -J^T r. The damping
/// is multiplied by 0.3 after a step that lowers the loss, and by 8 after one that does not.
class Descent {
 public:
  Descent(const Problem& problem, const Vector& w)
      : problem_(problem), w_(w), loss_(problem.loss(w)) {}

  void iterate() {
    if (stale_) problem_.normal_equations(w_, JtJ_, Jtr_);
    Square damped = JtJ_;
    const Vector diagonal = JtJ_.diagonal();
    damped.diagonal() += damping_ * (diagonal.array() + 1e-3 * diagonal.mean()).matrix();
    const Vector next = w_ - damped.selfadjointView<Eigen::Lower>().llt().solve(Jtr_);
    const double loss =
        next.allFinite() ? problem_.loss(next) : std::numeric_limits<double>::infinity();
    stale_ = loss < loss_;
    if (stale_) w_ = next, loss_ = loss;
    damping_ = std::clamp(damping_ * (stale_ ? 0.3 : 8.0), 1e-9, 1e6);
  }

  const Vector& weights() const { return w_; }
  double loss() const { return loss_; }

 private:
  const Problem& problem_;
  Vector w_;
  double loss_, damping_ = 1e-3;
  Square JtJ_;
  Vector Jtr_;
  bool stale_ = true;  // whether w has changed since JtJ was computed
};

}  // namespace

LastLayer::LastLayer(std::span<const float> weights, const LastLayerOptions& options)
    : options_(options), weights_(weights.begin(), weights.end()) {
  ELASTOGEN_CHECK(int64_t(weights.size()) == kMtlParameters, "a NeuralMTL has ", kMtlParameters,
                  " weights, not ", weights.size());
  ELASTOGEN_CHECK(options.iterations > 0 && options.strains > 0,
                  "iterations and strains must be positive, got ", options.iterations, " and ",
                  options.strains);
  // the strains, and inputs and features of the net there, for all materials
  e_ = sample_strains(options.box, options.seed, 0, options.strains);
  inputs_ = Array<double>(options.strains, 2 * kJet);
  features_ = Array<double>(options.strains * kJet, kWidth);
  const Hidden net(weights_);
  // the anchor: value and slopes at rest
  const Eigen::Matrix<double, 3, kWidth> rest = at_rest(net);
  for_blocks(
      options.strains,
      [&](int64_t begin, int64_t end) {
        // jets of the hidden layers at the points of some strains
        const int64_t count = 3 * (end - begin);
        Eigen::MatrixXd X = Eigen::MatrixXd::Zero(10 * count, 3);
        for (int64_t p = 0; p < count; ++p)
          write_input(e_.row(begin + p / 3), int(p % 3), X, p, count);
        const Rows jets = hidden_jets(net, X, count);
        // subtract the anchor, sort by strain
        for (int64_t row = 0; row < 10 * count; ++row) {
          const int64_t channel = row / count, p = row % count, s = begin + p / 3,
                        k = 3 * channel + p % 3;
          for (int input = 0; input < 2; ++input) inputs_(s, int(2 * k + input)) = X(row, input);
          auto to = Eigen::Map<Eigen::Matrix<double, 1, kWidth>>(features_.row(kJet * s + k));
          to = jets.row(row) - X(row, 0) * rest.row(1) - X(row, 1) * rest.row(2);
          if (channel == 0) to -= rest.row(0);
        }
      },
      8);
}

LastLayerFit LastLayer::fit(const FitMaterial& material, std::span<const float> start,
                            const FitWatch& watch) const {
  ELASTOGEN_CHECK(start.empty() || int(start.size()) == kWidth, "a last layer has ", kWidth,
                  " weights, not ", start.size());
  // start from the given layer, or from zeros
  Vector w = Vector::Zero();
  for (size_t k = 0; k < start.size(); ++k) w[Eigen::Index(k)] = double(start[k]);
  // iterate until the error is small enough or ten iterations gain too little
  const Problem problem(material, e_, inputs_, features_);
  Descent descent(problem, w);
  LastLayerFit result;
  for (double before = descent.loss(); result.iterations < options_.iterations;) {
    descent.iterate();
    ++result.iterations;
    if (watch) watch(result.iterations, {descent.weights().data(), kWidth});
    if (descent.loss() < options_.enough * options_.enough) break;
    if (result.iterations % 10) continue;
    if (descent.loss() > 0.96 * before) break;  // 2 % of the error, the root of the loss
    before = descent.loss();
  }
  // the hidden layers stay; b3 cancels and is 0
  result.error = std::sqrt(descent.loss());
  result.weights = weights_;
  for (int k = 0; k < kWidth; ++k)
    result.weights[result.weights.size() - kWidth - 1 + size_t(k)] = float(descent.weights()[k]);
  result.weights.back() = 0;
  return result;
}

Array<double> LastLayer::stress_metric(const FitMaterial& material,
                                       std::span<const double> w) const {
  ELASTOGEN_CHECK(int(w.size()) == kWidth, "a last layer has ", kWidth, " weights, not ", w.size());
  const Problem problem(material, e_, inputs_, features_);
  Square lower;
  Vector unused;
  problem.normal_equations(Eigen::Map<const Vector>(w.data()), lower, unused, 3);
  Array<double> metric(kWidth, kWidth);
  for (int i = 0; i < kWidth; ++i)
    for (int j = 0; j < kWidth; ++j)
      metric(i, j) = lower(std::max(i, j), std::min(i, j)) / double(e_.rows());
  return metric;
}

Array<double> LastLayer::strains(const FitMaterial& material, std::span<const double> w) const {
  ELASTOGEN_CHECK(int(w.size()) == kWidth, "a last layer has ", kWidth, " weights, not ", w.size());
  const Problem problem(material, e_, inputs_, features_);
  Array<double> q(e_.rows(), kJet);
  for (int64_t s = 0; s < e_.rows(); ++s)
    problem.strain(s, Eigen::Map<const Vector>(w.data()), q.row(s));
  return q;
}

}  // namespace elastogen
