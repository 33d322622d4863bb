// SPDX-License-Identifier: Apache-2.0
// Decompression of LZF (M. Lehmann, liblzf), which compressed PCD files use.

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace elastogen {

/// The `size` bytes that were packed, none if the packed ones do not give exactly as many. Memory
/// is taken only where the packed bytes could give so many (88 times their number at most).
std::optional<std::string> lzf_unpacked(std::string_view packed, size_t size);

}  // namespace elastogen
