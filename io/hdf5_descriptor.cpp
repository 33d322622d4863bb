// SPDX-License-Identifier: Apache-2.0
// HDF5 files on an open descriptor. The library opens files by name only, but an unfinished file
// has no name.

#include "core/error.hpp"
#include "io/hdf5_file.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

namespace elastogen::hdf5 {
namespace {

/// The library's part of a file, then our part.
struct DescriptorFile {
  H5FD_t common = {};
  int descriptor = -1;
  haddr_t end_of_addresses = 0, end_of_file = 0;
};

DescriptorFile& ours(H5FD_t* file) {
  return *reinterpret_cast<DescriptorFile*>(file);
}
const DescriptorFile& ours(const H5FD_t* file) {
  return *reinterpret_cast<const DescriptorFile*>(file);
}

H5FD_t* open_file(const char*, unsigned, hid_t properties, haddr_t) {
  const auto* descriptor = static_cast<const int*>(H5Pget_driver_info(properties));
  if (!descriptor) return nullptr;
  auto file = std::make_unique<DescriptorFile>();
  file->descriptor = *descriptor;
  return &file.release()->common;  // the library hands it to close_file
}

herr_t close_file(H5FD_t* file) {
  const std::unique_ptr<DescriptorFile> last(&ours(file));
  return 0;
}

herr_t query(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA;
  return 0;
}

haddr_t get_eoa(const H5FD_t* file, H5FD_mem_t) {
  return ours(file).end_of_addresses;
}

herr_t set_eoa(H5FD_t* file, H5FD_mem_t, haddr_t address) {
  ours(file).end_of_addresses = address;
  return 0;
}

haddr_t get_eof(const H5FD_t* file, H5FD_mem_t) {
  return ours(file).end_of_file;
}

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, size_t size, void* to) {
  auto* at = static_cast<char*>(to);
  while (size > 0) {
    const ssize_t n = ::pread(ours(file).descriptor, at, size, off_t(address));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    if (n == 0) {  // beyond the end: zeros, as the library expects
      std::memset(at, 0, size);
      return 0;
    }
    at += n, address += haddr_t(n), size -= size_t(n);
  }
  return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, size_t size, const void* from) {
  const auto* at = static_cast<const char*>(from);
  while (size > 0) {
    const ssize_t n = ::pwrite(ours(file).descriptor, at, size, off_t(address));
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return -1;
    at += n, address += haddr_t(n), size -= size_t(n);
  }
  ours(file).end_of_file = std::max(ours(file).end_of_file, address);
  return 0;
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t) {
  DescriptorFile& f = ours(file);
  if (f.end_of_file == f.end_of_addresses) return 0;
  if (::ftruncate(f.descriptor, off_t(f.end_of_addresses)) != 0) return -1;
  f.end_of_file = f.end_of_addresses;
  return 0;
}

H5FD_class_t driver_class() {
  H5FD_class_t c{};
  c.name = "descriptor";
  c.maxaddr = haddr_t(1) << 62;
  c.fc_degree = H5F_CLOSE_STRONG;
  c.fapl_size = sizeof(int);
  c.open = open_file;
  c.close = close_file;
  c.query = query;
  c.get_eoa = get_eoa;
  c.set_eoa = set_eoa;
  c.get_eof = get_eof;
  c.read = read;
  c.write = write;
  c.truncate = truncate;
  const H5FD_mem_t map[H5FD_MEM_NTYPES] = H5FD_FLMAP_DICHOTOMY;
  std::copy(map, map + H5FD_MEM_NTYPES, c.fl_map);
  return c;
}

}  // namespace

Handle create_file(int descriptor, const std::string& path) {
  // else the library tries at exit to write data that a full disk has refused, and crashes
  H5dont_atexit();
  // errors are reported as exceptions, not on stderr
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  static const H5FD_class_t driver = driver_class();
  static const hid_t id = H5FDregister(&driver);
  const Handle properties(H5Pcreate(H5P_FILE_ACCESS), H5Pclose, path);
  check(H5Pset_driver(properties, id, &descriptor), path);
  return {H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, properties), H5Fclose, path};
}

}  // namespace elastogen::hdf5
