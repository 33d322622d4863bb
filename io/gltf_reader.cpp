// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_reader.hpp"

#include "core/error.hpp"
#include "io/asset_check.hpp"
#include "io/gltf_accessor.hpp"
#include "io/gltf_animations.hpp"
#include "io/gltf_hidden.hpp"
#include "io/gltf_model.hpp"
#include "io/gltf_nodes.hpp"
#include "io/json_text.hpp"
#include "io/plain_gltf.hpp"

#include <nlohmann/json.hpp>
#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#include <tiny_gltf.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>

namespace elastogen {

namespace {

using Json = nlohmann::ordered_json;

/// Decoded vertices and corners may outnumber the bytes of the file, but not by more.
constexpr uint64_t kMaxVertexReuse = 64;

class GltfReader {
 public:
  GltfReader(const std::string& path, const ReadOptions& options) : options_(options) {
    asset_.path = path;
    GltfSource source = read_gltf_source(path);
    channels_ = count_channels(parsed_json(source.json));
    source_ = plain_gltf(std::move(source), asset_.findings);
    document_ = parsed_json(source_.json);
    read_gltf_model(source_, model_);
    for (const Bytes& buffer : source_.buffers) budget_ += kMaxVertexReuse * buffer.size();
  }

  Asset read() {
    const bool binary = source_.json.size() > 0 && asset_.path.ends_with(".glb");
    asset_.format = binary ? "glb" : "gltf";
    asset_.up = 2;
    asset_.unit = 1;
    read_nodes();
    for (size_t m = 0; m < model_.materials.size(); ++m) read_material(model_.materials[m]);
    read_meshes();
    note_what_is_left_out();
    return std::move(asset_);
  }

 private:
  template <class... Parts>
  void check(bool condition, const Parts&... parts) const {
    ELASTOGEN_CHECK_ASSET(condition, asset_.path, ": ", parts...);
  }

  void note(const char* what, int64_t count, const std::string& text) {
    add_finding(asset_, what, count, text);
  }

  /// All nodes. A root of the scene stands in the tree without its parent, if it has one. Hidden
  /// nodes show nothing.
  void read_nodes() {
    asset_.nodes = gltf_nodes(asset_.path, model_);
    const std::vector<char> is_hidden =
        hidden_nodes(asset_.path, document_.value("nodes", Json::array()), model_);
    std::vector<int> hidden;
    for (const int n : gltf_scene_nodes(asset_.path, model_)) {
      if (!is_hidden[size_t(n)]) {
        asset_.nodes[size_t(n)].mesh = model_.nodes[size_t(n)].mesh;
      } else if (model_.nodes[size_t(n)].mesh >= 0) {
        hidden.push_back(n);
      }
    }
    std::ranges::sort(hidden);
    hidden_ = int64_t(hidden.size());
    note("hidden", hidden_, "nodes with a mesh are hidden: " + node_names(asset_.nodes, hidden));
    for (const int root : gltf_scene_roots(asset_.path, model_))
      asset_.nodes[size_t(root)].parent = -1;
  }

  void read_material(const tinygltf::Material& from) {
    AssetMaterial material;
    material.name = from.name;
    material.double_sided = from.doubleSided;
    const std::vector<double>& factor = from.pbrMetallicRoughness.baseColorFactor;
    for (size_t c = 0; c < 4; ++c)
      material.base_colour[c] = c < factor.size() ? float(factor[c]) : 1;
    asset_.materials.push_back(std::move(material));
  }

  // meshes

  static bool is_surface(const tinygltf::Primitive& primitive) {
    return primitive.mode >= TINYGLTF_MODE_TRIANGLES &&
           primitive.mode <= TINYGLTF_MODE_TRIANGLE_FAN &&
           primitive.attributes.contains("POSITION");
  }

  static bool is_points_or_lines(const tinygltf::Primitive& primitive) {
    return primitive.mode >= TINYGLTF_MODE_POINTS && primitive.mode <= TINYGLTF_MODE_LINE_STRIP &&
           primitive.attributes.contains("POSITION");
  }

  /// Takes decoded numbers from the budget, so that a small file cannot ask for endless copies.
  void spend(uint64_t count) {
    check(count <= budget_, "its accessors are used more often than any real file does");
    budget_ -= count;
  }

  /// Appends an accessor's rows to an attribute that so far fills `first` vertices.
  template <size_t N>
  void append(int accessor, int64_t first, int64_t count,
              std::vector<std::array<float, N>>& attribute, std::array<float, N> fill) {
    const Array<double> values = accessor_values(source_, model_, accessor);
    check(values.rows() == count, "accessors[", accessor, "] has ", values.rows(),
          " vertices, its POSITION has ", count);
    attribute.resize(size_t(first), fill);
    for (int64_t v = 0; v < count; ++v) {
      std::array<float, N> row = fill;
      for (int c = 0; c < values.cols() && c < int(N); ++c) row[size_t(c)] = float(values(v, c));
      attribute.push_back(row);
    }
  }

