// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "io/json_text.hpp"
#include "io/safe_file.hpp"
#include "io/study_errors.hpp"
#include "io/study_fields.hpp"
#include "io/study_writer.hpp"

#include <nlohmann/json.hpp>

#include <limits>
#include <set>

namespace elastogen {
namespace {

using StudyJson = nlohmann::json;

constexpr int64_t kMaxStudyBytes = int64_t{256} << 20;

/// Fills the members of a result from JSON; `place` names the place in the file.
class Decoder {
 public:
  explicit Decoder(std::string file) : file_(std::move(file)) {}

  void decode(const StudyJson& json, const std::string& place, double& value) const {
    const bool is_text = json.is_string();
    if (is_text && json == "nan")
      value = std::numeric_limits<double>::quiet_NaN();
    else if (is_text && json == "inf")
      value = std::numeric_limits<double>::infinity();
    else if (is_text && json == "-inf")
      value = -std::numeric_limits<double>::infinity();
    else
      value = get<double>(json, place, json.is_number(), "a number");
  }
  void decode(const StudyJson& json, const std::string& place, int64_t& value) const {
    constexpr uint64_t kLargest = std::numeric_limits<int64_t>::max();
    const bool fits =
        json.is_number_integer() && !(json.is_number_unsigned() && json.get<uint64_t>() > kLargest);
    value = get<int64_t>(json, place, fits, "a whole number of 64 bits");
  }
  void decode(const StudyJson& json, const std::string& place, bool& value) const {
    value = get<bool>(json, place, json.is_boolean(), "true or false");
  }
  void decode(const StudyJson& json, const std::string& place, std::string& value) const {
    value = get<std::string>(json, place, json.is_string(), "a text");
  }
  void decode(const StudyJson& json, const std::string& place, ErrorFamily& value) const {
    const bool solver = json == StudyJson(family_name(ErrorFamily::kSolver));
    if (!solver && json != StudyJson(family_name(ErrorFamily::kDiscretisation)))
      fail(place, "must be solver_error or discretisation_error");
    value = solver ? ErrorFamily::kSolver : ErrorFamily::kDiscretisation;
  }
  void decode(const StudyJson& json, const std::string& place, ErrorMeasure& value) const {
    const bool step = json == StudyJson(measure_name(ErrorMeasure::kStep));
    if (!step && json != StudyJson(measure_name(ErrorMeasure::kFreeRun)))
      fail(place, "must be step or free_run");
    value = step ? ErrorMeasure::kStep : ErrorMeasure::kFreeRun;
  }
  void decode(const StudyJson& json, const std::string& place, std::array<double, 2>& value) const {
    if (!json.is_array() || json.size() != 2) fail(place, "must be a list of two numbers");
    for (size_t k = 0; k < 2; ++k) decode(json[k], place, value[k]);
  }
  template <class T>
  void decode(const StudyJson& json, const std::string& place, std::optional<T>& value) const {
    if (!json.is_null()) decode(json, place, value.emplace());
  }
  template <class T>
  void decode(const StudyJson& json, const std::string& place, std::vector<T>& values) const {
    if (!json.is_array()) fail(place, "must be a list");
    values.resize(json.size());
    for (size_t k = 0; k < json.size(); ++k)
      decode(json[k], place + '[' + std::to_string(k) + ']', values[k]);
  }
  template <class Struct>
  void decode(const StudyJson& json, const std::string& place, Struct& value) const {
    if (!json.is_object()) fail(place, "must be an object");
    std::set<std::string> known;
    const std::string prefix = place.empty() ? "" : place + '.';
    each_field(value, [&](const char* name, auto& member) {
      const StudyJson::const_iterator field = json.find(name);
      if (field == json.end()) fail(prefix + name, "is missing");
      decode(*field, prefix + name, member);
      known.insert(name);
    });
    for (const auto& field : json.items())
      if (!known.count(field.key())) fail(prefix + field.key(), "is not known");
  }

  [[noreturn]] void fail(const std::string& place, const std::string& what) const {
    throw Error(concat(file_, ": ", place, ' ', what), ErrorKind::kAsset);
  }

 private:
  template <class T>
  T get(const StudyJson& json, const std::string& place, bool is, const char* expected) const {
    if (!is) fail(place, concat("must be ", expected, ", is ", json.type_name()));
    return json.get<T>();
  }

  std::string file_;
};

StudyJson parsed(std::string_view text, const std::string& name) {
  try {
    return parsed_sorted_json(text);
  } catch (const StudyJson::exception& error) {
    throw Error(concat(name, ": is no JSON: ", error.what()), ErrorKind::kAsset);
  }
}

}  // namespace

StudyResult study_from_json(std::string_view text, const std::string& name) {
  StudyJson json = parsed(text, name);
  ELASTOGEN_CHECK_ASSET(json.is_object() && json.value("format", StudyJson()) == "elastogen-study",
                        name, ": is no study: 'format' must be \"elastogen-study\"");
  const StudyJson version = json.value("version", StudyJson());
  ELASTOGEN_CHECK_ASSET(version == kStudyVersion, name, ": has version ", version.dump(),
                        ", only version ", kStudyVersion, " is read");
  json.erase("format");
  json.erase("version");

  StudyResult result;
  Decoder(name).decode(json, "", result);
  const std::string contradiction = contradiction_in(result);
  ELASTOGEN_CHECK_ASSET(contradiction.empty(), name, ": ", contradiction);
  return result;
}

StudyResult read_study(const std::string& path) {
  return study_from_json(read_file(path, kMaxStudyBytes), path);
}

}  // namespace elastogen
