// SPDX-License-Identifier: Apache-2.0
// A scene file as a tree, from TOML or JSON.

#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

struct SceneMember;

/// A value of a scene file. Its kind tells which member holds it.
struct SceneValue {
  enum class Kind { kFlag, kNumber, kText, kList, kTable };
  Kind kind = Kind::kTable;
  bool flag = false;
  double number = 0;  ///< finite
  std::string text;
  std::vector<SceneValue> items;
  std::vector<SceneMember> members;  ///< no key twice
  int line = 0;                      ///< of the file, from 1; 0: not known

  /// The member of that key, or nullptr.
  const SceneValue* find(std::string_view key) const;
  /// Adds a member.
  void set(const std::string& key, SceneValue value);
};

struct SceneMember {
  std::string key;
  SceneValue value;
};

SceneValue scene_flag(bool flag);
SceneValue scene_number(double number);
SceneValue scene_text(const std::string& text);
SceneValue scene_texts(const std::vector<std::string>& texts);

}  // namespace elastogen