  /// Appends the vertices of a primitive to a mesh; returns how many.
  int64_t append_vertices(const tinygltf::Primitive& primitive, Mesh& mesh) {
    const int index = primitive.attributes.at("POSITION");
    const Array<double> position = accessor_values(source_, model_, index);
    check(position.cols() == 3, "accessors[", index, "]: POSITION must be VEC3");
    const auto first = int64_t(mesh.position.size()), count = position.rows();
    spend(uint64_t(count));
    check(first + count <= INT32_MAX, "a mesh has more than 2^31 vertices");
    for (int64_t v = 0; v < count; ++v) {
      mesh.position.push_back({position(v, 0), position(v, 1), position(v, 2)});
      mesh.position_of.push_back(int32_t(first + v));
    }
    const auto has = [&](const char* name) { return primitive.attributes.contains(name); };
    const auto at = [&](const char* name) { return primitive.attributes.at(name); };
    if (has("TEXCOORD_0")) append(at("TEXCOORD_0"), first, count, mesh.uv, {});
    if (has("NORMAL")) append(at("NORMAL"), first, count, mesh.normal, {});
    if (has("COLOR_0")) append(at("COLOR_0"), first, count, mesh.colour, {1, 1, 1, 1});
    if (options_.attributes) append_attributes(primitive, first, count, mesh.attributes);
    return count;
  }

  /// Appends the custom attributes of a primitive, a column for each component.
  void append_attributes(const tinygltf::Primitive& primitive, int64_t first, int64_t count,
                         std::vector<OwnColumn>& columns) {
    for (const auto& [name, accessor] : primitive.attributes) {
      if (!name.starts_with('_')) continue;
      const Array<double> values = accessor_values(source_, model_, accessor);
      check(values.rows() == count, "accessors[", accessor, "] has ", values.rows(),
            " vertices, its POSITION has ", count);
      for (int c = 0; c < values.cols(); ++c) {
        const std::string full = values.cols() == 1 ? name : concat(name, '.', "xyzw"[c]);
        auto column = std::ranges::find(columns, full, &OwnColumn::name);
        if (column == columns.end()) column = columns.insert(column, {full, {}, {}});
        pad(first, *column);
        spend(uint64_t(count));
        for (int64_t v = 0; v < count; ++v) column->value.push_back(values(v, c));
      }
    }
  }

  /// Fills a custom attribute up to a vertex.
  void pad(int64_t vertices, OwnColumn& column) {
    spend(uint64_t(vertices) - column.value.size());
    column.value.resize(size_t(vertices), std::numeric_limits<double>::quiet_NaN());
  }

  static void add_triangles(const tinygltf::Primitive& primitive,
                            const std::vector<uint32_t>& index, int64_t first,
                            std::vector<int32_t>& corner) {
    const auto add = [&](size_t a, size_t b, size_t c) {
      for (const size_t i : {a, b, c}) corner.push_back(int32_t(first + index[i]));
    };
    const size_t n = index.size();
    if (primitive.mode == TINYGLTF_MODE_TRIANGLES) {
      for (size_t i = 0; i + 2 < n; i += 3) add(i, i + 1, i + 2);
    } else if (primitive.mode == TINYGLTF_MODE_TRIANGLE_STRIP) {
      for (size_t i = 0; i + 2 < n; ++i) add(i, i + 1 + i % 2, i + 2 - i % 2);
    } else {
      for (size_t i = 1; i + 1 < n; ++i) add(i, i + 1, 0);
    }
  }

  std::vector<uint32_t> indices_of(const tinygltf::Primitive& primitive, int64_t vertices) {
    if (primitive.indices >= 0) {
      return accessor_indices(source_, model_, primitive.indices, vertices);
    }
    std::vector<uint32_t> all(static_cast<size_t>(vertices));
    for (size_t i = 0; i < all.size(); ++i) all[i] = uint32_t(i);
    return all;
  }

  /// First vertex and count of POSITION accessors.
  using Ranges = std::map<int, std::pair<int64_t, int64_t>>;

  /// Vertices of points and lines beside triangles are carried too: without a triangle, behind the
  /// others.
  void append_riders(const tinygltf::Mesh& from, Ranges& ranges, Mesh& mesh) {
    for (const tinygltf::Primitive& primitive : from.primitives) {
      if (!is_points_or_lines(primitive)) continue;
      const auto [range, is_new] = ranges.try_emplace(primitive.attributes.at("POSITION"));
      const auto first = int64_t(mesh.position.size());
      if (is_new) range->second = {first, append_vertices(primitive, mesh)};
    }
  }

