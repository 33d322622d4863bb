// SPDX-License-Identifier: Apache-2.0
// With xi_q = abar dJbar - a_q dJ_q, a = d(ln j)/dJ / 3, the differentials are
//
//     dFbar_q = r_q (dF_q + xi_q F_q),
//     dE      = sum_q w_q (r_q P_q + kappa_q C_q) : dF_q,
//     d2E     = sum_q w_q [ dFbar : A : dFbar + 2 r xi P : dF + t (xi^2 - a' dJ^2) + kappa d2J ]
//               + T abar' dJbar^2,
//
// P, A the first two derivatives of psi at Fbar, t = P : Fbar, C the cofactor of F, T = sum_q w_q
// t_q, kappa_q = T abar/W - t_q a_q, W = sum_q w_q.

#include "mpm_fem/fem/mean_dilatation.hpp"

#include <Eigen/Eigenvalues>

#include <cmath>

namespace elastogen::fem {
namespace {

using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDofs, 1>;
using Matrix =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxDofs, kMaxDofs>;

/// ln(j)/3 and its derivatives a, a'.
struct Dilatation {
  double value, first, second;
};

Dilatation dilatation(double J) {
  constexpr double kStart = 0.1;
  if (J >= kStart) return {std::log(J) / 3, 1 / (3 * J), -1 / (3 * J * J)};
  const double y = J / kStart - 1, D = 1 - y + y * y, slope = (1 - 2 * y) / D;
  const double scale = 1 / (3 * kStart);
  return {(std::log(kStart) - std::log(D)) / 3, scale * slope,
          scale / kStart * (slope * slope - 2 / D)};
}

double inner(const Mat3<double>& A, const Mat3<double>& B) {
  double sum = 0;
  for (int k = 0; k < 9; ++k) sum += A.m[k] * B.m[k];
  return sum;
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

/// What energy, gradient and Hessian share.
struct Points {
  Mat3<double> F[kMaxPoints], Fbar[kMaxPoints];
  double r[kMaxPoints];
  Dilatation own[kMaxPoints], mean;
  double volume = 0;
};

Points points_of(const ElementState& e) {
  Points p;
  double sum = 0;
  for (int q = 0; q < e.points; ++q) {
    p.F[q] = deformation_gradient(e, q);
    const double J = determinant(p.F[q]);
    p.own[q] = dilatation(J);
    sum += e.weight[q] * J;
    p.volume += e.weight[q];
  }
  p.mean = dilatation(sum / p.volume);
  for (int q = 0; q < e.points; ++q) {
    p.r[q] = std::exp(p.mean.value - p.own[q].value);
    p.Fbar[q] = scaled(p.F[q], p.r[q]);
  }
  return p;
}

/// P, t and kappa of all points, and T.
struct Stresses {
  Mat3<double> P[kMaxPoints];
  double t[kMaxPoints], kappa[kMaxPoints], T = 0;
};

Stresses stresses_of(const ElementState& e, const Points& p) {
  Stresses s;
  for (int q = 0; q < e.points; ++q) {
    s.P[q] = piola_stress(e.law, p.Fbar[q]);
    s.t[q] = inner(s.P[q], p.Fbar[q]);
    s.T += e.weight[q] * s.t[q];
  }
  for (int q = 0; q < e.points; ++q)
    s.kappa[q] = s.T * p.mean.first / p.volume - s.t[q] * p.own[q].first;
  return s;
}

/// G^T S: the derivative of S : F_q in u.
Vector transposed(const ElementState& e, int q, const Mat3<double>& S) {
  Vector v = Vector::Zero(3 * e.nodes);
  add_transposed(e, q, S, v.data());
  return v;
}

/// Adds what the factor r_q of one point brings to the Hessian, products of vectors; A is (9, 9).
void add_rank_one(const ElementState& e, int q, const Points& p, const Stresses& s,
                  const Vector& dJ_mean, const double* A, Matrix& K) {
  const Vector dJ = transposed(e, q, cofactor(p.F[q]));
  const Vector xi = p.mean.first * dJ_mean - p.own[q].first * dJ;
  Mat3<double> AF{};
  for (int row = 0; row < 9; ++row)
    for (int col = 0; col < 9; ++col) AF.m[row] += A[9 * row + col] * p.Fbar[q].m[col];
  const double along = inner(p.Fbar[q], AF) + s.t[q];
  for (int k = 0; k < 9; ++k) AF.m[k] += s.P[q].m[k];
  const Vector m = (e.weight[q] * p.r[q]) * transposed(e, q, AF);
  K += m * xi.transpose() + xi * m.transpose();
  K += (e.weight[q] * along) * (xi * xi.transpose());
  K -= (e.weight[q] * s.t[q] * p.own[q].second) * (dJ * dJ.transpose());
}

/// Sets the negative eigenvalues to 0; unchanged to the bit where there are none.
void clamp(Matrix& K) {
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(K);
  for (Eigen::Index k = 0; k < K.rows(); ++k) {
    const double value = solver.eigenvalues()(k);
    if (value >= 0) break;
    const Vector direction = solver.eigenvectors().col(k);
    K -= value * (direction * direction.transpose());
  }
  mirror(int(K.rows()), K.data());
}

}  // namespace

void mean_dilatation_gradients(const ElementState& e, Mat3<double>* Fbar) {
  const Points p = points_of(e);
  for (int q = 0; q < e.points; ++q) Fbar[q] = p.Fbar[q];
}

double mean_dilatation_energy(const ElementState& e) {
  const Points p = points_of(e);
  double energy = 0;
  for (int q = 0; q < e.points; ++q) energy += e.weight[q] * energy_density(e.law, p.Fbar[q]);
  return energy;
}

void add_mean_dilatation_gradient(const ElementState& e, double* f) {
  const Points p = points_of(e);
  const Stresses s = stresses_of(e, p);
  for (int q = 0; q < e.points; ++q) {
    const Mat3<double> C = cofactor(p.F[q]);
    Mat3<double> P;
    for (int k = 0; k < 9; ++k) P.m[k] = e.weight[q] * (p.r[q] * s.P[q].m[k] + s.kappa[q] * C.m[k]);
    add_transposed(e, q, P, f);
  }
}

void mean_dilatation_hessian(const ElementState& e, TangentKind kind, double* result) {
  const Points p = points_of(e);
  const Stresses s = stresses_of(e, p);
  const int size = 3 * e.nodes;
  Matrix K = Matrix::Zero(size, size);
  Vector dJ_mean = Vector::Zero(size);
  for (int q = 0; q < e.points; ++q)
    dJ_mean += (e.weight[q] / p.volume) * transposed(e, q, cofactor(p.F[q]));

  for (int q = 0; q < e.points; ++q) {
    double A[81];
    piola_gradient(e.law, p.Fbar[q], TangentKind::kTrue, A);
    add_rank_one(e, q, p, s, dJ_mean, A, K);
    for (double& a : A) a *= e.weight[q] * p.r[q] * p.r[q];
    add_cofactor_gradient(p.F[q], e.weight[q] * s.kappa[q], A);
    add_product(e, q, A, K.data());
  }
  K += (s.T * p.mean.second) * (dJ_mean * dJ_mean.transpose());
  mirror(size, K.data());
  if (kind == TangentKind::kProjected) clamp(K);
  Eigen::Map<Matrix>(result, size, size) = K;
}

}  // namespace elastogen::fem
