// Means with their uncertainties, in the thesis's tables: incoming ball, rebounding ball, parameters, for each spin.
#include <fmt/format.h>

#include <array>
#include <cmath>

#include "host/report/sections/parts.hpp"
#include "host/report/sections/sections.hpp"

namespace strobe::lab_report {

namespace {

using reduction::Quantity;
using C = thesis::Condition;

struct Shown {
  Quantity quantity;
  thesis::MeanSd C::*printed;  ///< null: the thesis has it not
};

struct Kind {
  const char* key;
  const char* title;
  int offset;  ///< of the thesis's table after the spin's first
  std::vector<Shown> quantities;
  int C::*n;
};

std::vector<Kind> kinds(bool all) {
  std::vector<Kind> out{{"incoming",
                         "Incoming ball",
                         0,
                         {{Quantity::theta_in_deg, &C::theta_in_deg},
                          {Quantity::vx_td_mps, &C::vx_td_mps},
                          {Quantity::vy_td_mps, &C::vy_td_mps},
                          {Quantity::v_td_mps, &C::v_td_mps},
                          {Quantity::omega_td_radps, &C::omega_td_radps}},
                         &C::n_incoming},
                        {"rebounding",
                         "Rebounding ball",
                         3,
                         {{Quantity::theta_out_deg, &C::theta_out_deg},
                          {Quantity::vx_lo_mps, &C::vx_lo_mps},
                          {Quantity::vy_lo_mps, &C::vy_lo_mps},
                          {Quantity::v_lo_mps, &C::v_lo_mps},
                          {Quantity::omega_lo_radps, &C::omega_lo_radps}},
                         &C::n_rebound},
                        {"parameters",
                         "Parameters of the impact",
                         6,
                         {{Quantity::e, &C::e},
                          {Quantity::mu, &C::mu},
                          {Quantity::dwell_time_ms, &C::dwell_time_ms},
                          {Quantity::dwell_distance_cm, &C::dwell_distance_cm}},
                         &C::n_system}};
  if (all)
    out[2].quantities.insert(out[2].quantities.end(),
                             {{Quantity::slip_lo_mps, nullptr}, {Quantity::court_pace, nullptr}});
  return out;
}

/// Tables 2, 3 and 4 are no spin, topspin and backspin.
int first_table(const std::string& spin) { return spin == "top" ? 3 : spin == "back" ? 4 : 2; }

Cell thesis_cell(const C& c, const Shown& shown) {
  if (!shown.printed) return {"-", {}};
  const thesis::MeanSd& printed = c.*shown.printed;
  return {fmt::format("{:.2f} ± {:.2f}", printed.mean, printed.sd), printed.mean};
}

/// In the thesis's replicate sd.
Cell difference_cell(const ConditionGroup& group, const Shown& shown) {
  const host::QuantitySummary& s = group.of(shown.quantity);
  if (!shown.printed || s.n == 0) return {"-", {}};
  const thesis::MeanSd& printed = group.thesis->*shown.printed;
  if (!(printed.sd > 0.0)) return {"-", {}};
  const double difference = (s.mean - printed.mean) / printed.sd;
  const bool none = std::abs(difference) < 0.05;  // no sign
  return {none ? "0.0 sd" : fmt::format("{:+.1f} sd", difference), difference};
}

void add_rows(Table& table, const ConditionGroup& group, const Kind& kind) {
  const auto row = [&](std::string what, Cell n, bool begins, bool beside, auto cell_of) {
    Row out{{text_cell(begins ? group.label : ""), text_cell(std::move(what)), std::move(n)}, begins, beside};
    for (const Shown& shown : kind.quantities) out.cells.push_back(cell_of(shown));
    table.rows.push_back(std::move(out));
  };
  row("mean ± U", count_cell(group.summary.counted), true, false,
      [&](const Shown& shown) { return expanded_cell(group.of(shown.quantity)); });
  row("scatter sd", text_cell(""), false, false,
      [&](const Shown& shown) { return sd_cell(group.of(shown.quantity).scatter_sd); });
  if (!group.thesis) return;
  row("thesis, mean ± sd", count_cell(group.thesis->*kind.n), false, true,
      [&](const Shown& shown) { return thesis_cell(*group.thesis, shown); });
  row("difference", text_cell(""), false, true,
      [&](const Shown& shown) { return difference_cell(group, shown); });
}

Table table_of(const std::vector<const ConditionGroup*>& groups, const Kind& kind, const std::string& spin,
               const std::string& spin_words, int number) {
  Table table{fmt::format("{}_{}", kind.key, number),
              fmt::format("{}{}{}", kind.title, spin_words.empty() ? "" : ", ", spin_words),
              {{"condition", "condition", "", false}, {"what", "", "", false}, {"n", "n", ""}},
              {},
              {}};
  for (const Shown& shown : kind.quantities) {
    const host::QuantityLabel& label = label_of(shown.quantity);
    table.columns.push_back(
        {std::string(reduction::name(shown.quantity)), std::string(label.words), std::string(label.unit)});
  }
  bool beside = false;
  for (const ConditionGroup* group : groups) {
    add_rows(table, *group, kind);
    beside = beside || group->thesis;
  }
  if (beside) table.title += fmt::format(" (beside the thesis's Table {})", first_table(spin) + kind.offset);
  return table;
}

Table uncertainty_table(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  Table table{"uncertainty_" + group.key,
              "Expanded uncertainties: " + group.label,
              {{"quantity", "quantity", "", false},
               {"unit", "unit", "", false},
               {"n", "n", ""},
               {"mean", "mean", ""},
               {"scatter_sd", "scatter", "sd"},
               {"standard_error", "of the mean", "sd"},
               {"shared_sd", "shared part", "sd"},
               {"total_sd", "combined", "u"},
               {"degrees_of_freedom", "degrees of freedom", ""},
               {"coverage_factor", "coverage factor", "k"},
               {"expanded_uncertainty", "expanded", "U"}},
              {},
              {}};
  for (const Quantity q : quantities) {
    const host::QuantitySummary& s = group.of(q);
    if (s.n == 0) continue;
    const host::QuantityLabel& label = label_of(q);
    const auto k = coverage_factor(s);
    const Cell freedom = s.degrees_of_freedom && *s.degrees_of_freedom < 1e4
                             ? Cell{fmt::format("{:.1f}", *s.degrees_of_freedom), s.degrees_of_freedom}
                             : Cell{s.total_sd ? "∞" : "-", {}};
    table.rows.push_back(
        {{text_cell(std::string(label.words)), text_cell(std::string(label.unit)), count_cell(s.n),
          number_cell(s.mean, s.expanded_uncertainty), sd_cell(s.scatter_sd), sd_cell(s.standard_error),
          sd_cell(s.shared_sd), sd_cell(s.total_sd), freedom,
          k ? Cell{fmt::format("{:.2f}", *k), k} : Cell{"-", {}}, sd_cell(s.expanded_uncertainty)}});
  }
  return table;
}

Table outlier_table(const Content& content) {
  Table table{"outliers",
              "Shots that stand apart",
              {{"condition", "condition", "", false},
               {"shot", "shot", "", false},
               {"quantity", "quantity", "", false},
               {"sds", "from the others' mean", "their sd"}},
              {},
              {"They count all the same: no shot is left out for what it reads."}};
  for (const ConditionGroup& group : content.conditions)
    for (const host::SeriesOutlier& o : group.summary.outliers)
      table.rows.push_back(
          {{text_cell(group.label), text_cell(o.shot), text_cell(std::string(label_of(o.quantity).words)),
            Cell{fmt::format("{:+.1f}", o.sds), o.sds}}});
  return table;
}

void add_tables(Section& section, const Content& content) {
  std::vector<std::string> spins;
  for (const ConditionGroup& group : content.conditions)
    if (std::find(spins.begin(), spins.end(), group.spin) == spins.end()) spins.push_back(group.spin);
  int number = 0;
  for (const std::string& spin : spins) {
    std::vector<const ConditionGroup*> groups;
    for (const ConditionGroup& group : content.conditions)
      if (group.spin == spin) groups.push_back(&group);
    ++number;
    const bool known = spin == "zero" || spin == "top" || spin == "back";
    const std::string spin_words = known ? std::string(thesis::spin_phrase(spin)) : spin;
    for (const Kind& kind : kinds(content.input.all))
      section.blocks.emplace_back(table_of(groups, kind, spin, spin_words, number));
  }
}

}  // namespace

Section results(const Content& content) {
  Section section{"results", "Results", {}};
  if (content.conditions.empty()) {
    section.blocks.emplace_back(Paragraph{"none", "No shot was fired."});
    return section;
  }
  section.blocks.emplace_back(
      Paragraph{"meaning",
                "U is the expanded uncertainty of the mean: the half width of an interval that holds the "
                "quantity's true mean with a "
                "probability of 95 %, everything known to be uncertain included (JCGM 100:2008). Scatter sd: "
                "of single shots about "
                "their mean. Angles, speeds and spins are those when the ball's centre is one radius above "
                "the surface; x along the "
                "surface in the direction of travel, y up from it, backspin positive."});
  add_tables(section, content);
  const auto quantities = quantities_of(content.input);
  for (const ConditionGroup& group : content.conditions)
    if (!group.counted.empty()) section.blocks.emplace_back(uncertainty_table(group, quantities));
  Table outliers = outlier_table(content);
  if (!outliers.rows.empty()) section.blocks.emplace_back(std::move(outliers));
  return section;
}

}  // namespace strobe::lab_report
