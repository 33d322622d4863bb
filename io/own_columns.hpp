// SPDX-License-Identifier: Apache-2.0
// Columns of points and splats that mean nothing here, carried to outputs that can hold them.

#pragma once

#include "io/ply_header.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace elastogen {

struct Asset;

/// Numbers of points in the types of their file.
struct OwnColumns {
  struct Column {
    std::string name;  ///< one word
    PlyType type = PlyType::kFloat32;
  };
  std::vector<Column> columns;
  std::string rows;  ///< little-endian, point by point: (points, row_bytes())

  size_t row_bytes() const;

  /// Appends the value of a column of the next point.
  void add(size_t column, double value);
};

/// Bytes of a value; integers are rounded and held within their type, not-a-number is 0 there.
void append_number(std::string& bytes, PlyType type, double value);

/// Finding "carried-columns" that names those of a cloud, if there are any.
void note_own_columns(Asset& asset, const OwnColumns& own);

/// Finding "lost-columns" that names what could not be carried, if there is anything.
void note_lost_columns(Asset& asset, const std::vector<std::string>& names);

}  // namespace elastogen
