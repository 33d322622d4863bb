// SPDX-License-Identifier: Apache-2.0
// Texts about keys of scene files: ranges, units, the nearest key.

#include "core/error.hpp"
#include "io/scene_keys.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {

bool SceneRange::has(double value) const {
  return (above ? value > least : value >= least) && (below ? value < most : value <= most);
}

std::string SceneRange::text() const {
  const auto end = [](double value) {
    return value == std::floor(value) && std::abs(value) < 1e15 ? concat(int64_t(value))
                                                                : concat(value);
  };
  std::string text;
  if (std::isfinite(least)) text = (above ? "above " : "at least ") + end(least);
  if (std::isfinite(most) && most < 1e15)
    text += (text.empty() ? "" : ", ") + std::string(below ? "below " : "at most ") + end(most);
  return text;
}

std::string nearest_scene_key(std::string_view table, std::string_view name) {
  std::string nearest;
  int least = std::numeric_limits<int>::max();
  const auto offer = [&](const std::string& path, std::string_view home, std::string_view other) {
    const int distance = edit_distance(name, other) + (home == table ? 0 : 2);
    if (distance < least) least = distance, nearest = path;
  };
  for (const SceneTable& t : scene_tables()) offer(t.name, "", t.name);
  for (const SceneKey& key : scene_keys()) offer(key.path(), key.table, key.name);
  return nearest;
}

int edit_distance(std::string_view a, std::string_view b) {
  a = a.substr(0, 64);  // longer than any key: enough to tell them apart
  std::vector<int> row(b.size() + 1);
  std::iota(row.begin(), row.end(), 0);
  for (size_t i = 1; i <= a.size(); ++i) {
    int corner = row[0]++;
    for (size_t j = 1; j <= b.size(); ++j) {
      const int changed = corner + (a[i - 1] != b[j - 1]);
      corner = row[j];
      row[j] = std::min({changed, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row.back();
}

std::string_view si_unit(Quantity quantity) {
  static constexpr std::string_view kUnits[] = {"",     "m",   "Pa",    "kg/m3", "s",  "m/s",
                                                "m/s2", "rad", "rad/s", "N",     "Hz", "bytes"};
  return kUnits[int(quantity)];
}

}  // namespace elastogen
