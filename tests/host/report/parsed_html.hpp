// What a parser of XML (GLib's) makes of a document. Fails the test where it is not well-formed.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace strobe::report_test {

struct Element {
  std::string name;
  std::map<std::string, std::string> attributes;
};

struct ParsedHtml {
  bool well_formed = false;
  std::string problem;
  std::vector<Element> elements;  ///< in order
  std::string text;               ///< of all but style; each piece followed by a line break
  std::string style;

  std::size_t count(const std::string& name) const;
};

ParsedHtml parse_html(const std::string& html);

}  // namespace strobe::report_test
