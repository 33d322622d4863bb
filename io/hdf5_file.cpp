// SPDX-License-Identifier: Apache-2.0
#include "io/hdf5_file.hpp"

#include "core/error.hpp"

#include <cerrno>
#include <cstring>

namespace elastogen::hdf5 {

namespace {

Handle scalar_space() {
  return {H5Screate(H5S_SCALAR), H5Sclose, "dataspace"};
}

void write_attribute(hid_t object, const char* name, hid_t file_type, hid_t memory_type,
                     hid_t space, const void* value) {
  const Handle attribute(H5Acreate2(object, name, file_type, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose, name);
  check(H5Awrite(attribute, memory_type, value), name);
}

}  // namespace

void check(herr_t status, const std::string& what) {
  if (status >= 0) return;
  const int reason = errno;  // of the system call, if one failed
  const bool system = reason == ENOSPC || reason == EFBIG || reason == EDQUOT || reason == EIO;
  throw Error(
      concat("writing HDF5 failed at ", what, system ? concat(": ", std::strerror(reason)) : ""),
      ErrorKind::kResources);
}

Handle::Handle(hid_t id, herr_t (*close)(hid_t), const std::string& what)
    : id_(id), close_(close), what_(what) {
  check(id < 0 ? -1 : 0, what);
}

Handle::Handle(Handle&& other) noexcept
    : id_(std::exchange(other.id_, -1)), close_(other.close_), what_(std::move(other.what_)) {}

Handle::~Handle() {
  if (id_ >= 0) close_(id_);
}

void Handle::close() {
  check(close_(std::exchange(id_, -1)), what_);
}

template <>
NumberType number_type<float>() {
  return {H5T_NATIVE_FLOAT, H5T_IEEE_F32LE};
}
template <>
NumberType number_type<double>() {
  return {H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE};
}
template <>
NumberType number_type<int32_t>() {
  return {H5T_NATIVE_INT32, H5T_STD_I32LE};
}
template <>
NumberType number_type<uint8_t>() {
  return {H5T_NATIVE_UINT8, H5T_STD_U8LE};
}

Handle create_group(hid_t parent, const char* name) {
  return {H5Gcreate2(parent, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), H5Gclose, name};
}

Handle create_dataset(hid_t parent, const char* name, hid_t file_type,
                      const std::vector<hsize_t>& extents) {
  const Handle space(H5Screate_simple(int(extents.size()), extents.data(), nullptr), H5Sclose,
                     name);
  // no time of day in the file, so that every run gives the same bits
  const Handle creation(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, name);
  check(H5Pset_obj_track_times(creation, false), name);
  return {H5Dcreate2(parent, name, file_type, space, H5P_DEFAULT, creation, H5P_DEFAULT), H5Dclose,
          name};
}

void write_attribute(hid_t object, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose, name);
  check(H5Tset_size(type, text.size() + 1), name);
  check(H5Tset_cset(type, H5T_CSET_UTF8), name);
  write_attribute(object, name, type, type, scalar_space(), text.c_str());
}

void write_attribute(hid_t object, const char* name, double value) {
  write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, scalar_space(), &value);
}

void write_attribute(hid_t object, const char* name, int value) {
  write_attribute(object, name, H5T_STD_I32LE, H5T_NATIVE_INT, scalar_space(), &value);
}

void write_attribute(hid_t object, const char* name, const double (&value)[3]) {
  const hsize_t extent = 3;
  const Handle space(H5Screate_simple(1, &extent, nullptr), H5Sclose, name);
  write_attribute(object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, space, value);
}

template <class T>
void write_dataset(hid_t parent, const char* name, Span<const T> values) {
  std::vector<hsize_t> extents = {hsize_t(values.rows)};
  if (values.cols != 1) extents.push_back(hsize_t(values.cols));
  const auto [memory, file] = number_type<T>();
  const Handle dataset = create_dataset(parent, name, file, extents);
  if (values.size() == 0) return;
  check(H5Dwrite(dataset, memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data), name);
}

template void write_dataset(hid_t, const char*, Span<const double>);
template void write_dataset(hid_t, const char*, Span<const float>);
template void write_dataset(hid_t, const char*, Span<const int32_t>);
template void write_dataset(hid_t, const char*, Span<const uint8_t>);

void write_entry(hid_t dataset, hsize_t entry, Span<const double> values) {
  if (values.size() == 0) return;
  const Handle file_space(H5Dget_space(dataset), H5Sclose, "dataspace");
  const hsize_t start[4] = {entry};
  hsize_t count[4];
  const int rank = H5Sget_simple_extent_dims(file_space, count, nullptr);
  check(rank, "dataspace");
  count[0] = 1;
  check(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, nullptr, count, nullptr), "entry");
  const Handle memory_space(H5Screate_simple(rank, count, nullptr), H5Sclose, "dataspace");
  check(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory_space, file_space, H5P_DEFAULT, values.data),
        "entry");
}

}  // namespace elastogen::hdf5
