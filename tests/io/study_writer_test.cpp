// SPDX-License-Identifier: Apache-2.0
#include "io/study_writer.hpp"

#include "tests/io/study_example.hpp"
#include "tests/io/test_files.hpp"

#include <nlohmann/json.hpp>

#include <cstring>
#include <limits>
#include <map>
#include <set>

namespace elastogen {
namespace {

using Json = nlohmann::json;

/// A study of one run that has both families, with an entry of every list.
StudyResult small_study() {
  StudyResult study = test::example_study();
  study.runs = {study.runs[0]};
  study.runs[0].loops = LoopBudget{11, 21, 57};
  study.time_to_error = {{ErrorFamily::kDiscretisation,
                          ErrorMeasure::kFreeRun,
                          "tet10 fine",
                          "quasi",
                          {{0.125, "quasi 1e-2", 8}, {0.0625, "", {}}}}};
  study.overlays[0].outlines = {{"tet10 fine", {{{0.75, 0.5}}, {{1, 2}, {3, 4}}}}};
  study.figures.pop_back();
  return study;
}

TEST(StudyJson, HasEveryFieldOfTheDocumentation) {
  // every member, with a number of its own
  const Json expected = Json::parse(R"({"format": "elastogen-study", "version": 1,
    "header": {"scene": "beam", "scene_text": "h = 0.03125\n",
      "command": "elastogen study beam.toml", "commit": "abc123", "date": "2026-11-22T10:00:00Z",
      "threads": 2, "repeats": 5, "machine": {"cpu": "AMD EPYC", "cores": 4,
        "memory_bytes": 25769803776, "copy_bandwidth": 23.75e9}},
    "runs": [{"name": "quasi 1e-2", "solver": "quasi", "element": "voxel", "h": 0.03125, "dt": 0.5,
      "tolerance": 0.0078125, "loops": {"outer": 11, "inner": 21, "modes": 57}, "steps": 2,
      "voxels": 64, "elements": 65, "dofs": 300,
      "step_ms": {"lower_quartile": 7, "median": 8, "upper_quartile": 9},
      "state_bytes": 6000, "state_copies_per_second": 12500, "outer": 7, "inner": 18,
      "converged_share": 0.5, "worst_residual": 0.015625, "min_j": 0.8125,
      "residual": [0.00390625, 0.015625],
      "energy": {"kinetic": [1, 2], "elastic": [3, 4], "hourglass": [5, 6], "gravity": [7, 8],
        "contact": [9, 10], "total": [25, 30]},
      "solver_error": {"reference": "newton 1e-12",
        "step": {"steps": [0.009765625, 0.01171875], "max": 0.01171875},
        "free_run": {"steps": [0.017578125, 0.01953125], "max": 0.01953125},
        "iou": 0.9921875, "energy_drift": 0.025390625, "reference_change": null},
      "discretisation_error": {"reference": "tet10 fine",
        "step": {"steps": [0.15625, 0.1875], "max": 0.1875},
        "free_run": {"steps": [0.28125, 0.3125], "max": 0.3125},
        "iou": 0.875, "energy_drift": 0.40625, "reference_change": 0.0625}}],
    "time_to_error": [{"family": "discretisation_error", "measure": "free_run",
      "reference": "tet10 fine", "solver": "quasi", "levels": [
        {"error": 0.125, "run": "quasi 1e-2", "ms": 8}, {"error": 0.0625, "run": "", "ms": null}]}],
    "sweeps": [{"name": "quasi, voxel", "variable": "h", "unit": "m",
      "family": "discretisation_error", "measure": "free_run", "x": [0.125, 0.0625, 0.03125],
      "error": [0.25, 0.0625, 0.015625], "order": 2}],
    "overlays": [{"title": "last frame", "time": 1, "horizontal": "x", "vertical": "y",
      "outlines": [{"name": "tet10 fine", "lines": [[[0.75, 0.5]], [[1, 2], [3, 4]]]}]}],
    "figures": [{"name": "first frequency", "value": 5.0625, "reference": 5.078125,
      "tolerance": 0.05078125, "unit": "Hz", "pass": true}]})");
  EXPECT_EQ(Json::parse(study_json(small_study())), expected);
}

void collect_keys(const Json& json, std::set<std::string>& keys) {
  for (const auto& item : json.items()) {
    if (json.is_object()) keys.insert(item.key());
    if (item.value().is_structured()) collect_keys(item.value(), keys);
  }
}

TEST(StudyJson, HasNoFieldThatTheDocumentationLacks) {
  std::ifstream file(std::string(ELASTOGEN_DOCS) + "/study.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  std::set<std::string> keys;
  collect_keys(Json::parse(study_json(small_study())), keys);
  EXPECT_EQ(keys.size(), 78u);
  for (const std::string& key : keys) test::expect_says(page, '`' + key + '`');
}

// that writing again gives the same text says that the reader loses nothing: the text holds every
// member (the test above), and two doubles never have the same shortest text
TEST(StudyJson, ComesBackAsItWas) {
  for (const StudyResult& study : {test::example_study(), small_study(), StudyResult()}) {
    const std::string text = study_json(study);
    EXPECT_EQ(study_json(study_from_json(text, "study.json")), text);
  }
  const test::TempFolder folder;
  const std::string path = folder.path("study.json");
  write_study_json(path, test::example_study());
  const StudyResult back = read_study(path);
  EXPECT_EQ(back.runs.size(), 4u);
  EXPECT_FALSE(back.runs[3].solver_error.has_value());
  EXPECT_EQ(back.runs[3].loops->modes, 54);
  EXPECT_EQ(back.time_to_error.size(), test::example_study().time_to_error.size());
}

TEST(StudyJson, KeepsTheBitsOfEveryDouble) {
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  std::vector<double> values = {0.1,
                                -0.0,
                                0.0,
                                5e-324,
                                -2.2250738585072014e-308,
                                1e22,
                                kInfinity,
                                -kInfinity,
                                std::numeric_limits<double>::quiet_NaN(),
                                std::numeric_limits<double>::max()};
  for (int k = 1; k < 1000; ++k) values.push_back(std::sin(k) * std::pow(10, k % 600 - 300));
  StudyResult study = small_study();
  study.runs[0].residual = values;
  study.overlays[0].time = kInfinity;
  const StudyResult back = study_from_json(study_json(study), "study.json");
  ASSERT_EQ(back.runs[0].residual.size(), values.size());
  EXPECT_EQ(std::memcmp(back.runs[0].residual.data(), values.data(), 8 * values.size()), 0);
  EXPECT_EQ(back.overlays[0].time, kInfinity);
}

TEST(StudyJson, KeepsHostileText) {
  StudyResult study = small_study();
  const std::string text = "<script> \"\\ \n\t\x01 \xc3\xb6 \xf0\x9f\x98\x80";
  study.runs[0].name = study.header.scene_text = text;
  study.header.command = "name \xff of a file";
  const StudyResult back = study_from_json(study_json(study), "study.json");
  EXPECT_EQ(back.runs[0].name, text);
  EXPECT_EQ(back.header.scene_text, text);
  EXPECT_EQ(back.header.command, "name \xef\xbf\xbd of a file");
}

/// The reader's message for the small study after a change of its JSON.
std::string refusal(const std::function<void(Json&)>& change) {
  Json json = Json::parse(study_json(small_study()));
  change(json);
  return test::error_of([&] { study_from_json(json.dump(), "bad.json"); });
}

TEST(StudyReader, RefusesAnotherFormatOrVersion) {
  test::expect_says(refusal([](Json& j) { j["format"] = "elastogen-state"; }), "is no study");
  test::expect_says(refusal([](Json& j) { j.erase("format"); }), "is no study");
  test::expect_says(refusal([](Json& j) { j["version"] = 2; }), "has version 2");
  test::expect_says(refusal([](Json& j) { j["version"] = "1"; }), "has version \"1\"");
  test::expect_says(refusal([](Json& j) { j.erase("version"); }), "has version null");
  test::expect_says(refusal([](Json& j) { j = Json::array(); }), "is no study");
}

TEST(StudyReader, RefusesEveryMissingAndEveryUnknownField) {
  const Json whole = Json::parse(study_json(small_study())).flatten();
  for (const auto& item : whole.items()) {
    const Json::json_pointer pointer(item.key()), parent = pointer.parent_pointer();
    const std::string key = pointer.back();
    if (std::isdigit(key[0])) continue;  // a value of a list
    test::expect_says(refusal([&](Json& j) { j[parent].erase(key); }), "bad.json: ");
    test::expect_says(refusal([&](Json& j) { j[parent]["extra"] = 1; }), "extra is not known");
  }
}

TEST(StudyReader, RefusesWrongTypesWithTheirPlace) {
  const auto says = [](const char* pointer, const Json& value, const std::string& part) {
    test::expect_says(refusal([&](Json& j) { j[Json::json_pointer(pointer)] = value; }), part);
  };
  says("/runs/0/h", "wide", "bad.json: runs[0].h must be a number, is string");
  says("/runs/0/h", nullptr, "runs[0].h must be a number, is null");
  says("/runs/0/residual/1", true, "runs[0].residual[1] must be a number");
  says("/runs/0/steps", 1.5, "runs[0].steps must be a whole number");
  says("/runs/0/steps", uint64_t{1} << 63, "runs[0].steps must be a whole number");
  says("/runs/0/name", 3, "runs[0].name must be a text");
  says("/runs/0/energy/total", 3, "runs[0].energy.total must be a list");
  says("/runs/0/solver_error", 3, "runs[0].solver_error must be an object");
  says("/runs/0/tolerance", "no", "runs[0].tolerance must be a number");
  says("/figures/0/pass", 1, "figures[0].pass must be true or false");
  says("/sweeps/0/family", "error", "sweeps[0].family must be solver_error or");
  says("/sweeps/0/measure", nullptr, "sweeps[0].measure must be step or");
  says("/overlays/0/outlines/0/lines/1/0", Json::array({1, 2, 3}), "must be a list of two numbers");
  says("/header", Json::array(), "header must be an object");
  says("/runs/0/energy/total", Json::array(), "energies of run 'quasi 1e-2'");
}

TEST(StudyReader, RefusesWhatIsNoJson) {
  for (const char* text : {"", "{", "{\"format\": \"elastogen-study\"", "{}{}", "[1e999]", "\xff"})
    test::error_of([&] { study_from_json(text, "bad.json"); });
  const std::string whole = study_json(small_study());
  for (size_t size = 0; size + 1 < whole.size(); size += 97)
    test::error_of([&] { study_from_json(whole.substr(0, size), "bad.json"); });
  test::error_of([&] { study_from_json(std::string(100000, '['), "bad.json"); });
  const test::TempFolder folder;
  test::expect_says(test::error_of([&] { read_study(folder.path("absent.json")); }), "absent.json");
}

TEST(StudyWriter, RefusesAContradictionAndAMissingFolder) {
  StudyResult study = test::example_study();
  test::error_of([&] { write_study_json("/nonexistent/study.json", study); },
                 ErrorKind::kResources);
  test::error_of([&] { write_study_csv("/nonexistent/study.csv", study); }, ErrorKind::kResources);
  study.sweeps[0].error.pop_back();
  test::error_of([&] { study_json(study); }, ErrorKind::kUsage);
}

/// The cells of a CSV text by RFC 4180.
std::vector<std::vector<std::string>> csv_rows(const std::string& csv) {
  std::vector<std::vector<std::string>> rows(1, {""});
  bool quoted = false;
  for (size_t k = 0; k < csv.size(); ++k) {
    if (csv[k] == '"' && quoted && csv[k + 1] == '"')
      rows.back().back() += csv[++k];
    else if (csv[k] == '"')
      quoted = !quoted;
    else if (csv[k] == ',' && !quoted)
      rows.back().emplace_back();
    else if (csv[k] == '\n' && !quoted)
      rows.push_back({""});
    else
      rows.back().back() += csv[k];
  }
  rows.pop_back();
  return rows;
}

/// A cell of a run by its head.
std::map<std::string, std::string> csv_row(const StudyRun& run) {
  const auto rows = csv_rows(study_csv({run}));
  EXPECT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0].size(), rows[1].size());
  std::map<std::string, std::string> row;
  for (size_t k = 0; k < rows[0].size(); ++k) row[rows[0][k]] = rows[1][k];
  EXPECT_EQ(row.size(), rows[0].size()) << "two heads are the same";
  return row;
}

