// SPDX-License-Identifier: Apache-2.0
#include "io/scene_file.hpp"

#include "io/safe_file.hpp"
#include "io/scene_keys.hpp"
#include "tests/io/scene_texts.hpp"

#include <algorithm>
#include <numbers>

namespace elastogen::test {
namespace {

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
}  // namespace elastogen::test
