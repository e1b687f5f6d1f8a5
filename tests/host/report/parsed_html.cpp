#include "tests/host/report/parsed_html.hpp"

#include <glib.h>

#include <algorithm>

namespace strobe::report_test {

namespace {

void begin(GMarkupParseContext*, const gchar* name, const gchar** names, const gchar** values, gpointer data,
           GError**) {
  Element element{name, {}};
  for (int i = 0; names[i] != nullptr; ++i) element.attributes[names[i]] = values[i];
  static_cast<ParsedHtml*>(data)->elements.push_back(std::move(element));
}

void take_text(GMarkupParseContext* context, const gchar* text, gsize length, gpointer data, GError**) {
  auto* parsed = static_cast<ParsedHtml*>(data);
  const std::string within = g_markup_parse_context_get_element(context);
  std::string& out = within == "style" ? parsed->style : parsed->text;
  out.append(text, length);
  if (within != "style") out += "\n";
}

}  // namespace

std::size_t ParsedHtml::count(const std::string& name) const {
  return static_cast<std::size_t>(
      std::count_if(elements.begin(), elements.end(), [&](const Element& e) { return e.name == name; }));
}

ParsedHtml parse_html(const std::string& html) {
  ParsedHtml parsed;
  const GMarkupParser parser{begin, nullptr, take_text, nullptr, nullptr};
  GMarkupParseContext* context =
      g_markup_parse_context_new(&parser, G_MARKUP_TREAT_CDATA_AS_TEXT, &parsed, nullptr);
  GError* error = nullptr;
  parsed.well_formed =
      g_markup_parse_context_parse(context, html.data(), static_cast<gssize>(html.size()), &error) != FALSE &&
      g_markup_parse_context_end_parse(context, &error) != FALSE;
  if (error != nullptr) parsed.problem = error->message;
  g_clear_error(&error);
  g_markup_parse_context_free(context);
  return parsed;
}

}  // namespace strobe::report_test
