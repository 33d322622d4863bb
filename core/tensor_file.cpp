// SPDX-License-Identifier: Apache-2.0
#include "core/tensor_file.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <set>

namespace elastogen {
namespace {

static_assert(std::endian::native == std::endian::little, "files are little-endian");

constexpr std::string_view kMagic = "elastogen-tensor";
constexpr uint32_t kVersion = 1, kMostEntries = 1 << 16, kMostDimensions = 8;
constexpr size_t kMostName = 255, kMostText = 1 << 20, kSeal = 32;

template <class T>
void append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

void append_text(std::string& bytes, std::string_view text) {
  append(bytes, uint32_t(text.size()));
  bytes += text;
}

/// Reads values from the front of bytes; a count is accepted only if its bytes are there.
class Reader {
 public:
  Reader(std::string_view bytes, const std::string& place) : bytes_(bytes), place_(place) {}

  size_t left() const { return bytes_.size(); }

  std::string_view take(size_t count, const char* what) {
    ELASTOGEN_CHECK_ASSET(count <= bytes_.size(), place_, ": ", count, " bytes of ", what,
                          " are claimed but only ", bytes_.size(), " are left");
    const std::string_view front = bytes_.substr(0, count);
    bytes_.remove_prefix(count);
    return front;
  }

  template <class T>
  T value(const char* what) {
    T result;
    std::memcpy(&result, take(sizeof result, what).data(), sizeof result);
    return result;
  }

  uint32_t count(uint32_t most, const char* what) {
    const auto n = value<uint32_t>(what);
    ELASTOGEN_CHECK_ASSET(n <= most, place_, ": ", n, ' ', what, ", ", most, " at most");
    return n;
  }

  std::string text(size_t most, const char* what) {
    return std::string(take(count(uint32_t(most), what), what));
  }

