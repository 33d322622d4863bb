// SPDX-License-Identifier: Apache-2.0
// Any bytes either give an asset that the gate lets through, which can then be posed, or an Error.

#include FUZZ_HEADER

#include "core/error.hpp"
#include "io/asset_check.hpp"

#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  try {
    Asset asset = FUZZ_READ;
    check_asset(asset);
  } catch (const Error&) {
  }
  return 0;
}
