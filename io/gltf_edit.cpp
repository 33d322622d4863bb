// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_edit.hpp"

#include "core/error.hpp"
#include "io/glb_document.hpp"
#include "io/json_text.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace elastogen {

namespace {

constexpr uint64_t kMaxAdded = uint64_t{1} << 32, kMaxReuse = 64;

/// Least or largest value of each column, by the choice.
template <class Choose>
std::vector<float> bound(const std::vector<float>& rows, size_t width, Choose choose) {
  std::vector<float> result(rows.begin(), rows.begin() + std::ptrdiff_t(width));
  for (size_t i = width; i < rows.size(); ++i)
    result[i % width] = choose(result[i % width], rows[i]);
  return result;
}

}  // namespace

GltfEdit::GltfEdit(GltfSource source)
    : json(parsed_json(source.json)), source_(std::move(source)), added_(source_.buffers.size()) {
  file_bytes_ = source_.json.size();
  for (const Bytes& buffer : source_.buffers) file_bytes_ += buffer.size();
  source_.buffers.emplace_back();
}

const GltfSource& GltfEdit::current() {
  source_.json = json.dump();
  return source_;
}

GltfSource GltfEdit::finished() {
  // without additions the buffers are those of the file
  if (source_.buffers[added_].empty()) {
    source_.buffers.pop_back();
  } else {
    append("buffers", {{"byteLength", source_.buffers[added_].size()}});
  }
  current();
  return std::move(source_);
}

void GltfEdit::claim(uint64_t bytes, const std::string& place) {
  ELASTOGEN_CHECK_ASSET(bytes <= kMaxAdded && claimed_ + bytes <= kMaxAdded, place,
                        ": the meshes would fill more than 4 GiB; split the file");
  claimed_ += bytes;
}

void GltfEdit::claim_copy(uint64_t bytes, const std::string& place) {
  claim(bytes, place);
  copied_ += bytes;
  const uint64_t there = file_bytes_ + claimed_ - copied_;
  ELASTOGEN_CHECK_ASSET(copied_ / kMaxReuse <= there, place,
                        ": its accessors are used more often than any real file does");
}

GltfEdit::Json GltfEdit::view_of(const Bytes& bytes) {
  const uint64_t offset = append_bytes(source_.buffers[added_], bytes.data(), bytes.size());
  return {{"buffer", added_}, {"byteOffset", offset}, {"byteLength", bytes.size()}};
}

void GltfEdit::set_floats(Json& accessor, const std::vector<float>& rows, size_t width,
                          bool bounds) {
  static const std::array<const char*, 5> kTypes = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
  const auto* bytes = reinterpret_cast<const uint8_t*>(rows.data());
  Json view = view_of(Bytes(bytes, bytes + rows.size() * sizeof(float)));
  for (const char* key : {"byteOffset", "normalized", "sparse", "min", "max"}) accessor.erase(key);
  accessor["bufferView"] = append("bufferViews", std::move(view));
  accessor["componentType"] = 5126;
  accessor["count"] = rows.size() / width;
  accessor["type"] = kTypes.at(width);
  const bool finite =
      std::all_of(rows.begin(), rows.end(), [](float x) { return std::isfinite(x); });
  if (!bounds || !finite || rows.empty()) return;
  accessor["min"] = bound(rows, width, [](float a, float b) { return std::min(a, b); });
  accessor["max"] = bound(rows, width, [](float a, float b) { return std::max(a, b); });
}

size_t GltfEdit::append(const char* list, Json entry) {
  json[list].push_back(std::move(entry));
  return json[list].size() - 1;
}

GltfEdit::Json& GltfEdit::entry(const char* list, uint64_t index, const std::string& place) {
  ELASTOGEN_CHECK_ASSET(json.contains(list) && index < json[list].size(), place, ": ", list, '[',
                        index, "] does not exist");
  return json[list][size_t(index)];
}

uint64_t count_of(const GltfEdit::Json& object, const char* key, const std::string& place) {
  const bool count = object.is_object() && object.contains(key) &&
                     object[key].is_number_unsigned() &&
                     object[key].get<uint64_t>() < uint64_t{1} << 53;
  ELASTOGEN_CHECK_ASSET(count, place, ": \"", key, "\" must be a non-negative integer");
  return object[key].get<uint64_t>();
}

uint64_t count_of(const GltfEdit::Json& object, const char* key, const std::string& place,
                  uint64_t missing) {
  return object.is_object() && object.contains(key) ? count_of(object, key, place) : missing;
}

}  // namespace elastogen
