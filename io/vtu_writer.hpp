// SPDX-License-Identifier: Apache-2.0
// Voxels or tetrahedra with strain and stress for ParaView: a PVD collection and one VTU file a
// frame.

#pragma once

#include "io/animation_writer.hpp"

namespace elastogen {

/// A writer of NAME.pvd, written by finish(), and of NAME_00000.vtu, ... beside it, each complete
/// as soon as its frame has come. Voxels are hexahedra at their deformed corners [m], tetrahedra
/// are linear or quadratic. Appended raw data, float32:
///
/// - cells: `F` (9, row-major), `J`, `cauchy_stress` [Pa] (xx yy zz xy yz xz; NaN where J <= 0),
///   `fill` (voxels only), `material`; F is the mean gradient over the filled part of a voxel, or
///   the gradient at the centroid of a tetrahedron;
/// - points: `displacement` [m], `velocity` [m/s], `residual` [N] where the frame has one.
///
/// @throws Error (usage) without options.scene, and from frame without a state of the scene; others
///         as AnimationWriter.
std::unique_ptr<AnimationWriter> make_vtu_writer(const std::string& path,
                                                 const AnimationOptions& options);

}  // namespace elastogen
