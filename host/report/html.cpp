// A report as HTML.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "host/figures/escape.hpp"
#include "host/figures/svg.hpp"
#include "host/report/hashes.hpp"
#include "host/report/report.hpp"

namespace strobe::report {

namespace {

using figures::escaped;

constexpr std::string_view kPages = R"(
@page {{
  size: A4; margin: 16mm 15mm 18mm 15mm;
  @bottom-left {{ content: "Report {0}"; font: 8pt sans-serif; color: #444; }}
  @bottom-right {{ content: "page " counter(page) " of " counter(pages); font: 8pt sans-serif; color: #444; }}
}}
@media screen {{ body {{ max-width: 190mm; margin: 8mm auto; padding: 0 6mm; }} .running {{ display: none; }} }}
@media print {{
  .running {{ display: none; }}
  /* Browsers without margin boxes: the report's name at the foot of each page; they number pages themselves. */
  @supports (-moz-appearance: none) {{
    .running {{ display: block; position: fixed; bottom: 0; left: 0; font-size: 8pt; color: #444; }}
  }}
}}
)";

constexpr std::string_view kLook = R"(
body { font: 9.5pt/1.4 "DejaVu Sans", "Helvetica Neue", Arial, sans-serif; color: #1a1a1a; background: #fff; }
h1 { font-size: 17pt; line-height: 1.2; margin: 0 0 1mm 0; }
h2 { font-size: 12.5pt; margin: 8mm 0 2mm 0; padding-bottom: 0.8mm; border-bottom: 0.4mm solid #1f4e79; color: #1f4e79;
     break-after: avoid; }
h3 { font-size: 10.5pt; margin: 5mm 0 1.5mm 0; break-after: avoid; }
p { margin: 1.5mm 0; orphans: 3; widows: 3; }
p.lead { break-after: avoid; }
.id { font-size: 10.5pt; margin: 0 0 5mm 0; color: #333; }
.strong { font-weight: bold; }
table { border-collapse: collapse; width: 100%; margin: 1.5mm 0 1mm 0; font-size: 8pt; line-height: 1.3; }
thead { display: table-header-group; break-after: avoid; }
caption { break-after: avoid; text-align: left; font-weight: bold; font-size: 9pt; padding: 2mm 0 1mm 0; caption-side: top; }
th { text-align: right; vertical-align: bottom; font-weight: bold; border-bottom: 0.3mm solid #555; padding: 0.6mm 1mm; }
th .unit { font-weight: normal; color: #555; display: block; }
td { padding: 0.5mm 1mm; vertical-align: top; text-align: right; white-space: nowrap; }
th.words, td.words { text-align: left; white-space: normal; overflow-wrap: anywhere; }
th.short, td.short { white-space: nowrap; }
td.hash { white-space: nowrap; font-size: 6.5pt; }
table.wide { font-size: 7pt; }
table.wide th, table.wide td { padding-left: 0.5mm; padding-right: 0.5mm; }
tr { break-inside: avoid; }
table.short, table.facts, tbody.group { break-inside: avoid; }
.note { break-before: avoid; }
tr.begins td { border-top: 0.2mm solid #bbb; }
tr.beside td { color: #5a5a5a; font-style: italic; }
.note { font-size: 8pt; color: #444; margin: 0.5mm 0; }
table.facts { margin: 1mm 0 2mm 0; font-size: 9pt; }
table.facts td { text-align: left; white-space: normal; border-bottom: 0.15mm solid #e3e3e3; padding: 0.7mm 1mm; }
table.facts td.label { width: 48mm; color: #444; }
table.facts td.value { overflow-wrap: anywhere; }
.missing { color: #9a3412; font-style: italic; }
figure { margin: 3mm 0; }
figure svg { width: 100%; height: auto; display: block; break-inside: avoid; }
figcaption { font-size: 8.5pt; margin-bottom: 1mm; break-after: avoid; }
figcaption .title { font-weight: bold; }
pre { font: 7pt/1.3 "DejaVu Sans Mono", monospace; white-space: pre-wrap; overflow-wrap: anywhere; background: #f6f6f6;
      padding: 2mm; margin: 1mm 0; }
table.shot { margin: 0; border-top: 0.2mm solid #bbb; }
table.shot td { text-align: left; white-space: normal; padding: 1mm 0; }
.shot .title { font-weight: bold; font-size: 9pt; margin: 0 0 1mm 0; }
.shot.rejected .title { color: #9a3412; }
table.card { margin: 0; }
table.card td.picture { width: 104mm; padding: 0 3mm 0 0; }
table.card td.picture img { max-width: 104mm; max-height: 66mm; width: auto; height: auto; display: block; }
table.card td.numbers { padding: 0; }
.shot table.facts { font-size: 7.5pt; margin: 0; }
.shot table.facts td { padding: 0.25mm 0.8mm; }
.shot table.facts td.label { width: auto; }
.shot table.facts td.value { text-align: right; white-space: nowrap; }
table.signature { margin-top: 14mm; }
table.signature td { text-align: left; border-top: 0.3mm solid #333; padding: 1mm; white-space: normal; font-size: 8.5pt; }
table.signature td.gap { border: none; width: 8mm; }
.end { break-before: avoid; text-align: center; margin: 8mm 0 2mm 0; font-weight: bold; break-inside: avoid; }
)";

/// Numbers printed pages and names the report on each. `id`: letters, digits and - only.
std::string style_sheet(std::string_view id) {
  return fmt::format(fmt::runtime(kPages), id) + std::string(kLook);
}

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

/// Short words stay on one line, so that columns of numbers do not squeeze them; a hash fits one in small
/// print.
const char* words_class(const std::string& text) {
  constexpr std::size_t kShort = 26, kHash = 64;
  if (text.size() == kHash && text.find(' ') == text.npos) return " class=\"words hash\"";
  return text.size() <= kShort ? " class=\"words short\"" : " class=\"words\"";
}

std::string head_of(const Column& column) {
  const std::string unit =
      column.unit.empty() ? std::string() : "<span class=\"unit\">" + escaped(column.unit) + "</span>";
  return fmt::format("<th{}>{}{}</th>", column.is_number ? "" : words_class(column.head),
                     escaped(column.head), unit);
}

std::string row_class(const Row& row) {
  std::string kind = row.begins ? "begins" : "";
  if (row.beside) kind += kind.empty() ? "beside" : " beside";
  return kind.empty() ? kind : " class=\"" + kind + "\"";
}

std::string row_of(const Table& table, const Row& row) {
  std::string out = "<tr" + row_class(row) + ">";
  for (std::size_t i = 0; i < row.cells.size() && i < table.columns.size(); ++i)
    out += fmt::format("<td{}>{}</td>", table.columns[i].is_number ? "" : words_class(row.cells[i].text),
                       escaped(row.cells[i].text));
  return out + "</tr>\n";
}

/// Rows that belong together stay on one page.
std::string body_of(const Table& table) {
  const bool in_groups = std::ranges::any_of(table.rows, &Row::begins);
  const std::string begin = in_groups ? "<tbody class=\"group\">\n" : "<tbody>\n";
  std::string out = begin;
  for (const Row& row : table.rows) {
    if (row.begins && &row != &table.rows.front()) out += "</tbody>\n" + begin;
    out += row_of(table, row);
  }
  return out + "</tbody>\n";
}

/// Short tables stay on one page, wide ones have small print.
std::string table_begin(const Table& table) {
  constexpr std::size_t kWide = 10, kShort = 10;
  std::string kind = table.columns.size() > kWide ? "wide" : "";
  if (table.rows.size() <= kShort) kind += kind.empty() ? "short" : " short";
  return kind.empty() ? "<table>\n" : "<table class=\"" + kind + "\">\n";
}

struct HtmlWriter {
  bool leads = false;  ///< the block is its section's first of several

  std::string operator()(const Facts& f) const { return heading(f.title) + facts_table(f.facts); }

  std::string operator()(const Table& table) const {
    std::string out = table_begin(table);
    if (!table.title.empty()) out += "<caption>" + escaped(table.title) + "</caption>\n";
    out += "<thead><tr>";
    for (const Column& column : table.columns) out += head_of(column);
    out += "</tr></thead>\n" + body_of(table) + "</table>\n";
    for (const std::string& note : table.notes) out += paragraph(note, "note");
    return out;
  }

  std::string operator()(const Chart& chart) const {
    return fmt::format(
        "<figure>\n<figcaption><span class=\"title\">{}</span>{}{}</figcaption>\n{}</figure>\n",
        escaped(chart.title), chart.caption.empty() ? "" : ". ", escaped(chart.caption),
        fmt::join(figures::svg_rows(chart), ""));
  }

  std::string operator()(const Paragraph& p) const {
    return paragraph(p.text, p.is_emphasized ? "strong" : leads || p.leads ? "lead" : "plain");
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
    if (!shot.drawing.empty()) out += "<figure>\n" + shot.drawing + "</figure>\n";
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
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n<meta "
      "http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src "
      "'{}'; base-uri 'none'; form-action 'none'\"/>\n<meta name=\"viewport\" "
      "content=\"width=device-width\"/>\n<title>{} {}</title>\n<style>{}</style>\n</head>\n",
      policy_hash(style), escaped(report.title), escaped(report.id), style);
}

}  // namespace

std::string render_html(const Report& report) {
  std::string out = head(report, style_sheet(report.id));
  out += fmt::format(
      "<body>\n<div class=\"running\">Report {0}</div>\n<h1>{1}</h1>\n<p class=\"id\">Report {0}, issued "
      "{2}</p>\n",
      escaped(report.id), escaped(report.title), escaped(report.issued));
  int number = 0;
  for (const Section& section : report.sections) {
    out += fmt::format("<h2 id=\"{}\">{}. {}</h2>\n", escaped(section.key), ++number, escaped(section.title));
    for (std::size_t i = 0; i < section.blocks.size(); ++i)
      out += std::visit(HtmlWriter{i == 0 && section.blocks.size() > 1}, section.blocks[i]);
  }
  return out + fmt::format("<p class=\"end\">End of report {}</p>\n</body>\n</html>\n", escaped(report.id));
}

}  // namespace strobe::report
