// SPDX-License-Identifier: Apache-2.0
#include "io/scene_value.hpp"

#include <utility>

namespace elastogen {

const SceneValue* SceneValue::find(std::string_view key) const {
  for (const SceneMember& member : members)
    if (member.key == key) return &member.value;
  return nullptr;
}

void SceneValue::set(const std::string& key, SceneValue value) {
  members.push_back({key, std::move(value)});
}

SceneValue scene_flag(bool flag) {
  SceneValue value;
  value.kind = SceneValue::Kind::kFlag;
  value.flag = flag;
  return value;
}

SceneValue scene_number(double number) {
  SceneValue value;
  value.kind = SceneValue::Kind::kNumber;
  value.number = number;
  return value;
}

SceneValue scene_text(const std::string& text) {
  SceneValue value;
  value.kind = SceneValue::Kind::kText;
  value.text = text;
  return value;
}

SceneValue scene_texts(const std::vector<std::string>& texts) {
  SceneValue list;
  list.kind = SceneValue::Kind::kList;
  for (const std::string& text : texts) list.items.push_back(scene_text(text));
  return list;
}

}  // namespace elastogen
