// What was foretold of the session, beside what it became.
#include <fmt/format.h>

#include "host/design/promise.hpp"
#include "host/report/sections.hpp"
#include "host/text/text.hpp"

namespace strobe::report {

namespace {

Cell promised_cell(double number, double promised) { return {host::rounded(number, promised), number}; }

Row promised_row(const ConditionGroup& group, const host::Kept& k) {
  const auto& label = host::kQuantityLabels[static_cast<std::size_t>(k.quantity)];
  std::string missed;
  if (k.scatter_missed) missed = "scatters more than chance allows";
  if (k.sd_missed) append(missed, "shots are less certain", "; ");
  return {{group.label, label.words, label.unit, promised_cell(k.promised_sd, k.promised_sd),
           promised_cell(k.shot_sd, k.promised_sd), promised_cell(k.promised_scatter, k.promised_scatter),
           promised_cell(k.scatter, k.promised_scatter),
           promised_cell(k.promised_expanded, k.promised_expanded),
           promised_cell(k.expanded, k.promised_expanded), missed.empty() ? "kept" : missed}};
}

}  // namespace

Section promises(const Content& content) {
  Section section{"promises", "Promised and achieved"};
  for (const auto& [session, key] : content.sessions()) {
    const auto promise = host::promise_of(session->folder);
    if (!promise) {
      section.blocks.emplace_back(Paragraph{"unread" + key, promise.error().message, true});
      continue;
    }
    if (!*promise) continue;
    Table table{"promises" + key,
                "What was foretold before the first shot, and what it became",
                {{"condition", "Condition", "", false},
                 {"quantity", "Quantity", "", false},
                 {"unit", "Unit", "", false},
                 {"promised_shot_sd", "u of one shot, promised", ""},
                 {"shot_sd", "became", ""},
                 {"promised_scatter_sd", "scatter, promised", ""},
                 {"scatter_sd", "became", ""},
                 {"promised_expanded", "mean ± 95 %, promised", ""},
                 {"expanded", "became", ""},
                 {"verdict", "Verdict", "", false}}};
    for (const ConditionGroup& group : content.conditions) {
      std::vector<host::Shot> shots;
      for (const ReportShot& each : group.counted) shots.push_back(*each.in_series);
      for (const host::Kept& k : host::kept(**promise, group.summary, shots))
        table.rows.push_back(promised_row(group, k));
    }
    table.notes.push_back(
        fmt::format("A promise is missed where shots scatter as chance makes them in fewer than one of "
                    "{:.0f} series, or state an "
                    "uncertainty more than {:.0f} % larger.",
                    1.0 / host::kPromiseLevel, 100.0 * (host::kPromiseMargin - 1.0)));
    section.blocks.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace strobe::report
