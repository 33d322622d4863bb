// SPDX-License-Identifier: Apache-2.0
// Every key of a scene file in one table. The check, the published schema, the page docs/scene.md
// and the options that the values become are all made from it.

#pragma once

#include "io/units.hpp"

#include <limits>
#include <span>
#include <string>
#include <vector>

namespace elastogen {

enum class SceneType {
  kFlag,    ///< true or false
  kWhole,   ///< a whole number, or one of the words
  kNumber,  ///< a number in SI, a text with a unit, or one of the words
  kVector,  ///< three numbers
  kText,    ///< one of the words, any text if there are none; in "a=NUMBER" any number
  kTexts,   ///< a list of texts
  kPath,    ///< a list of [t, x, y, z]: time, place
  kTurn,    ///< a list of [t, angle]
};

/// An interval; ends at infinity are always open.
struct SceneRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;  ///< least itself is not allowed
  bool below = false;  ///< most itself is not allowed

  bool has(double value) const;
  std::string text() const;  ///< "at least 1", "above 0, below 0.5", "" for any
};

struct SceneKey {
  std::string table;  ///< "" for the root
  std::string name;
  SceneType type = SceneType::kText;
  std::string fallback;     ///< default in the words of the page; "" for none
  const char* option = "";  ///< option of animate that replaces the key; "" for none
  std::string text;         ///< a sentence
  Quantity quantity = {};   ///< of the numbers
  SceneRange range = {};    ///< of the numbers in SI
  std::vector<std::string> words = {};

  std::string path() const { return table.empty() ? name : table + '.' + name; }
};

struct SceneTable {
  std::string name;
  bool many = false;  ///< [[name]]
  std::string text;   ///< a sentence
};

std::span<const SceneTable> scene_tables();
std::span<const SceneKey> scene_keys();  ///< the keys of one table stand together

/// The key at that place, or nullptr.
const SceneKey* find_scene_key(std::string_view table, std::string_view name);
const SceneTable* find_scene_table(std::string_view name);

/// The path of the key or table nearest to an unknown one: smallest edit distance of the names,
/// plus 2 if it belongs to another table; the first of equals.
std::string nearest_scene_key(std::string_view table, std::string_view name);

/// Least number of letters to add, remove or exchange (Levenshtein).
int edit_distance(std::string_view a, std::string_view b);

/// SI unit of a quantity, "" for a plain number.
std::string_view si_unit(Quantity quantity);

/// docs/scene.schema.json: a JSON schema (2020-12).
std::string scene_schema();

/// The table of docs/scene.md.
std::string scene_key_page();

}  // namespace elastogen
