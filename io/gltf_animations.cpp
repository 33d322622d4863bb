// SPDX-License-Identifier: Apache-2.0
#include "io/gltf_animations.hpp"

#include <charconv>
#include <functional>
#include <map>
#include <optional>

namespace elastogen {

namespace {

using Json = nlohmann::ordered_json;

const Json& list_of(const Json& object, const char* key) {
  static const Json kNone = Json::array();
  if (!object.is_object()) return kNone;
  const auto found = object.find(key);
  return found != object.end() && found->is_array() ? *found : kNone;
}

/// An index into a list of `size`; no value where it is none.
std::optional<size_t> index_of(const Json& object, const char* key, size_t size) {
  if (!object.is_object() || !object.contains(key) || !object[key].is_number_unsigned()) return {};
  const auto index = object[key].get<uint64_t>();
  return index < size ? std::optional<size_t>(size_t(index)) : std::nullopt;
}

/// Target of a channel: a node, or something that the simulation does not touch.
struct Target {
  bool valid = false;
  std::optional<size_t> node = {};
};

/// Target of a pointer: "/nodes/3/..." is node 3; "/meshes/..." is invalid: any node may show it.
Target pointer_target(const std::string& pointer, size_t nodes) {
  constexpr std::string_view kNodes = "/nodes/";
  if (pointer.starts_with("/meshes/")) return {};
  if (!pointer.starts_with(kNodes)) return {true};
  size_t node = nodes;
  std::from_chars(pointer.data() + kNodes.size(), pointer.data() + pointer.size(), node);
  return node < nodes ? Target{true, node} : Target{};
}

Target target_of(const Json& channel, size_t nodes) {
  if (!channel.is_object() || !channel.contains("target")) return {};
  const Json& target = channel["target"];
  const Json::json_pointer pointer("/extensions/KHR_animation_pointer/pointer");
  if (target.contains(pointer) && target[pointer].is_string())
    return pointer_target(target[pointer].get<std::string>(), nodes);
  const std::optional<size_t> node = index_of(target, "node", nodes);
  return {node.has_value() && target.contains("path") && target["path"].is_string(), node};
}

/// Whether the sampler of a channel names accessors of the document.
bool has_sampler(const Json& animation, const Json& channel, size_t accessors) {
  const Json& samplers = list_of(animation, "samplers");
  const std::optional<size_t> sampler = index_of(channel, "sampler", samplers.size());
  return sampler && index_of(samplers[*sampler], "input", accessors) &&
         index_of(samplers[*sampler], "output", accessors);
}

/// The animation reduced to some channels and the samplers that they use; null without channels.
Json with_channels(const Json& animation, const std::function<bool(const Json&)>& stays) {
  Json result = animation, channels = Json::array(), samplers = Json::array();
  std::map<size_t, size_t> place;  // new index of each sampler
  for (const Json& channel : list_of(animation, "channels")) {
    if (!stays(channel)) continue;
    const auto sampler = channel["sampler"].get<size_t>();
    const auto [at, is_new] = place.try_emplace(sampler, samplers.size());
    if (is_new) samplers.push_back(animation["samplers"][sampler]);
    channels.push_back(channel);
    channels.back()["sampler"] = at->second;
  }
  if (channels.empty()) return nullptr;
  result["channels"] = std::move(channels);
  result["samplers"] = std::move(samplers);
  return result;
}

void filter(Json& document, const std::function<bool(const Target&)>& stays) {
  const size_t nodes = list_of(document, "nodes").size(),
               accessors = list_of(document, "accessors").size();
  Json left = Json::array();
  for (const Json& animation : list_of(document, "animations")) {
    Json kept = with_channels(animation, [&](const Json& channel) {
      const Target target = target_of(channel, nodes);
      return target.valid && has_sampler(animation, channel, accessors) && stays(target);
    });
    if (!kept.is_null()) left.push_back(std::move(kept));
  }
  document.erase("animations");
  if (!left.empty()) document["animations"] = std::move(left);
}

/// Marks the nodes and all nodes above them.
std::vector<char> with_ancestors(const std::vector<int>& parent, std::vector<char> marked) {
  for (size_t n = 0; n < marked.size(); ++n) {
    if (marked[n] != 1) continue;
    for (int above = parent[n]; above >= 0 && marked[size_t(above)] == 0;
         above = parent[size_t(above)])
      marked[size_t(above)] = 2;
  }
  return marked;
}

}  // namespace

int64_t count_channels(const Json& document) {
  int64_t count = 0;
  for (const Json& animation : list_of(document, "animations"))
    count += int64_t(list_of(animation, "channels").size());
  return count;
}

void keep_other_animations(Json& document, const std::vector<AssetNode>& nodes) {
  std::vector<int> parent;
  std::vector<char> simulated;
  for (const AssetNode& node : nodes) {
    parent.push_back(node.parent);
    simulated.push_back(node.mesh >= 0 ? 1 : 0);
  }
  simulated = with_ancestors(parent, std::move(simulated));
  filter(document, [&](const Target& target) {
    return !target.node || (*target.node < simulated.size() && !simulated[*target.node]);
  });
}

void remove_joint_channels(Json& document) {
  const Json& nodes = list_of(document, "nodes");
  std::vector<int> parent(nodes.size(), -1);
  std::vector<char> is_joint(nodes.size(), 0), shows(nodes.size(), 0);
  for (size_t n = 0; n < nodes.size(); ++n) {
    for (const Json& child : list_of(nodes[n], "children")) parent[child.get<size_t>()] = int(n);
    const bool lamp = nodes[n].contains("extensions");
    shows[n] = lamp || nodes[n].contains("camera") ||
               (nodes[n].contains("mesh") && !nodes[n].contains("skin"));
  }
  for (const Json& skin : list_of(document, "skins"))
    for (const Json& joint : list_of(skin, "joints"))
      if (joint.is_number_unsigned() && joint.get<uint64_t>() < nodes.size())
        is_joint[joint.get<size_t>()] = 1;
  shows = with_ancestors(parent, std::move(shows));
  filter(document, [&](const Target& target) {
    return !target.node || !is_joint[*target.node] || shows[*target.node];
  });
}

}  // namespace elastogen
