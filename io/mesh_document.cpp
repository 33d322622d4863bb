// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "io/glb_document.hpp"
#include "io/safe_file.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>

namespace elastogen {

namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kUnsignedInt = 5125, kVertices = 34962, kIndices = 34963;

/// a b of column-major matrices.
Matrix4 product(const Matrix4& a, const Matrix4& b) {
  Matrix4 result = {};
  for (size_t c = 0; c < 4; ++c) {
    for (size_t r = 0; r < 4; ++r) {
      for (size_t k = 0; k < 4; ++k) result[4 * c + r] += a[4 * k + r] * b[4 * c + k];
    }
  }
  return result;
}

Matrix4 translation(const Vec3& t, double sign) {
  Matrix4 result = kIdentity4;
  for (size_t d = 0; d < 3; ++d) result[12 + d] = sign * t[d];
  return result;
}

/// Centre of a mesh that single precision would blur where it lies, else zero.
Vec3 far_centre(const Mesh& mesh) {
  Box box;
  for (const Vec3& p : mesh.position) box.add(p);
  Vec3 centre = {};
  double extent = 0, distance = 0;
  for (int d = 0; d < 3; ++d) {
    centre[d] = box.lower[d] + box.extent(d) / 2;
    extent = std::max(extent, box.extent(d));
    distance = std::max(distance, std::abs(centre[d]));
  }
  return !mesh.position.empty() && distance > 100 * extent ? centre : Vec3{};
}

class MeshDocument {
 public:
  explicit MeshDocument(const Asset& asset) : asset_(asset) {}

  GlbDocument build() {
    document_ = {{"asset", {{"version", "2.0"}}}};
    for (const AssetMaterial& material : asset_.materials) add_material(material);
    for (const Mesh& mesh : asset_.meshes) add_mesh(mesh);
    add_nodes();
    document_["accessors"] = std::move(accessors_);
    document_["bufferViews"] = std::move(views_);
    result_.json = document_.dump(-1, ' ', false, Json::error_handler_t::replace);
    return std::move(result_);
  }

 private:
  /// Adds a buffer view with the bytes of the values.
  template <class T>
  size_t add_view(const std::vector<T>& values, int target) {
    const size_t size = values.size() * sizeof(T);
    const uint64_t offset = append_bytes(result_.bin, values.data(), size);
    views_.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
    if (target != 0) views_.back()["target"] = target;
    return views_.size() - 1;
  }

  template <class T>
  size_t add_accessor(const std::vector<T>& values, const char* type, int component, int target) {
    accessors_.push_back({{"bufferView", add_view(values, target)},
                          {"componentType", component},
                          {"count", values.size()},
                          {"type", type}});
    return accessors_.size() - 1;
  }

  /// Positions of the drawn vertices from `centre`, with their bounds.
  size_t add_positions(const Mesh& mesh, const Vec3& centre) {
    std::vector<std::array<float, 3>> positions;
    std::array<float, 3> lower = {INFINITY, INFINITY, INFINITY},
                         upper = {-INFINITY, -INFINITY, -INFINITY};
    for (const int32_t p : mesh.position_of) {
      auto& x = positions.emplace_back();
      for (size_t d = 0; d < 3; ++d) {
        x[d] = float(mesh.position[size_t(p)][d] - centre[d]);
        lower[d] = std::min(lower[d], x[d]);
        upper[d] = std::max(upper[d], x[d]);
      }
    }
    const size_t index = add_accessor(positions, "VEC3", kFloat, kVertices);
    accessors_[index]["min"] = lower;
    accessors_[index]["max"] = upper;
    return index;
  }

  void add_mesh(const Mesh& mesh) {
    centre_.push_back(far_centre(mesh));
    Json primitives = Json::array(), attributes;
    // a mesh without triangles is not written
    const auto empty = [](const TriangleGroup& group) { return group.corner.empty(); };
    if (std::all_of(mesh.groups.begin(), mesh.groups.end(), empty)) {
      mesh_index_.push_back(-1);
      return;
    }
    // all groups share the attributes
    attributes["POSITION"] = add_positions(mesh, centre_.back());
    if (!mesh.normal.empty())
      attributes["NORMAL"] = add_accessor(mesh.normal, "VEC3", kFloat, kVertices);
    if (!mesh.uv.empty())
      attributes["TEXCOORD_0"] = add_accessor(mesh.uv, "VEC2", kFloat, kVertices);
    if (!mesh.colour.empty())
      attributes["COLOR_0"] = add_accessor(mesh.colour, "VEC4", kFloat, kVertices);
    // a primitive for each group, so that each has its material
    for (const TriangleGroup& group : mesh.groups) {
      if (empty(group)) continue;
      const std::vector<uint32_t> index(group.corner.begin(), group.corner.end());
      primitives.push_back({{"attributes", attributes},
                            {"indices", add_accessor(index, "SCALAR", kUnsignedInt, kIndices)},
                            {"material", group.material >= 0 ? group.material : plain_material()}});
    }
    mesh_index_.push_back(int(document_["meshes"].size()));
    document_["meshes"].push_back({{"name", mesh.name}, {"primitives", primitives}});
  }

