// SPDX-License-Identifier: Apache-2.0
// Columns of points and splats without a meaning here, carried to outputs that can hold them.

#pragma once

#include "io/ply_header.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace elastogen {

struct Asset;

/// Columns of numbers of points, in the types of their file.
struct OwnColumns {
  struct Column {
    std::string name;  ///< one word
    PlyType type = PlyType::kFloat32;
  };
  std::vector<Column> columns;
  std::string rows;  ///< little-endian, point by point: (points, row_bytes())

  size_t row_bytes() const;

  /// Value of a column of a point.
  double value(size_t point, size_t column) const;

  /// Appends the value of a column for the next point.
  void add(size_t column, double value);
};

/// Appends the bytes of a value; integers are rounded and clamped to their type, NaN becomes 0.
void append_number(std::string& bytes, PlyType type, double value);

/// Adds the finding "carried-columns", which names the columns of a cloud, if it has any.
void note_own_columns(Asset& asset, const OwnColumns& own);

/// Adds the finding "lost-columns", which names the columns that could not be carried, if any.
void note_lost_columns(Asset& asset, const std::vector<std::string>& names);

}  // namespace elastogen
