// SPDX-License-Identifier: Apache-2.0
// Change of the normals of a mesh when its vertices move.

#pragma once

#include "core/array.hpp"
#include "io/asset.hpp"

namespace elastogen {

/// Change of each drawn vertex's normal n. A triangle with edges e1, e2 and unit normal m
/// transforms n as a covector,
///
///     n' = (n.e1) (e2' x m') / |e1' x e2'| + (n.e2) (m' x e1') / |e1' x e2'| + (n.m) m',
///
/// exactly R n under a rotation R, whatever the direction of n. The delta is the mean of n' over
/// the vertex's triangles, weighted by their areas at rest, scaled to the length of n, minus n.
/// Triangles without area, at rest or moved, are left out; a vertex without triangles keeps n.
/// @param displacement  of the positions in the mesh's own numbers, (positions, 3).
/// @param delta  result, (drawn vertices, 3).
void normal_deltas(const Mesh& mesh, In<double> displacement, Out<float> delta);

}  // namespace elastogen
