// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_normals.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/gltf_accessor.hpp"
#include "io/gltf_model.hpp"

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <cmath>
#include <map>

namespace elastogen {

namespace {

using Json = GltfEdit::Json;

Vec3 row_of(const Array<double>& rows, int64_t v) {
  return {rows(v, 0), rows(v, 1), rows(v, 2)};
}

/// Mends the normals of the primitives of one document.
class NormalMender {
 public:
  NormalMender(GltfEdit& edit, const tinygltf::Model& model) : edit_(edit), model_(model) {}

  void mend_all(std::vector<Finding>& findings) {
    for (size_t m = 0; m < model_.meshes.size(); ++m)
      for (size_t p = 0; p < model_.meshes[m].primitives.size(); ++p) {
        const tinygltf::Primitive& primitive = model_.meshes[m].primitives[p];
        if (!primitive.attributes.contains("NORMAL") || !primitive.attributes.contains("POSITION"))
          continue;
        const std::string place = concat("meshes[", m, "].primitives[", p, ']');
        Json& attributes = edit_.json["meshes"][m]["primitives"][p]["attributes"];
        // primitives that share their vertices share the mended normals, unless some are zero
        const int normal = primitive.attributes.at("NORMAL");
        const auto known = mended_.find(normal);
        const int accessor = known != mended_.end() ? known->second : mend(primitive, place);
        if (accessor >= 0) attributes["NORMAL"] = accessor;
      }
    const std::string where = ", the first in ";
    if (zero_ > 0)
      findings.push_back({"zero-normals", zero_, "normals have no length" + where + zero_place_});
    if (long_ > 0)
      findings.push_back(
          {"long-normals", long_, "normals are not of length one" + where + long_place_});
  }

 private:
  /// @return the new accessor, -1 where the normals stay.
  int mend(const tinygltf::Primitive& primitive, const std::string& place) {
    constexpr double kCounted = 1e-2, kRounding = 5e-4;
    const int accessor = primitive.attributes.at("NORMAL");
    // read the normals of the primitive
    edit_.claim_copy(uint64_t(model_.accessors.at(size_t(accessor)).count) * 24, place);
    Array<double> rows = accessor_values(edit_.source(), model_, accessor);
    ELASTOGEN_CHECK_ASSET(rows.cols() == 3, edit_.path(), ": ", place,
                          ": its normals do not have three numbers");
    // scale each to length one; by_area is made for the first of length zero
    int64_t zero = 0, counted = 0, off = 0;
    std::vector<Vec3> by_area;
    for (int64_t v = 0; v < rows.rows(); ++v) {
      Vec3 n = row_of(rows, v);
      if (!finite(n)) continue;  // the check of the asset counts them
      double length = safe_norm(n);
      counted += length > 0 && std::abs(length - 1) > kCounted;
      off += std::abs(length - 1) > kRounding;
      if (length == 0) {
        ++zero;
        if (by_area.empty()) by_area = area_normals(primitive, rows.rows(), place);
        n = by_area[size_t(v)];
        length = safe_norm(n);
        if (!(length > 0 && std::isfinite(length))) n = {0, 0, 1}, length = 1;
      }
      for (int d = 0; d < 3; ++d) rows(v, d) = n[size_t(d)] / length;
    }
    // faults are counted; normals are stored only if they are off by more than rounding
    say(zero, zero_, zero_place_, place);
    say(counted, long_, long_place_, place);
    const int result = off > 0 ? int(add(rows, place)) : -1;
    if (zero == 0) mended_[accessor] = result;
    return result;
  }

  static void say(int64_t count, int64_t& sum, std::string& first, const std::string& place) {
    if (count > 0 && sum == 0) first = place;
    sum += count;
  }

  size_t add(const Array<double>& rows, const std::string& place) {
    edit_.claim_copy(uint64_t(rows.size()) * 4, place);
    Json accessor = Json::object();
    edit_.set_floats(accessor, {rows.data(), rows.data() + rows.size()}, 3, false);
    return edit_.append("accessors", std::move(accessor));
  }

  /// Normal of each vertex by the triangles of a primitive, as long as twice their area.
  std::vector<Vec3> area_normals(const tinygltf::Primitive& primitive, int64_t vertices,
                                 const std::string& place) {
    // positions and corners of the primitive
    const int position = primitive.attributes.at("POSITION");
    edit_.claim_copy(uint64_t(model_.accessors.at(size_t(position)).count) * 24, place);
    const Array<double> x = accessor_values(edit_.source(), model_, position);
    ELASTOGEN_CHECK_ASSET(x.rows() == vertices && x.cols() == 3, edit_.path(), ": ", place, ": ",
                          vertices, " normals for ", x.rows(), " vertices");
    std::vector<uint32_t> index;
    if (primitive.indices >= 0)
      index = accessor_indices(edit_.source(), model_, primitive.indices, vertices);
    else
      for (int64_t v = 0; v < vertices; ++v) index.push_back(uint32_t(v));
    // each face adds its normal, as long as twice its area, to its corners
    std::vector<Vec3> sum(size_t(vertices), Vec3{});
    const auto add_face = [&](size_t a, size_t b, size_t c) {
      const Vec3 p = row_of(x, index[a]);
      const Vec3 n = cross(minus(row_of(x, index[b]), p), minus(row_of(x, index[c]), p));
      for (const size_t k : {a, b, c}) sum[index[k]] = plus(sum[index[k]], n);
    };
    // every second triangle of a strip has the opposite winding
    const int mode = primitive.mode;
    for (size_t i = 0; i + 2 < index.size(); i += mode == TINYGLTF_MODE_TRIANGLES ? 3 : 1) {
      if (mode == TINYGLTF_MODE_TRIANGLES) add_face(i, i + 1, i + 2);
      if (mode == TINYGLTF_MODE_TRIANGLE_STRIP) add_face(i, i + 1 + i % 2, i + 2 - i % 2);
      if (mode == TINYGLTF_MODE_TRIANGLE_FAN) add_face(0, i + 1, i + 2);
    }
    return sum;
  }

  GltfEdit& edit_;
  const tinygltf::Model& model_;
  std::map<int, int> mended_;  // the new accessor by the old (without zeros), -1 where it stays
  int64_t zero_ = 0, long_ = 0;
  std::string zero_place_, long_place_;
};

}  // namespace

void mend_gltf_normals(GltfEdit& edit, std::vector<Finding>& findings) {
  if (!edit.json.contains("meshes")) return;
  tinygltf::Model model;
  read_gltf_model(edit.current(), model);
  NormalMender(edit, model).mend_all(findings);
}

}  // namespace elastogen
