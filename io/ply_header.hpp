// SPDX-License-Identifier: Apache-2.0
// The header of a PLY file: its elements, and how their values are stored.

#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

enum class PlyType { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

/// Bytes of a value in a binary file.
int size_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::kFloat32;
  bool is_list = false;
  PlyType count_type = PlyType::kUint8;  ///< of a list's length
};

struct PlyElement {
  std::string name;
  int64_t count = 0;
  std::vector<PlyProperty> properties;

  /// Index of the first property with one of the names, -1 if there is none.
  int find(std::initializer_list<std::string_view> names) const;

  /// Index of a property that is not a list. @throws Error (asset) if there is none of that name.
  size_t number(const std::string& property, const std::string& path) const;
};

struct PlyHeader {
  enum Encoding { kText, kLittleEndian, kBigEndian } encoding = kText;
  std::vector<PlyElement> elements;
  std::vector<std::string> textures;  ///< named by "comment TextureFile" lines
  std::vector<std::string> skipped;   ///< beginnings of lines that belong to no header
  size_t bytes = 0;                   ///< of the header; the values follow
  int64_t lines = 0;
};

/// @throws Error (asset) with the line: no magic, no end_header in the first 64 KiB, an unknown
///         type, an invalid count or one beyond the bytes that follow.
PlyHeader read_ply_header(std::string_view bytes, const std::string& path);

}  // namespace elastogen
