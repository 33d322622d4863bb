// SPDX-License-Identifier: Apache-2.0
#include "diffusion/weight_dataset.hpp"

#include "core/error.hpp"
#include "core/hash.hpp"
#include "diffusion/material_features.hpp"
#include "tests/diffusion/dataset.hpp"

#include <gtest/gtest.h>
#include <hdf5.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

namespace elastogen {
namespace {

constexpr size_t kUserBlock = 512, kHashAt = 27;

/// Puts the right hash over the bytes behind the user block, as an attacker would.
std::string sealed(std::string bytes) {
  const std::string digits = hex(sha256(std::string_view(bytes).substr(kUserBlock)));
  std::copy(digits.begin(), digits.end(), bytes.begin() + kHashAt);
  return bytes;
}

/// The file after a change by the library.
std::string changed(const std::string& bytes, const std::function<void(hid_t)>& change) {
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
  H5Pset_fapl_core(access, 1 << 16, 0);
  H5Pset_file_image(access, const_cast<char*>(bytes.data()), bytes.size());
  const hid_t file = H5Fopen("test", H5F_ACC_RDWR, access);
  EXPECT_GE(file, 0);
  change(file);
  H5Fflush(file, H5F_SCOPE_GLOBAL);
  std::string image(kUserBlock + size_t(H5Fget_file_image(file, nullptr, 0)), '\0');
  std::copy_n(bytes.begin(), kUserBlock, image.begin());
  H5Fget_file_image(file, image.data() + kUserBlock, image.size() - kUserBlock);
  H5Fclose(file);
  H5Pclose(access);
  return sealed(std::move(image));
}

/// The message that refuses a file.
std::string refusal(const std::string& bytes) {
  try {
    decode_dataset(bytes, "d.h5");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    return error.what();
  }
  return "";
}

template <class T>
void put(hid_t file, const char* name, hid_t type, hid_t file_type, std::vector<hsize_t> extents,
         const std::vector<T>& values, hid_t creation = H5P_DEFAULT) {
  H5Ldelete(file, name, H5P_DEFAULT);
  const hid_t space = H5Screate_simple(int(extents.size()), extents.data(), nullptr);
  const hid_t array = H5Dcreate2(file, name, file_type, space, H5P_DEFAULT, creation, H5P_DEFAULT);
  if (!values.empty()) H5Dwrite(array, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(array);
  H5Sclose(space);
}

void put_doubles(hid_t file, const char* name, std::vector<hsize_t> extents, double value) {
  hsize_t count = 1;
  for (const hsize_t extent : extents) count *= extent;
  put<double>(file, name, H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, std::move(extents),
              std::vector<double>(count, value));
}

TEST(WeightDataset, ReadsWhatItWrote) {
  const WeightDataset data = test::some_dataset(9);
  const WeightDataset again = decode_dataset(encode_dataset(data), "d.h5");
  ASSERT_EQ(again.count(), 9);
  for (size_t n = 0; n < 9; ++n) {
    EXPECT_EQ(again.materials[n].name, data.materials[n].name);
    EXPECT_EQ(again.materials[n].poisson, data.materials[n].poisson);
    EXPECT_EQ(law_text(again.materials[n].terms), law_text(data.materials[n].terms));
  }
  EXPECT_EQ(again.hidden, data.hidden);
  EXPECT_EQ(again.layers, data.layers);
  EXPECT_EQ(again.features, data.features);
  EXPECT_EQ(again.errors, data.errors);
  EXPECT_EQ(again.rms, data.rms);
  EXPECT_EQ(again.iterations, data.iterations);
}

TEST(WeightDataset, WritesTheSameBytesAtAnotherTime) {
  const WeightDataset data = test::some_dataset(2);
  const std::string bytes = encode_dataset(data);
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5's times are in seconds
  EXPECT_EQ(encode_dataset(data), bytes);
}

TEST(WeightDataset, JoinsHiddenAndLastLayers) {
  const WeightDataset data = test::some_dataset(3);
  const std::vector<float> weights = data.weights(2);
  ASSERT_EQ(int64_t(weights.size()), kMtlParameters);
  EXPECT_TRUE(std::equal(data.hidden.begin(), data.hidden.end() - kMtlLast, weights.begin()));
  EXPECT_TRUE(std::equal(data.layers.row(2), data.layers.row(2) + 128, weights.end() - kMtlLast));
  EXPECT_EQ(weights.back(), 0);
}

TEST(WeightDataset, TakesRowsInTheirOrder) {
  const WeightDataset data = test::some_dataset(6), rows = dataset_rows(data, {4, 1});
  ASSERT_EQ(rows.count(), 2);
  EXPECT_EQ(rows.materials[0].name, data.materials[4].name);
  EXPECT_EQ(rows.layers(1, 100), data.layers(1, 100));
  EXPECT_EQ(rows.errors(0, 3), data.errors(4, 3));
  EXPECT_EQ(rows.features(1, 12), data.features(1, 12));
  EXPECT_EQ(rows.iterations, (std::vector<int32_t>{14, 11}));
}

TEST(WeightDataset, RefusesEveryShortenedFileAndEveryFlippedByte) {
  const std::string bytes = encode_dataset(test::some_dataset(3));
  for (size_t size = 0; size < bytes.size(); size += 997)
    EXPECT_NE(refusal(bytes.substr(0, size)), "") << size;
  for (size_t at = kUserBlock; at < bytes.size(); at += 1009) {
    std::string other = bytes;
    other[at] = char(other[at] ^ 0x10);
    EXPECT_NE(refusal(other), "") << at;
  }
}

TEST(WeightDataset, RefusesArraysThatAreNotWhatTheyShouldBe) {
  const std::string bytes = encode_dataset(test::some_dataset(3));
  // a changed array under a valid seal
  const auto expect = [&](const char* what, const std::function<void(hid_t)>& change) {
    const std::string message = refusal(changed(bytes, change));
    EXPECT_NE(message.find(what), std::string::npos) << what << ": " << message;
    EXPECT_EQ(message.find("d.h5: "), 0u) << message;
  };
  // missing arrays and wrong sizes
  expect("no array 'layers'", [](hid_t f) { H5Ldelete(f, "layers", H5P_DEFAULT); });
  expect("'poisson' must have 1", [](hid_t f) { put_doubles(f, "poisson", {0}, 0); });
  expect("'poisson' must have 1", [](hid_t f) { put_doubles(f, "poisson", {3, 1}, 0.1); });
  expect("'law' does not have 2 rows", [](hid_t f) { put_doubles(f, "poisson", {2}, 0.1); });
  expect("material 0: ", [](hid_t f) { put_doubles(f, "poisson", {3}, 0.7); });
  expect("'rms' does not have 3 rows", [](hid_t f) { put_doubles(f, "rms", {4}, 0); });
  expect("'rms' is of another type", [](hid_t f) {
    put<int>(f, "rms", H5T_NATIVE_INT, H5T_STD_I32LE, {3}, {1, 2, 3});
  });
  // wrong values
  expect("number 0 of 'rms' is not finite", [](hid_t f) { put_doubles(f, "rms", {3}, NAN); });
  expect("negative", [](hid_t f) { put_doubles(f, "rms", {3}, -1); });
  expect("features of material 0", [](hid_t f) { put_doubles(f, "features", {3, 15}, 0.5); });
  expect("'law' must have texts", [](hid_t f) { put_doubles(f, "law", {3}, 0); });
  expect("hash", [](hid_t f) {
    std::vector<float> other = test::some_hidden();
    other[5] += 1;
    put(f, "hidden", H5T_NATIVE_FLOAT, H5T_IEEE_F32LE, {hsize_t(kMtlParameters)}, other);
  });
}

TEST(WeightDataset, RefusesNumbersThatLieElsewhereOrTakeMoreRoomThanTheFile) {
  const std::string bytes = encode_dataset(test::some_dataset(3));
  // packed, which could unfold to anything
  std::string other = changed(bytes, [](hid_t f) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk[] = {3};
    H5Pset_chunk(creation, 1, chunk);
    H5Pset_deflate(creation, 9);
    put<double>(f, "rms", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, {3}, {0, 0, 0}, creation);
    H5Pclose(creation);
  });
  EXPECT_NE(refusal(other).find("plain numbers"), std::string::npos) << refusal(other);
  // in another file
  other = changed(bytes, [](hid_t f) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_external(creation, "/etc/hostname", 0, 24);
    put<double>(f, "rms", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, {3}, {}, creation);
    H5Pclose(creation);
  });
  EXPECT_NE(refusal(other).find("plain numbers"), std::string::npos) << refusal(other);
  // a link out of the file
  other = changed(bytes, [](hid_t f) {
    H5Ldelete(f, "rms", H5P_DEFAULT);
    H5Lcreate_external("/etc/hostname", "rms", f, "rms", H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_NE(refusal(other).find("no array 'rms'"), std::string::npos) << refusal(other);
  // a million rows that were never written
  other = changed(bytes, [](hid_t f) {
    put<double>(f, "poisson", H5T_NATIVE_DOUBLE, H5T_IEEE_F64LE, {1 << 20}, {});
  });
  EXPECT_NE(refusal(other).find("plain numbers"), std::string::npos) << refusal(other);
}

TEST(WeightDataset, RefusesWhatHoldsNoMaterial) {
  EXPECT_THROW(encode_dataset(empty_dataset(test::some_hidden(), {})), Error);
  EXPECT_THROW(empty_dataset(std::vector<float>(5), {}), Error);
  WeightDataset data = test::some_dataset(3);
  data.rms.pop_back();
  EXPECT_THROW(encode_dataset(data), Error);
  EXPECT_NE(refusal("elastogen-tensor").find("not a dataset"), std::string::npos);
}

}  // namespace
}  // namespace elastogen
