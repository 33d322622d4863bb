// SPDX-License-Identifier: Apache-2.0
#include "tests/stress/equations.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/stress/floor.hpp"

#include <Eigen/Dense>

#include <cmath>

namespace elastogen::stress {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Corners = Eigen::Matrix<double, 3, 8>;

int sign(int c, int d) {
  return c >> d & 1 ? 1 : -1;
}

/// Corner displacements x - X.
Corners corner_motion(const Scene& scene, int64_t v, const Array<double>& x) {
  Corners u;
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) {
      const int64_t n = scene.grid.corners(v, c);
      u(i, c) = x(n, i) - scene.grid.rest(n, i);
    }
  return u;
}

/// D_cd = s_cd (N_c + N_c') / h, columns are corners.
Corners mean_gradients(const Scene& scene, int64_t v) {
  Corners D;
  const double* N = scene.grid.shape_mean.row(v);
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) D(d, c) = sign(c, d) * (N[c] + N[c ^ 1 << d]) / scene.grid.h;
  return D;
}

Matrix3d gradient(const Scene& scene, int64_t v, const Array<double>& x) {
  return Matrix3d::Identity() + corner_motion(scene, v, x) * mean_gradients(scene, v).transpose();
}

Matrix3d cofactor(const Matrix3d& F) {
  Matrix3d C;
  C.row(0) = F.row(1).cross(F.row(2));
  C.row(1) = F.row(2).cross(F.row(0));
  C.row(2) = F.row(0).cross(F.row(1));
  return C;
}

/// The rotation U V^T with U and V rotations, or 0 where it is not unique.
Matrix3d polar(const Matrix3d& F) {
  const Eigen::JacobiSVD<Matrix3d> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d U = svd.matrixU();
  Vector3d s = svd.singularValues();
  if (U.determinant() * svd.matrixV().determinant() < 0) U.col(2) *= -1, s(2) *= -1;
  if (s(1) + s(2) > 1e-6 * std::max(s(0), 1.0)) return U * svd.matrixV().transpose();
  return Matrix3d::Zero();
}

/// Largest tr(R^T F) over rotations R.
double largest_trace(const Matrix3d& F) {
  const Vector3d s = F.jacobiSvd().singularValues();
  return s(0) + s(1) + std::copysign(s(2), F.determinant());
}

struct Stress {
  double psi;
  Matrix3d P;
};

/// Energy density and stress at F = I + H; invariants less their value at rest, so that the energy
/// of stiff solids keeps its digits.
Stress stress(const Material& m, const Matrix3d& H) {
  const Matrix3d one = Matrix3d::Identity(), F = one + H, C = cofactor(F);
  const double mu = m.mu(), lambda = m.lambda();
  const double I_3 = 2 * H.trace() + H.squaredNorm();  // |F|^2 - 3
  const double J_1 = H.trace() + cofactor(H).trace() + H.determinant(), J = 1 + J_1;
  if (m.law == Law::kFixedCorotated) {
    // without a unique rotation the energy still exists
    const Matrix3d R = polar(F);
    const double spread =
        R.isZero() ? F.squaredNorm() + 3 - 2 * largest_trace(F) : (F - R).squaredNorm();
    return {mu * spread + lambda / 2 * J_1 * J_1, 2 * mu * (F - R) + lambda * J_1 * C};
  }
  if (m.law == Law::kNeoHookean) {
    // the logarithm is continued below J = 0.1
    const double d = (J - 0.1) / 0.1;
    const double l = J > 0.1 ? std::log1p(J_1) : std::log(0.1) + d - d * d / 2;
    const double slope = J > 0.1 ? 1 / J : (1 - d) / 0.1;
    return {mu * (I_3 / 2 - l) + lambda / 2 * l * l, mu * F + (lambda * l - mu) * slope * C};
  }
  if (m.law == Law::kStableNeoHookean) {
    const double k = 4 * mu / 3, l = lambda + 5 * mu / 6, a_1 = 3 * k / (4 * l);
    return {k / 2 * (I_3 - std::log1p(I_3 / 4)) + l / 2 * J_1 * (J_1 - 2 * a_1),
            k * (1 - 1 / (I_3 + 4)) * F + l * (J_1 - a_1) * C};
  }
  ELASTOGEN_CHECK(m.law == Law::kStvk, "no stress cases with this law");
  const Matrix3d E = (H + H.transpose() + H.transpose() * H) / 2;
  return {mu * E.squaredNorm() + lambda / 2 * E.trace() * E.trace(),
          F * (2 * mu * E + lambda * E.trace() * one)};
}

