// SPDX-License-Identifier: Apache-2.0
#include "tests/support/element_assembly.hpp"

#include "voxelize/bricks.hpp"

#include <Eigen/SparseCholesky>

namespace elastogen::test {

Scene scene_of(VoxelGrid grid, const Material& material, Hourglass hourglass) {
  Scene scene;
  scene.grid = std::move(grid);
  scene.materials = {material};
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  scene.hourglass = hourglass;
  finish_scene(scene);
  return scene;
}

Scene box_scene(int nx, int ny, int nz, double h, const Material& material, Hourglass hourglass) {
  return scene_of(make_box(nx, ny, nz, h), material, hourglass);
}

VoxelData<double> voxel_data(const Scene& scene, int64_t voxel) {
  const Material& m = scene.materials[size_t(scene.material(voxel))];
  VoxelData<double> v{};
  v.law = {m.law, m.mu(), m.lambda()};
  v.h = scene.grid.h;
  v.hourglass = scene.hourglass;
  v.phi = scene.grid.fill(voxel);
  for (int k = 0; k < 4; ++k) v.c[k] = scene.variance(voxel, k);
  hex8::fill_moments(scene.grid.shape_mean.row(voxel), v.M);
  for (int d = 0; d < 3; ++d) v.R[4 * d] = 1;
  return v;
}

void gather(const VoxelGrid& grid, int64_t voxel, const Eigen::VectorXd& field, double u[3][8]) {
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i) u[i][c] = field(3 * grid.corners(voxel, c) + i);
}

Eigen::MatrixXd corner_matrix(const CornerMap& map) {
  Eigen::MatrixXd K(24, 24);
  for (int col = 0; col < 24; ++col) {
    double p[3][8] = {}, f[3][8];
    p[col % 3][col / 3] = 1;
    map(p, f);
    for (int row = 0; row < 24; ++row) K(row, col) = f[row % 3][row / 3];
  }
  return K;
}

Eigen::MatrixXd rest_stiffness(const VoxelData<double>& v) {
  return corner_matrix(
      [&](const double p[3][8], double f[3][8]) { voxel_rest_hessian<true>(v, p, f); });
}

Eigen::SparseMatrix<double> assemble(const VoxelGrid& grid,
                                     const std::function<Eigen::MatrixXd(int64_t)>& element) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const Eigen::MatrixXd K = element(v);
    for (int row = 0; row < 24; ++row)
      for (int col = 0; col < 24; ++col)
        entries.emplace_back(3 * grid.corners(v, row / 3) + row % 3,
                             3 * grid.corners(v, col / 3) + col % 3, K(row, col));
  }
  const Eigen::Index size = 3 * grid.node_count();
  Eigen::SparseMatrix<double> result(size, size);
  result.setFromTriplets(entries.begin(), entries.end());
  return result;
}

Eigen::SparseMatrix<double> rest_stiffness(const Scene& scene) {
  return assemble(scene.grid, [&](int64_t v) { return rest_stiffness(voxel_data(scene, v)); });
}

Eigen::VectorXd internal_gradient(const Scene& scene, const Eigen::VectorXd& u) {
  Eigen::VectorXd result = Eigen::VectorXd::Zero(u.size());
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) {
    double corner[3][8], f[3][8];
    gather(scene.grid, v, u, corner);
    voxel_energy<true>(voxel_data(scene, v), corner, f);
    for (int c = 0; c < 8; ++c)
      for (int i = 0; i < 3; ++i) result(3 * scene.grid.corners(v, c) + i) += f[i][c];
  }
  return result;
}

Eigen::VectorXd solve(const Eigen::SparseMatrix<double>& K, const Eigen::VectorXd& f,
                      const std::map<int, double>& held) {
  Eigen::VectorXd u = Eigen::VectorXd::Zero(f.size());
  for (const auto& [dof, value] : held) u(dof) = value;
  // rows and columns of the free components
  std::vector<int> place(size_t(f.size()), -1);
  int free = 0;
  for (int dof = 0; dof < f.size(); ++dof)
    if (!held.contains(dof)) place[size_t(dof)] = free++;
  std::vector<Eigen::Triplet<double>> entries;
  for (int col = 0; col < K.outerSize(); ++col)
    for (Eigen::SparseMatrix<double>::InnerIterator it(K, col); it; ++it) {
      const int i = place[size_t(it.row())], j = place[size_t(col)];
      if (i >= 0 && j >= 0) entries.emplace_back(i, j, it.value());
    }
  Eigen::SparseMatrix<double> reduced(free, free);
  reduced.setFromTriplets(entries.begin(), entries.end());

  const Eigen::VectorXd load = f - K * u;
  Eigen::VectorXd b(free);
  for (int dof = 0; dof < f.size(); ++dof)
    if (place[size_t(dof)] >= 0) b(place[size_t(dof)]) = load(dof);
  const Eigen::VectorXd x = Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>>(reduced).solve(b);
  for (int dof = 0; dof < f.size(); ++dof)
    if (place[size_t(dof)] >= 0) u(dof) = x(place[size_t(dof)]);
  return u;
}

}  // namespace elastogen::test
