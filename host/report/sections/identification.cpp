// Who, for whom, what, when.
#include <fmt/format.h>

#include <set>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

/// What the shots' records say under a key: each text once, in the order of the shots.
std::string recorded(const Content& content, const std::string& key) {
  std::set<std::string> seen;
  std::string out;
  for (const ReportShot& each : content.shots) {
    const auto& record = each.shot->readout.record;
    const auto found = record.find(key);
    if (found == record.end() || found->second.empty() || !seen.insert(found->second).second) continue;
    out += (out.empty() ? "" : "; ") + found->second;
  }
  return out;
}

std::string joined(std::initializer_list<std::pair<const char*, std::string>> parts) {
  std::string out;
  for (const auto& [words, text] : parts)
    if (!text.empty()) out += (out.empty() ? "" : "; ") + std::string(words) + " " + text;
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
        out += (out.empty() ? "" : "; ") + run.operator_name;
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

Facts who(const Content& content) {
  return {"who",
          "",
          {stated_fact("laboratory", "Laboratory", content.stated("laboratory")),
           stated_fact("address", "Address", content.stated("address")),
           stated_fact("contact", "Contact", content.stated("contact")),
           stated_fact("location", "Place of the tests", content.stated("location")),
           stated_fact("accreditation", "Accreditation", content.stated("accreditation")),
           stated_fact("customer", "Customer", content.stated("customer")),
           stated_fact("customer_contact", "Customer's contact", content.stated("customer_contact"))}};
}

Facts what(const Content& content, const std::string& issued) {
  return {"what",
          "",
          {stated_fact("item", "Item tested", item(content)),
           stated_fact("item_condition", "Condition of the item", content.stated("item_condition")),
           stated_fact("sampling", "Sampling", content.stated("sampling")),
           stated_fact("received", "Date of receipt", content.stated("received")),
           stated_fact("tested", "Dates of the tests", days(content)),
           stated_fact("issued", "Date of issue", issued),
           stated_fact("operator", "Operator", operators(content)),
           stated_fact("environment", "Environmental conditions", environment(content)),
           stated_fact("remarks", "Remarks", content.stated("remarks"))}};
}

std::string in_short(const Content& content) {
  long counted = 0;
  for (const ReportShot& each : content.shots) counted += each.counts ? 1 : 0;
  std::string text =
      fmt::format("{} of {} shots counted, in {} {}.", counted, content.shots.size(),
                  content.conditions.size(), content.conditions.size() == 1 ? "condition" : "conditions");
  bool verified = true;
  for (const auto& session : content.input.sessions) verified = verified && session.verified;
  text += verified
              ? " All messages are sealed with the laboratory's key."
              : " Nothing proves that all messages are the laboratory's: not all are sealed with its key.";
  return text;
}

}  // namespace

Section identification(const Content& content, const std::string& issued) {
  Section section{"identification", "Identification", {}};
  section.blocks.emplace_back(who(content));
  section.blocks.emplace_back(what(content, issued));
  section.blocks.emplace_back(Paragraph{"in_short", in_short(content)});
  section.blocks.emplace_back(Paragraph{
      "scope",
      "The results relate only to the items tested, as they were received. This report shall not be "
      "reproduced except in full without the laboratory's approval."});
  Fact by = stated_fact("authorised_by", "Authorised by", content.stated("authorised_by"));
  if (const std::string role = content.stated("authorised_role"); by.stated && !role.empty())
    by.text += ", " + role;
  section.blocks.emplace_back(Signature{"authorisation", {by, fact("signature", "Signature and date", "")}});
  return section;
}

}  // namespace strobe::lab_report
