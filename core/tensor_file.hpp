// SPDX-License-Identifier: Apache-2.0
// Flat files of named tensors and texts: weights with their model card. Numbers only, nothing that
// is executed; sealed by a SHA-256. Layout in docs/formats.md.

#pragma once

#include "core/hash.hpp"

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// Row-major float32 numbers; a tensor without dimensions holds one.
struct Tensor {
  std::string name;
  std::vector<int64_t> shape;
  std::vector<float> values;
};

struct TensorFile {
  std::map<std::string, std::string> text;  ///< the model card: who made it, from what, how good
  std::vector<Tensor> tensors;

  /// The tensor of that name. @throws Error (asset) if there is none, or of another shape.
  const Tensor& get(std::string_view name, const std::vector<int64_t>& shape) const;
};

/// Largest file that is read [bytes].
inline constexpr int64_t kMaxTensorBytes = int64_t{1} << 31;

/// The bytes of a file; the last 32 are the SHA-256 of those before.
/// @throws Error if a tensor's numbers do not fit its shape, a name is empty, there twice or has
///         more than 255 bytes, or a text more than 1 MiB.
std::string encode_tensors(const TensorFile& file);

/// Reads the bytes of encode_tensors.
/// @param place  name of the file, for messages.
/// @throws Error (asset) that names the place: not a file of tensors, of a later version, cut
///         short, changed since it was written, counts out of range, names twice, numbers that
///         are not finite.
TensorFile decode_tensors(std::string_view bytes, const std::string& place);

}  // namespace elastogen
