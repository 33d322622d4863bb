// SPDX-License-Identifier: Apache-2.0
// Values of glTF accessors. Strides, integer types, normalisation and sparse entries are resolved;
// all ranges are checked without overflow.

#pragma once

#include "core/array.hpp"
#include "io/gltf_source.hpp"

namespace tinygltf {
class Model;
}

namespace elastogen {

/// Values of a float or integer accessor, (count, components of its type). A normalised integer c
/// of b bits becomes c / (2^b - 1), a signed one max(c / (2^(b-1) - 1), -1).
/// @throws Error (asset) if the accessor, its buffer view or its sparse part goes beyond its bytes,
///         or it is not a scalar or vector.
Array<double> accessor_values(const GltfSource& source, const tinygltf::Model& model, int accessor);

/// Entries of an accessor of 4x4 float matrices, column-major, (count, 16).
/// @throws Error (asset) as accessor_values, and on any other type.
Array<double> accessor_matrices(const GltfSource& source, const tinygltf::Model& model,
                                int accessor);

/// Values of an accessor of vertex indices, each below `vertices`.
/// @throws Error (asset) as accessor_values, and on an index out of range or a type other than
///         unsigned scalars.
std::vector<uint32_t> accessor_indices(const GltfSource& source, const tinygltf::Model& model,
                                       int accessor, int64_t vertices);

}  // namespace elastogen
