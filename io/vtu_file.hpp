// SPDX-License-Identifier: Apache-2.0
// Parts of files for ParaView: unstructured grids (VTU) with appended raw arrays, and the
// collection (PVD) that gives each of them a time.

#pragma once

#include "core/base.hpp"
#include "core/error.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace elastogen {

/// An unstructured grid as XML with its arrays appended.
class VtuFile {
 public:
  void section(const std::string& text) { xml_ += text; }

  /// @param type  VTK's name of T, e.g. "Float32".
  template <class T>
  void array(const std::string& name, const char* type, const std::vector<T>& values,
             int components = 1) {
    const uint64_t bytes = values.size() * sizeof(T);
    xml_ += concat("<DataArray type=\"", type, "\" Name=\"", name, "\" NumberOfComponents=\"",
                   components, "\" format=\"appended\" offset=\"", data_.size(), "\"/>\n");
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof(bytes));
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }
  void floats(const std::string& name, const double* values, int64_t count, int components = 1) {
    array(name, "Float32", std::vector<float>(values, values + count), components);
  }

  /// Positions of points. They are in double precision if `place`, the position of their origin, is
  /// not 0, because floats are coarse there.
  /// @param x  relative to place [m], (points, 3).
  void points(const double* x, int64_t points, const Vec3& place);

  void write(const std::string& path) const;

 private:
  std::string xml_ =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
      "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n";
  std::string data_;
};

/// Writes NAME.pvd over NAME_00000.vtu, ...
class PvdFrames {
 public:
  explicit PvdFrames(const std::string& path);

  /// Writes the next frame. @param time  [s]
  void add(const VtuFile& frame, double time);

  /// Writes the collection. @throws Error (usage) without a frame.
  void finish() const;

 private:
  std::string path_, entries_;
  int64_t frames_ = 0;
};

}  // namespace elastogen
