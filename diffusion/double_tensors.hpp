// SPDX-License-Identifier: Apache-2.0
// Doubles in a file of float tensors: the nearest float as NAME, what it misses as NAME.rest. Used
// where many large terms cancel, so that floats alone would not do.

#pragma once

#include "core/array.hpp"
#include "core/tensor_file.hpp"

namespace elastogen {

/// Adds an array (rows, cols). @throws Error (usage) if a number is no float.
void add_doubles(TensorFile& file, const std::string& name, In<double> values);

/// @throws Error (asset) if there is none, or of other sizes.
Array<double> get_doubles(const TensorFile& file, const std::string& name, int64_t rows, int cols);

/// The number a text of the file states, within least ... most.
/// @throws Error (asset) that names it, where it is missing, no number or beyond them.
int64_t get_count(const TensorFile& file, const std::string& name, int64_t least, int64_t most);

}  // namespace elastogen
