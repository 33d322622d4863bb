// SPDX-License-Identifier: Apache-2.0
// The table of io/scene_keys.hpp as a JSON schema and as the table of docs/scene.md.

#include "core/error.hpp"
#include "io/scene_keys.hpp"

#include <nlohmann/json.hpp>

#include <cmath>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

bool is_quantity(const SceneKey& key) {
  return !si_unit(key.quantity).empty();
}

/// A number of the key, or a text with a unit where it has one.
Json number_schema(const SceneKey& key, bool with_range) {
  Json number = {{"type", key.type == SceneType::kWhole ? "integer" : "number"}};
  const SceneRange& range = key.range;
  if (with_range && std::isfinite(range.least))
    number[range.above ? "exclusiveMinimum" : "minimum"] = range.least;
  if (with_range && std::isfinite(range.most))
    number[range.below ? "exclusiveMaximum" : "maximum"] = range.most;
  if (!is_quantity(key)) return number;
  return {{"anyOf", {number, {{"type", "string"}}}}};
}

Json list_schema(Json items, int count) {
  return {{"type", "array"}, {"items", std::move(items)}, {"minItems", count}, {"maxItems", count}};
}

/// One of the words; a word that ends in =NUMBER becomes a pattern.
Json text_schema(const SceneKey& key) {
  if (key.words.empty()) return {{"type", "string"}};
  constexpr std::string_view kNumber = "=NUMBER";
  Json words = Json::array();
  std::string families;
  for (const std::string& word : key.words)
    if (word.ends_with(kNumber))
      families += concat(families.empty() ? "" : "|", word.substr(0, word.size() - kNumber.size()));
    else
      words.push_back(word);
  if (families.empty()) return {{"enum", words}};
  const std::string pattern = concat("^(", families, ")=-?[0-9.]+(e[+-]?[0-9]+)?$");
  return {{"anyOf", Json::array({{{"enum", words}}, {{"type", "string"}, {"pattern", pattern}}})}};
}

Json value_schema(const SceneKey& key) {
  // plain values
  switch (key.type) {
    case SceneType::kFlag:
      return {{"type", "boolean"}};
    case SceneType::kText:
      return text_schema(key);
    case SceneType::kTexts:
      return {{"type", "array"}, {"items", {{"type", "string"}}}};
    // lists of points in time, numbers with or without a unit
    case SceneType::kPath:
      return {{"type", "array"},
              {"items", list_schema({{"type", Json::array({"number", "string"})}}, 4)}};
    case SceneType::kTurn:
      return {{"type", "array"},
              {"items", list_schema({{"type", Json::array({"number", "string"})}}, 2)}};
    // three numbers, or a word
    case SceneType::kVector: {
      Json any = Json::array({list_schema(number_schema(key, false), 3), {{"type", "string"}}});
      return {{"anyOf", std::move(any)}};
    }
    // a number of the key's range, or one of its words
    case SceneType::kWhole:
    case SceneType::kNumber: {
      if (key.words.empty()) return number_schema(key, true);
      Json any = Json::array({number_schema(key, true), {{"enum", key.words}}});
      return {{"anyOf", std::move(any)}};
    }
  }
  return {};
}

std::string unit_text(const SceneKey& key) {
  return is_quantity(key) ? " [" + std::string(si_unit(key.quantity)) + ']' : "";
}

Json key_schema(const SceneKey& key) {
  Json schema = {{"description", key.text + unit_text(key)}};
  if (!key.fallback.empty()) schema["x-default"] = key.fallback;
  if (*key.option) schema["x-option"] = key.option;
  schema.update(value_schema(key));
  return schema;
}

Json properties_of(std::string_view table) {
  Json properties = Json::object();
  for (const SceneKey& key : scene_keys())
    if (key.table == table) properties[key.name] = key_schema(key);
  return properties;
}

/// Schemas of which each needs one of the keys.
Json one_of(std::initializer_list<const char*> keys) {
  Json schemas = Json::array();
  for (const char* key : keys) schemas.push_back({{"required", Json::array({key})}});
  return schemas;
}

Json table_schema(const SceneTable& table) {
  Json schema = {{"type", "object"},
                 {"description", table.text},
                 {"properties", properties_of(table.name)},
                 {"additionalProperties", false}};
  if (find_scene_key(table.name, "gltf_material"))
    schema["oneOf"] = one_of({"select", "node", "gltf_material"});
  if (table.name == "hold") schema["required"] = {"axes"};
  if (table.name == "traction")
    schema["allOf"] = Json::array({{{"oneOf", one_of({"force", "pressure"})}}});
  if (table.name == "collider") schema["required"] = {"shape"};
  if (table.name == "shape") schema["required"] = {"kind"};
  if (!table.many) return schema;
  return {{"type", "array"}, {"items", std::move(schema)}};
}

std::string type_text(const SceneKey& key) {
  static constexpr const char* kTypes[] = {"true or false",
                                           "whole number",
                                           "number",
                                           "three numbers",
                                           "text",
                                           "list of texts",
                                           "list of [t, x, y, z]",
                                           "list of [t, angle]"};
  std::string text =
      key.type == SceneType::kText && !key.words.empty() ? "" : kTypes[int(key.type)];
  text += unit_text(key);
  if (!key.range.text().empty()) text += ' ' + key.range.text();
  for (size_t k = 0; k < key.words.size(); ++k)
    text += (text.empty() ? "`" : k + 1 < key.words.size() ? ", `" : " or `") + key.words[k] + '`';
  return text;
}

}  // namespace

std::string scene_schema() {
  Json properties = properties_of("");
  for (const SceneTable& table : scene_tables()) properties[table.name] = table_schema(table);
  const Json schema = {{"$schema", "https://json-schema.org/draft/2020-12/schema"},
                       {"title", "elastogen scene"},
                       {"type", "object"},
                       {"properties", std::move(properties)},
                       {"additionalProperties", false}};
  return schema.dump(2) + '\n';
}

std::string scene_key_page() {
  std::string page, heading = "-";
  for (const SceneKey& key : scene_keys()) {
    if (key.table != heading) {
      heading = key.table;
      const SceneTable* table = find_scene_table(heading);
      if (!table)
        page += "Before the first table:\n";
      else
        page += (table->many ? "\n`[[" + heading + "]]` " : "\n`[" + heading + "]` ") +
                table->text + '\n';
      page += "\n| key | value | default | option | meaning |\n|---|---|---|---|---|\n";
    }
    const std::string option = *key.option ? '`' + std::string(key.option) + '`' : "";
    page += "| `" + key.name + "` | " + type_text(key) + " | " + key.fallback + " | " + option +
            " | " + key.text + " |\n";
  }
  return page;
}

}  // namespace elastogen
