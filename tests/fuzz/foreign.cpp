// SPDX-License-Identifier: Apache-2.0
// The reading of elastogen-reader without its limits: the first byte chooses one of FUZZ_FORMATS. A
// crash here is a library's; in the command it ends only the reader's process. A library may throw
// anything, as in the reader; the asset that it returns must survive the pipe.

#include "io/asset_stream.hpp"
#include "reader/assimp_reader.hpp"
#include "tests/fuzz/asset_harness.hpp"
#include "voxelize/vdb_io.hpp"

#include <cstddef>
#include <cstdint>
#include <exception>

namespace elastogen {
namespace {

Asset read(const std::string& format, std::string_view bytes) {
  const std::string path = fuzz::file("fuzz." + format, bytes);
  return format == "vdb" ? read_vdb(path) : read_assimp(path, format);
}

}  // namespace
}  // namespace elastogen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  static const std::string kFormats[] = {FUZZ_FORMATS};
  if (size == 0) return 0;
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::string& format = kFormats[data[0] % std::size(kFormats)];
  std::string answer;
  try {
    answer = encode_asset(read(format, bytes.substr(1)));
  } catch (const std::exception&) {
    return 0;
  }
  fuzz::check_reader([&] { return decode_asset(answer, fuzz::path_of("fuzz." + format)); });
  return 0;
}
