// SPDX-License-Identifier: Apache-2.0
// Bytes as a file of tensors, sealed here, so that the code behind the check of the seal is
// reached.

#include "core/tensor_file.hpp"
#include "tests/fuzz/harness.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  std::string bytes(reinterpret_cast<const char*>(data), size);
  const Sha256 seal = sha256(bytes);
  bytes.append(reinterpret_cast<const char*>(seal.data()), seal.size());
  try {
    const TensorFile file = decode_tensors(bytes, "fuzz.weights");
    for (const Tensor& tensor : file.tensors)
      for (const float value : tensor.values)
        fuzz::require(std::isfinite(value), "every number is finite");
    const TensorFile again = decode_tensors(encode_tensors(file), "again");
    fuzz::require(again.text == file.text && again.tensors.size() == file.tensors.size(),
                  "what was read is written and read again");
  } catch (const Error& error) {
    fuzz::require_kind(error, ErrorKind::kAsset);
  }
  return 0;
}
