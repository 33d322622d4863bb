// SPDX-License-Identifier: Apache-2.0
#include "io/scene_toml.hpp"

#include "core/error.hpp"
#include "io/scene_text.hpp"

#include <toml.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>

namespace elastogen {
namespace {

using Toml = toml::basic_value<toml::discard_comments, std::map, std::vector>;
using Kind = SceneValue::Kind;

/// Refuses text that is nested too deeply before the recursive parser reads it: it counts open
/// brackets and the parts of dotted keys. Texts and comments are skipped.
class DepthScan {
 public:
  DepthScan(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  void run() {
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        pass_text(c);
        continue;
      }
      if (c == '#') at_ = std::min(text_.find('\n', at_), text_.size() - 1);
      count(text_[at_++]);
    }
  }

 private:
  void count(char c) {
    if (c == '[' || c == '{') ++open_;
    if ((c == ']' || c == '}') && open_ > 0) --open_;
    if (c == '.') ++dots_;
    if (c == '\n') ++line_;
    if (std::string_view("[]{},=\n").find(c) != std::string_view::npos) dots_ = 0;
    ELASTOGEN_CHECK(open_ <= kMaxSceneDepth && dots_ < kMaxSceneDepth, name_, ":", line_,
                    ": is nested more than ", kMaxSceneDepth, " levels deep");
  }

  /// Goes behind a text in one or three quotes; the parser refuses one without an end.
  void pass_text(char quote) {
    const std::string three(3, quote);
    const bool is_long = text_.substr(at_, 3) == three;
    at_ += is_long ? 3 : 1;
    for (; at_ < text_.size(); ++at_) {
      if (text_[at_] == '\n') {
        if (!is_long) return;
        ++line_;
      }
      if (text_[at_] == '\\' && quote == '"') {
        ++at_;
      } else if (is_long ? text_.substr(at_, 3) == three : text_[at_] == quote) {
        at_ += is_long ? 3 : 1;
        // the content of a long text may end in one or two quotes
        for (int k = 0; is_long && k < 2 && at_ < text_.size() && text_[at_] == quote; ++k) ++at_;
        return;
      }
    }
  }

  std::string_view text_;
  const std::string& name_;
  size_t at_ = 0;
  int open_ = 0, dots_ = 0, line_ = 1;
};

/// The tree of a parsed file.
class Tree {
 public:
  explicit Tree(const std::string& name) : name_(name) {}

  SceneValue value(const Toml& toml, const std::string& key, int depth) {
    ELASTOGEN_CHECK(depth <= kMaxSceneDepth, name_, ": '", key, "' is nested more than ",
                    kMaxSceneDepth, " levels deep");
    SceneValue result;
    if (toml.is_table()) {
      for (const auto& [name, member] : toml.as_table()) {
        const int line = line_of(member);
        result.set(name, value(member, name, depth + 1));
        result.members.back().value.line = line;
      }
    } else if (toml.is_array()) {
      result.kind = Kind::kList;
      for (const Toml& item : toml.as_array()) {
        const int line = item.is_table() ? line_of(item) : 0;
        result.items.push_back(value(item, key, depth + 1));
        result.items.back().line = line;
      }
    } else if (toml.is_boolean()) {
      result = scene_flag(toml.as_boolean());
    } else if (toml.is_string()) {
      result = scene_text(toml.as_string().str);
    } else if (toml.is_integer()) {
      // the parser turns larger integers into the largest one
      constexpr int64_t kLargest = std::numeric_limits<int64_t>::max();
      const int64_t number = toml.as_integer();
      ELASTOGEN_CHECK(-kLargest < number && number < kLargest, name_, ":", toml.location().line(),
                      ": '", key, "': the number is too large");
      result = scene_number(double(number));
    } else {
      ELASTOGEN_CHECK(toml.is_floating(), name_, ":", toml.location().line(), ": '", key,
                      "': dates and times have no meaning in a scene");
      // the parser turns larger floats into the largest one
      const bool finite = std::abs(toml.as_floating()) < std::numeric_limits<double>::max();
      ELASTOGEN_CHECK(finite, name_, ":", toml.location().line(), ": '", key,
                      "': the number is not finite");
      result = scene_number(toml.as_floating());
    }
    return result;
  }

 private:
  /// The parser counts lines from the start for each answer, so only the first values ask for
  /// theirs.
  int line_of(const Toml& toml) { return ++asked_ <= 1000 ? int(toml.location().line()) : 0; }

  const std::string& name_;
  int asked_ = 0;
};

/// @throws Error if the parser would need long.
void check_size(std::string_view text, const std::string& name) {
  ELASTOGEN_CHECK(int64_t(text.size()) <= kMaxTomlBytes, name, ": has ", text.size(),
                  " bytes; a scene in TOML may have ", kMaxTomlBytes, ": write it as JSON");
  for (int line = 1; !text.empty(); ++line) {
    const size_t end = std::min(text.find('\n'), text.size());
    ELASTOGEN_CHECK(int64_t(end) <= kMaxTomlLine, name, ":", line, ": the line has ", end,
                    " bytes; a line of TOML may have ", kMaxTomlLine,
                    ": break it, or write the scene as JSON");
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

/// Length of the UTF-8 character at the begin of a text, 0 if it is invalid (RFC 3629).
size_t utf8_length(std::string_view text) {
  const auto byte = [&](size_t k) { return k < text.size() ? uint8_t(text[k]) : uint8_t(0); };
  const uint8_t lead = byte(0);
  if (lead < 0x80) return 1;
  if (lead < 0xc2 || lead > 0xf4) return 0;
  const size_t length = lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
  // neither overlong nor a surrogate nor beyond U+10FFFF
  const uint8_t low = lead == 0xe0 ? 0xa0 : lead == 0xf0 ? 0x90 : 0x80;
  const uint8_t high = lead == 0xed ? 0x9f : lead == 0xf4 ? 0x8f : 0xbf;
  if (byte(1) < low || byte(1) > high) return 0;
  for (size_t k = 2; k < length; ++k)
    if (byte(k) < 0x80 || byte(k) > 0xbf) return 0;
  return length;
}

/// @throws Error naming the line of the first byte that is not UTF-8. toml11 3.7 reads beyond its
///         buffer if a text in three quotes has such a byte.
void check_utf8(std::string_view text, const std::string& name) {
  for (int line = 1; !text.empty();) {
    const size_t length = utf8_length(text);
    ELASTOGEN_CHECK(length > 0, name, ":", line, ": is no TOML: a byte is not UTF-8");
    line += text[0] == '\n';
    text.remove_prefix(length);
  }
}

/// The first sentence of the parser's message, which continues with a drawing of the place.
std::string one_sentence(const std::string& what) {
  std::string text = what.substr(0, what.find('\n'));
  for (const std::string_view head : {"[error] ", "toml::"})
    if (text.starts_with(head)) text.erase(0, head.size());
  return text;
}

}  // namespace

SceneValue parse_scene_toml(std::string_view text, const std::string& name) {
  DepthScan(text, name).run();
  check_size(text, name);
  check_utf8(text, name);
  try {
    std::istringstream stream{std::string(text)};
    return Tree(name).value(toml::parse<toml::discard_comments, std::map>(stream, name), "", 0);
  } catch (const toml::exception& error) {
    throw Error(
        concat(name, ":", error.location().line(), ": is no TOML: ", one_sentence(error.what())));
  } catch (const Error&) {
    throw;
  } catch (const std::exception& error) {
    throw Error(concat(name, ": is no TOML: ", one_sentence(error.what())));
  }
}

}  // namespace elastogen
