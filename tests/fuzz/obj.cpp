// SPDX-License-Identifier: Apache-2.0
// An OBJ file and, behind the first byte 0, the file fuzz.mtl beside it.

#include "io/obj_reader.hpp"
#include "tests/fuzz/asset_harness.hpp"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const size_t end = std::min(bytes.find('\0'), size);
  if (end < size) fuzz::file("fuzz.mtl", bytes.substr(end + 1));
  const std::string path = fuzz::path_of("fuzz.obj");
  fuzz::check_reader([&] { return parse_obj(bytes.substr(0, end), path); });
  return 0;
}