/// Numbers of the small study's run by their heads; h is set to 0.1.
std::map<std::string, double> small_study_numbers() {
  // settings and sizes, then times, convergence and errors
  return {{"h [m]", 0.1},
          {"dt [s]", 0.5},
          {"tolerance [-]", 0.0078125},
          {"loops.outer [1]", 11},
          {"loops.inner [1]", 21},
          {"loops.modes [1]", 57},
          {"steps [1]", 2},
          {"voxels [1]", 64},
          {"elements [1]", 65},
          {"dofs [1]", 300},
          {"step_ms.lower_quartile [ms]", 7},
          {"step_ms.median [ms]", 8},
          {"step_ms.upper_quartile [ms]", 9},
          {"state_bytes [B]", 6000},
          {"state_copies_per_second [1/s]", 12500},
          {"outer [1]", 7},
          {"inner [1]", 18},
          {"converged_share [-]", 0.5},
          {"worst_residual [-]", 0.015625},
          {"min_j [-]", 0.8125},
          {"solver_error.step.max [-]", 0.01171875},
          {"solver_error.free_run.max [-]", 0.01953125},
          {"solver_error.iou [-]", 0.9921875},
          {"solver_error.energy_drift [-]", 0.025390625},
          {"discretisation_error.step.max [-]", 0.1875},
          {"discretisation_error.free_run.max [-]", 0.3125},
          {"discretisation_error.iou [-]", 0.875},
          {"discretisation_error.energy_drift [-]", 0.40625},
          {"discretisation_error.reference_change [-]", 0.0625}};
}

