// SPDX-License-Identifier: Apache-2.0
#include "io/tets/xml_scanner.hpp"

#include "io/byte_reader.hpp"

#include <algorithm>

namespace elastogen::tets {
namespace {

constexpr size_t kMaxDepth = 32, kMaxAttributes = 32, kMaxName = 64;

bool is_space(char c) {
  return is_blank(c) || c == '\n';
}

bool is_name_part(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-' || c == '.' || c == ':';
}

}  // namespace

int64_t XmlScanner::line() const {
  return 1 + std::count(bytes_.begin(), bytes_.begin() + last_, '\n');
}

void XmlScanner::skip_past(std::string_view text) {
  const size_t found = bytes_.find(text, at_);
  check(found != bytes_.npos, "a tag does not end");
  at_ = found + text.size();
}

void XmlScanner::skip_blanks() {
  while (at_ < bytes_.size() && is_space(bytes_[at_])) ++at_;
}

std::string_view XmlScanner::name() {
  const size_t begin = at_;
  while (at_ < bytes_.size() && is_name_part(bytes_[at_])) ++at_;
  check(at_ > begin && at_ - begin <= kMaxName, "a name is expected");
  return bytes_.substr(begin, at_ - begin);
}

std::string_view XmlScanner::text() const {
  return bytes_.substr(at_, bytes_.find('<', at_) - at_);
}

std::optional<std::string_view> XmlScanner::attribute(std::string_view name) const {
  for (const auto& [key, value] : attributes_)
    if (key == name) return value;
  return {};
}

bool XmlScanner::next() {
  // the element that began last may have ended in its own tag
  if (is_empty_) open_.pop_back();
  is_empty_ = false;
  // pass over comments, declarations and ends of elements
  while (true) {
    if (!element_.empty() && open_.empty()) return false;
    at_ = std::min(bytes_.find('<', at_), bytes_.size());
    last_ = at_;
    check(at_ < bytes_.size(), "the file ends within an element");
    check(!starts("<!DOCTYPE") && !starts("<![CDATA["), "document types and CDATA are not read");
    if (starts("<!--")) {
      skip_past("-->");
    } else if (starts("<?")) {
      skip_past("?>");
    } else if (starts("</")) {
      close();
    } else {
      break;
    }
  }
  // a start: name, attributes, and the path of open elements
  ++at_;
  open_.push_back(name());
  check(open_.size() <= kMaxDepth, "elements are nested too deep");
  read_attributes();
  element_.clear();
  for (const std::string_view part : open_) {
    if (!element_.empty()) element_ += '/';
    element_ += part;
  }
  return true;
}

void XmlScanner::close() {
  at_ += 2;
  const std::string_view closed = name();
  skip_blanks();
  check(!open_.empty() && open_.back() == closed && starts(">"),
        "the end of another element than that which began");
  ++at_;
  open_.pop_back();
}

void XmlScanner::read_attributes() {
  attributes_.clear();
  for (skip_blanks(); !starts(">") && !starts("/>"); skip_blanks()) {
    const std::string_view key = name();
    check(!attribute(key) && attributes_.size() < kMaxAttributes,
          "an attribute twice, or too many of them");
    skip_blanks();
    check(starts("="), "an attribute has no value");
    ++at_;
    skip_blanks();
    check(starts("\"") || starts("'"), "a value is not in quotes");
    const char quote = bytes_[at_++];
    const size_t end = bytes_.find(quote, at_);
    check(end != bytes_.npos, "a value does not end");
    attributes_.push_back({key, bytes_.substr(at_, end - at_)});
    at_ = end + 1;
  }
  is_empty_ = starts("/>");
  at_ += is_empty_ ? 2 : 1;
}

}  // namespace elastogen::tets
