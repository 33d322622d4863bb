// SPDX-License-Identifier: Apache-2.0
// Every key of a scene file, in one table: the check, the published schema, the page docs/scene.md
// and the options that the values become follow from it.

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
  kVector,  ///< three of them
  kText,    ///< one of the words; any text where there are none; "a=NUMBER" stands for any number
  kTexts,   ///< a list of texts
  kPath,    ///< a list of [t, x, y, z]: time, place
  kTurn,    ///< a list of [t, angle]
};

/// An interval; ends at infinity are always open.
struct SceneRange {
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  bool above = false;  ///< least itself is out
  bool below = false;  ///< most itself is out

  bool has(double value) const;
  std::string text() const;  ///< "at least 1", "above 0, below 0.5", "" for any
};

struct SceneKey {
  std::string table;  ///< "" for the root
  std::string name;
  SceneType type = SceneType::kText;
  std::string fallback;     ///< what holds without the key, as it is shown; "" for nothing
  const char* option = "";  ///< of elastogen animate that it is the default of; "" for none
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

/// The path of the key or table that is nearest to an unknown one: smallest edit distance of the
/// names, 2 more where it stands in another table; the first of equals.
std::string nearest_scene_key(std::string_view table, std::string_view name);

/// Least number of letters to add, drop or exchange (Levenshtein).
int edit_distance(std::string_view a, std::string_view b);

/// SI unit of a quantity, "" for a plain number.
std::string_view si_unit(Quantity quantity);

/// docs/scene.schema.json: a JSON schema (2020-12).
std::string scene_schema();

/// The table of docs/scene.md.
std::string scene_key_page();

}  // namespace elastogen
