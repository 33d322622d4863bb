// SPDX-License-Identifier: Apache-2.0
// Whether text is well-formed as XML, as far as pages and plots need it.

#pragma once

#include <cctype>
#include <regex>
#include <string>
#include <vector>

namespace elastogen::test {

/// The fault of a text between two tags: a bare & or >, a control character.
inline std::string text_fault(const std::string& text) {
  static const std::regex reference("&(amp|lt|gt|quot|#39);");
  const std::string plain = std::regex_replace(text, reference, "");
  for (const char c : plain)
    if (c == '&' || c == '<' || c == '>' ||
        (static_cast<unsigned char>(c) < 0x20 && c != '\n' && c != '\t'))
      return "bare character " + std::to_string(int(c)) + " in '" + text.substr(0, 80) + "'";
  return "";
}

/// The fault of the attributes of a tag: each must be a name, = and a value in quotes.
inline std::string attribute_fault(const std::string& text) {
  size_t at = 0;
  while (at < text.size()) {
    const size_t name = text.find_first_not_of(" \n", at), equals = text.find("=\"", at);
    const size_t end = equals == text.npos ? text.npos : text.find('"', equals + 2);
    if (name == at || end == text.npos) return "broken attribute '" + text.substr(at, 80) + "'";
    for (size_t k = name; k < equals; ++k)
      if (!std::isalpha(static_cast<unsigned char>(text[k])) && text[k] != '-')
        return "broken attribute '" + text.substr(at, 80) + "'";
    const std::string fault = text_fault(text.substr(equals + 2, end - equals - 2));
    if (!fault.empty()) return fault;
    at = end + 1;
  }
  return "";
}

/// The fault of the text between < and > of a tag, given the tags that are open.
inline std::string tag_fault(std::string tag, std::vector<std::string>& open) {
  if (!tag.empty() && tag[0] == '/') {
    if (open.empty() || open.back() != tag.substr(1)) return "<" + tag + "> is not open";
    open.pop_back();
    return "";
  }
  const bool closed = !tag.empty() && tag.back() == '/';
  if (closed) tag.pop_back();
  size_t letters = 0;
  while (letters < tag.size() && std::isalnum(static_cast<unsigned char>(tag[letters]))) ++letters;
  if (letters == 0) return "broken tag <" + tag.substr(0, 80) + ">";
  if (!closed) open.push_back(tag.substr(0, letters));
  return attribute_fault(tag.substr(letters));
}

/// The first fault of a document or element: tags that do not match, attributes without quotes,
/// bare characters. @return "" if it is well-formed.
inline std::string markup_fault(const std::string& markup) {
  const std::string doctype = "<!DOCTYPE html>";
  size_t at = markup.rfind(doctype, 0) == 0 ? doctype.size() : 0;
  std::vector<std::string> open;
  while (at < markup.size()) {
    const size_t tag = markup.find('<', at);
    std::string fault = text_fault(markup.substr(at, tag == markup.npos ? tag : tag - at));
    if (!fault.empty()) return fault;
    if (tag == markup.npos) break;
    const size_t end = markup.find('>', tag);
    if (end == markup.npos) return "a tag without end";
    fault = tag_fault(markup.substr(tag + 1, end - tag - 1), open);
    if (!fault.empty()) return fault;
    at = end + 1;
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

/// How often the text has the part.
inline int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (size_t at = text.find(part); at != text.npos; at = text.find(part, at + part.size()))
    ++count;
  return count;
}

/// The texts between each begin and the next end.
inline std::vector<std::string> parts_between(const std::string& text, const std::string& begin,
                                              const std::string& end) {
  std::vector<std::string> parts;
  size_t at = 0;
  while ((at = text.find(begin, at)) != text.npos) {
    at += begin.size();
    parts.push_back(text.substr(at, text.find(end, at) - at));
  }
  return parts;
}

}  // namespace elastogen::test
