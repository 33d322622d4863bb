// SPDX-License-Identifier: Apache-2.0
// Small scenes as sparse matrices: element matrices by unit vectors, assembly, a direct solve with
// single components held. Degree of freedom 3 node + component.

#pragma once

#include "network/potential/local_model.hpp"

#include <Eigen/SparseCore>

#include <functional>
#include <map>

namespace elastogen::test {

/// A box of full voxels of one material, finished.
Scene box_scene(int nx, int ny, int nz, double h, const Material& material,
                Hourglass hourglass = Hourglass::kFull);

/// A finished scene of the grid with one material and nothing pinned.
Scene scene_of(VoxelGrid grid, const Material& material, Hourglass hourglass = Hourglass::kFull);

/// The element's data of a voxel; the rotation is I.
VoxelData<double> voxel_data(const Scene& scene, int64_t voxel);

/// Corner values (component, corner) of a nodal field with dof 3 node + component.
void gather(const VoxelGrid& grid, int64_t voxel, const Eigen::VectorXd& field, double u[3][8]);

/// The linear map p -> f on corner values as a 24x24 matrix, dof 3 corner + component.
using CornerMap = std::function<void(const double p[3][8], double f[3][8])>;
Eigen::MatrixXd corner_matrix(const CornerMap& map);

/// Stiffness of a voxel at rest.
Eigen::MatrixXd rest_stiffness(const VoxelData<double>& v);

/// Sum over the voxels of their 24x24 matrices.
Eigen::SparseMatrix<double> assemble(const VoxelGrid& grid,
                                     const std::function<Eigen::MatrixXd(int64_t)>& element);

/// Stiffness of a scene at rest.
Eigen::SparseMatrix<double> rest_stiffness(const Scene& scene);

/// Sum over the voxels of the derivative of voxel_energy at displacement u.
Eigen::VectorXd internal_gradient(const Scene& scene, const Eigen::VectorXd& u);

/// Solves K u = f where the held components have given values, by sparse LDL^T.
Eigen::VectorXd solve(const Eigen::SparseMatrix<double>& K, const Eigen::VectorXd& f,
                      const std::map<int, double>& held = {});

}  // namespace elastogen::test