 private:
  std::string_view bytes_;
  const std::string& place_;
};

Tensor read_tensor(Reader& reader, const std::string& place) {
  Tensor tensor;
  tensor.name = reader.text(kMostName, "bytes in the name of a tensor");
  const uint32_t rank = reader.count(kMostDimensions, "dimensions of a tensor");
  uint64_t count = 1;
  for (uint32_t d = 0; d < rank; ++d) {
    const auto size = reader.value<uint64_t>("a dimension");
    // below 2^61 before and after, so the product does not wrap
    ELASTOGEN_CHECK_ASSET(size > 0 && size <= reader.left() / sizeof(float) / count, place,
                          ": tensor '", tensor.name, "' is larger than what is left of the file");
    count *= size;
    tensor.shape.push_back(int64_t(size));
  }
  tensor.values.resize(size_t(count));
  const std::string_view raw = reader.take(size_t(count) * sizeof(float), "numbers");
  std::memcpy(tensor.values.data(), raw.data(), raw.size());
  for (size_t k = 0; k < tensor.values.size(); ++k)
    ELASTOGEN_CHECK_ASSET(std::isfinite(tensor.values[k]), place, ": number ", k, " of tensor '",
                          tensor.name, "' is not finite");
  return tensor;
}

void check_tensor(const Tensor& tensor) {
  ELASTOGEN_CHECK(!tensor.name.empty() && tensor.name.size() <= kMostName,
                  "the name of a tensor must have 1 to ", kMostName, " bytes");
  ELASTOGEN_CHECK(tensor.shape.size() <= kMostDimensions, "tensor '", tensor.name,
                  "' has more than ", kMostDimensions, " dimensions");
  size_t count = 1;
  for (const int64_t size : tensor.shape) {
    ELASTOGEN_CHECK(size > 0, "tensor '", tensor.name, "' has a dimension of ", size);
    count *= size_t(size);
  }
  ELASTOGEN_CHECK(count == tensor.values.size(), "tensor '", tensor.name, "' has ",
                  tensor.values.size(), " numbers for a shape of ", count);
}

}  // namespace

const Tensor& TensorFile::get(std::string_view name, const std::vector<int64_t>& shape) const {
  const auto found = std::find_if(tensors.begin(), tensors.end(),
                                  [&](const Tensor& tensor) { return tensor.name == name; });
  ELASTOGEN_CHECK_ASSET(found != tensors.end(), "the file has no tensor '", name, "'");
  ELASTOGEN_CHECK_ASSET(found->shape == shape, "tensor '", name, "' has ", found->values.size(),
                        " numbers in ", found->shape.size(), " dimensions, which is not the shape ",
                        "that it should have");
  return *found;
}

std::string encode_tensors(const TensorFile& file) {
  std::string bytes(kMagic);
  append(bytes, kVersion);
  ELASTOGEN_CHECK(file.text.size() <= kMostEntries && file.tensors.size() <= kMostEntries,
                  "more than ", kMostEntries, " texts or tensors");
  // the texts of the model card
  append(bytes, uint32_t(file.text.size()));
  for (const auto& [key, value] : file.text) {
    ELASTOGEN_CHECK(!key.empty() && key.size() <= kMostName && value.size() <= kMostText, "text '",
                    key, "' is too long, or has no name");
    append_text(bytes, key);
    append_text(bytes, value);
  }
  // the tensors
  append(bytes, uint32_t(file.tensors.size()));
  std::set<std::string> names;
  for (const Tensor& tensor : file.tensors) {
    check_tensor(tensor);
    ELASTOGEN_CHECK(names.insert(tensor.name).second, "two tensors '", tensor.name, "'");
    append_text(bytes, tensor.name);
    append(bytes, uint32_t(tensor.shape.size()));
    for (const int64_t size : tensor.shape) append(bytes, uint64_t(size));
    bytes.append(reinterpret_cast<const char*>(tensor.values.data()),
                 tensor.values.size() * sizeof(float));
  }
  // the seal of all bytes before
  const Sha256 seal = sha256(bytes);
  bytes.append(reinterpret_cast<const char*>(seal.data()), seal.size());
  return bytes;
}

TensorFile decode_tensors(std::string_view bytes, const std::string& place) {
  ELASTOGEN_CHECK_ASSET(bytes.substr(0, kMagic.size()) == kMagic, place,
                        ": not a file of tensors (it does not begin with '", kMagic, "')");
  ELASTOGEN_CHECK_ASSET(bytes.size() >= kMagic.size() + sizeof kVersion + kSeal, place,
                        ": cut short after ", bytes.size(), " bytes");
  // the seal is checked before anything is read
  const std::string_view content = bytes.substr(0, bytes.size() - kSeal);
  const Sha256 seal = sha256(content);
  ELASTOGEN_CHECK_ASSET(
      std::memcmp(seal.data(), bytes.data() + content.size(), kSeal) == 0, place,
      ": cut short or changed since it was written (its SHA-256 is another); get it anew");

  Reader reader(content.substr(kMagic.size()), place);
  const auto version = reader.value<uint32_t>("version");
  ELASTOGEN_CHECK_ASSET(version == kVersion, place, ": version ", version, " of the format, not ",
                        kVersion);
  // the texts of the model card
  TensorFile file;
  for (uint32_t left = reader.count(kMostEntries, "texts"); left > 0; --left) {
    const std::string key = reader.text(kMostName, "bytes in the name of a text");
    const bool is_new = file.text.emplace(key, reader.text(kMostText, "bytes in a text")).second;
    ELASTOGEN_CHECK_ASSET(is_new && !key.empty(), place, ": text '", key, "' is there twice");
  }
  // the tensors, after which nothing may follow
  std::set<std::string> names;
  for (uint32_t left = reader.count(kMostEntries, "tensors"); left > 0; --left) {
    file.tensors.push_back(read_tensor(reader, place));
    const std::string& name = file.tensors.back().name;
    ELASTOGEN_CHECK_ASSET(names.insert(name).second && !name.empty(), place, ": tensor '", name,
                          "' is there twice");
  }
  ELASTOGEN_CHECK_ASSET(reader.left() == 0, place, ": ", reader.left(), " bytes too many");
  return file;
}

}  // namespace elastogen
