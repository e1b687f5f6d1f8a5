// Any text comes through HTML as it is, and no text becomes markup.
#include <glib.h>
#include <rapidcheck.h>

#include "host/figures/escape.hpp"
#include "tests/host/report/parsed_html.hpp"
#include "tests/support/string_from.hpp"

#include <CppUTest/TestHarness.h>

using strobe::figures::escaped;
using strobe::report_test::parse_html;

namespace {

/// As a reader of the document sees it, in an element and in an attribute.
std::string read_back(const std::string& text) {
  const auto parsed = parse_html("<p title=\"" + escaped(text) + "\">" + escaped(text) + "</p>");
  if (!parsed.well_formed || parsed.elements.size() != 1) return "not well-formed: " + parsed.problem;
  const std::string body = parsed.text.empty() ? "" : parsed.text.substr(0, parsed.text.size() - 1);
  // XML takes line breaks and tabs within attributes for spaces; GLib leaves them.
  return body == parsed.elements[0].attributes.at("title") ? body : "differs in the attribute";
}

}  // namespace

TEST_GROUP(Escape){};

TEST(Escape, MarkupComesBackAsText) {
  for (const char* text : {"<script>alert(1)</script>", "a & b &amp; c", "\"quoted\" 'too'", "]]>",
                           "<!-- -->", "&#x3c;", "Grüße, 23 °C, 日本, 🎾"})
    CHECK_EQUAL(std::string(text), read_back(text));
}

TEST(Escape, AnyPrintableTextComesBack) {
  CHECK(rc::check("text comes back", [] {
    const auto characters = *rc::gen::container<std::vector<char>>(rc::gen::inRange(' ', '\x7f'));
    const std::string text(characters.begin(), characters.end());
    RC_ASSERT(read_back(text) == text);
  }));
}

TEST(Escape, AnyBytesMakeAWellFormedDocument) {
  CHECK(rc::check("bytes are harmless", [] {
    const auto text = *rc::gen::arbitrary<std::string>();
    const std::string html = "<p>" + escaped(text) + "</p>";
    const auto parsed = parse_html(html);
    RC_ASSERT(parsed.well_formed);
    RC_ASSERT(parsed.elements.size() == 1U);
    RC_ASSERT(g_utf8_validate(html.data(), static_cast<gssize>(html.size()), nullptr) != FALSE);
  }));
}

TEST(Escape, CharactersThatTurnTheOrderOfATextAreReplaced) {
  CHECK_EQUAL(std::string("a\xEF\xBF\xBD"
                          "b"),
              escaped("a\u202E"
                      "b"));
  CHECK_EQUAL(std::string("\xEF\xBF\xBD"), escaped("\x1b"));
  CHECK_EQUAL(std::string("\xEF\xBF\xBD"), escaped(std::string_view("\0", 1)));
  CHECK_EQUAL(std::string("\xEF\xBF\xBD\xEF\xBF\xBD"), escaped("\xE2\x82"));
}
