// SPDX-License-Identifier: Apache-2.0
#include "io/flat_stream.hpp"

#include "io/child_process.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr size_t kMaxMessage = 300;  ///< of a message that is shown [bytes]

}  // namespace

std::string encode_failure(ReaderFailure failure, std::string_view message) {
  StreamWriter stream;
  stream.value(uint8_t(failure));
  stream.array(message);
  return stream.take();
}

void begin_answer(StreamReader& stream) {
  ELASTOGEN_CHECK_ASSET(stream.take(kAnswerMagic.size(), 1) == kAnswerMagic,
                        "its answer is no asset");
  uint8_t failure = 0;
  stream.value(failure);
  if (failure == 0) return;
  std::string message;
  stream.array(message);
  if (ReaderFailure(failure) == ReaderFailure::kMemory)
    message = concat("reading it needed more than ", kReaderMemory >> 30,
                     " GiB; simplify it, or convert it to GLB");
  throw Error(shown_line(message), ErrorKind::kAsset);
}

std::string shown_line(std::string_view message) {
  std::string text(message.substr(0, kMaxMessage));
  std::ranges::replace_if(
      text, [](char c) { return uint8_t(c) < 0x20 || c == 0x7f; }, ' ');
  return message.size() > kMaxMessage ? text + "..." : text;
}

}  // namespace elastogen
