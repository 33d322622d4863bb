// SPDX-License-Identifier: Apache-2.0
#include "io/scene_file.hpp"

#include "core/error.hpp"
#include "core/material.hpp"
#include "io/safe_file.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_text.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;
using Kind = SceneValue::Kind;

const char* kind_text(Kind kind) {
  static constexpr const char* kTexts[] = {"true or false", "a number", "a text", "a list",
                                           "a table"};
  return kTexts[int(kind)];
}

bool is_control(char c) {
  return static_cast<unsigned char>(c) < ' ' || c == 127;
}

/// Checks values and turns them into SI, in place.
class Check {
 public:
  explicit Check(const std::string& name) : name_(name) {}

  void root(SceneValue& scene) {
    for (SceneMember& member : scene.members) {
      const SceneTable* table = find_scene_table(member.key);
      if (!table) {
        value(member, "");
      } else if (table->many) {
        expect(member, member.value, Kind::kList, member.key);
        for (SceneValue& item : member.value.items) members(item, member, member.key);
      } else {
        members(member.value, member, member.key);
      }
    }
  }

 private:
  [[noreturn]] void fail(int line, const std::string& text) const {
    throw Error(concat(name_, line > 0 ? concat(':', line) : "", ": ", text));
  }

  /// Runs a parser of io/units.hpp and adds the place to its message.
  template <class Call>
  auto located(int line, const std::string& path, const Call& call) const {
    try {
      return call();
    } catch (const Error& error) {
      fail(line, concat('\'', path, "': ", error.what()));
    }
  }

  void expect(const SceneMember& at, const SceneValue& value, Kind kind,
              const std::string& path) const {
    if (value.kind != kind)
      fail(at.value.line,
           concat('\'', path, "': ", kind_text(kind), " is expected, not ", kind_text(value.kind)));
  }

  void members(SceneValue& table, const SceneMember& at, const std::string& name) {
    expect(at, table, Kind::kTable, name);
    for (SceneMember& member : table.members) value(member, name);
    const int line = table.line > 0 ? table.line : at.value.line;
    if (find_scene_key(name, "gltf_material")) check_selection(name, table, line);
    if (name == "hold" && !table.find("axes")) fail(line, "'hold': needs axes");
    if (name == "traction" && !table.find("force") == !table.find("pressure"))
      fail(line, "'traction': needs one of force and pressure");
    if (name == "move") check_move(table, line);
    if (name == "collider") check_collider(table, line);
    if (name == "shape")
      check_form("shape", "kind", table, line, {kBoxKeys, kBallKeys, kBoxKeys, kBallKeys});
  }

  void check_selection(const std::string& name, const SceneValue& table, int line) const {
    int given = 0;
    for (const char* key : {"select", "node", "gltf_material"}) given += table.find(key) != nullptr;
    if (given != 1)
      fail(line, concat('\'', name, "': needs one of select, node and gltf_material"));
  }

  /// A move must have a path, or all keys of a turn.
  void check_move(const SceneValue& move, int line) const {
    int turn = 0;
    for (const char* key : {"turn", "turn_centre", "turn_axis"}) turn += move.find(key) != nullptr;
    if (move.find("path") ? turn != 0 : turn != 3)
      fail(line, "'move': needs path, or turn with turn_centre and turn_axis");
  }

  using TwoKeys = std::array<std::string_view, 2>;
  static constexpr TwoKeys kBoxKeys = {"lower", "upper"}, kBallKeys = {"centre", "radius"},
                           kPlaneKeys = {"centre", "normal"};

