// Who, for whom, what, when, how; and where what ISO/IEC 17025 asks of a report stands in this one.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "host/report/sections.hpp"

namespace strobe::report {

namespace {

/// What the shots' records say under a key: each text once, in the order of the shots.
std::string recorded(const Content& content, const std::string& key) {
  std::set<std::string> seen;
  std::string out;
  for (const ReportShot& each : content.shots) {
    const auto& record = each.shot->readout.record;
    const auto found = record.find(key);
    if (found == record.end() || found->second.empty() || !seen.insert(found->second).second) continue;
    append(out, found->second, "; ");
  }
  return out;
}

std::string joined(std::initializer_list<std::pair<const char*, std::string>> parts) {
  std::string out;
  for (const auto& [words, text] : parts)
    if (!text.empty()) append(out, std::string(words) + " " + text, "; ");
  return out;
}

std::string stated_or(const Content& content, const std::string& id, const std::string& otherwise) {
  const std::string text = content.stated(id);
  return text.empty() ? otherwise : text;
}

/// Who the records name, else who started the runs.
std::string operators(const Content& content) {
  const std::string named = stated_or(content, "tested_by", recorded(content, "operator"));
  if (!named.empty()) return named;
  std::set<std::string> seen;
  std::string out;
  for (const auto& session : content.input.sessions)
    for (const auto& run : session.runs)
      if (!run.operator_name.empty() && seen.insert(run.operator_name).second)
        append(out, run.operator_name, "; ");
  return out;
}

std::string days(const Content& content) {
  if (content.first_day == content.last_day) return content.first_day;
  return content.first_day + " to " + content.last_day;
}

std::string environment(const Content& content) {
  const std::string temperature = recorded(content, "temperature_c");
  return stated_or(content, "conditions", temperature.empty() ? "" : "temperature " + temperature + " °C");
}

std::string item(const Content& content) {
  const std::string recorded_item = joined(
      {{"ball:", joined({{"", recorded(content, "ball_name")}, {"grade", recorded(content, "ball_grade")}})},
       {"surface:",
        joined({{"", recorded(content, "surface_name")}, {"grade", recorded(content, "surface_grade")}})}});
  const std::string stated = content.stated("item");
  if (stated.empty()) return recorded_item;
  return recorded_item.empty() ? stated : stated + "; " + recorded_item;
}

std::string in_short(const Content& content) {
  const auto counted = std::ranges::count(content.shots, true, &ReportShot::counts);
  std::string text =
      fmt::format("{} of {} shots counted, in {} {}.", counted, content.shots.size(),
                  content.conditions.size(), content.conditions.size() == 1 ? "condition" : "conditions");
  text += std::ranges::all_of(content.input.sessions, &host::StoredSession::verified)
              ? " All messages are sealed with the laboratory's key."
              : " Nothing proves that all messages are the laboratory's: not all are sealed with its key.";
  return text;
}

std::string flights(const Content& content) {
  std::map<std::string, int> methods;
  for (const ReportShot& each : content.shots)
    if (each.counts) ++methods[each.shot->readout.method];
  std::string out;
  for (const auto& [method, count] : methods) append(out, fmt::format("{} ({} shots)", method, count));
  return out.empty() ? "none" : out;
}

/// What the session itself shows to be other than planned.
std::vector<std::string> seen_deviations(const Content& content) {
  std::vector<std::string> out;
  int by_hand = 0, rejected = 0;
  for (const ReportShot& each : content.shots) {
    if (!each.shot->digitizations.empty() && each.shot->digitizations.back().by_hand) ++by_hand;
    if (!each.counts) ++rejected;
  }
  if (by_hand > 0)
    out.push_back(fmt::format("{} of {} photographs were measured or corrected by hand.", by_hand,
                              content.shots.size()));
  if (rejected > 0)
    out.push_back(fmt::format("{} of {} shots do not count; the reasons are given with the shots.", rejected,
                              content.shots.size()));
  for (const auto& session : content.input.sessions) {
    for (const host::Instrument& instrument : session.rig.instruments)
      if (is_overdue(instrument, content))
        out.push_back(fmt::format("The calibration of {} was due on {}.", instrument.name, instrument.due));
    for (const std::string& remark : session.remarks) out.push_back(remark);
  }
  return out;
}

struct Clause {
  const char* number;
  const char* asks;
  const char* section;  ///< key
  const char* where;    ///< in it
};

constexpr Clause kClauses[] = {
    {"7.8.1.2", "what is needed to interpret the results", "set_up",
     "rig, camera, instruments with certificates"},
    {"7.8.2.1 a", "title", "", "head of the report"},
    {"7.8.2.1 b", "name and address of the laboratory", "identification", "laboratory, address"},
    {"7.8.2.1 c", "place of the laboratory's activities", "identification", "place of the tests"},
    {"7.8.2.1 d", "unique identification on each page, end", "", "foot of each page, end mark"},
    {"7.8.2.1 e", "name and contact of the customer", "identification", "customer"},
    {"7.8.2.1 f", "method", "method", "method, principle"},
    {"7.8.2.1 g", "item: description, identification, condition", "identification", "item tested"},
    {"7.8.2.1 h", "dates of receipt and sampling", "identification", "date of receipt"},
    {"7.8.2.1 i", "dates of the tests", "identification", "dates of the tests"},
    {"7.8.2.1 j", "date of issue", "identification", "date of issue"},
    {"7.8.2.1 k", "sampling plan and method", "identification", "sampling"},
    {"7.8.2.1 l", "results relate only to the items tested", "identification", "statement"},
    {"7.8.2.1 m", "results with units", "results", "tables"},
    {"7.8.2.1 n", "deviations, additions, exclusions", "method", "deviations"},
    {"7.8.2.1 o", "who authorises the report", "identification", "signature"},
    {"7.8.2.1 p", "results of external providers", "", "none: all results are of this session"},
    {"7.8.3.1 a", "test conditions", "identification", "environmental conditions"},
    {"7.8.3.1 b", "statement of conformity", "conformity", "tables"},
    {"7.8.3.1 c", "measurement uncertainty", "results", "U; budgets in their own section"},
    {"7.8.6.1", "decision rule and its risk", "conformity", "decision rule"},
    {"7.8.6.2", "results, specifications and rule of the statement", "conformity", "tables"},
};

std::string place(const Clause& clause, const std::vector<Section>& sections) {
  for (std::size_t i = 0; i < sections.size(); ++i)
    if (sections[i].key == clause.section) return fmt::format("section {}: {}", i + 1, clause.where);
  return clause.where;
}

/// Each once, section by section.
std::string unstated(const std::vector<Section>& sections) {
  std::string out;
  for (std::size_t i = 0; i < sections.size(); ++i) {
    std::vector<std::string> labels;
    const auto look = [&](const std::vector<Fact>& facts) {
      for (const Fact& fact : facts)
        if (!fact.stated && std::find(labels.begin(), labels.end(), fact.label) == labels.end())
          labels.push_back(fact.label);
    };
    for (const Block& block : sections[i].blocks) {
      if (const auto* facts = std::get_if<Facts>(&block)) look(facts->facts);
      if (const auto* signature = std::get_if<Signature>(&block)) look(signature->lines);
    }
    if (!labels.empty()) append(out, fmt::format("section {}: {}", i + 1, fmt::join(labels, ", ")), "; ");
  }
  return out;
}

}  // namespace

Section identification(const Content& content, const std::string& issued) {
  Section section{"identification", "Identification"};
  const auto stated = [&](const char* id, const char* label) {
    return stated_fact(id, label, content.stated(id));
  };
  section.blocks.emplace_back(
      Facts{"who",
            "",
            {stated("laboratory", "Laboratory"), stated("address", "Address"), stated("contact", "Contact"),
             stated("location", "Place of the tests"), stated("accreditation", "Accreditation"),
             stated("customer", "Customer"), stated("customer_contact", "Customer's contact")}});
  section.blocks.emplace_back(Facts{
      "what",
      "",
      {stated_fact("item", "Item tested", item(content)), stated("item_condition", "Condition of the item"),
       stated("sampling", "Sampling"), stated("received", "Date of receipt"),
       stated_fact("tested", "Dates of the tests", days(content)),
       stated_fact("issued", "Date of issue", issued),
       stated_fact("operator", "Operator", operators(content)),
       stated_fact("environment", "Environmental conditions", environment(content)),
       stated("remarks", "Remarks")}});
  section.blocks.emplace_back(Paragraph{"in_short", in_short(content)});
  section.blocks.emplace_back(
      Paragraph{"scope",
                "The results relate only to the items tested, as they were received. This report shall not "
                "be reproduced except in full without the laboratory's approval."});
  Fact by = stated("authorised_by", "Authorised by");
  if (const std::string role = content.stated("authorised_role"); by.stated && !role.empty())
    by.text += ", " + role;
  section.blocks.emplace_back(Signature{"authorisation", {by, fact("signature", "Signature and date", "")}});
  return section;
}

Section method(const Content& content) {
  Section section{"method", "Method"};
  Facts facts{"method", "", {}};
  facts.facts = {
      stated_fact("method", "Method", content.stated("method")),
      fact("principle", "Principle",
           "Stroboscopic photographs of the ball before, in and after contact; times of the flashes by "
           "sensors; least squares over all images of both legs, with gravity, drag and lift where they "
           "matter. Thesis on the impact dynamics of a tennis ball striking a hard surface (Oregon State "
           "University); documentation of strobe " +
               content.input.version + ", reduction."),
      fact("estimator", "Estimator", flights(content)),
      fact("uncertainty", "Uncertainty",
           "JCGM 100:2008 (GUM). What all shots share (scale, ball, air, calibration) does not become "
           "smaller with their number; degrees of freedom by Welch and Satterthwaite; coverage 95 %."),
      stated_fact("deviations", "Deviations from the method", content.stated("deviations"))};
  section.blocks.emplace_back(std::move(facts));
  int number = 0;
  for (std::string& words : seen_deviations(content))
    section.blocks.emplace_back(Paragraph{fmt::format("deviation_{}", ++number), std::move(words)});
  return section;
}

Section clauses(const std::vector<Section>& before) {
  Table table{"clauses",
              "",
              {text_column("clause"), text_column("asks", "asks for"), text_column("where", "stands in")}};
  for (const Clause& clause : kClauses)
    table.rows.push_back({{clause.number, clause.asks, place(clause, before)}});
  const std::string missing = unstated(before);
  return {"clauses",
          "What ISO/IEC 17025:2017, 7.8, asks for",
          {std::move(table), Paragraph{"not_stated", missing.empty() ? "Nothing is left unstated."
                                                                     : "Not stated: " + missing + "."}}};
}

}  // namespace strobe::report
