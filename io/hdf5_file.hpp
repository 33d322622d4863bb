// SPDX-License-Identifier: Apache-2.0
// The few parts of HDF5 that the state file needs: attributes, groups, whole arrays, arrays by
// rows. Not a public header: only io/*.cpp may include it.

#pragma once

#include "core/array.hpp"

#include <hdf5.h>

#include <string>
#include <vector>

namespace elastogen::hdf5 {

/// Owns an identifier of the library. The constructor throws Error (resources) on a failed call.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what);
  Handle(Handle&& other) noexcept;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle();
  operator hid_t() const { return id_; }
  /// Closes before destruction. @throws Error (resources) if buffered data could not be written.
  void close();

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
  std::string what_;
};

/// The type in memory and in the file (little-endian) of a number.
struct NumberType {
  hid_t memory, file;
};
template <class T>
NumberType number_type();

/// @throws Error (resources) saying what failed, if status < 0.
void check(herr_t status, const std::string& what);

/// A file on an open, empty descriptor, which the file does not close; `path` is for messages.
Handle create_file(int descriptor, const std::string& path);
Handle create_group(hid_t parent, const char* name);
/// A dataset of the given extents, without values.
Handle create_dataset(hid_t parent, const char* name, hid_t file_type,
                      const std::vector<hsize_t>& extents);

void write_attribute(hid_t object, const char* name, const std::string& text);
void write_attribute(hid_t object, const char* name, double value);
void write_attribute(hid_t object, const char* name, int value);
/// An attribute of shape (3).
void write_attribute(hid_t object, const char* name, const double (&value)[3]);

/// A dataset of shape (rows) if cols is 1, else (rows, cols).
template <class T>
void write_dataset(hid_t parent, const char* name, Span<const T> values);

/// One entry of a dataset (entries, ...) of four extents at most, which has as many values.
void write_entry(hid_t dataset, hsize_t entry, Span<const double> values);

}  // namespace elastogen::hdf5
