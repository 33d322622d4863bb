// SPDX-License-Identifier: Apache-2.0
#include "io/tets/mesh_source.hpp"

#include <algorithm>

namespace elastogen::tets {

std::string MeshSource::place() const {
  if (binary_) return concat(name_, ": byte ", last_, ": ");
  const std::string_view before = bytes_.substr(0, last_);
  return concat(name_, ':', 1 + std::count(before.begin(), before.end(), '\n'), ": ");
}

std::string_view MeshSource::line() {
  last_ = at_;
  std::string_view rest = bytes_.substr(at_);
  const std::string_view line = next_line(rest);
  at_ = bytes_.size() - rest.size();
  return line;
}

std::string_view MeshSource::next_word() {
  const auto blank = [](char c) { return is_blank(c) || c == '\n'; };
  while (at_ < bytes_.size() && blank(bytes_[at_])) ++at_;
  last_ = at_;
  while (at_ < bytes_.size() && !blank(bytes_[at_])) ++at_;
  return bytes_.substr(last_, at_ - last_);
}

std::string_view MeshSource::word(const char* expected) {
  const std::string_view word = next_word();
  check(!word.empty(), "the file ends where ", expected, " should be");
  return word;
}

void MeshSource::skip_past(const std::string& text) {
  last_ = at_;
  const size_t found = bytes_.find(text, at_);
  check(found != bytes_.npos, "the file ends before ", text);
  at_ = found + text.size();
}

template <class T>
T MeshSource::raw(const char* what) {
  last_ = at_;
  check(left() >= int64_t(sizeof(T)), "the file ends within ", what);
  char bytes[sizeof(T)];
  std::memcpy(bytes, bytes_.data() + at_, sizeof(T));
  at_ += sizeof(T);
  if (order_ != std::endian::native) std::reverse(bytes, bytes + sizeof(T));
  return std::bit_cast<T>(bytes);
}

int64_t MeshSource::raw_integer(Number type, const char* what) {
  switch (type) {
    case Number::kInt8:
      return raw<int8_t>(what);
    case Number::kUint8:
      return raw<uint8_t>(what);
    case Number::kInt16:
      return raw<int16_t>(what);
    case Number::kUint16:
      return raw<uint16_t>(what);
    case Number::kInt32:
      return raw<int32_t>(what);
    case Number::kUint32:
      return raw<uint32_t>(what);
    case Number::kInt64:
      return raw<int64_t>(what);
    default: {
      const auto value = raw<uint64_t>(what);
      check(value <= uint64_t(std::numeric_limits<int64_t>::max()), what, " is ", value);
      return int64_t(value);
    }
  }
}

int64_t MeshSource::integer(Number type, const char* what) {
  if (binary_) return raw_integer(type, what);
  const std::string_view text = word(what);
  const std::optional<int64_t> value = to_integer(text);
  check(value.has_value(), what, " must be an integer, not \"", text.substr(0, 40), '"');
  return *value;
}

int64_t MeshSource::integer_below(Number type, int64_t limit, const char* what) {
  const int64_t value = integer(type, what);
  check(value >= 0 && value < limit, what, " must be from 0 to ", limit - 1, ", not ", value);
  return value;
}

double MeshSource::finite(Number type, const char* what) {
  double value = 0;
  if (!binary_) {
    const std::string_view text = word(what);
    const std::optional<double> number = to_double(text);
    check(number.has_value(), what, " must be a number, not \"", text.substr(0, 40), '"');
    value = *number;
  } else if (is_integer(type)) {
    value = double(raw_integer(type, what));
  } else {
    value = type == Number::kFloat32 ? double(raw<float>(what)) : raw<double>(what);
  }
  check(std::isfinite(value), what, " is not finite");
  return value;
}

void MeshSource::claim(int64_t count, Number type, const char* what) const {
  // a word needs at least one letter and a blank; the last word may lack the blank
  const int64_t most = binary_ ? left() / size_of(type) : (left() + 1) / 2;
  check(count >= 0 && count <= most, count, " numbers of ", what, " are claimed but only ", left(),
        " bytes are left");
}

void MeshSource::skip(int64_t count, Number type, const char* what) {
  claim(count, type, what);
  if (binary_) {
    at_ += size_t(count) * size_t(size_of(type));
  } else {
    for (int64_t k = 0; k < count; ++k) word(what);
  }
}

}  // namespace elastogen::tets
