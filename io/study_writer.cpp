// SPDX-License-Identifier: Apache-2.0
#include "io/study_writer.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "io/study_errors.hpp"
#include "io/study_fields.hpp"
#include "io/text_format.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>

namespace elastogen {
namespace {

using Json = nlohmann::ordered_json;

/// Encodes a member of a result as JSON.
struct Encoder {
  static Json encode(double value) {
    if (std::isfinite(value)) return value;
    return exact_number(value);
  }
  static Json encode(int64_t value) { return value; }
  static Json encode(bool value) { return value; }
  static Json encode(const std::string& value) { return value; }
  static Json encode(ErrorFamily value) { return family_name(value); }
  static Json encode(ErrorMeasure value) { return measure_name(value); }
  static Json encode(const std::array<double, 2>& value) {
    return Json::array({encode(value[0]), encode(value[1])});
  }
  template <class T>
  static Json encode(const std::optional<T>& value) {
    return value ? encode(*value) : Json();
  }
  template <class T>
  static Json encode(const std::vector<T>& values) {
    Json list = Json::array();
    for (const T& value : values) list.push_back(encode(value));
    return list;
  }
  template <class Struct>
  static Json encode(const Struct& value) {
    Json object = Json::object();
    each_field(value, [&](const char* name, const auto& member) { object[name] = encode(member); });
    return object;
  }
};

struct Column {
  std::string head;
  std::function<std::string(const StudyRun&)> cell;
};

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == text.npos) return text;
  std::string cell = "\"";
  for (const char c : text) cell += c == '"' ? "\"\"" : std::string(1, c);
  return cell + '"';
}

Column text_column(const char* head, std::string StudyRun::*member) {
  return {head, [=](const StudyRun& run) { return quoted(run.*member); }};
}

Column number_column(const char* head, double StudyRun::*member) {
  return {head, [=](const StudyRun& run) { return exact_number(run.*member); }};
}

Column count_column(const char* head, int64_t StudyRun::*member) {
  return {head, [=](const StudyRun& run) { return std::to_string(run.*member); }};
}

Column time_column(const char* head, double StepTime::*member) {
  return {head, [=](const StudyRun& run) { return exact_number(run.step_ms.*member); }};
}

Column loop_column(const char* head, int64_t LoopBudget::*member) {
  return {head, [=](const StudyRun& run) {
            return run.loops ? std::to_string((*run.loops).*member) : "";
          }};
}

void add_error_columns(std::vector<Column>& columns, ErrorFamily family) {
  const std::string prefix = std::string(family_name(family)) + '.';
  const auto add = [&](const char* head, std::string (*text)(const StudyErrors&)) {
    columns.push_back({prefix + head, [=](const StudyRun& run) {
                         const std::optional<StudyErrors>& errors = errors_of(run, family);
                         return errors ? text(*errors) : "";
                       }});
  };
  add("reference", [](const StudyErrors& e) { return quoted(e.reference); });
  add("step.max [-]", [](const StudyErrors& e) { return exact_number(e.step.max); });
  add("free_run.max [-]", [](const StudyErrors& e) { return exact_number(e.free_run.max); });
  add("iou [-]", [](const StudyErrors& e) { return exact_number(e.iou); });
  add("energy_drift [-]", [](const StudyErrors& e) { return exact_number(e.energy_drift); });
  if (family == ErrorFamily::kDiscretisation)
    add("reference_change [-]", [](const StudyErrors& e) {
      return e.reference_change ? exact_number(*e.reference_change) : "";
    });
}

std::vector<Column> csv_columns() {
  // what was solved, and how finely
  std::vector<Column> columns = {
      text_column("name", &StudyRun::name),
      text_column("solver", &StudyRun::solver),
      text_column("element", &StudyRun::element),
      number_column("h [m]", &StudyRun::h),
      number_column("dt [s]", &StudyRun::dt),
      {"tolerance [-]",
       [](const StudyRun& run) { return run.tolerance ? exact_number(*run.tolerance) : ""; }},
      loop_column("loops.outer [1]", &LoopBudget::outer),
      loop_column("loops.inner [1]", &LoopBudget::inner),
      loop_column("loops.modes [1]", &LoopBudget::modes),
      count_column("steps [1]", &StudyRun::steps),
      count_column("voxels [1]", &StudyRun::voxels),
      count_column("elements [1]", &StudyRun::elements),
      count_column("dofs [1]", &StudyRun::dofs),
      // cost
      time_column("step_ms.lower_quartile [ms]", &StepTime::lower_quartile),
      time_column("step_ms.median [ms]", &StepTime::median),
      time_column("step_ms.upper_quartile [ms]", &StepTime::upper_quartile),
      count_column("state_bytes [B]", &StudyRun::state_bytes),
      number_column("state_copies_per_second [1/s]", &StudyRun::state_copies_per_second),
      // how well it was solved
      count_column("outer [1]", &StudyRun::outer),
      count_column("inner [1]", &StudyRun::inner),
      number_column("converged_share [-]", &StudyRun::converged_share),
      number_column("worst_residual [-]", &StudyRun::worst_residual),
      number_column("min_j [-]", &StudyRun::min_j),
  };
  // errors
  add_error_columns(columns, ErrorFamily::kSolver);
  add_error_columns(columns, ErrorFamily::kDiscretisation);
  return columns;
}

}  // namespace

std::string study_json(const StudyResult& result) {
  const std::string contradiction = contradiction_in(result);
  ELASTOGEN_CHECK(contradiction.empty(), "a study cannot be written: ", contradiction);
  Json json = {{"format", "elastogen-study"}, {"version", kStudyVersion}};
  json.update(Encoder::encode(result));
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + '\n';
}

std::string study_csv(const std::vector<StudyRun>& runs) {
  const std::vector<Column> columns = csv_columns();
  std::string csv;
  for (const Column& column : columns) csv += (csv.empty() ? "" : ",") + column.head;
  csv += '\n';
  for (const StudyRun& run : runs)
    for (size_t k = 0; k < columns.size(); ++k)
      csv += columns[k].cell(run) + (k + 1 < columns.size() ? ',' : '\n');
  return csv;
}

void write_study_json(const std::string& path, const StudyResult& result) {
  write_file(path, study_json(result));
}

void write_study_csv(const std::string& path, const StudyResult& result) {
  write_file(path, study_csv(result.runs));
}

}  // namespace elastogen
