#include "host/report/html/style.hpp"

#include <fmt/format.h>

namespace strobe::lab_report {

namespace {

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
p { margin: 1.5mm 0; }
.id { font-size: 10.5pt; margin: 0 0 5mm 0; color: #333; }
.strong { font-weight: bold; }
table { border-collapse: collapse; width: 100%; margin: 1.5mm 0 1mm 0; font-size: 8pt; line-height: 1.3; }
thead { display: table-header-group; break-after: avoid; }
caption { text-align: left; font-weight: bold; font-size: 9pt; padding: 2mm 0 1mm 0; caption-side: top; }
th { text-align: right; vertical-align: bottom; font-weight: bold; border-bottom: 0.3mm solid #555; padding: 0.6mm 1mm; }
th .unit { font-weight: normal; color: #555; display: block; }
td { padding: 0.5mm 1mm; vertical-align: top; text-align: right; white-space: nowrap; }
th.words, td.words { text-align: left; white-space: normal; overflow-wrap: anywhere; }
th.short, td.short { white-space: nowrap; }
table.wide { font-size: 7pt; }
table.wide th, table.wide td { padding-left: 0.5mm; padding-right: 0.5mm; }
tr { break-inside: avoid; }
tr.follows { break-before: avoid; }
tr.begins td { border-top: 0.2mm solid #bbb; }
tr.beside td { color: #5a5a5a; font-style: italic; }
.note { font-size: 8pt; color: #444; margin: 0.5mm 0; }
table.facts { margin: 1mm 0 2mm 0; font-size: 9pt; }
table.facts td { text-align: left; white-space: normal; border-bottom: 0.15mm solid #e3e3e3; padding: 0.7mm 1mm; }
table.facts td.label { width: 48mm; color: #444; }
table.facts td.value { overflow-wrap: anywhere; }
.missing { color: #9a3412; font-style: italic; }
figure { margin: 3mm 0; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; }
figcaption { font-size: 8.5pt; margin-bottom: 1mm; }
figcaption .title { font-weight: bold; }
pre { font: 7pt/1.3 "DejaVu Sans Mono", monospace; white-space: pre-wrap; overflow-wrap: anywhere; background: #f6f6f6;
      padding: 2mm; margin: 1mm 0; }
table.shot { margin: 0; border-top: 0.2mm solid #bbb; }
table.shot td { text-align: left; white-space: normal; padding: 1mm 0; }
.shot .title { font-weight: bold; font-size: 9pt; margin: 0 0 1mm 0; }
.shot.rejected .title { color: #9a3412; }
table.card { margin: 0; }
table.card td.picture { width: 118mm; padding: 0 3mm 0 0; }
table.card td.picture img { width: 118mm; height: auto; display: block; }
table.card td.numbers { padding: 0; }
.shot table.facts { font-size: 7.5pt; margin: 0; }
.shot table.facts td { padding: 0.25mm 0.8mm; }
.shot table.facts td.label { width: auto; }
.shot table.facts td.value { text-align: right; white-space: nowrap; }
table.signature { margin-top: 14mm; }
table.signature td { text-align: left; border-top: 0.3mm solid #333; padding: 1mm; white-space: normal; font-size: 8.5pt; }
table.signature td.gap { border: none; width: 8mm; }
.end { text-align: center; margin: 8mm 0 2mm 0; font-weight: bold; break-inside: avoid; }
)";

}  // namespace

std::string style_sheet(std::string_view id) {
  return fmt::format(fmt::runtime(kPages), id) + std::string(kLook);
}

}  // namespace strobe::lab_report
