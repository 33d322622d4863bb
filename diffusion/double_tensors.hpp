// SPDX-License-Identifier: Apache-2.0
// Doubles in a file of float tensors: the nearest float as NAME, the remainder as NAME.rest. They
// are needed where many large terms cancel, for which floats are too coarse.

#pragma once

#include "core/array.hpp"
#include "core/tensor_file.hpp"

namespace elastogen {

/// Adds an array (rows, cols). @throws Error (usage) if a number exceeds the range of floats.
void add_doubles(TensorFile& file, const std::string& name, In<double> values);

/// Reads such an array. @throws Error (asset) if it is missing or has other sizes.
Array<double> get_doubles(const TensorFile& file, const std::string& name, int64_t rows, int cols);

/// The number that a text of the file states, within least ... most.
/// @throws Error (asset) naming the text if it is missing, no number, or outside that range.
int64_t get_count(const TensorFile& file, const std::string& name, int64_t least, int64_t most);

}  // namespace elastogen
