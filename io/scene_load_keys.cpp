// SPDX-License-Identifier: Apache-2.0
#include "io/scene_load_keys.hpp"

namespace elastogen {
namespace {

using T = SceneType;
using Q = Quantity;
using Keys = std::vector<SceneKey>;

/// Boundary conditions and loads.
Keys boundary_keys() {
  return {
      // nodes that do not move
      {"", "holds", T::kTexts, "[]", "--hold", "holds as the option writes them"},
      {"hold",
       "axes",
       T::kText,
       "",
       "",
       "along which its nodes do not move",
       Q::kNumber,
       {},
       {"x", "y", "z", "xy", "xz", "yz", "xyz"}},
      // forces and pressures on the surface
      {"", "tractions", T::kTexts, "[]", "--traction", "tractions as the option writes them"},
      {"traction", "force", T::kVector, "", "", "in all, spread evenly over the surface in it",
       Q::kForce},
      {"traction", "pressure", T::kNumber, "", "",
       "in place of force: on every face in it, against its outward normal at rest", Q::kPressure},
      {"", "forces", T::kTexts, "[]", "--force", "forces as the option writes them"},
      {"", "wind", T::kText, "", "--wind", "velocity of the air as the option writes it"},
      // nodes whose motion is given
      {"", "moves", T::kTexts, "[]", "--move", "moves as the option writes them"},
      {"move", "path", T::kPath, "", "",
       "[t, x, y, z] in s and m: how far its nodes are from their places, straight between"},
      {"move", "turn", T::kTurn, "", "",
       "[t, angle] in s and rad, in place of path: how far its nodes are turned"},
      {"move", "turn_centre", T::kVector, "", "", "a point of the axis", Q::kLength},
      {"move", "turn_axis", T::kVector, "", "", "about which it turns, by the right hand"},
      {"move", "ease", T::kFlag, "false", "", "it slows down at each time of path or turn"},
      {"move", "loop", T::kFlag, "false", "", "after the last time it begins anew at the first"},
  };
}

}  // namespace

std::vector<SceneKey> selection_keys(const char* table) {
  return {{table, "select", T::kText, "", "", "a selection"},
          {table, "node", T::kText, "", "", "in place of select: name of nodes of the asset"},
          {table, "gltf_material", T::kText, "", "",
           "in place of select: name of materials of the asset"}};
}

std::vector<SceneKey> load_keys() {
  Keys keys = {
      {"", "pins", T::kTexts, "[]", "--pin", "selections whose nodes are held, like y<5%"},
      {"", "regions", T::kTexts, "[]", "--region", "regions as the option writes them"},
      {"",
       "gravity",
       T::kVector,
       "auto",
       "--gravity",
       "acceleration of everything; auto: 9.81 m/s2 against up",
       Q::kAcceleration,
       {},
       {"auto"}},
      {"motion", "velocity", T::kVector, "[0, 0, 0]", "--velocity",
       "of the whole asset at the start", Q::kSpeed},
      {"motion", "spin", T::kVector, "[0, 0, 0]", "--spin", "about the centre of mass at the start",
       Q::kSpin},
  };
  for (const char* table : {"pin", "hold", "traction", "move"})
    for (SceneKey& key : selection_keys(table)) keys.push_back(std::move(key));
  for (SceneKey& key : boundary_keys()) keys.push_back(std::move(key));
  return keys;
}

}  // namespace elastogen