  /// Reads one mesh; counts the primitives that are no triangles.
  Mesh read_mesh(const tinygltf::Mesh& from, int64_t& skipped) {
    Mesh mesh;
    // vertices that primitives share are read once
    mesh.name = from.name;
    Ranges ranges;
    for (size_t p = 0; p < from.primitives.size(); ++p) {
      const tinygltf::Primitive& primitive = from.primitives[p];
      if (!is_surface(primitive)) {
        ++skipped;
        continue;
      }
      const auto [range, is_new] = ranges.try_emplace(primitive.attributes.at("POSITION"));
      if (is_new) {
        const auto first = int64_t(mesh.position.size());
        range->second = {first, append_vertices(primitive, mesh)};
      }
      const auto [first, count] = range->second;
      // one group of triangles for each primitive
      const std::vector<uint32_t> indices = indices_of(primitive, count);
      spend(indices.size());
      check(primitive.material < int64_t(model_.materials.size()), "mesh \"", from.name,
            "\": there is no material ", primitive.material);
      TriangleGroup group{primitive.material, {}, int(p)};
      add_triangles(primitive, indices, first, group.corner);
      mesh.groups.push_back(std::move(group));
    }
    // vertices of points and lines follow, then attributes are padded to all vertices
    if (!mesh.groups.empty()) append_riders(from, ranges, mesh);
    const size_t drawn = mesh.position.size();
    if (!mesh.uv.empty()) mesh.uv.resize(drawn, {});
    if (!mesh.normal.empty()) mesh.normal.resize(drawn, {});
    if (!mesh.colour.empty()) mesh.colour.resize(drawn, {1, 1, 1, 1});
    for (OwnColumn& column : mesh.attributes) pad(int64_t(drawn), column);
    return mesh;
  }

  /// Reads the meshes that are shown and turns the nodes' file indices into the asset's.
  void read_meshes() {
    std::map<int, int> index_of;
    for (const AssetNode& node : asset_.nodes) {
      if (node.mesh >= 0) index_of[node.mesh] = -1;
    }
    int64_t skipped = 0;
    for (auto& [file_index, index] : index_of) {
      Mesh mesh = read_mesh(model_.meshes[size_t(file_index)], skipped);
      if (mesh.groups.empty()) continue;
      index = int(asset_.meshes.size());
      asset_.meshes.push_back(std::move(mesh));
    }
    for (AssetNode& node : asset_.nodes) {
      if (node.mesh >= 0) node.mesh = index_of[node.mesh];
    }
    check(!asset_.meshes.empty() || hidden_ == 0,
          "has no triangle that is shown: nothing to simulate");
    note("not-triangles", skipped, "primitives are points or lines");
    note_tangents();
  }

  /// Primitives with tangents in the meshes that are simulated.
  void note_tangents() {
    std::set<int> meshes;
    for (size_t n = 0; n < asset_.nodes.size(); ++n)
      if (asset_.nodes[n].mesh >= 0) meshes.insert(model_.nodes[n].mesh);
    int64_t count = 0;
    for (const int m : meshes)
      for (const tinygltf::Primitive& primitive : model_.meshes[size_t(m)].primitives)
        count += primitive.attributes.contains("TANGENT");
    note("tangents", count, "primitives have tangents");
  }

  /// Throws unless the accessors of animations that the output keeps lie within their bytes.
  void check_animations() const {
    for (const Json& animation : document_.value("animations", Json::array())) {
      for (const Json& sampler : animation["samplers"]) {
        accessor_values(source_, model_, sampler["input"].get<int>());
        accessor_values(source_, model_, sampler["output"].get<int>());
      }
    }
  }

  void note_what_is_left_out() {
    keep_other_animations(document_, asset_.nodes);
    note("animations", channels_ - count_channels(document_),
         "channels of the file's animations move what is simulated");
    check_animations();
    int64_t missing = 0;
    const Json images = document_.value("images", Json::array());
    check(images.is_array(), "images must be a list");
    for (size_t i = 0; i < images.size(); ++i) {
      if (!images[i].is_object() || !images[i].contains("uri")) continue;
      check(images[i]["uri"].is_string(), "images[", i, "]: the URI is not a string");
      const std::string uri = images[i]["uri"].get<std::string>();
      const std::string what = concat("images[", i, ']');
      missing += !is_data_uri(uri) && resolve_gltf_uri(asset_.path, uri, what).empty();
    }
    note("missing-texture", missing, "images are not beside the file");
  }

  ReadOptions options_;
  GltfSource source_;
  Json document_;  ///< of the source
  tinygltf::Model model_;
  Asset asset_;
  uint64_t budget_ = 0;
  int64_t hidden_ = 0;    ///< nodes with a mesh
  int64_t channels_ = 0;  ///< of animations of the file
};

}  // namespace

Asset read_gltf(const std::string& path, const ReadOptions& options) {
  return GltfReader(path, options).read();
}

Asset read_gltf(const std::string& path) {
  return read_gltf(path, {});
}

}  // namespace elastogen