TEST(StudyCsv, HasTheNumbersOfTheRun) {
  StudyRun run = small_study().runs[0];
  run.h = 0.1;  // not a binary fraction
  std::map<std::string, std::string> row = csv_row(run);
  const std::map<std::string, double> expected = small_study_numbers();
  for (const auto& [head, value] : expected)
    EXPECT_EQ(std::strtod(row.at(head).c_str(), nullptr), value) << head << ": " << row[head];
  EXPECT_EQ(row["name"], "quasi 1e-2");
  EXPECT_EQ(row["solver"], "quasi");
  EXPECT_EQ(row["element"], "voxel");
  EXPECT_EQ(row["solver_error.reference"], "newton 1e-12");
  EXPECT_EQ(row["discretisation_error.reference"], "tet10 fine");
  EXPECT_EQ(row.size(), expected.size() + 5);
}

TEST(StudyCsv, LeavesEmptyWhatARunDoesNotHave) {
  StudyRun run;
  run.worst_residual = std::numeric_limits<double>::infinity();
  run.min_j = std::numeric_limits<double>::quiet_NaN();
  run.discretisation_error = StudyErrors();
  std::map<std::string, std::string> row = csv_row(run);
  for (const char* head : {"tolerance [-]", "loops.outer [1]", "solver_error.reference",
                           "solver_error.step.max [-]", "solver_error.iou [-]"})
    EXPECT_EQ(row.at(head), "") << head;
  EXPECT_EQ(row["discretisation_error.step.max [-]"], "0");
  EXPECT_EQ(row["discretisation_error.reference_change [-]"], "");
  EXPECT_EQ(row["worst_residual [-]"], "inf");
  EXPECT_EQ(row["min_j [-]"], "nan");
}

TEST(StudyCsv, QuotesWhatWouldBreakARow) {
  StudyRun run;
  run.name = test::kHostile;
  EXPECT_EQ(csv_row(run)["name"], test::kHostile);
  EXPECT_EQ(csv_rows(study_csv({})).size(), 1u);
}

TEST(StudyCsv, IsWrittenWithARowForEachRun) {
  const test::TempFolder folder;
  write_study_csv(folder.path("study.csv"), test::example_study());
  std::ifstream file(folder.path("study.csv"));
  const std::string csv{std::istreambuf_iterator<char>(file), {}};
  const auto rows = csv_rows(csv);
  ASSERT_EQ(rows.size(), 5u);
  EXPECT_EQ(rows[4][0], "tet10 fine");
}

}  // namespace
}  // namespace elastogen
