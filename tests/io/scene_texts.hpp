// SPDX-License-Identifier: Apache-2.0
// One scene with something in every table, in TOML and in JSON.

#pragma once

#include "io/scene_file.hpp"
#include "io/scene_text.hpp"
#include "tests/io/test_files.hpp"

#include <nlohmann/json.hpp>

#include <string>

namespace elastogen::test {

inline constexpr const char* kToml = R"~(# a scene with something in every table
pins = ["y<5%", "sphere(0,50%,0, 3cm)"]
gravity = [0, "-981 cm/s2", 0]

[asset]
file = "bunny.obj"
size = "20 cm"
up = "z"
voxels = 32

[material]
preset = "jelly"
young = "30 kPa"
poisson = 0.4
density = "1.1 g/cm3"

[[region]]
select = "y>80%"
preset = "foam"

[[region]]
gltf_material = "ears"
young = 5e4

[[pin]]
select = "x<1%"

[[hold]]
select = "y<1%"
axes = "yz"

[[traction]]
select = "x>99%"
force = [0, "-1 kN", 0]

[[move]]
select = "z>99%"
path = [[0, 0, 0, 0], [1, 0, 0, "1 cm"]]

[[move]]
select = "z<1%"
turn = [[0, 0], ["1 s", "180 deg"]]
turn_centre = [0, "1 cm", 0]
turn_axis = [0, 0, 1]

[motion]
velocity = "1, 0, 0 km/h"
spin = ["90 deg/s", 0, 0]

[floor]
place = "-30 cm"
friction = 0.25

[[collider]]
shape = "sphere"
name = "ball"
centre = [0, "1 m", 0]
radius = "5 cm"
path = [[0, 0, 0, 0], ["500 ms", 0, "-20 cm", 0]]

[time]
frames = 60
substeps = "auto"
scheme = "bdf2"

[solver]
mode = "newton"
skip = false

[limits]
max_memory = "2 GiB"
max_time = "10 min"

[output]
files = ["out.glb"]
quiet = true
)~";

inline constexpr const char* kJson = R"~({
 "pins": ["y<5%", "sphere(0,50%,0, 3cm)"], "gravity": [0, "-981 cm/s2", 0],
 "asset": {"file": "bunny.obj", "size": "20 cm", "up": "z", "voxels": 32},
 "material": {"preset": "jelly", "young": "30 kPa", "poisson": 0.4, "density": "1.1 g/cm3"},
 "region": [{"select": "y>80%", "preset": "foam"}, {"gltf_material": "ears", "young": 5e4}],
 "pin": [{"select": "x<1%"}],
 "hold": [{"select": "y<1%", "axes": "yz"}],
 "traction": [{"select": "x>99%", "force": [0, "-1 kN", 0]}],
 "move": [{"select": "z>99%", "path": [[0, 0, 0, 0], [1, 0, 0, "1 cm"]]},
          {"select": "z<1%", "turn": [[0, 0], ["1 s", "180 deg"]], "turn_centre": [0, "1 cm", 0],
           "turn_axis": [0, 0, 1]}],
 "motion": {"velocity": "1, 0, 0 km/h", "spin": ["90 deg/s", 0, 0]},
 "floor": {"place": "-30 cm", "friction": 0.25},
 "collider": [{"shape": "sphere", "name": "ball", "centre": [0, "1 m", 0], "radius": "5 cm",
               "path": [[0, 0, 0, 0], ["500 ms", 0, "-20 cm", 0]]}],
 "time": {"frames": 60, "substeps": "auto", "scheme": "bdf2"},
 "solver": {"mode": "newton", "skip": false},
 "limits": {"max_memory": "2 GiB", "max_time": "10 min"},
 "output": {
  "files" : ["out.glb"], "quiet" : true
}
})~";

inline nlohmann::json json_of(const SceneValue& scene) {
  return nlohmann::json::parse(scene_json(scene));
}

inline std::string refusal(const std::string& text, const std::string& name = "s.toml") {
  return error_of([&] { check_scene(text, name); }, ErrorKind::kUsage);
}

}  // namespace elastogen::test
