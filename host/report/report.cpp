#include "host/report/report.hpp"

#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>

#include "common/config/files.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/report/hashes.hpp"
#include "host/report/sections.hpp"

namespace strobe::report {

namespace {

using nlohmann::ordered_json;

ordered_json number(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? ordered_json(*value) : ordered_json();
}

ordered_json number(double value) { return number(std::optional(value)); }

ordered_json fact_json(const Fact& fact) {
  ordered_json out{{"label", fact.label}, {"text", fact.text}};
  if (fact.number) out["number"] = number(fact.number);
  if (!fact.stated) out["stated"] = false;
  return out;
}

ordered_json facts_json(const std::vector<Fact>& facts) {
  ordered_json out = ordered_json::object();
  for (const Fact& fact : facts) out[fact.key] = fact_json(fact);
  return out;
}

ordered_json table_json(const Table& table) {
  ordered_json columns = ordered_json::array(), rows = ordered_json::array();
  for (const Column& column : table.columns)
    columns.push_back({{"key", column.key}, {"head", column.head}, {"unit", column.unit}});
  for (const Row& row : table.rows) {
    ordered_json cells = ordered_json::object();
    for (std::size_t i = 0; i < row.cells.size() && i < table.columns.size(); ++i) {
      const Cell& cell = row.cells[i];
      ordered_json& out = cells[table.columns[i].key];
      out["text"] = cell.text;
      if (cell.number) out["number"] = number(cell.number);
    }
    if (row.beside) cells["beside"] = true;
    rows.push_back(std::move(cells));
  }
  return {{"title", table.title}, {"columns", columns}, {"rows", rows}, {"notes", table.notes}};
}

ordered_json axis_json(const std::string& label, const figures::Axis& axis) {
  ordered_json ticks = ordered_json::array();
  for (const figures::Tick& tick : axis.ticks)
    ticks.push_back({{"at", number(tick.at)}, {"text", tick.text}});
  return {{"label", label}, {"low", number(axis.low)}, {"high", number(axis.high)}, {"ticks", ticks}};
}

ordered_json series_json(const figures::Series& series) {
  ordered_json points = ordered_json::array();
  for (const figures::PlotPoint& p : series.points) {
    ordered_json point = ordered_json::array({number(p.x), number(p.y)});
    if (std::isfinite(p.low) || std::isfinite(p.high))
      point.insert(point.end(), {number(p.low), number(p.high)});
    points.push_back(std::move(point));
  }
  return {{"name", series.name}, {"legend", series.legend}, {"points", points}};
}

ordered_json chart_json(const Chart& chart) {
  ordered_json panels = ordered_json::array();
  for (const figures::ChartPanel& panel : chart.panels) {
    ordered_json series = ordered_json::array();
    for (const figures::Series& each : panel.panel.series) series.push_back(series_json(each));
    panels.push_back({{"title", panel.panel.title},
                      {"x", axis_json(panel.panel.x_label, panel.x)},
                      {"y", axis_json(panel.panel.y_label, panel.y)},
                      {"series", series}});
  }
  return {{"title", chart.title}, {"caption", chart.caption}, {"panels", panels}};
}

ordered_json shot_json(const ShotCard& shot) {
  ordered_json out{{"title", shot.title},
                   {"counts", shot.counts},
                   {"facts", facts_json(shot.facts)},
                   {"remarks", shot.remarks}};
  if (!shot.picture) return out["no_picture"] = shot.no_picture, out;
  out["picture"] = {{"width_px", shot.picture->width_px},
                    {"height_px", shot.picture->height_px},
                    {"jpeg_base64", base64(shot.picture->jpeg)}};
  return out;
}

/// Puts each block where its kind's are.
struct JsonWriter {
  ordered_json& section;

  void operator()(const Facts& facts) const {
    for (const Fact& fact : facts.facts) section["facts"][facts.key][fact.key] = fact_json(fact);
    if (!facts.title.empty()) section["titles"][facts.key] = facts.title;
  }
  void operator()(const Table& table) const { section["tables"][table.key] = table_json(table); }
  void operator()(const Chart& chart) const { section["charts"][chart.key] = chart_json(chart); }
  void operator()(const Paragraph& p) const { section["texts"][p.key] = p.text; }
  void operator()(const Listing& listing) const {
    section["files"][listing.key] = {{"title", listing.title}, {"text", listing.text}};
  }
  void operator()(const ShotCard& shot) const { section["shots"][shot.key] = shot_json(shot); }
  void operator()(const Signature& signature) const {
    section["signatures"][signature.key] = facts_json(signature.lines);
  }
};

ordered_json sections_json(const Report& report) {
  ordered_json sections = ordered_json::object();
  int count = 0;
  for (const Section& section : report.sections) {
    ordered_json out{{"number", ++count}, {"title", section.title}};
    for (const Block& block : section.blocks) std::visit(JsonWriter{out}, block);
    sections[section.key] = std::move(out);
  }
  return sections;
}

/// The id that follows from all else: the same content has the same one.
std::string identify(const Report& report) { return sha256_hex(report_json(report)).substr(0, 16); }

}  // namespace

Report build_report(const ReportInput& input) {
  assert(!input.sessions.empty());
  const Content content = content_of(input);
  Report report;
  report.title = content.stated("title");
  if (report.title.empty()) report.title = "Report on the impact of a ball on a surface";
  report.issued = content.stated("issued");
  if (report.issued.empty()) report.issued = content.last_day;
  report.sections.push_back(identification(content, report.issued));
  if (Section tested = test_by_protocol(content); !tested.blocks.empty())
    report.sections.push_back(std::move(tested));
  report.sections.push_back(conformity(content));
  report.sections.push_back(results(content));
  report.sections.push_back(method(content));
  report.sections.push_back(set_up(content));
  report.sections.push_back(commissioning(content));
  report.sections.push_back(figures(content));
  if (Section contact = contact_figures(content); !contact.blocks.empty())
    report.sections.push_back(std::move(contact));
  if (Section promised = promises(content); !promised.blocks.empty())
    report.sections.push_back(std::move(promised));
  report.sections.push_back(witnesses(content));
  report.sections.push_back(shots(content));
  report.sections.push_back(photographs(content));
  report.sections.push_back(budgets(content));
  report.sections.push_back(timing(content));
  report.sections.push_back(records(content));
  report.sections.push_back(clauses(report.sections));
  report.id = identify(report);
  return report;
}

std::string report_json(const Report& report) {
  ordered_json out;
  out["report"] = {{"id", report.id}, {"title", report.title}, {"issued", report.issued}};
  out["sections"] = sections_json(report);
  return messages::json_text(out);
}

std::optional<thesis::ThesisInputs> shipped_thesis() {
  const auto share = config::share_folder();
  if (!share) return std::nullopt;
  auto inputs = thesis::load_inputs(*share / "thesis", thesis::Version::corrected, "");
  return inputs ? std::optional(*std::move(inputs)) : std::nullopt;
}

}  // namespace strobe::report
