// SPDX-License-Identifier: Apache-2.0
// Builds without CUDA have no card.
#include "bench/card.hpp"
#include "core/error.hpp"

namespace elastogen::bench {
namespace {

[[noreturn]] void refuse() {
  throw Error("built without CUDA", ErrorKind::kDevice);
}

}  // namespace

double card_copy_rate() {
  refuse();
}

CardCeilings card_ceilings() {
  refuse();
}

int64_t card_memory_used() {
  refuse();
}

std::vector<KernelRow> card_kernels(const Scene&) {
  refuse();
}

}  // namespace elastogen::bench
