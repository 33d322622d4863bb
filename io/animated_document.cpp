// SPDX-License-Identifier: Apache-2.0
#include "io/animated_document.hpp"

#include "core/error.hpp"
#include "io/json_text.hpp"

#include <algorithm>

namespace elastogen {

namespace {

using Json = AnimatedDocument::Json;

/// Lists of a document that get further entries.
constexpr const char* kLists[] = {"accessors", "bufferViews", "materials", "meshes", "nodes"};

/// Nodes without a parent.
Json roots_of(const Json& nodes) {
  std::set<size_t> children;
  for (const Json& node : nodes) {
    for (const Json& child : node.value("children", Json::array()))
      children.insert(child.get<size_t>());
  }
  Json result = Json::array();
  for (size_t n = 0; n < nodes.size(); ++n) {
    if (!children.contains(n)) result.push_back(n);
  }
  return result;
}

bool has_mode(const Json& primitive, int first, int last) {
  const int mode = primitive.value("mode", 4);
  return mode >= first && mode <= last && primitive["attributes"].contains("POSITION");
}

/// Primitives in the order in which io/gltf_reader.hpp reads their vertices: triangles first, then
/// points and lines.
std::vector<const Json*> in_order(const Json& primitives) {
  std::vector<const Json*> order;
  for (const auto& [first, last] : {std::pair(4, 6), std::pair(0, 3)})
    for (const Json& primitive : primitives)
      if (has_mode(primitive, first, last)) order.push_back(&primitive);
  return order;
}

}  // namespace

AnimatedDocument::AnimatedDocument(GlbDocument base, std::vector<float> clip_times)
    : bin_(std::move(base.bin)), json_(parsed_json(base.json)), clip_times_(std::move(clip_times)) {
  // make all lists now: one that is added later moves the others, and references to them dangle
  for (const char* list : kLists)
    if (!json_.contains(list)) json_[list] = Json::array();
  for (const Json& node : json_["nodes"]) names_.try_emplace(node.value("name", ""), 2);
}

void AnimatedDocument::keep_meshes_of_others(const std::set<size_t>& staged) {
  const Json& nodes = json_["nodes"];
  for (size_t n = 0; n < nodes.size(); ++n)
    if (nodes[n].contains("mesh") && !staged.contains(n))
      taken_.insert(nodes[n]["mesh"].get<size_t>());
}

std::vector<size_t> AnimatedDocument::stage(size_t node, const std::vector<FrameRange>& pieces) {
  const auto mesh = json_["nodes"][node]["mesh"].get<size_t>();
  std::vector<size_t> nodes = {node};
  if (pieces.size() > 1 || json_["nodes"][node].contains("matrix") || shows_below(node)) {
    nodes.clear();
    json_["nodes"][node].erase("mesh");
    for (size_t p = 0; p < pieces.size(); ++p)
      nodes.push_back(add_child(node, pieces.size() > 1 ? concat("_part_", p + 1) : "_mesh"));
  }
  for (const size_t n : nodes) own_mesh(n, mesh);
  if (pieces.size() > 1) show_in_turn(nodes, pieces);
  return nodes;
}

size_t AnimatedDocument::add_weights(const Array<float>& weights) {
  return add_scalars({weights.data(), weights.data() + weights.size()});
}

void AnimatedDocument::play(size_t node, const MorphTargets& targets, const FrameRange& frames,
                            size_t weights) {
  if (targets.count() == 0) return;
  Json& mesh = json_["meshes"][json_["nodes"][node]["mesh"].get<size_t>()];
  set_targets(mesh, targets);
  const std::vector<int> at_rest(size_t(targets.count()), 0);
  mesh["weights"] = at_rest;
  json_["nodes"][node]["weights"] = at_rest;
  add_channel(node, "weights", "LINEAR", times_of(frames), weights);
}

/// The default scene; makes one if there is none.
Json& AnimatedDocument::scene() {
  if (!json_.contains("scenes"))
    json_["scenes"] = Json::array({{{"nodes", roots_of(json_["nodes"])}}});
  if (!json_.contains("scene")) json_["scene"] = 0;
  return json_["scenes"][json_["scene"].get<size_t>()];
}

void AnimatedDocument::add_root(const Matrix4& matrix) {
  Json& shown = scene();
  Json& nodes = json_["nodes"];
  nodes.push_back({{"name", "elastogen_root"}, {"matrix", matrix}, {"children", shown["nodes"]}});
  shown["nodes"] = Json::array({nodes.size() - 1});
}

void AnimatedDocument::write(const std::string& path) {
  if (!channels_.empty()) {
    // extend the first animation, because many clients play that one
    Json animations =
        Json::array({{{"name", "elastogen"}, {"channels", channels_}, {"samplers", samplers_}}});
    for (Json& other : json_.value("animations", Json::array()))
      animations.push_back(std::move(other));
    json_["animations"] = std::move(animations);
  }
  json_["buffers"] = Json::array({{{"byteLength", bin_.size()}}});
  for (const char* list : kLists)
    if (json_[list].empty()) json_.erase(list);
  write_glb(path, json_.dump(-1, ' ', false, Json::error_handler_t::replace), bin_);
}

/// Whether a node below this one has a mesh. Not recursive, as a tree may be one long chain.
bool AnimatedDocument::shows_below(size_t node) const {
  const Json& nodes = json_["nodes"];
  std::vector<size_t> stack = {node};
  while (!stack.empty()) {
    const Json& above = nodes[stack.back()];
    stack.pop_back();
    if (!above.contains("children")) continue;
    for (const Json& child : above["children"]) {
      stack.push_back(child.get<size_t>());
      if (nodes[stack.back()].contains("mesh")) return true;
    }
  }
  return false;
}

/// A name that no node has yet, reserved for one: some clients find nodes by their names.
std::string AnimatedDocument::free_name(const std::string& wanted) {
  auto [taken, is_free] = names_.try_emplace(wanted, 2);
  std::string name = wanted;
  while (!is_free) {
    name = concat(wanted, '_', taken->second++);
    is_free = names_.try_emplace(name, 2).second;
  }
  return name;
}

/// A child without transform, named after its parent.
size_t AnimatedDocument::add_child(size_t node, const std::string& ending) {
  Json& nodes = json_["nodes"];
  const size_t child = nodes.size();
  const std::string name = free_name(nodes[node].value("name", "node") + ending);
  nodes.push_back({{"name", name}});
  nodes[node]["children"].push_back(child);
  return child;
}

/// An empty material, as glTF assumes for a primitive that names none. Without one Filament drops
/// the normals of morph targets.
size_t AnimatedDocument::default_material() {
  if (!material_) {
    json_["materials"].push_back(Json::object());
    material_ = json_["materials"].size() - 1;
  }
  return *material_;
}

/// Lets the node show the mesh, or a copy without targets if another node owns the mesh.
void AnimatedDocument::own_mesh(size_t node, size_t mesh) {
  if (!taken_.insert(mesh).second) {
    Json copy = json_["meshes"][mesh];
    for (Json& primitive : copy["primitives"]) primitive.erase("targets");
    copy.erase("weights");
    if (copy.contains("extras") && copy["extras"].is_object()) copy["extras"].erase("targetNames");
    mesh = json_["meshes"].size();
    json_["meshes"].push_back(std::move(copy));
    taken_.insert(mesh);
  }
  json_["nodes"][node]["mesh"] = mesh;
}

/// Gives each node the scale 1 during its piece and 0 else, in steps; at a time that two pieces
/// share the later one is shown.
void AnimatedDocument::show_in_turn(const std::vector<size_t>& nodes,
                                    const std::vector<FrameRange>& pieces) {
  std::vector<float> times;
  for (const FrameRange& piece : pieces) times.push_back(clip_times_[size_t(piece.first)]);
  const size_t input = add_scalars(times);
  for (size_t p = 0; p < nodes.size(); ++p) {
    std::vector<float> scale(3 * pieces.size(), 0);
    std::fill_n(scale.begin() + std::ptrdiff_t(3 * p), 3, 1.f);
    const uint64_t offset = append_bytes(bin_, scale.data(), scale.size() * sizeof(float));
    const size_t view = add_view(offset, scale.size() * sizeof(float));
    const auto count = int64_t(pieces.size());
    add_channel(nodes[p], "scale", "STEP", input, add_vectors(view, 0, scale.data(), count));
    if (p > 0) json_["nodes"][nodes[p]]["scale"] = {0, 0, 0};
  }
}

void AnimatedDocument::add_channel(size_t node, const char* path, const char* interpolation,
                                   size_t input, size_t output) {
  channels_.push_back(
      {{"sampler", samplers_.size()}, {"target", {{"node", node}, {"path", path}}}});
  samplers_.push_back({{"input", input}, {"interpolation", interpolation}, {"output", output}});
}

size_t AnimatedDocument::add_scalars(const std::vector<float>& values) {
  const uint64_t offset = append_bytes(bin_, values.data(), values.size() * sizeof(float));
  const size_t view = add_view(offset, values.size() * sizeof(float));
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  return add_accessor({{"bufferView", view},
                       {"componentType", kFloat},
                       {"count", values.size()},
                       {"type", "SCALAR"},
                       {"min", Json::array({*least})},
                       {"max", Json::array({*largest})}});
}

/// The accessor of the times of a range of frames, stored once.
size_t AnimatedDocument::times_of(const FrameRange& frames) {
  const auto [at, is_new] = times_.try_emplace({frames.first, frames.last});
  if (is_new) {
    const auto first = clip_times_.begin() + frames.first;
    at->second = add_scalars({first, first + frames.count()});
  }
  return at->second;
}

size_t AnimatedDocument::add_view(uint64_t offset, size_t size) {
  json_["bufferViews"].push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", size}});
  return json_["bufferViews"].size() - 1;
}

size_t AnimatedDocument::add_accessor(Json accessor) {
  json_["accessors"].push_back(std::move(accessor));
  return json_["accessors"].size() - 1;
}

/// An accessor with bounds of elements of three floats, at an offset of a view.
size_t AnimatedDocument::add_vectors(size_t view, uint64_t offset, const float* values,
                                     int64_t count) {
  std::array<float, 3> lower, upper;
  for (size_t d = 0; d < 3; ++d) {
    lower[d] = upper[d] = values[d];
    for (int64_t v = 1; v < count; ++v) {
      lower[d] = std::min(lower[d], values[size_t(3 * v) + d]);
      upper[d] = std::max(upper[d], values[size_t(3 * v) + d]);
    }
  }
  return add_accessor({{"bufferView", view},
                       {"byteOffset", offset},
                       {"componentType", kFloat},
                       {"count", count},
                       {"type", "VEC3"},
                       {"min", lower},
                       {"max", upper}});
}

/// An accessor of zero vectors, stored once for each count.
size_t AnimatedDocument::zeros(int64_t count) {
  const auto [at, is_new] = zeros_.try_emplace(count);
  if (is_new) {
    const std::vector<float> values(size_t(3 * count), 0);
    const size_t size = values.size() * sizeof(float);
    const size_t view = add_view(append_bytes(bin_, values.data(), size), size);
    json_["bufferViews"][view]["target"] = kVertices;
    at->second = add_vectors(view, 0, values.data(), count);
  }
  return at->second;
}

/// Adds one view with rows of vectors, and an accessor for each row.
std::vector<size_t> AnimatedDocument::add_rows(const Array<float>& rows, const Range& range) {
  std::vector<size_t> accessors;
  if (rows.rows() == 0) return accessors;
  const size_t size = size_t(range.count) * 12, view = json_["bufferViews"].size();
  for (int64_t k = 0; k < rows.rows(); ++k) {
    const float* values = rows.row(k) + 3 * range.first;
    const uint64_t at = append_bytes(bin_, values, size);
    if (k == 0) add_view(at, size * size_t(rows.rows()));
    accessors.push_back(add_vectors(view, uint64_t(k) * size, values, range.count));
  }
  json_["bufferViews"][view]["byteStride"] = 12;
  json_["bufferViews"][view]["target"] = kVertices;
  return accessors;
}

void AnimatedDocument::fill_range(const MorphTargets& targets, Range& range) {
  range.targets = {Json::array(), Json::array()};
  const std::vector<size_t> position = add_rows(targets.position, range),
                            normal = add_rows(targets.normal, range);
  const auto accessor = [&](const std::vector<size_t>& rows, int row) {
    return row < 0 ? zeros(range.count) : rows[size_t(row)];
  };
  for (size_t k = 0; k < targets.position_row.size(); ++k) {
    Json target = {{"POSITION", accessor(position, targets.position_row[k])}};
    range.targets[0].push_back(target);
    if (targets.normal_row.empty()) continue;
    target["NORMAL"] = accessor(normal, targets.normal_row[k]);
    range.targets[1].push_back(std::move(target));
  }
}

/// The distinct POSITION accessors of a mesh in order of first use, in which the reader joins them.
std::map<size_t, AnimatedDocument::Range> AnimatedDocument::ranges_of(const Json& mesh,
                                                                      const MorphTargets& targets) {
  std::map<size_t, Range> ranges;
  int64_t first = 0;
  for (const Json* primitive : in_order(mesh["primitives"])) {
    const auto accessor = (*primitive)["attributes"]["POSITION"].get<size_t>();
    const auto [range, is_new] = ranges.try_emplace(accessor);
    if (!is_new) continue;
    range->second.first = first;
    range->second.count = json_["accessors"][accessor]["count"].get<int64_t>();
    first += range->second.count;
  }
  const int64_t expected = targets.position.rows() > 0 ? targets.position.cols() / 3 : first;
  ELASTOGEN_CHECK_ASSET(first == expected, "the asset file changed while it was animated");
  for (auto& [accessor, range] : ranges) fill_range(targets, range);
  return ranges;
}

void AnimatedDocument::set_targets(Json& mesh, const MorphTargets& targets) {
  const std::map<size_t, Range> ranges = ranges_of(mesh, targets);
  for (Json& primitive : mesh["primitives"]) {
    Json& attributes = primitive["attributes"];
    if (!attributes.contains("POSITION")) continue;
    // tangents at rest do not fit the moved normals; clients compute their own where there are none
    attributes.erase("TANGENT");
    const auto found = ranges.find(attributes["POSITION"].get<size_t>());
    Json list = Json::array();
    if (found != ranges.end()) {
      const bool normals = attributes.contains("NORMAL") && !targets.normal_row.empty();
      list = found->second.targets[normals ? 1 : 0];
      if (normals && !primitive.contains("material")) primitive["material"] = default_material();
    } else {
      // primitives of an unknown mode
      const auto count = json_["accessors"][attributes["POSITION"].get<size_t>()]["count"];
      const Json still = {{"POSITION", zeros(count.get<int64_t>())}};
      list = Json(size_t(targets.count()), still);
    }
    primitive["targets"] = std::move(list);
  }
  if (mesh.contains("extras") && !mesh["extras"].is_object()) return;
  Json names = Json::array();
  for (int k = 0; k < targets.count(); ++k)
    names.push_back(concat(targets.position_row[size_t(k)] < 0 ? "normals_" : "elastogen_", k));
  mesh["extras"]["targetNames"] = std::move(names);
}

}  // namespace elastogen
