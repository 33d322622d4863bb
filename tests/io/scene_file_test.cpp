// SPDX-License-Identifier: Apache-2.0
#include "io/scene_file.hpp"

#include "io/safe_file.hpp"
#include "io/scene_keys.hpp"
#include "io/scene_text.hpp"
#include "tests/io/test_files.hpp"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <numbers>
#include <random>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;
using test::TempFolder;

constexpr const char* kToml = R"~(# a scene with something in every table
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

constexpr const char* kJson = R"~({
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

nlohmann::json json_of(const SceneValue& scene) {
  return nlohmann::json::parse(scene_json(scene));
}

std::string refusal(const std::string& text, const std::string& name = "s.toml") {
  return error_of([&] { check_scene(text, name); }, ErrorKind::kUsage);
}

TEST(SceneFile, GivesEveryNumberInSi) {
  const auto scene = json_of(check_scene(kToml, "s.toml"));
  EXPECT_EQ(scene["asset"]["size"], 0.2);
  EXPECT_EQ(scene["gravity"], nlohmann::json({0, -9.81, 0}));
  EXPECT_EQ(scene["material"]["young"], 30000);
  EXPECT_EQ(scene["material"]["density"], 1100);
  EXPECT_EQ(scene["motion"]["velocity"][0], 1 / 3.6);
  EXPECT_NEAR(scene["motion"]["spin"][0].get<double>(), std::numbers::pi / 2, 1e-15);
  EXPECT_EQ(scene["collider"][0]["path"][1], nlohmann::json({0.5, 0, -0.2, 0}));
  EXPECT_EQ(scene["traction"][0]["force"], nlohmann::json({0, -1000, 0}));
  EXPECT_EQ(scene["move"][0]["path"][1], nlohmann::json({1, 0, 0, 0.01}));
  EXPECT_NEAR(scene["move"][1]["turn"][1][1].get<double>(), std::numbers::pi, 1e-15);
  EXPECT_EQ(scene["limits"]["max_memory"], int64_t{2} << 30);
  EXPECT_EQ(scene["limits"]["max_time"], 600);
  EXPECT_EQ(scene["time"]["substeps"], "auto");
  EXPECT_EQ(scene["region"][1]["gltf_material"], "ears");
}

TEST(SceneFile, TomlAndJsonSayTheSame) {
  EXPECT_EQ(json_of(check_scene(kToml, "s.toml")), json_of(check_scene(kJson, "s.json")));
  EXPECT_EQ(json_of(check_scene(kToml, "scene")), json_of(check_scene(kJson, "scene")));
  const std::string mark = "\xEF\xBB\xBF";
  EXPECT_EQ(json_of(check_scene(mark + kToml, "s.toml")), json_of(check_scene(kToml, "s.toml")));
  EXPECT_EQ(json_of(check_scene(mark + kJson, "s.json")), json_of(check_scene(kJson, "s.json")));
}

TEST(SceneFile, WhatItPrintsIsTheSameScene) {
  const std::string printed = scene_json(check_scene(kToml, "s.toml"));
  EXPECT_EQ(scene_json(check_scene(printed, "again.json")), printed);
}

TEST(SceneFile, ReadsTheAssetFromTheFolderOfTheScene) {
  const TempFolder folder;
  const std::string path = folder.write("s.toml", "[asset]\nfile = \"meshes/a.obj\"\n");
  EXPECT_EQ(json_of(read_scene(path))["asset"]["file"], folder.path("meshes/a.obj"));
  folder.write("t.toml", "[asset]\nfile = \"/meshes/a.obj\"\n");
  EXPECT_EQ(json_of(read_scene(folder.path("t.toml")))["asset"]["file"], "/meshes/a.obj");
}

