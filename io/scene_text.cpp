// SPDX-License-Identifier: Apache-2.0
#include "io/scene_text.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "io/scene_toml.hpp"

#include <nlohmann/json.hpp>

#include <cmath>
#include <iterator>
#include <set>

namespace elastogen {
namespace {

using SceneJson = nlohmann::json;
using Kind = SceneValue::Kind;

/// Iterates over the bytes of a text and counts lines.
class LineIterator {
 public:
  using iterator_category = std::input_iterator_tag;
  using difference_type = std::ptrdiff_t;
  using value_type = char;
  using pointer = const char*;
  using reference = const char&;

  LineIterator(const char* at, int* line) : at_(at), line_(line) {}
  reference operator*() const { return *at_; }
  LineIterator& operator++() {
    *line_ += *at_ == '\n';
    ++at_;
    return *this;
  }
  LineIterator operator++(int) {
    const LineIterator before = *this;
    ++*this;
    return before;
  }
  bool operator==(const LineIterator& other) const { return at_ == other.at_; }
  bool operator!=(const LineIterator& other) const { return at_ != other.at_; }

 private:
  const char* at_;
  int* line_;
};

/// Builds the tree from the events of the parser.
class JsonTree final : public nlohmann::json_sax<SceneJson> {
 public:
  JsonTree(const std::string& name, const int& line) : name_(name), line_(line) {}

  SceneValue& root() { return root_; }

  bool null() override { fail("null has no meaning in a scene: leave the key out"); }
  bool boolean(bool flag) override { return add(scene_flag(flag)); }
  bool number_integer(int64_t number) override { return add(scene_number(double(number))); }
  bool number_unsigned(uint64_t number) override { return add(scene_number(double(number))); }
  bool number_float(double number, const std::string& text) override {
    if (!std::isfinite(number)) fail(text + " is not finite");
    return add(scene_number(number));
  }
  bool string(std::string& text) override { return add(scene_text(text)); }
  bool binary(SceneJson::binary_t&) override { fail("binary data have no meaning in a scene"); }

  bool start_object(size_t) override {
    open(Kind::kTable);
    return true;
  }
  bool start_array(size_t) override {
    open(Kind::kList);
    return true;
  }
  bool end_object() override { return close(); }
  bool end_array() override { return close(); }

  bool key(std::string& key) override {
    if (!keys_.back().insert(key).second) fail("'" + key + "' is there twice");
    key_ = key;
    key_line_ = line_;
    return true;
  }

  bool parse_error(size_t, const std::string&, const nlohmann::detail::exception& error) override {
    const std::string what = error.what();
    const size_t sentence = what.find("] ");
    fail("is no JSON: " + (sentence == std::string::npos ? what : what.substr(sentence + 2)));
  }

 private:
  [[noreturn]] void fail(const std::string& text) const {
    throw Error(concat(name_, ":", line_, ": ", text));
  }

  /// Adds a value to the open table or list. Its address is valid until the next one is added.
  bool add(SceneValue value) {
    value.line = key_line_ > 0 ? key_line_ : line_;
    key_line_ = 0;
    if (open_.empty()) {
      root_ = std::move(value);
      last_ = &root_;
    } else if (open_.back()->kind == Kind::kTable) {
      open_.back()->set(key_, std::move(value));
      last_ = &open_.back()->members.back().value;
    } else {
      open_.back()->items.push_back(std::move(value));
      last_ = &open_.back()->items.back();
    }
    return true;
  }

  void open(Kind kind) {
    if (open_.size() >= size_t(kMaxSceneDepth))
      fail(concat("is nested more than ", kMaxSceneDepth, " levels deep"));
    SceneValue value;
    value.kind = kind;
    add(std::move(value));
    open_.push_back(last_);
    keys_.emplace_back();
  }

  bool close() {
    open_.pop_back();
    keys_.pop_back();
    return true;
  }

  const std::string& name_;
  const int& line_;
  SceneValue root_;
  SceneValue* last_ = nullptr;
  std::vector<SceneValue*> open_;
  std::vector<std::set<std::string>> keys_;  ///< of each open table
  std::string key_;
  int key_line_ = 0;
};

SceneValue parse_scene_json(std::string_view text, const std::string& name) {
  // the parser treats a zero byte as the end
  ELASTOGEN_CHECK(text.find('\0') == text.npos, name, ": is no JSON: it holds a byte 0");
  int line = 1, end_line = 1;
  JsonTree tree(name, line);
  SceneJson::sax_parse(LineIterator(text.data(), &line),
                       LineIterator(text.data() + text.size(), &end_line), &tree);
  ELASTOGEN_CHECK(tree.root().kind == Kind::kTable, name, ":1: a scene is a table of keys");
  return std::move(tree.root());
}

}  // namespace

SceneValue parse_scene(std::string_view text, const std::string& name) {
  ELASTOGEN_CHECK(int64_t(text.size()) <= kMaxSceneBytes, name, ": has ", text.size(),
                  " bytes; a scene may have ", kMaxSceneBytes);
  text = without_mark(text);
  const size_t first = text.find_first_not_of(" \t\r\n");
  const bool brace = first != std::string_view::npos && text[first] == '{';
  const bool json = name.ends_with(".json") || (brace && !name.ends_with(".toml"));
  return json ? parse_scene_json(text, name) : parse_scene_toml(text, name);
}

}  // namespace elastogen