  /// Material of triangles without one: grey, or white where vertices have colours; both sides.
  int plain_material() {
    if (plain_ < 0) {
      const bool coloured = std::any_of(asset_.meshes.begin(), asset_.meshes.end(),
                                        [](const Mesh& mesh) { return !mesh.colour.empty(); });
      const float grey = coloured ? 1 : AssetMaterial{}.base_colour[0];
      add_material({"", {grey, grey, grey, 1}, "", true});
      plain_ = int(document_["materials"].size()) - 1;
    }
    return plain_;
  }

  void add_material(const AssetMaterial& from) {
    Json material = {
        {"pbrMetallicRoughness",
         {{"baseColorFactor", from.base_colour}, {"metallicFactor", 0}, {"roughnessFactor", 0.8}}}};
    if (!from.name.empty()) material["name"] = from.name;
    if (from.double_sided) material["doubleSided"] = true;
    if (from.base_colour[3] < 1) material["alphaMode"] = "BLEND";
    const int texture = add_texture(from.texture);
    if (texture >= 0) material["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", texture}};
    document_["materials"].push_back(material);
  }

  /// Embeds an image file; returns -1 if it is no image of glTF or cannot be read.
  int add_texture(const std::string& path) {
    if (path.empty()) return -1;
    try {
      const std::string text = read_file(path);
      const Bytes image(text.begin(), text.end());
      const std::string type = image_type(image);
      if (type == "image/png" || type == "image/jpeg") {
        document_["images"].push_back({{"bufferView", add_view(image, 0)}, {"mimeType", type}});
        document_["textures"].push_back({{"source", document_["images"].size() - 1}});
        return int(document_["textures"].size()) - 1;
      }
      result_.notes.push_back(path + " was left out: only PNG and JPEG textures are embedded");
    } catch (const Error& error) {
      result_.notes.push_back(concat("a texture was left out: ", error.what()));
    }
    return -1;
  }

  Vec3 centre_of(int node) const {
    const int mesh = node >= 0 ? asset_.nodes[size_t(node)].mesh : -1;
    return mesh >= 0 ? centre_[size_t(mesh)] : Vec3{};
  }

  void add_nodes() {
    Json nodes = Json::array(), roots = Json::array();
    for (size_t n = 0; n < asset_.nodes.size(); ++n) {
      const AssetNode& from = asset_.nodes[n];
      // the centre of a mesh moves from its vertices to its node; children subtract it again
      const Matrix4 matrix = product(translation(centre_of(from.parent), -1),
                                     product(from.matrix, translation(centre_of(int(n)), 1)));
      Json node = Json::object();
      if (!from.name.empty()) node["name"] = from.name;
      const Vec3 shift = {matrix[12], matrix[13], matrix[14]};
      if (matrix != translation(shift, 1)) {
        node["matrix"] = matrix;
      } else if (shift != Vec3{}) {
        node["translation"] = shift;
      }
      if (from.mesh >= 0 && mesh_index_[size_t(from.mesh)] >= 0)
        node["mesh"] = mesh_index_[size_t(from.mesh)];
      nodes.push_back(node);
      if (from.parent < 0) roots.push_back(n);
    }
    for (size_t n = 0; n < asset_.nodes.size(); ++n) {
      const int parent = asset_.nodes[n].parent;
      if (parent >= 0) nodes[size_t(parent)]["children"].push_back(n);
    }
    document_["nodes"] = nodes;
    document_["scenes"] = Json::array({{{"nodes", roots}}});
    document_["scene"] = 0;
  }

  const Asset& asset_;
  GlbDocument result_;
  Json document_, accessors_ = Json::array(), views_ = Json::array();
  std::vector<Vec3> centre_;     // of each mesh of the asset
  std::vector<int> mesh_index_;  // in the document, -1 for a mesh without triangles
  int plain_ = -1;
};

}  // namespace

GlbDocument mesh_document(const Asset& asset) {
  return MeshDocument(asset).build();
}

}  // namespace elastogen
