// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/viscous_body.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/fem/point_gradients.hpp"
#include "mpm_fem/fem/positive_part.hpp"
#include "mpm_fem/fem/voxel_element.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

Mat3<double> minus_identity(Mat3<double> F) {
  for (int d = 0; d < 3; ++d) F(d, d) -= 1;
  return F;
}

/// dP/dF of the viscous stress at a point, (9, 9).
void viscous_gradient(const ViscousModuli<double>& moduli, const Mat3<double>& H, const double* E_b,
                      TangentKind kind, double* A) {
  for (int k = 0; k < 9; ++k) {
    Mat3<double> dF = {}, dP = {};
    dF.m[k] = 1;
    add_viscous_tangent(moduli, H, E_b, kind, dF, dP);
    std::copy(dP.m, dP.m + 9, A + 9 * k);
  }
  mirror(9, A);
}

}  // namespace

bool is_damped(const Material& material) {
  return viscous_time(material) > 0;
}

/// A_ik = sum_j F_ji q_jk of a displaced voxel, whose energy is 1/2 sum_ik weight_k (A - A_b)_ik^2.
struct ViscousBody::Within {
  const double* gradient;  // of the corners at the point with the mean F, (8, 3)
  double pattern[4][8];
  Mat3<double> F;
  double q[3][4] = {};  // [m]
  double weight[4];     // [N/m]

  double A(int i, int k) const { return F(0, i) * q[0][k] + F(1, i) * q[1][k] + F(2, i) * q[2][k]; }
  /// dA_ik/du.
  void row(int i, int k, double* row) const {
    for (int c = 0; c < 8; ++c)
      for (int j = 0; j < 3; ++j)
        row[3 * c + j] = gradient[3 * c + i] * q[j][k] + F(j, i) * pattern[k][c];
  }
  /// Adds a times the second derivative of A_ik to K, (24, 24).
  void add_curvature(int i, int k, double a, double* K) const {
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 8; ++d) {
        const double value =
            a * (gradient[3 * c + i] * pattern[k][d] + pattern[k][c] * gradient[3 * d + i]);
        for (int j = 0; j < 3; ++j) K[24 * (3 * c + j) + 3 * d + j] += value;
      }
  }
};

ViscousBody::ViscousBody(const ElementMesh& mesh, std::vector<Material> materials)
    : tables_(mesh), materials_(std::move(materials)) {
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    ELASTOGEN_CHECK(mesh.material(e) >= 0 && mesh.material(e) < int(materials_.size()), "element ",
                    e, " has material ", mesh.material(e), " of ", materials_.size());
  before_ = Array<double>(mesh.elements.rows(), 6 * tables_.points() + (varies() ? 12 : 0));
}

const Material& ViscousBody::material_of(int64_t element) const {
  return materials_[size_t(mesh().material(element))];
}

ViscousModuli<double> ViscousBody::moduli(int64_t element) const {
  const Material& m = material_of(element);
  const double beta = viscous_time(m) * rate_;
  return {beta * m.mu(), beta * m.lambda()};
}

bool ViscousBody::varies() const {
  return mesh().element == Element::kVoxel && mesh().hourglass != Hourglass::kOff;
}

ViscousBody::Within ViscousBody::within(int64_t voxel, const ElementState& e) const {
  Within result;
  result.gradient = e.gradient_at(0);
  voxel_patterns(mesh().shape_mean.row(voxel), result.pattern);
  result.F = fem::deformation_gradient(e, 0);
  const double scale = viscous_time(material_of(voxel)) * rate_ * mesh().fill(voxel) * mesh().h;
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 3; ++j)
      for (int c = 0; c < 8; ++c) result.q[j][k] += result.pattern[k][c] * e.u[3 * c + j];
    result.weight[k] = scale * mesh().variance(voxel, k) / (k < 3 ? 24 : 48);
  }
  return result;
}

/// E of the points, then A.
void ViscousBody::find_strains(In<double> u, Array<double>& strain) const {
  tables_.check_nodal(u);
  for_each(
      mesh().elements.rows(),
      [&](int64_t k) {
        const ElementState e = tables_.state(k, u);
        const PointGradients points(mesh().element, e);
        double* to = strain.row(k);
        for (int q = 0; q < e.points; ++q, to += 6) {
          const Symmetric3<double> E = strain::green(minus_identity(points.F(q)));
          std::copy(E.m, E.m + 6, to);
        }
        if (!varies()) return;
        const Within part = within(k, e);
        for (int i = 0; i < 12; ++i) to[i] = part.A(i / 4, i % 4);
      },
      kElementBlock);
}