  /// A table must have the keys of its form and no others.
  /// @param own  keys of each form, by the word that names the form.
  void check_form(std::string_view name, std::string_view kind, const SceneValue& table, int line,
                  const std::vector<TwoKeys>& own) const {
    const SceneValue* form = table.find(kind);
    if (!form) fail(line, concat('\'', name, "': needs ", kind));
    const auto& words = find_scene_key(name, kind)->words;
    const TwoKeys& keys =
        own[size_t(std::find(words.begin(), words.end(), form->text) - words.begin())];
    for (const std::string_view key : keys)
      if (!table.find(key))
        fail(line, concat('\'', name, "': a ", form->text, " needs ", keys[0], " and ", keys[1]));
    for (const std::string_view key : {"centre", "normal", "radius", "lower", "upper"})
      if (table.find(key) && key != keys[0] && key != keys[1])
        fail(table.find(key)->line, concat('\'', name, '.', key, "': a ", form->text, " has none"));
  }

  void check_collider(const SceneValue& collider, int line) const {
    check_form("collider", "shape", collider, line, {kPlaneKeys, kBallKeys, kBoxKeys});
    const SceneValue* name = collider.find("name");
    static constexpr const char* kLetters =
        "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    if (name && (name->text.empty() || name->text.find_first_not_of(kLetters) != std::string::npos))
      fail(name->line, "'collider.name': letters, digits, - and _ are expected");
  }

  void value(SceneMember& member, const std::string& table) {
    // an unknown key names its nearest neighbour
    const SceneKey* key = find_scene_key(table, member.key);
    if (!key) {
      const std::string path = (table.empty() ? "" : table + '.') + member.key;
      fail(member.value.line, concat("unknown key '", path.substr(0, 100), "'; the nearest is '",
                                     nearest_scene_key(table, member.key), '\''));
    }
    // each type has its check, which also turns numbers into SI
    SceneValue& v = member.value;
    switch (key->type) {
      case SceneType::kFlag:
        return expect(member, v, Kind::kFlag, key->path());
      case SceneType::kText:
        return check_text(member, v, *key);
      case SceneType::kTexts:
        expect(member, v, Kind::kList, key->path());
        for (const SceneValue& item : v.items) check_text(member, item, *key);
        return;
      // some keys take a word in place of numbers, like auto
      case SceneType::kWhole:
      case SceneType::kNumber:
        if (!is_word(v, *key)) number(member, v, *key, key->quantity);
        return;
      case SceneType::kVector:
        if (!is_word(v, *key)) vector(member, *key);
        return;
      case SceneType::kPath:
        return path(member, *key, "t, x, y, z", Quantity::kLength);
      case SceneType::kTurn:
        return path(member, *key, "t, angle", Quantity::kAngle);
    }
  }

  static bool is_word(const SceneValue& v, const SceneKey& key) {
    if (v.kind != Kind::kText) return false;
    const size_t equals = v.text.find('=');
    const std::string word = equals == v.text.npos ? v.text : v.text.substr(0, equals) + "=NUMBER";
    return std::find(key.words.begin(), key.words.end(), word) != key.words.end();
  }

  static std::string words_text(const SceneKey& key) {
    std::string text;
    for (const std::string& word : key.words) text += (text.empty() ? "" : ", ") + word;
    return text;
  }

  void check_text(const SceneMember& member, const SceneValue& v, const SceneKey& key) const {
    expect(member, v, Kind::kText, key.path());
    if (std::any_of(v.text.begin(), v.text.end(), is_control))
      fail(member.value.line, concat('\'', key.path(), "': has a control character"));
    if (!key.words.empty() && !is_word(v, key))
      fail(member.value.line, concat('\'', key.path(), "': '", v.text.substr(0, 100),
                                     "' is not known; known are ", words_text(key)));
    if (!key.words.empty() && v.text.find('=') != v.text.npos)
      located(member.value.line, key.path(), [&] { return law_from_name(v.text); });
  }

  void number(const SceneMember& member, SceneValue& v, const SceneKey& key, Quantity quantity) {
    const int line = member.value.line;
    if (v.kind == Kind::kText)
      v = scene_number(located(line, key.path(), [&] { return parse_quantity(v.text, quantity); }));
    if (v.kind != Kind::kNumber)
      fail(line, concat('\'', key.path(), "': a number", words_of(key), " is expected, not ",
                        kind_text(v.kind)));
    if (key.type == SceneType::kWhole && v.number != std::floor(v.number))
      fail(line, concat('\'', key.path(), "': a whole number is expected, not ", v.number));
    if (!key.range.has(v.number))
      fail(line, concat('\'', key.path(), "': ", key.range.text(), " is expected, not ", v.number));
    v.line = line;
  }

