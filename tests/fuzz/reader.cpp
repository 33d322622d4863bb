// SPDX-License-Identifier: Apache-2.0
// Any bytes as a file of one format (CMakeLists.txt: FUZZ_READ reads `bytes`).

#include FUZZ_HEADER

#include "tests/fuzz/asset_harness.hpp"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  using fuzz::file, fuzz::path_of;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  fuzz::check_reader([&]() -> Asset { return FUZZ_READ; });
  return 0;
}