void ViscousBody::begin(double rate, In<double> u, double weight, In<double> other) {
  rate_ = rate;
  find_strains(u, before_);
  if (weight == 0) return;
  Array<double> there = before_;
  find_strains(other, there);
  for (int64_t k = 0; k < there.size(); ++k)
    before_.data()[k] += weight * (there.data()[k] - before_.data()[k]);
}

double ViscousBody::stiffness() const {
  double sum = 0;
  for (int64_t e = 0; e < mesh().elements.rows(); ++e) {
    const ViscousModuli<double> m = moduli(e);
    sum += tables_.volume(e) * (2 * m.mu + m.lambda);
  }
  return sum;
}

double ViscousBody::energy(In<double> u) const {
  tables_.check_nodal(u);
  const int64_t elements = mesh().elements.rows();
  Array<double> lost(elements);
  for_each(
      elements,
      [&](int64_t k) {
        if (!is_damped(material_of(k))) return;
        const ElementState e = tables_.state(k, u);
        const PointGradients points(mesh().element, e);
        const ViscousModuli<double> m = moduli(k);
        // the points, then what varies within a voxel
        const double* before = before_.row(k);
        for (int q = 0; q < e.points; ++q, before += 6) {
          Mat3<double> P = {};
          lost(k) += e.weight[q] * add_viscous(m, minus_identity(points.F(q)), before, P);
        }
        if (!varies()) return;
        const Within part = within(k, e);
        for (int i = 0; i < 12; ++i) {
          const double change = part.A(i / 4, i % 4) - before[i];
          lost(k) += part.weight[i % 4] / 2 * change * change;
        }
      },
      kElementBlock);
  return total(lost);
}

void ViscousBody::add_gradient(In<double> u, Out<double> g) const {
  tables_.check_nodal(u);
  tables_.check_nodal(g);
  tables_.add_forces(
      [&](int64_t k, double* f) {
        if (!is_damped(material_of(k))) return;
        const ElementState e = tables_.state(k, u);
        const PointGradients points(mesh().element, e);
        const ViscousModuli<double> m = moduli(k);
        // the points, then what varies within a voxel
        const double* before = before_.row(k);
        Mat3<double> P[kMaxPoints] = {};
        for (int q = 0; q < e.points; ++q, before += 6)
          add_viscous(m, minus_identity(points.F(q)), before, P[q]);
        points.add_force(e, P, f);
        if (!varies()) return;
        const Within part = within(k, e);
        for (int i = 0; i < 12; ++i) {
          const double slope = part.weight[i % 4] * (part.A(i / 4, i % 4) - before[i]);
          double row[24];
          part.row(i / 4, i % 4, row);
          for (int a = 0; a < 24; ++a) f[a] += slope * row[a];
        }
      },
      g);
}

void ViscousBody::element_hessian(int64_t element, In<double> u, TangentKind kind,
                                  double* K) const {
  tables_.check_nodal(u);
  const ElementState e = tables_.state(element, u);
  const PointGradients points(mesh().element, e);
  const ViscousModuli<double> m = moduli(element);
  const bool projected = kind == TangentKind::kProjected, shares = points.shares_dilatation();
  // the points
  const double* before = before_.row(element);
  Mat3<double> P[kMaxPoints] = {};
  double A[81 * kMaxPoints];
  for (int q = 0; q < e.points; ++q, before += 6) {
    const Mat3<double> H = minus_identity(points.F(q));
    add_viscous(m, H, before, P[q]);
    viscous_gradient(m, H, before, shares ? TangentKind::kTrue : kind, A + 81 * q);
  }
  points.stiffness(e, P, A, true, K);
  if (projected && shares) clamp_eigenvalues(3 * e.nodes, K);
  if (!varies()) return;
  // what varies within a voxel
  const Within part = within(element, e);
  for (int i = 0; i < 12; ++i) {
    const double weight = part.weight[i % 4];
    double row[24];
    part.row(i / 4, i % 4, row);
    for (int a = 0; a < 24; ++a)
      for (int b = 0; b < 24; ++b) K[24 * a + b] += weight * (row[a] * row[b]);
    const double slope = weight * (part.A(i / 4, i % 4) - before[i]);
    if (!projected) part.add_curvature(i / 4, i % 4, slope, K);
  }
}

}  // namespace elastogen::fem
