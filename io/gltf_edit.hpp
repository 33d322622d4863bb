// SPDX-License-Identifier: Apache-2.0
// A glTF document whose meshes are rewritten.

#pragma once

#include "io/gltf_source.hpp"

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace elastogen {

/// The parsed document, its buffers, and one further buffer for additions. The document has passed
/// check_gltf_types: the fields of its lists have their types, indices may still be out of range.
class GltfEdit {
 public:
  using Json = nlohmann::ordered_json;

  /// @throws Error (asset) if the text is no JSON.
  explicit GltfEdit(GltfSource source);

  const std::string& path() const { return source_.path; }
  /// The source with the additions; current() brings its text up to date.
  const GltfSource& source() const { return source_; }
  const GltfSource& current();
  /// The buffers: those of the file, then the one for additions.
  const std::vector<Bytes>& buffers() const { return source_.buffers; }
  size_t file_buffers() const { return added_; }
  /// The source after the last change.
  GltfSource finished();

  /// Counts bytes towards the 4 GiB that may be added in all.
  /// @throws Error (asset) naming the place.
  void claim(uint64_t bytes, const std::string& place);
  /// Like claim, for numbers that exist already and are only copied: at most 64 times the bytes of
  /// the file, so that a small file cannot ask for endless copies.
  void claim_copy(uint64_t bytes, const std::string& place);

  /// Appends bytes; returns a buffer view of them without stride and target.
  Json view_of(const Bytes& bytes);
  /// Gives an accessor float values, row by row; POSITIONs with bounds.
  /// @param rows  values, `width` of them a row.
  void set_floats(Json& accessor, const std::vector<float>& rows, size_t width, bool bounds);
  /// Appends to a list of the document; returns the index.
  size_t append(const char* list, Json entry);
  /// The entry of a list of the document at an index.
  /// @throws Error (asset) naming the place if there is none.
  Json& entry(const char* list, uint64_t index, const std::string& place);

  Json json;

 private:
  GltfSource source_;
  size_t added_ = 0;  ///< index of the further buffer
  uint64_t file_bytes_ = 0, claimed_ = 0, copied_ = 0;
};

/// A non-negative integer of an object.
/// @throws Error (asset) if it is missing (without a default), of another type, or beyond 2^53.
uint64_t count_of(const GltfEdit::Json& object, const char* key, const std::string& place);
uint64_t count_of(const GltfEdit::Json& object, const char* key, const std::string& place,
                  uint64_t missing);

}  // namespace elastogen