/// Centred patterns Q_pc of xy, yz, zx, xyz: q_p = sum_c w_c Q_pc.
Eigen::Matrix<double, 4, 8> patterns(const double* N) {
  double M[3] = {};
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) M[d] += N[c] * sign(c, d);
  Eigen::Matrix<double, 4, 8> Q;
  for (int c = 0; c < 8; ++c) {
    const int x = sign(c, 0), y = sign(c, 1), z = sign(c, 2);
    Q.col(c) << x * y + M[2] * x * y * z, y * z + M[0] * x * y * z, z * x + M[1] * x * y * z,
        x * y * z;
  }
  return Q;
}

/// Energy of variance and torsion [J]; adds its derivative in the corners.
double hourglass(const Scene& scene, int64_t v, const Corners& u, const Matrix3d& R, Corners& f) {
  if (scene.hourglass == Hourglass::kOff) return 0;
  // variance of the gradient, by patterns
  const Eigen::Matrix<double, 4, 8> Q = patterns(scene.grid.shape_mean.row(v));
  const Eigen::Matrix<double, 3, 4> q = u * Q.transpose();
  const double* c = scene.variance.row(v);
  const double weight = scene.grid.fill(v) * scene.grid.h;
  Eigen::Matrix<double, 3, 4> slope;
  double energy = 0;
  for (int p = 0; p < 4; ++p) {
    const double share = c[p] / (p < 3 ? 24 : 48);
    energy += share / 2 * q.col(p).squaredNorm();
    slope.col(p) = share * q.col(p);
  }
  // torsion in the frame of R
  if (scene.hourglass == Hourglass::kFull) {
    const double mu = scene.materials[size_t(scene.material(v))].mu();
    const double a = R.col(0).dot(q.col(1)), b = R.col(1).dot(q.col(2)), d = R.col(2).dot(q.col(0));
    energy += (mu * ((a + b) * (a + b) + (b + d) * (b + d) + (d + a) * (d + a)) -
               2 * (c[1] * a * a + c[2] * b * b + c[0] * d * d)) /
              96;
    slope.col(1) += (2 * mu * (2 * a + b + d) - 4 * c[1] * a) / 96 * R.col(0);
    slope.col(2) += (2 * mu * (2 * b + d + a) - 4 * c[2] * b) / 96 * R.col(1);
    slope.col(0) += (2 * mu * (2 * d + a + b) - 4 * c[0] * d) / 96 * R.col(2);
  }
  f += weight * slope * Q;
  return weight * energy;
}

/// Energy of the voxels [J] at x with rotations of x_rotation; derivative in f, (nodes, 3).
double internal_energy(const Scene& scene, const Array<double>& x, const Array<double>& x_rotation,
                       std::vector<double>& f) {
  const VoxelGrid& grid = scene.grid;
  const int64_t voxels = grid.voxel_count();
  std::vector<Corners> forces(static_cast<size_t>(voxels));
  std::vector<double> energy(static_cast<size_t>(voxels));
  // voxels side by side
  for_each(voxels, [&](int64_t v) {
    const Corners u = corner_motion(scene, v, x), D = mean_gradients(scene, v);
    const Stress s = stress(scene.materials[size_t(scene.material(v))], u * D.transpose());
    const double volume = grid.fill(v) * grid.h * grid.h * grid.h;
    Corners& force = forces[size_t(v)];
    force = volume * s.P * D;
    const bool turned = scene.hourglass == Hourglass::kFull;
    const Matrix3d R = turned ? polar(gradient(scene, v, x_rotation)) : Matrix3d::Identity();
    energy[size_t(v)] = volume * s.psi + hourglass(scene, v, u, R, force);
  });
  // summed in their order
  f.assign(size_t(x.size()), 0);
  double sum = 0;
  for (int64_t v = 0; v < voxels; ++v) {
    sum += energy[size_t(v)];
    for (int c = 0; c < 8; ++c)
      for (int i = 0; i < 3; ++i) f[size_t(3 * grid.corners(v, c) + i)] += forces[size_t(v)](i, c);
  }
  return sum;
}

