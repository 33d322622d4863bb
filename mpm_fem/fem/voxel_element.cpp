// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/voxel_element.hpp"

namespace elastogen::fem {
namespace {

/// Sign of corner c along an axis.
double sign(int c, int axis) {
  return c >> axis & 1 ? 1 : -1;
}

/// Sets the next row to 0 and gives it.
double* next_row(VoxelHourglass& h, double weight) {
  h.weight[h.count] = weight;
  for (double& value : h.row[h.count]) value = 0;
  return h.row[h.count++];
}

/// Adds to a row component d of R^T q of a pattern.
void add_rotated(const double pattern[8], const double* R, int d, double* row) {
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) row[3 * c + i] += R[3 * i + d] * pattern[c];
}

double row_times(const double row[24], const double* u) {
  double sum = 0;
  for (int k = 0; k < 24; ++k) sum += row[k] * u[k];
  return sum;
}

}  // namespace

void voxel_gradient(const double* shape_mean, double h, double* gradient) {
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d)
      gradient[3 * c + d] = sign(c, d) * (shape_mean[c] + shape_mean[c ^ 1 << d]) / h;
}

void voxel_patterns(const double* shape_mean, double pattern[4][8]) {
  double moment[3] = {};
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) moment[d] += shape_mean[c] * sign(c, d);
  for (int c = 0; c < 8; ++c) {
    pattern[3][c] = sign(c, 0) * sign(c, 1) * sign(c, 2);
    for (int d = 0; d < 3; ++d) {
      const int third = (d + 2) % 3;
      pattern[d][c] = sign(c, d) * sign(c, (d + 1) % 3) + moment[third] * pattern[3][c];
    }
  }
}

VoxelHourglass voxel_hourglass(const ElementMesh& mesh, int64_t voxel, double mu, const double* R) {
  constexpr double kUnit[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  VoxelHourglass h;
  if (mesh.hourglass == Hourglass::kOff) return h;
  const double scale = mesh.fill(voxel) * mesh.h;
  const double* c = mesh.variance.row(voxel);
  double pattern[4][8];
  voxel_patterns(mesh.shape_mean.row(voxel), pattern);
  for (int p = 0; p < 4; ++p)
    for (int i = 0; i < 3; ++i)
      add_rotated(pattern[p], kUnit, i, next_row(h, scale * c[p] / (p < 3 ? 24 : 48)));
  if (mesh.hourglass == Hourglass::kVariance) return h;
  // torsion: sums of two of yz of x, zx of y, xy of z, less the variance energy of each
  constexpr int kPattern[3] = {1, 2, 0};
  for (int d = 0; d < 3; ++d) {
    const int e = (d + 1) % 3;
    double* sum = next_row(h, scale * mu / 48);
    add_rotated(pattern[kPattern[d]], R, d, sum);
    add_rotated(pattern[kPattern[e]], R, e, sum);
    add_rotated(pattern[kPattern[d]], R, d, next_row(h, -scale * c[kPattern[d]] / 24));
  }
  return h;
}

double hourglass_energy(const VoxelHourglass& hourglass, const double* u) {
  double sum = 0;
  for (int k = 0; k < hourglass.count; ++k) {
    const double q = row_times(hourglass.row[k], u);
    sum += hourglass.weight[k] * q * q;
  }
  return sum / 2;
}

void add_hourglass_gradient(const VoxelHourglass& hourglass, const double* u, double* f) {
  for (int k = 0; k < hourglass.count; ++k) {
    const double force = hourglass.weight[k] * row_times(hourglass.row[k], u);
    for (int i = 0; i < 24; ++i) f[i] += force * hourglass.row[k][i];
  }
}

void add_hourglass_hessian(const VoxelHourglass& hourglass, double* K) {
  for (int k = 0; k < hourglass.count; ++k) {
    const double* v = hourglass.row[k];
    for (int row = 0; row < 24; ++row)
      for (int col = 0; col < 24; ++col)
        K[24 * row + col] += hourglass.weight[k] * (v[row] * v[col]);
  }
}

}  // namespace elastogen::fem
