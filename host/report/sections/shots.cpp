// Each shot in numbers.
#include <fmt/format.h>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"
#include "host/session/shot.hpp"

namespace strobe::lab_report {

namespace {

using reduction::Quantity;

constexpr Quantity kColumns[] = {Quantity::theta_in_deg,
                                 Quantity::v_td_mps,
                                 Quantity::omega_td_radps,
                                 Quantity::theta_out_deg,
                                 Quantity::v_lo_mps,
                                 Quantity::omega_lo_radps,
                                 Quantity::e,
                                 Quantity::mu,
                                 Quantity::dwell_time_ms};

std::vector<Quantity> shot_quantities(bool all) {
  if (!all) return {std::begin(kColumns), std::end(kColumns)};
  std::vector<Quantity> out;
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) out.push_back(static_cast<Quantity>(i));
  return out;
}

Table numbers_table(const Content& content, const ConditionGroup& group) {
  Table table{
      "numbers_" + group.key,
      "Shots: " + group.label,
      {{"shot", "shot", "", false}, {"utc", "time (UTC)", "", false}, {"counts", "counts", "", false}},
      {},
      {}};
  const auto quantities = shot_quantities(content.input.all);
  for (const Quantity q : quantities) {
    const host::QuantityLabel& label = label_of(q);
    table.columns.push_back(
        {std::string(reduction::name(q)), std::string(label.words), std::string(label.unit)});
  }
  for (const ReportShot& each : group.shots) {
    const auto& readout = each.shot->readout;
    Row row{{text_cell(each.name), text_cell(each.shot->utc), text_cell(each.counts ? "yes" : "no")},
            false,
            !each.counts};
    for (const Quantity q : quantities) row.cells.push_back(number_cell(readout.value[q], readout.sd[q]));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table rejected_table(const Content& content) {
  Table table{
      "rejected",
      "Shots that do not count",
      {{"shot", "shot", "", false}, {"condition", "condition", "", false}, {"reason", "reason", "", false}},
      {},
      {}};
  for (const ConditionGroup& group : content.conditions)
    for (const ReportShot& each : group.shots) {
      if (each.counts) continue;
      const auto& result = *each.shot;
      std::string why = result.rejected.value_or(result.dry ? "a dry shot, without photograph" : "");
      if (why.empty()) why = each.shot->summary ? "no number could be read" : "strobed ended during the shot";
      if (!result.problem.empty() && result.problem != why) why += "; " + result.problem;
      table.rows.push_back({{text_cell(each.name), text_cell(group.label), text_cell(why)}});
    }
  return table;
}

Table flags_table(const Content& content) {
  Table table{"flags",
              "Flags",
              {{"flag", "flag", "", false}, {"words", "meaning", "", false}, {"shots", "shots", "", false}},
              {},
              {}};
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    std::string names;
    for (const ReportShot& each : content.shots)
      if (each.shot->readout.flags.has(flag)) names += (names.empty() ? "" : ", ") + each.name;
    if (!names.empty())
      table.rows.push_back({{text_cell(std::string(reduction::name(flag))),
                             text_cell(std::string(host::words(flag))), text_cell(names)}});
  }
  return table;
}

}  // namespace

Section shots(const Content& content) {
  Section section{"shots", "Shots", {}};
  for (const ConditionGroup& group : content.conditions)
    section.blocks.emplace_back(numbers_table(content, group));
  Table rejected = rejected_table(content);
  if (rejected.rows.empty()) {
    section.blocks.emplace_back(Paragraph{"none_rejected", "All shots count."});
  } else {
    section.blocks.emplace_back(std::move(rejected));
  }
  if (Table flags = flags_table(content); !flags.rows.empty()) section.blocks.emplace_back(std::move(flags));
  return section;
}

}  // namespace strobe::lab_report