double kinetic_energy(const Scene& scene, const Array<double>& v) {
  double sum = 0;
  for (int64_t k = 0; k < v.size(); ++k) sum += scene.mass(k / 3) / 2 * v.data()[k] * v.data()[k];
  return sum;
}

/// x' - xhat of a component.
double inertial_motion(const Scene& scene, const State& s, double x, int64_t n, int d, bool bdf2) {
  const double dt = scene.dt, g = scene.gravity[size_t(d)];
  if (!bdf2) return x - s.x(n, d) - dt * s.v(n, d) - dt * dt * g;
  return x - s.x(n, d) - (s.x(n, d) - s.x_before(n, d)) / 3 -
         2 * dt / 9 * (4 * s.v(n, d) - s.v_before(n, d)) - 4 * dt * dt / 9 * g;
}

}  // namespace

Balance balance(const Scene& scene, const State& before, const State& after, TimeScheme scheme) {
  Balance b;
  std::vector<double> r;
  // energies at the start and at the end
  const double internal_before = internal_energy(scene, before.x, before.x, r);
  b.energy_before =
      internal_before + kinetic_energy(scene, before.v) + barrier_energy(scene, before.x);
  const double internal_after = internal_energy(scene, after.x, before.x, b.internal);
  b.convexity = internal_before - internal_after;
  for (int64_t k = 0; k < after.x.size(); ++k)
    b.convexity += b.internal[size_t(k)] * (after.x.data()[k] - before.x.data()[k]);
  b.energy = internal_after + kinetic_energy(scene, after.v) + barrier_energy(scene, after.x);
  // the residual: internal, contact and inertial forces
  r = b.internal;
  add_contact_force(scene, before.x, after.x, r);
  const bool bdf2 = scheme == TimeScheme::kBdf2;
  double size = 0, masses = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    if (scene.pinned(n)) continue;
    masses += scene.mass(n) * scene.mass(n);
    for (int d = 0; d < 3; ++d) {
      double& force = r[size_t(3 * n + d)];
      force += (bdf2 ? 2.25 : 1) * scene.mass(n) *
               inertial_motion(scene, before, after.x(n, d), n, d, bdf2) / (scene.dt * scene.dt);
      const double step = after.x(n, d) - before.x(n, d);
      size += force * force;
      b.residual_work += force * step;
      b.gravity_work += scene.mass(n) * scene.gravity[size_t(d)] * step;
    }
  }
  b.residual = masses > 0 ? std::sqrt(size / masses) / 9.81 : 0;
  return b;
}

std::vector<double> voxel_jacobians(const Scene& scene, const Array<double>& x) {
  std::vector<double> J(size_t(scene.grid.voxel_count()));
  for (size_t v = 0; v < J.size(); ++v) J[v] = gradient(scene, int64_t(v), x).determinant();
  return J;
}

int64_t inverted_corners(const Scene& scene, const Array<double>& x) {
  int64_t count = 0;
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    for (int c = 0; c < 8; ++c) {
      Matrix3d edges;
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d)
          edges(i, d) =
              x(scene.grid.corners(v, c | 1 << d), i) - x(scene.grid.corners(v, c & ~(1 << d)), i);
      count += edges.determinant() <= 0;
    }
  return count;
}

double shape_distance(const Array<double>& x, const Array<double>& y) {
  const auto row = [](const Array<double>& a, int64_t n) {
    return Vector3d(a(n, 0), a(n, 1), a(n, 2));
  };
  Vector3d mean_x = Vector3d::Zero(), mean_y = Vector3d::Zero();
  for (int64_t n = 0; n < x.rows(); ++n) mean_x += row(x, n), mean_y += row(y, n);
  mean_x /= double(x.rows()), mean_y /= double(x.rows());
  Matrix3d A = Matrix3d::Zero();
  double size = 0;
  for (int64_t n = 0; n < x.rows(); ++n) {
    A += (row(x, n) - mean_x) * (row(y, n) - mean_y).transpose();
    size += (row(y, n) - mean_y).squaredNorm();
  }
  const Matrix3d R = size > 0 ? polar(A / size) : Matrix3d::Zero();
  double farthest = 0;
  for (int64_t n = 0; n < x.rows(); ++n)
    farthest = std::max(farthest, (row(x, n) - mean_x - R * (row(y, n) - mean_y)).norm());
  return farthest;
}

}  // namespace elastogen::stress
