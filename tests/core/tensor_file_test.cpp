// SPDX-License-Identifier: Apache-2.0
// Files of tensors: written files are read, changed files are refused with a sentence.

#include "core/tensor_file.hpp"

#include "core/error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

namespace elastogen {
namespace {

TensorFile sample() {
  TensorFile file;
  file.text = {{"law", "neo-hookean"}, {"poisson", "0.45"}};
  file.tensors.push_back({"matrix", {2, 3}, {1, 2, 3, 4, 5, 6}});
  file.tensors.push_back({"number", {}, {7.5f}});
  return file;
}

/// Bytes with a seal that fits them.
std::string sealed(std::string bytes) {
  bytes.resize(bytes.size() - 32);
  const Sha256 seal = sha256(bytes);
  bytes.append(reinterpret_cast<const char*>(seal.data()), seal.size());
  return bytes;
}

std::string refusal(const std::string& bytes) {
  try {
    decode_tensors(bytes, "w.tensors");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset);
    return error.what();
  }
  return "not refused";
}

void expect_refused(const std::string& bytes, const std::string& words) {
  const std::string message = refusal(bytes);
  EXPECT_NE(message.find(words), std::string::npos) << message;
  EXPECT_NE(message.find("w.tensors"), std::string::npos) << message;
}

TEST(TensorFile, ReadsWhatItWrote) {
  const TensorFile file = decode_tensors(encode_tensors(sample()), "w");
  EXPECT_EQ(file.text, sample().text);
  ASSERT_EQ(file.tensors.size(), 2u);
  EXPECT_EQ(file.get("matrix", {2, 3}).values, sample().tensors[0].values);
  EXPECT_EQ(file.get("number", {}).values, sample().tensors[1].values);
  EXPECT_THROW(file.get("matrix", {3, 2}), Error);
  EXPECT_THROW(file.get("other", {2}), Error);
}

TEST(TensorFile, RefusesEveryCutAndEveryChangedByte) {
  const std::string bytes = encode_tensors(sample());
  for (size_t length = 0; length < bytes.size(); ++length)
    EXPECT_NE(refusal(bytes.substr(0, length)), "not refused") << length;
  for (size_t k = 0; k < bytes.size(); ++k) {
    std::string changed = bytes;
    changed[k] = char(changed[k] ^ 1);
    EXPECT_NE(refusal(changed), "not refused") << k;
  }
  expect_refused("PK", "not a file of tensors");
  expect_refused(bytes.substr(0, bytes.size() - 1), "SHA-256");
}

TEST(TensorFile, RefusesLiesUnderAValidSeal) {
  const std::string bytes = encode_tensors(sample());
  const size_t shape = bytes.find("matrix") + 6 + 4;  // past the rank
  for (const uint64_t size : {uint64_t{1} << 63, uint64_t{1} << 61, uint64_t{0}, uint64_t{100}}) {
    std::string lie = bytes;
    std::memcpy(lie.data() + shape, &size, sizeof size);
    expect_refused(sealed(lie), "larger than what is left");
  }
  std::string nan = bytes;
  const float value = std::nanf("");
  std::memcpy(nan.data() + shape + 16, &value, sizeof value);
  expect_refused(sealed(nan), "number 0 of tensor 'matrix' is not finite");
  std::string version = bytes;
  version[16] = 9;
  expect_refused(sealed(version), "version 9");
  std::string twice = bytes;
  twice.replace(twice.find("number"), 6, "matrix");
  expect_refused(sealed(twice), "there twice");
  std::string more = bytes;
  more.insert(more.size() - 32, "abc");
  expect_refused(sealed(more), "3 bytes too many");
}

TEST(TensorFile, RefusesToWriteWhatItWouldNotRead) {
  TensorFile file = sample();
  file.tensors[0].values.pop_back();
  EXPECT_THROW(encode_tensors(file), Error);
  file = sample();
  file.tensors[1].name = "matrix";
  EXPECT_THROW(encode_tensors(file), Error);
  file = sample();
  file.tensors[0].shape = {0, 6};
  EXPECT_THROW(encode_tensors(file), Error);
}

}  // namespace
}  // namespace elastogen
