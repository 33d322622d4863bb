// SPDX-License-Identifier: Apache-2.0
// Point clouds as lines of numbers (.xyz .asc .pts) to an Asset.

#pragma once

#include "io/asset.hpp"

#include <string_view>

namespace elastogen {

/// One point a line: x y z and further columns between blanks, tabs, commas or semicolons; lines
/// that begin with # or // are comments. A first line of words names the columns (x y z, r g b or
/// red green blue, nx ny nz; also behind the sign of a comment). A first line of one integer is the
/// number of points. Without names: three further columns of unit length in every line are normals;
/// three within 0 ... 1 or 0 ... 255 are sRGB colours; behind a number of points and with seven
/// columns, the fourth is an intensity. Other columns of numbers are carried under their names,
/// else as column_4, ... (finding carried-columns); columns of words are not (lost-columns). Points
/// that are nan are left to the check.
/// @throws Error (asset) with file and line: fewer than three numbers, a word that is no number,
///         another count of columns than the first point has, decimal commas, another number of
///         points than the first line says.
Asset read_xyz(const std::string& path);

/// Reads points from memory; `path` is for messages.
Asset parse_xyz(std::string_view bytes, const std::string& path);

}  // namespace elastogen
