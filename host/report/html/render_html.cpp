#include "host/report/html/render_html.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "host/figures/escape.hpp"
#include "host/figures/svg.hpp"
#include "host/report/html/style.hpp"
#include "host/report/model/hashes.hpp"

namespace strobe::lab_report {

namespace {

using figures::escaped;

std::string paragraph(const std::string& words, const char* kind) {
  return fmt::format("<p class=\"{}\">{}</p>\n", kind, escaped(words));
}

std::string heading(const std::string& words) {
  return words.empty() ? std::string() : "<h3>" + escaped(words) + "</h3>\n";
}

std::string value_of(const Fact& fact) {
  return fact.stated ? escaped(fact.text) : "<span class=\"missing\">" + escaped(fact.text) + "</span>";
}

std::string facts_table(const std::vector<Fact>& facts) {
  std::string out = "<table class=\"facts\">\n";
  for (const Fact& fact : facts)
    out += fmt::format("<tr><td class=\"label\">{}</td><td class=\"value\">{}</td></tr>\n",
                       escaped(fact.label), value_of(fact));
  return facts.empty() ? std::string() : out + "</table>\n";
}

/// Short words stay on one line, so that columns of numbers do not squeeze them.
const char* words_class(const std::string& text) {
  constexpr std::size_t kShort = 26;
  return text.size() <= kShort ? " class=\"words short\"" : " class=\"words\"";
}

std::string head_of(const Column& column) {
  const std::string unit =
      column.unit.empty() ? std::string() : "<span class=\"unit\">" + escaped(column.unit) + "</span>";
  return fmt::format("<th{}>{}{}</th>", column.is_number ? "" : words_class(column.head),
                     escaped(column.head), unit);
}

std::string row_class(const Row& row, bool in_groups) {
  std::string kind = row.begins ? "begins" : in_groups ? "follows" : "";
  if (row.beside) kind += kind.empty() ? "beside" : " beside";
  return kind.empty() ? kind : " class=\"" + kind + "\"";
}

std::string row_of(const Table& table, const Row& row, bool in_groups) {
  std::string out = "<tr" + row_class(row, in_groups) + ">";
  for (std::size_t i = 0; i < row.cells.size() && i < table.columns.size(); ++i)
    out += fmt::format("<td{}>{}</td>", table.columns[i].is_number ? "" : words_class(row.cells[i].text),
                       escaped(row.cells[i].text));
  return out + "</tr>\n";
}

struct HtmlWriter {
  std::string operator()(const Facts& f) const { return heading(f.title) + facts_table(f.facts); }

  std::string operator()(const Table& table) const {
    constexpr std::size_t kWide = 10;
    std::string out = table.columns.size() > kWide ? "<table class=\"wide\">\n" : "<table>\n";
    const bool in_groups =
        std::any_of(table.rows.begin(), table.rows.end(), [](const Row& row) { return row.begins; });
    if (!table.title.empty()) out += "<caption>" + escaped(table.title) + "</caption>\n";
    out += "<thead><tr>";
    for (const Column& column : table.columns) out += head_of(column);
    out += "</tr></thead>\n<tbody>\n";
    for (const Row& row : table.rows) out += row_of(table, row, in_groups);
    out += "</tbody>\n</table>\n";
    for (const std::string& note : table.notes) out += paragraph(note, "note");
    return out;
  }

  std::string operator()(const Chart& chart) const {
    return fmt::format(
        "<figure>\n<figcaption><span class=\"title\">{}</span>{}{}</figcaption>\n{}</figure>\n",
        escaped(chart.title), chart.caption.empty() ? "" : ". ", escaped(chart.caption),
        figures::svg_of(chart));
  }

  std::string operator()(const Paragraph& p) const {
    return paragraph(p.text, p.is_emphasized ? "strong" : "plain");
  }

  std::string operator()(const Listing& listing) const {
    return heading(listing.title) + "<pre>" + escaped(listing.text) + "</pre>\n";
  }

  std::string operator()(const ShotCard& shot) const {
    std::string out = fmt::format("<table class=\"shot{}\"><tr><td>\n<p class=\"title\">{}</p>\n",
                                  shot.counts ? "" : " rejected", escaped(shot.title));
    if (shot.picture) {
      out += fmt::format(
          "<table class=\"card\"><tr><td class=\"picture\"><img width=\"{}\" height=\"{}\" alt=\"{}\" "
          "src=\"data:image/jpeg;base64,{}\"/></td><td class=\"numbers\">{}</td></tr></table>\n",
          shot.picture->width_px, shot.picture->height_px, escaped(shot.title), base64(shot.picture->jpeg),
          facts_table(shot.facts));
    } else {
      out += paragraph(shot.no_picture, "note") + facts_table(shot.facts);
    }
    for (const std::string& remark : shot.remarks) out += paragraph(remark, "note");
    return out + "</td></tr></table>\n";
  }

  std::string operator()(const Signature& signature) const {
    std::string out = "<table class=\"signature\"><tr>";
    for (std::size_t i = 0; i < signature.lines.size(); ++i)
      out += fmt::format("{}<td>{}: {}</td>", i == 0 ? "" : "<td class=\"gap\"></td>",
                         escaped(signature.lines[i].label), value_of(signature.lines[i]));
    return out + "</tr></table>\n";
  }
};

std::string head(const Report& report, const std::string& style) {
  return fmt::format(
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'{}'; base-uri 'none'; form-action 'none'\"/>\n"
      "<meta name=\"viewport\" content=\"width=device-width\"/>\n<title>{} {}</title>\n<style>{}</style>\n"
      "</head>\n",
      policy_hash(style), escaped(report.title), escaped(report.id), style);
}

}  // namespace

std::string render_html(const Report& report) {
  std::string out = head(report, style_sheet(report.id));
  out += fmt::format(
      "<body>\n<div class=\"running\">Report {0}</div>\n<h1>{1}</h1>\n<p class=\"id\">Report {0}, "
      "issued {2}</p>\n",
      escaped(report.id), escaped(report.title), escaped(report.issued));
  int number = 0;
  for (const Section& section : report.sections) {
    out += fmt::format("<h2 id=\"{}\">{}. {}</h2>\n", escaped(section.key), ++number, escaped(section.title));
    for (const Block& block : section.blocks) out += std::visit(HtmlWriter{}, block);
  }
  return out + fmt::format("<p class=\"end\">End of report {}</p>\n</body>\n</html>\n", escaped(report.id));
}

}  // namespace strobe::lab_report