  static std::string words_of(const SceneKey& key) {
    return key.words.empty() ? "" : " or " + words_text(key);
  }

  void vector(SceneMember& member, const SceneKey& key) {
    SceneValue& v = member.value;
    const int line = v.line;
    if (v.kind == Kind::kText) {
      const Vec3 x = located(line, key.path(), [&] { return parse_vec3(v.text, key.quantity); });
      v = SceneValue();
      v.kind = Kind::kList;
      v.line = line;
      for (const double number : x) v.items.push_back(scene_number(number));
    }
    if (v.kind != Kind::kList || v.items.size() != 3)
      fail(line, concat('\'', key.path(), "': three numbers", words_of(key), " are expected"));
    for (SceneValue& item : v.items) number(member, item, key, key.quantity);
  }

  /// Checks a list of entries of a time and values at that time.
  void path(SceneMember& member, const SceneKey& key, const char* names, Quantity quantity) {
    expect(member, member.value, Kind::kList, key.path());
    const size_t count = key.type == SceneType::kTurn ? 2 : 4;
    double before = -std::numeric_limits<double>::infinity();
    for (SceneValue& place : member.value.items) {
      if (place.kind != Kind::kList || place.items.size() != count)
        fail(member.value.line, concat('\'', key.path(), "': lists of ", names, " are expected"));
      for (size_t k = 0; k < count; ++k)
        number(member, place.items[k], key, k == 0 ? Quantity::kTime : quantity);
      if (place.items[0].number <= before)
        fail(member.value.line, concat('\'', key.path(), "': the times must ascend"));
      before = place.items[0].number;
    }
  }

  const std::string& name_;
};

Json to_json(const SceneValue& value) {
  switch (value.kind) {
    case Kind::kFlag:
      return value.flag;
    case Kind::kNumber:
      if (value.number == std::floor(value.number) && std::abs(value.number) < 1e15)
        return int64_t(value.number);
      return value.number;
    case Kind::kText:
      return value.text;
    case Kind::kList: {
      Json list = Json::array();
      for (const SceneValue& item : value.items) list.push_back(to_json(item));
      return list;
    }
    case Kind::kTable:
      break;
  }
  Json table = Json::object();
  for (const SceneMember& member : value.members) table[member.key] = to_json(member.value);
  return table;
}

/// Makes asset.file relative to the folder of the scene file.
void resolve_asset(SceneValue& scene, const std::string& name) {
  for (SceneMember& table : scene.members)
    for (SceneMember& member : table.value.members)
      if (table.key == "asset" && member.key == "file" && !member.value.text.empty())
        member.value.text =
            (std::filesystem::path(name).parent_path() / member.value.text).string();
}

/// A message that quotes the file, cut to 1000 bytes, with control characters as '?'.
std::string printable(std::string text) {
  if (text.size() > 1000) text = text.substr(0, 1000) + "...";
  std::replace_if(text.begin(), text.end(), is_control, '?');
  return text;
}

}  // namespace

SceneValue check_scene(std::string_view text, const std::string& name) {
  try {
    SceneValue scene = parse_scene(text, name);
    Check(name).root(scene);
    resolve_asset(scene, name);
    return scene;
  } catch (const Error& error) {
    throw Error(printable(error.what()));
  }
}

SceneValue read_scene(const std::string& path) {
  std::string text;
  try {
    text = read_file(path, kMaxSceneBytes);
  } catch (const Error& error) {
    throw Error(error.what());
  }
  return check_scene(text, path);
}

std::string scene_json(const SceneValue& scene) {
  return to_json(scene).dump(2, ' ', false, Json::error_handler_t::replace) + '\n';
}

}  // namespace elastogen
