// SPDX-License-Identifier: Apache-2.0
// With xi_q = abar dJbar - a_q dJ_q, a = d(ln j)/dJ / 3, the differentials are
//
//     dFbar_q = r_q (dF_q + xi_q F_q),
//     dE      = sum_q w_q (r_q P_q + kappa_q C_q) : dF_q,
//     d2E     = sum_q w_q [ dFbar : A : dFbar + 2 r xi P : dF + t (xi^2 - a' dJ^2) + kappa d2J ]
//               + T abar' dJbar^2,
//
// P, A the first two derivatives of psi at Fbar, or a stress without potential and its derivative,
// t = P : Fbar, C the cofactor of F, W = sum_q w_q, T = sum_q w_q t_q,
// kappa_q = T abar/W - t_q a_q.

#include "mpm_fem/fem/mean_dilatation.hpp"

#include <Eigen/Core>

#include <cmath>

namespace elastogen::fem {
namespace {

using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDofs, 1>;
using Matrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxDofs, kMaxDofs>;

Dilatation dilatation(double J) {
  constexpr double kStart = 0.1;
  if (J >= kStart) return {std::log(J) / 3, 1 / (3 * J), -1 / (3 * J * J)};
  const double y = J / kStart - 1, D = 1 - y + y * y, slope = (1 - 2 * y) / D;
  const double scale = 1 / (3 * kStart);
  return {(std::log(kStart) - std::log(D)) / 3, scale * slope,
          scale / kStart * (slope * slope - 2 / D)};
}

Dilatation scaled(const Dilatation& d, double factor) {
  return {factor * d.value, factor * d.first, factor * d.second};
}

Mat3<double> scaled(const Mat3<double>& A, double factor) {
  Mat3<double> B;
  for (int k = 0; k < 9; ++k) B.m[k] = factor * A.m[k];
  return B;
}

/// Adds scale d2J/dF2 to D, (9, 9).
void add_cofactor_gradient(const Mat3<double>& F, double scale, double* D) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int di = 1; di < 3; ++di)
        for (int dj = 1; dj < 3; ++dj) {
          const int k = (i + di) % 3, l = (j + dj) % 3;
          const double sign = di == dj ? 1 : -1;
          D[9 * (3 * i + j) + 3 * k + l] += sign * scale * F(3 - i - k, 3 - j - l);
        }
}

/// t and kappa of all points, and T.
struct Stresses {
  double t[kMaxPoints], kappa[kMaxPoints], T = 0;
};

Stresses stresses_of(const ElementState& e, const MeanDilatation& m, const Mat3<double>* P) {
  Stresses s;
  for (int q = 0; q < e.points; ++q) {
    s.t[q] = inner(P[q], m.Fbar[q]);
    s.T += e.weight[q] * s.t[q];
  }
  for (int q = 0; q < e.points; ++q)
    s.kappa[q] = s.T * m.mean.first / m.volume - s.t[q] * m.own[q].first;
  return s;
}

/// G^T S: the derivative of S : F_q in u.
Vector transposed(const ElementState& e, int q, const Mat3<double>& S) {
  Vector v = Vector::Zero(3 * e.nodes);
  add_transposed(e, q, S, v.data());
  return v;
}

/// w r G^T (A Fbar + P).
Vector mixed(const ElementState& e, int q, const MeanDilatation& m, const Mat3<double>& P,
             Mat3<double> AF) {
  for (int k = 0; k < 9; ++k) AF.m[k] += P.m[k];
  return (e.weight[q] * m.r[q]) * transposed(e, q, AF);
}

/// Adds the share of one point's factor r_q in the Hessian, as products of vectors; A is (9, 9).
void add_rank_one(const ElementState& e, int q, const MeanDilatation& p, const Stresses& s,
                  const Mat3<double>& P, const Vector& dJ_mean, const double* A, bool symmetric,
                  Matrix& K) {
  const Vector dJ = transposed(e, q, cofactor(p.F[q]));
  const Vector xi = p.mean.first * dJ_mean - p.own[q].first * dJ;
  Mat3<double> AF{}, FA{};
  for (int row = 0; row < 9; ++row)
    for (int col = 0; col < 9; ++col) {
      AF.m[row] += A[9 * row + col] * p.Fbar[q].m[col];
      FA.m[col] += A[9 * row + col] * p.Fbar[q].m[row];
    }
  const double along = inner(p.Fbar[q], AF) + s.t[q];
  const Vector m = mixed(e, q, p, P, AF);
  if (symmetric)
    K += m * xi.transpose() + xi * m.transpose();
  else
    K += m * xi.transpose() + xi * mixed(e, q, p, P, FA).transpose();
  K += (e.weight[q] * along) * (xi * xi.transpose());
  K -= (e.weight[q] * s.t[q] * p.own[q].second) * (dJ * dJ.transpose());
}

}  // namespace

MeanDilatation mean_dilatation(const ElementState& e, double share) {
  MeanDilatation p;
  double sum = 0;
  for (int q = 0; q < e.points; ++q) {
    p.F[q] = deformation_gradient(e, q);
    const double J = determinant(p.F[q]);
    p.own[q] = scaled(dilatation(J), share);
    sum += e.weight[q] * J;
    p.volume += e.weight[q];
  }
  p.mean = scaled(dilatation(sum / p.volume), share);
  for (int q = 0; q < e.points; ++q) {
    p.r[q] = std::exp(p.mean.value - p.own[q].value);
    p.Fbar[q] = scaled(p.F[q], p.r[q]);
  }
  return p;
}

void add_mean_dilatation_gradient(const ElementState& e, const MeanDilatation& m,
                                  const Mat3<double>* P, double* f) {
  const Stresses s = stresses_of(e, m, P);
  for (int q = 0; q < e.points; ++q) {
    const Mat3<double> C = cofactor(m.F[q]);
    Mat3<double> S;
    for (int k = 0; k < 9; ++k) S.m[k] = e.weight[q] * (m.r[q] * P[q].m[k] + s.kappa[q] * C.m[k]);
    add_transposed(e, q, S, f);
  }
}

void mean_dilatation_hessian(const ElementState& e, const MeanDilatation& m, const Mat3<double>* P,
                             const double* tangents, bool symmetric, double* result) {
  const Stresses s = stresses_of(e, m, P);
  const int size = 3 * e.nodes;
  Matrix K = Matrix::Zero(size, size);
  Vector dJ_mean = Vector::Zero(size);
  for (int q = 0; q < e.points; ++q)
    dJ_mean += (e.weight[q] / m.volume) * transposed(e, q, cofactor(m.F[q]));

  for (int q = 0; q < e.points; ++q) {
    double A[81];
    std::copy_n(tangents + 81 * q, 81, A);
    add_rank_one(e, q, m, s, P[q], dJ_mean, A, symmetric, K);
    for (double& a : A) a *= e.weight[q] * m.r[q] * m.r[q];
    add_cofactor_gradient(m.F[q], e.weight[q] * s.kappa[q], A);
    symmetric ? add_product(e, q, A, K.data()) : add_full_product(e, q, A, K.data());
  }
  K += (s.T * m.mean.second) * (dJ_mean * dJ_mean.transpose());
  if (symmetric) mirror(size, K.data());
  Eigen::Map<Matrix>(result, size, size) = K;
}

}  // namespace elastogen::fem
