// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_accessor.hpp"

#include "core/error.hpp"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <cstring>

namespace elastogen {

namespace {

/// Elements within the bytes of a buffer, `stride` apart.
struct Elements {
  const uint8_t* data = nullptr;
  uint64_t count = 0, stride = 0;
};

int component_bytes(int type) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
      return 4;
    default:
      return 0;
  }
}

/// Components of a scalar, a vector or a 4x4 matrix, 0 for other matrices.
int components(int type) {
  switch (type) {
    case TINYGLTF_TYPE_SCALAR:
      return 1;
    case TINYGLTF_TYPE_VEC2:
      return 2;
    case TINYGLTF_TYPE_VEC3:
      return 3;
    case TINYGLTF_TYPE_VEC4:
      return 4;
    case TINYGLTF_TYPE_MAT4:
      return 16;
    default:
      return 0;
  }
}

template <class T>
T load(const uint8_t* data) {
  T value;
  std::memcpy(&value, data, sizeof value);
  return value;
}

template <class T>
double load_integer(const uint8_t* data, bool normalized) {
  const double value = double(load<T>(data));
  if (!normalized) return value;
  return std::max(value / double(std::numeric_limits<T>::max()), -1.0);
}

double load_component(const uint8_t* data, int type, bool normalized) {
  switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
      return load_integer<int8_t>(data, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
      return load_integer<uint8_t>(data, normalized);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
      return load_integer<int16_t>(data, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
      return load_integer<uint16_t>(data, normalized);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
      return load_integer<uint32_t>(data, normalized);
    default:
      return double(load<float>(data));
  }
}

/// Reads accessors of one document.
class AccessorReader {
 public:
  AccessorReader(const GltfSource& source, const tinygltf::Model& model, int index)
      : source_(source), model_(model), place_(concat(source.path, ": accessors[", index, ']')) {
    check(index >= 0 && size_t(index) < model.accessors.size(), "there is no such accessor");
    accessor_ = &model.accessors[size_t(index)];
    size_ = component_bytes(accessor_->componentType);
    components_ = components(accessor_->type);
    check(size_ > 0, "componentType is not one of glTF's");
    check(components_ > 0, "matrices that are not 4x4 are not read");
  }

  const tinygltf::Accessor& accessor() const { return *accessor_; }
  int component_count() const { return components_; }

  void check(bool condition, const char* message) const {
    ELASTOGEN_CHECK_ASSET(condition, place_, ": ", message);
  }

  Array<double> values() const {
    const Elements base = elements();
    Array<double> result(int64_t(accessor_->count), components_);
    for (uint64_t i = 0; i < base.count; ++i) load_row(base.data + i * base.stride, result, i);
    if (accessor_->sparse.isSparse) apply_sparse(result);
    return result;
  }

 private:
  /// The bytes of elements in a buffer view, after all checks.
  Elements range(int view_index, uint64_t offset, uint64_t count, uint64_t element,
                 bool strided) const {
    check(view_index >= 0 && size_t(view_index) < model_.bufferViews.size(),
          "its buffer view does not exist");
    const tinygltf::BufferView& view = model_.bufferViews[size_t(view_index)];
    check(view.buffer >= 0 && size_t(view.buffer) < source_.buffers.size(),
          "the buffer of its buffer view does not exist");
    const Bytes& buffer = source_.buffers[size_t(view.buffer)];
    check(view.byteOffset <= buffer.size() && view.byteLength <= buffer.size() - view.byteOffset,
          "its buffer view leaves the buffer");
    const uint64_t stride = strided && view.byteStride > 0 ? view.byteStride : element;
    check(stride >= element, "its byteStride is smaller than an element");
    check(offset <= view.byteLength, "its byteOffset leaves the buffer view");
    const uint64_t left = view.byteLength - offset;
    check(left >= element && count - 1 <= (left - element) / stride,
          "its elements leave the buffer view");
    return {buffer.data() + view.byteOffset + offset, count, stride};
  }

  /// Elements of the accessor itself; none if it has no buffer view, which means all zeros.
  Elements elements() const {
    check(accessor_->count > 0, "count must be positive");
    if (accessor_->bufferView >= 0) {
      return range(accessor_->bufferView, accessor_->byteOffset, accessor_->count,
                   uint64_t(size_) * uint64_t(components_), true);
    }
    uint64_t bytes = 0;
    for (const Bytes& buffer : source_.buffers) bytes += buffer.size();
    check(accessor_->count <= bytes, "count is larger than the file without a buffer view");
    return {};
  }

  void load_row(const uint8_t* data, Array<double>& result, uint64_t row) const {
    for (int c = 0; c < components_; ++c) {
      result(int64_t(row), c) =
          load_component(data + c * size_, accessor_->componentType, accessor_->normalized);
    }
  }

  void apply_sparse(Array<double>& result) const {
    const auto& sparse = accessor_->sparse;
    check(sparse.count > 0 && uint64_t(sparse.count) <= accessor_->count,
          "its sparse count is out of range");
    check(sparse.indices.byteOffset >= 0 && sparse.values.byteOffset >= 0,
          "its sparse byteOffset is negative");
    const int type = sparse.indices.componentType;
    check(type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
              type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
              type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT,
          "its sparse indices must be unsigned integers");
    const auto count = uint64_t(sparse.count);
    const Elements at = range(sparse.indices.bufferView, uint64_t(sparse.indices.byteOffset), count,
                              uint64_t(component_bytes(type)), false);
    const Elements entries = range(sparse.values.bufferView, uint64_t(sparse.values.byteOffset),
                                   count, uint64_t(size_) * uint64_t(components_), false);
    for (uint64_t i = 0; i < count; ++i) {
      const auto row = uint64_t(load_component(at.data + i * at.stride, type, false));
      check(row < accessor_->count, "a sparse index is out of range");
      load_row(entries.data + i * entries.stride, result, row);
    }
  }

  const GltfSource& source_;
  const tinygltf::Model& model_;
  std::string place_;
  const tinygltf::Accessor* accessor_ = nullptr;
  int size_ = 0, components_ = 0;
};

}  // namespace

Array<double> accessor_values(const GltfSource& source, const tinygltf::Model& model,
                              int accessor) {
  const AccessorReader reader(source, model, accessor);
  reader.check(reader.component_count() <= 4, "matrices are not vertex data");
  return reader.values();
}

Array<double> accessor_matrices(const GltfSource& source, const tinygltf::Model& model,
                                int accessor) {
  const AccessorReader reader(source, model, accessor);
  reader.check(reader.component_count() == 16 &&
                   reader.accessor().componentType == TINYGLTF_COMPONENT_TYPE_FLOAT,
               "it must hold 4x4 matrices of floats");
  return reader.values();
}

std::vector<uint32_t> accessor_indices(const GltfSource& source, const tinygltf::Model& model,
                                       int accessor, int64_t vertices) {
  const AccessorReader reader(source, model, accessor);
  const int type = reader.accessor().componentType;
  reader.check(reader.component_count() == 1 && !reader.accessor().normalized &&
                   (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
                    type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
                    type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT),
               "vertex indices must be unsigned integers");
  const Array<double> values = reader.values();
  std::vector<uint32_t> indices(values.data(), values.data() + values.size());
  for (const uint32_t index : indices) {
    ELASTOGEN_CHECK_ASSET(index < vertices, source.path, ": accessors[", accessor,
                          "]: vertex index ", index, " is out of range; there are ", vertices,
                          " vertices");
  }
  return indices;
}

}  // namespace elastogen
