// SPDX-License-Identifier: Apache-2.0
#include "io/tets/vtu_arrays.hpp"

#include "io/safe_file.hpp"

#include <zlib.h>

#include <algorithm>
#include <vector>

namespace elastogen::tets {
namespace {

constexpr int64_t kMaxRatio = 100;  ///< unpacked over the size of the file

/// Value of a letter of base64, -1 for others.
int value_of(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  return c == '+' ? 62 : c == '/' ? 63 : -1;
}

/// Bytes that are raw or base64. Several pieces of base64, each padded by itself, may follow one
/// another.
class Bytes {
 public:
  Bytes(std::string_view rest, bool is_base64, const std::string& place)
      : rest_(rest), is_base64_(is_base64), place_(place) {}

  std::string take(int64_t count) {
    const auto left = int64_t(is_base64_ ? rest_.size() / 4 * 3 : rest_.size());
    check(count >= 0 && count <= int64_t(buffer_.size()) + left,
          "fewer bytes are there than its header claims");
    if (!is_base64_) {
      std::string bytes(rest_.substr(0, size_t(count)));
      rest_.remove_prefix(size_t(count));
      return bytes;
    }
    while (int64_t(buffer_.size()) < count) decode_four();
    std::string bytes = buffer_.substr(0, size_t(count));
    buffer_.erase(0, size_t(count));
    return bytes;
  }

  /// Reads numbers of a header.
  std::vector<int64_t> numbers(int64_t count, const VtuEncoding& encoding) {
    const int64_t size = size_of(encoding.header);
    check(count >= 0 && count <= int64_t(encoding.file.size()) / size,
          "more blocks are claimed than the file has bytes for");
    const std::string bytes = take(count * size);
    MeshSource source(bytes, place_);
    source.begin_binary(encoding.order);
    std::vector<int64_t> values(static_cast<size_t>(count));
    for (int64_t& value : values) value = source.integer(encoding.header, "the header");
    return values;
  }

  void check(bool condition, const char* what) const {
    ELASTOGEN_CHECK_ASSET(condition, place_, ": ", what);
  }

 private:
  void decode_four() {
    uint32_t bits = 0;
    int letters = 0, padding = 0;
    while (letters + padding < 4) {
      while (!rest_.empty() && (is_blank(rest_[0]) || rest_[0] == '\n')) rest_.remove_prefix(1);
      check(!rest_.empty(), "its base64 ends too early");
      const char c = rest_[0];
      rest_.remove_prefix(1);
      const int value = value_of(c);
      check(c == '=' ? letters >= 2 : value >= 0 && padding == 0, "its base64 is damaged");
      c == '=' ? ++padding : ++letters;
      bits = bits << 6 | uint32_t(std::max(value, 0));
    }
    for (int k = 0; k < letters - 1; ++k) buffer_ += char(bits >> (16 - 8 * k) & 0xff);
  }

  std::string_view rest_;
  std::string buffer_;
  bool is_base64_;
  const std::string& place_;
};

/// Unpacks blocks behind a header. The header has their number, the size of all but the last, the
/// size of the last (0: as the others), and the packed size of each.
std::string unpacked(Bytes& bytes, const VtuEncoding& encoding) {
  const std::vector<int64_t> head = bytes.numbers(3, encoding);
  const std::vector<int64_t> packed_size = bytes.numbers(head[0], encoding);
  const int64_t limit = std::min(kMaxFileBytes, kMaxRatio * int64_t(encoding.file.size()));
  std::string all;
  for (size_t b = 0; b < packed_size.size(); ++b) {
    const int64_t size = b + 1 == packed_size.size() && head[2] > 0 ? head[2] : head[1];
    bytes.check(size >= 0 && size <= limit - int64_t(all.size()),
                "it would unpack to more than 100 times the file");
    const std::string packed = bytes.take(packed_size[b]);
    const size_t done = all.size();
    all.resize(done + size_t(size));
    auto length = uLongf(size);
    const int result = uncompress(reinterpret_cast<Bytef*>(all.data() + done), &length,
                                  reinterpret_cast<const Bytef*>(packed.data()), packed.size());
    bytes.check(result == Z_OK && int64_t(length) == size, "a packed block is damaged");
  }
  return all;
}

}  // namespace

std::string decoded(const VtuArray& array, const VtuEncoding& encoding) {
  const bool is_inline = array.format == VtuArray::Format::kInline;
  ELASTOGEN_CHECK_ASSET(is_inline || array.offset <= encoding.appended.size(), array.place,
                        ": it begins behind the end of the appended data");
  Bytes bytes(is_inline ? array.text : encoding.appended.substr(array.offset),
              is_inline || encoding.is_base64, array.place);
  if (encoding.is_packed) return unpacked(bytes, encoding);
  return bytes.take(bytes.numbers(1, encoding)[0]);
}

}  // namespace elastogen::tets
