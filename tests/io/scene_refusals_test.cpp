// SPDX-License-Identifier: Apache-2.0
// Scene files that are refused, and that no text does worse than that.
#include "io/scene_keys.hpp"
#include "tests/io/scene_texts.hpp"

#include <algorithm>
#include <random>

namespace elastogen::test {
namespace {

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
  // pins, regions, colliders and holds
  expect_says(refusal("[[pin]]\n"), "'pin': needs one of select, node and gltf_material");
  expect_says(refusal("[[region]]\npreset = 'foam'\n"), "one of select, node and gltf_material");
  expect_says(refusal("[[region]]\nselect = 'all'\nnode = 'n'\n"), "one of select");
  expect_says(refusal("[[collider]]\nname = 'n'\n"), "needs shape");
  expect_says(refusal("[[hold]]\naxes = 'x'\n"), "'hold': needs one of select");
  expect_says(refusal("[[hold]]\nselect = 'all'\n"), "'hold': needs axes");
  expect_says(refusal("[[hold]]\nselect = 'all'\naxes = 'xw'\n"), "known are x, y, z, xy");
  // tractions
  const std::string traction = "[[traction]]\nselect = 'all'\n";
  expect_says(refusal("[[traction]]\npressure = 1\n"), "'traction': needs one of select");
  expect_says(refusal(traction), "'traction': needs one of force and pressure");
  expect_says(refusal(traction + "force = [0, 0, 1]\npressure = 1\n"), "one of force and pressure");
  expect_says(refusal(traction + "pressure = '1 N'\n"), "known are Pa");
  expect_says(refusal(traction + "pressure = [0, 0, 1]\n"), "'traction.pressure'");
  // moves
  const std::string move = "[[move]]\nselect = 'all'\n", path = "path = [[0,0,0,0]]\n";
  const std::string axis = "turn_centre = [0,0,0]\nturn_axis = [0,0,1]\n";
  expect_says(refusal("[[move]]\n" + path), "'move': needs one of select");
  expect_says(refusal(move), "needs path, or turn");
  expect_says(refusal(move + axis), "needs path, or turn");
  expect_says(refusal(move + path + axis), "needs path, or turn");
  expect_says(refusal(move + axis + "turn = [[0,0,0]]\n"), "t, angle");
  expect_says(refusal(move + axis + "turn = [[0,0], [0,'1 deg']]\n"), "must ascend");
  expect_says(refusal(move + axis + "turn = [[0,'1 m']]\n"), "rad, deg");
  // spheres
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
  // parts of the syntax of TOML and JSON
  static const std::string kParts[] = {"[",      "]",     "{",   "}", "\"",   "'",
                                       "\"\"\"", "\\u00", "=",   ",", ".",    "\n",
                                       "#",      "1e400", "nan", "-", "\xff", std::string(1, '\0'),
                                       "[[",     "true",  "null"};
  // one to four changes
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

}  // namespace
}  // namespace elastogen::test