TEST(SceneFile, NamesTheNearestKeyOfAnUnknownOneAndItsLine) {
  struct Case {
    const char *text, *unknown, *nearest;
  };
  for (const Case& c : {Case{"\n[materal]\nyoung = 1\n", "'materal'", "'material'"},
                        {"[material]\n\nyuong = 1\n", "'material.yuong'", "'material.young'"},
                        {"frames = 3\n", "'frames'", "'time.frames'"},
                        {"[floor]\nyoung = 3\n", "'floor.young'", "'material.young'"},
                        {"pin_s = []\n", "'pin_s'", "'pins'"},
                        {"[[collider]]\nshape = 'box'\ncenter = [0, 0, 0]\n", "'collider.center'",
                         "'collider.centre'"},
                        {"[asset]\n[asset.file]\nname = 1\n", "'asset.file'", "a text"}}) {
    const std::string message = refusal(c.text);
    expect_says(message, c.unknown);
    expect_says(message, c.nearest);
  }
  expect_says(refusal("[time]\n\nfarmes = 3\n"), "s.toml:3: ");
  expect_says(refusal("{\"time\":\n {\n \"farmes\":\n 3}}", "s.json"), "s.json:3: ");
  expect_says(refusal("{\"" + std::string(100'000, 'k') + "\": 1}", "s.json"), "the nearest is");
}

TEST(SceneFile, EveryKeyIsKnownAndMisspeltIsNot) {
  for (const SceneKey& key : scene_keys()) {
    EXPECT_EQ(find_scene_key(key.table, key.name), &key) << key.path();
    const std::string wrong = key.name + "_";
    const SceneTable* table = find_scene_table(key.table);
    const std::string head =
        !table ? "" : (table->many ? "[[" + key.table + "]]\n" : '[' + key.table + "]\n");
    expect_says(refusal(head + wrong + " = 1\n"), "the nearest is '" + key.path() + "'");
  }
}

TEST(SceneFile, RefusesKeysThatAreThereTwice) {
  expect_says(refusal("[time]\nfps = 3\nfps = 4\n"), "fps");
  expect_says(refusal("[time]\nfps = 3\n[time]\nframes = 4\n"), "time");
  expect_says(refusal("{\"time\": {\"fps\": 3,\n \"fps\": 3}}", "s.json"), "s.json:2: 'fps'");
  expect_says(refusal("{\"time\": {}, \"time\": {}}", "s.json"), "'time' is there twice");
  EXPECT_NO_THROW(check_scene(R"({"pin": [{"select": "all"}, {"select": "all"}]})", "s.json"));
}

TEST(SceneFile, RefusesNumbersThatAreNotFinite) {
  for (const char* number : {"inf", "-inf", "+nan", "nan", "1e999", "\"nan\"", "\"1e999\""})
    for (const char* key : {"[material]\nyoung = ", "[time]\nfps = ", "[floor]\nplace = "})
      expect_says(refusal(std::string(key) + number + '\n'), "s.toml");
  for (const char* number : {"1e999", "-1e999", "NaN", "Infinity", "\"inf\""})
    expect_says(refusal(std::string("{\"time\": {\"fps\": ") + number + "}}", "s.json"),
                "s.json:1");
}

TEST(SceneFile, RefusesIntegersThatTheParserCannotHold) {
  for (const char* number : {"99999999999999999999", "-99999999999999999999"})
    expect_says(refusal(std::string("[floor]\nplace = ") + number + '\n'), "s.toml:2");
  EXPECT_NO_THROW(check_scene("[floor]\nplace = 9007199254740993\n", "s.toml"));
}

TEST(SceneFile, MessagesQuoteTheFilePrintably) {
  const std::string key = refusal("{\"a\\u001b[2J\\n\": 1}", "s.json");
  expect_says(key, "'a?[2J?'");
  const std::string text =
      refusal("{\"material\": {\"young\": \"" + std::string(100'000, '9') + "q\"}}", "s.json");
  EXPECT_LT(text.size(), 1100u);
}

TEST(SceneFile, TheExampleOfThePageIsAScene) {
  const std::string page = read_file(ELASTOGEN_DOCS "/scene.md");
  const size_t begin = page.find("```toml\n") + 8;
  const auto scene =
      json_of(check_scene(page.substr(begin, page.find("```", begin) - begin), "s.toml"));
  EXPECT_EQ(scene["material"]["young"], 2e6);
  EXPECT_EQ(scene["collider"][0]["path"][1][2], -0.1);
}

TEST(SceneFile, SaysWhatTypeIsExpected) {
  expect_says(refusal("[time]\nframes = true\n"), "'time.frames': a number is expected, not true");
  expect_says(refusal("[time]\nframes = 1.5\n"), "a whole number is expected, not 1.5");
  expect_says(refusal("[solver]\nskip = 1\n"), "true or false is expected, not a number");
  expect_says(refusal("[asset]\nup = 3\n"), "a text is expected, not a number");
  expect_says(refusal("pins = \"all\"\n"), "a list is expected, not a text");
  expect_says(refusal("pins = [1]\n"), "a text is expected, not a number");
  expect_says(refusal("gravity = [1, 2]\n"), "three numbers or auto are expected");
  expect_says(refusal("gravity = 3\n"), "three numbers or auto are expected");
  expect_says(refusal("gravity = [1, 2, []]\n"), "a number or auto is expected, not a list");
  expect_says(refusal("time = 3\n"), "'time': a table is expected, not a number");
  expect_says(refusal("[pin]\nselect = 'all'\n"), "'pin': a list is expected, not a table");
  expect_says(refusal("[[time]]\nfps = 3\n"), "'time': a table is expected, not a list");
  expect_says(refusal("pin = [3]\n"), "'pin': a table is expected, not a number");
  expect_says(refusal("[time]\nfps = 1979-05-27\n"), "dates and times");
  expect_says(refusal("{\"time\": {\"fps\": null}}", "s.json"), "null");
  expect_says(refusal("[asset]\nfile = \"a\\u0007\"\n"), "control character");
  for (const char* text : {"[]", "3", "\"s\"", "true"}) refusal(text, "s.json");
}

TEST(SceneFile, RefusesUnitsWordsAndRanges) {
  expect_says(refusal("[material]\n\nyoung = \"3 kg\"\n"), "s.toml:3: 'material.young'");
  expect_says(refusal("[material]\nyoung = \"3 kg\"\n"), "GPa");
  expect_says(refusal("[material]\npoisson = \"0.3 m\"\n"), "without a unit");
  expect_says(refusal("[material]\npreset = \"jely\"\n"), "jelly");
  expect_says(refusal("[asset]\nup = \"w\"\n"), "auto, x, y, z, -x, -y, -z");
  expect_says(refusal("[material]\nyoung = 0\n"), "above 0 is expected, not 0");
  expect_says(refusal("[material]\npoisson = 0.5\n"), "at least 0, below 0.5");
  expect_says(refusal("[time]\nframes = -1\n"), "at least 0, at most 1000000");
  expect_says(refusal("[solver]\ntolerance = 1\n"), "above 0, below 1");
  expect_says(refusal("[limits]\nmax_voxels = 1e17\n"), "at least 1");
}

TEST(SceneFile, RefusesTablesThatContradictThemselves) {
  expect_says(refusal("[[pin]]\n"), "needs select");
  expect_says(refusal("[[region]]\npreset = 'foam'\n"), "one of select, node and gltf_material");
  expect_says(refusal("[[region]]\nselect = 'all'\nnode = 'n'\n"), "one of select");
  expect_says(refusal("[[collider]]\nname = 'n'\n"), "needs shape");
  expect_says(refusal("[[hold]]\naxes = 'x'\n"), "'hold': needs select");
  expect_says(refusal("[[hold]]\nselect = 'all'\n"), "'hold': needs axes");
  expect_says(refusal("[[hold]]\nselect = 'all'\naxes = 'xw'\n"), "known are x, y, z, xy");
  expect_says(refusal("[[traction]]\nselect = 'all'\n"), "'traction': needs force");
  const std::string move = "[[move]]\nselect = 'all'\n", path = "path = [[0,0,0,0]]\n";
  const std::string axis = "turn_centre = [0,0,0]\nturn_axis = [0,0,1]\n";
  expect_says(refusal("[[move]]\n" + path), "'move': needs select");
  expect_says(refusal(move), "needs path, or turn");
  expect_says(refusal(move + axis), "needs path, or turn");
  expect_says(refusal(move + path + axis), "needs path, or turn");
  expect_says(refusal(move + axis + "turn = [[0,0,0]]\n"), "t, angle");
  expect_says(refusal(move + axis + "turn = [[0,0], [0,'1 deg']]\n"), "must ascend");
  expect_says(refusal(move + axis + "turn = [[0,'1 m']]\n"), "rad, deg");
  const std::string sphere = "[[collider]]\nshape = 'sphere'\ncentre = [0,0,0]\n";
  expect_says(refusal(sphere), "a sphere needs centre and radius");
  expect_says(refusal(sphere + "radius = 1\nlower = [0,0,0]\n"), "'collider.lower': a sphere");
  expect_says(refusal(sphere + "radius = 1\nname = 'a b'\n"), "letters, digits");
  expect_says(refusal(sphere + "radius = 1\npath = [[0,0,0]]\n"), "t, x, y, z");
  expect_says(refusal(sphere + "radius = 1\npath = [[1,0,0,0], [1,0,0,0]]\n"), "must ascend");
}

TEST(SceneFile, RefusesWhatIsTooDeepOrTooLarge) {
  const auto repeated = [](const std::string& part, int count) {
    std::string text;
    for (int k = 0; k < count; ++k) text += part;
    return text;
  };
  for (const int count : {65, 1'000'000}) {
    for (const std::string& text :
         {"pins = " + repeated("[", count), "pins = " + repeated("{a = ", count),
          "[" + repeated("a.", count) + "a]", repeated("a . ", count) + "a = 1",
          "pins = [\"\"\"x\"\"\"\", " + repeated("[", count)})
      expect_says(refusal(text), "64 levels");
    expect_says(refusal("{\"pins\": " + repeated("[", count), "s.json"), "64 levels");
    expect_says(refusal(repeated("{\"a\": ", count), "s.json"), "64 levels");
  }
  EXPECT_NO_THROW(
      check_scene("pins = [\"" + repeated("[.", 500) + "\"] # " + repeated("[.", 500), "s.toml"));
  for (const char* name : {"s.toml", "s.json"})
    expect_says(refusal(std::string(16'000'001, ' '), name), "16000001 bytes");
  const TempFolder folder;
  const std::string path = folder.write("s.toml", std::string(16'000'001, '\n'));
  expect_says(error_of([&] { read_scene(path); }, ErrorKind::kUsage), path);
  expect_says(error_of([&] { read_scene(folder.path("none")); }, ErrorKind::kUsage), "none");
}

TEST(SceneFile, RefusesTomlThatWouldTakeLong) {
  const std::string whole = "# " + std::string(2046, '.') + "\n";
  EXPECT_NO_THROW(check_scene(whole + whole, "s.toml"));
  expect_says(refusal(whole + "#" + whole), "s.toml:2: the line has 2049 bytes");
  std::string lines(1 << 20, '\n');
  EXPECT_NO_THROW(check_scene(lines, "s.toml"));
  expect_says(refusal(lines + "\n"), "write it as JSON");
  EXPECT_NO_THROW(check_scene("{" + lines + "}", "s.json"));
}

TEST(SceneFile, RefusesWhatIsNoTomlOrJsonWithTheLine) {
  expect_says(refusal("[time]\nfps = \n"), "s.toml:2: is no TOML");
  expect_says(refusal("{\"time\":\n 3,}", "s.json"), "s.json:2: is no JSON");
  refusal("{\"time\": {}} {", "s.json");
  refusal("", "s.json");
  expect_says(refusal("{}" + std::string(2, '\0') + "x", "s.json"), "byte 0");
  EXPECT_NO_THROW(check_scene("", "s.toml"));
}

/// toml11 reads beyond its buffer at such bytes in a text of three quotes.
TEST(SceneFile, RefusesTomlThatIsNotUtf8WithTheLine) {
  for (const char* bytes : {"\xb9", "\xc0\x80", "\xe0\x80\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80",
                            "\xf5\x80\x80\x80", "\xe2\x82"})
    for (const char* quotes : {"\'\'\'", "\"\"\"", "\""})
      expect_says(refusal(concat("\npins = [", quotes, "y<5%", bytes, quotes, "]\n")),
                  "s.toml:2: is no TOML");
  EXPECT_NO_THROW(check_scene("# \u00e9 \u20ac \U0001F600\n", "s.toml"));
}

/// Changes a text at random: drops, doubles, moves and overwrites stretches of it.
std::string mutation(std::string text, std::mt19937& random) {
  const auto below = [&](size_t count) {
    return std::uniform_int_distribution<size_t>(0, count - 1)(random);
  };
  static const std::string kParts[] = {"[",      "]",     "{",   "}", "\"",   "'",
                                       "\"\"\"", "\\u00", "=",   ",", ".",    "\n",
                                       "#",      "1e400", "nan", "-", "\xff", std::string(1, '\0'),
                                       "[[",     "true",  "null"};
  for (size_t count = 1 + below(4); count > 0 && !text.empty(); --count) {
    const size_t at = below(text.size()), length = 1 + below(12);
    const std::string stretch = text.substr(at, length);
    switch (below(4)) {
      case 0:
        text.erase(at, length);
        break;
      case 1:
        text.insert(below(text.size()), stretch);
        break;
      case 2:
        text[at] = char(below(256));
        break;
      default:
        text.insert(at, kParts[below(std::size(kParts))]);
    }
  }
  return text;
}

TEST(SceneFile, AMutatedFileIsReadOrRefusedAsUsage) {
  std::mt19937 random(7);
  int read = 0, refused = 0;
  for (int k = 0; k < 2000; ++k) {
    const bool json = k % 2 == 1;
    const std::string text = mutation(json ? kJson : kToml, random);
    try {
      check_scene(text, json ? "s.json" : "s.toml");
      ++read;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
      ++refused;
    }
  }
  EXPECT_GT(read, 20);
  EXPECT_GT(refused, 500);
}

TEST(SceneFile, EveryBeginningIsReadOrRefusedAsUsage) {
  for (const std::string whole : {kToml, kJson})
    for (size_t length = 0; length < whole.size(); ++length) try {
        check_scene(whole.substr(0, length), whole[0] == '{' ? "s.json" : "s.toml");
      } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::kUsage) << error.what();
      }
}

TEST(SceneKeys, EditDistanceCountsLetters) {
  EXPECT_EQ(edit_distance("", ""), 0);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3);
  EXPECT_EQ(edit_distance("flaw", "lawn"), 2);
}

TEST(SceneKeys, ThePublishedSchemaIsThatOfTheTable) {
  EXPECT_EQ(read_file(ELASTOGEN_DOCS "/scene.schema.json"), scene_schema())
      << "elastogen inspect --schema > docs/scene.schema.json";
}

TEST(SceneKeys, ThePageOfTheKeysIsThatOfTheTable) {
  expect_says(read_file(ELASTOGEN_DOCS "/scene.md"), scene_key_page());
}

}  // namespace
}  // namespace elastogen
