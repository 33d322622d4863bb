// SPDX-License-Identifier: Apache-2.0
#include "io/lzf.hpp"

namespace elastogen {

std::optional<std::string> lzf_unpacked(std::string_view packed, size_t size) {
  constexpr size_t kMaxRatio = 88;  // a copy of 264 bytes takes three
  if (size / kMaxRatio > packed.size()) return {};
  std::string out;
  out.reserve(size);
  const auto next = [&] {
    const auto byte = static_cast<unsigned char>(packed.front());
    packed.remove_prefix(1);
    return size_t(byte);
  };

  while (!packed.empty()) {
    const size_t control = next();
    if (control < 32) {  // the next bytes as they are
      const size_t n = control + 1;
      if (n > packed.size() || n > size - out.size()) return {};
      out += packed.substr(0, n);
      packed.remove_prefix(n);
      continue;
    }

    // a copy of earlier bytes, which may overlap the bytes that it writes
    size_t n = (control >> 5) + 2;
    if (n == 9) {
      if (packed.empty()) return {};
      n += next();
    }
    if (packed.empty()) return {};
    const size_t back = ((control & 31) << 8) + next() + 1;
    if (back > out.size() || n > size - out.size()) return {};
    for (size_t k = 0; k < n; ++k) out += out[out.size() - back];
  }
  if (out.size() != size) return {};
  return out;
}

}  // namespace elastogen
