// Means with their uncertainties, in the thesis's tables: incoming ball, rebounding ball, parameters, for
// each spin; and what the uncertainties are made of.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/reduction/running_statistics.hpp"
#include "host/report/sections.hpp"
#include "host/series/compare.hpp"
#include "host/series/select.hpp"
#include "host/view/series_view.hpp"

namespace strobe::report {

namespace {

using host::BudgetLine;
using reduction::Quantity;
using C = thesis::Condition;

struct Kind {
  const char* key;
  const char* title;
  int offset;  ///< of the thesis's table after the spin's first
  std::vector<Quantity> quantities;
  int C::*n;
};

std::vector<Kind> kinds(bool all) {
  std::vector<Kind> out{{"incoming",
                         "Incoming ball",
                         0,
                         {Quantity::theta_in_deg, Quantity::vx_td_mps, Quantity::vy_td_mps,
                          Quantity::v_td_mps, Quantity::omega_td_radps},
                         &C::n_incoming},
                        {"rebounding",
                         "Rebounding ball",
                         3,
                         {Quantity::theta_out_deg, Quantity::vx_lo_mps, Quantity::vy_lo_mps,
                          Quantity::v_lo_mps, Quantity::omega_lo_radps},
                         &C::n_rebound},
                        {"parameters",
                         "Parameters of the impact",
                         6,
                         {Quantity::e, Quantity::mu, Quantity::dwell_time_ms, Quantity::dwell_distance_cm},
                         &C::n_system}};
  if (all) out[2].quantities.insert(out[2].quantities.end(), {Quantity::slip_lo_mps, Quantity::court_pace});
  return out;
}

/// Tables 2, 3 and 4 are no spin, topspin and backspin.
int first_table(const std::string& spin) { return spin == "top" ? 3 : spin == "back" ? 4 : 2; }

Cell thesis_cell(const C& condition, Quantity q) {
  const auto printed = host::thesis_number(condition, q);
  if (!printed) return "-";
  return {fmt::format("{:.2f} ± {:.2f}", printed->mean, printed->sd), printed->mean};
}

/// In the thesis's replicate sd.
Cell difference_cell(const ConditionGroup& group, Quantity q) {
  const auto printed = host::thesis_number(*group.thesis, q);
  if (!printed || group.of(q).n == 0 || !(printed->sd > 0.0)) return "-";
  const double difference = (group.of(q).mean - printed->mean) / printed->sd;
  const bool none = std::abs(difference) < 0.05;  // no sign
  return {none ? "0.0 sd" : fmt::format("{:+.1f} sd", difference), difference};
}

void add_rows(Table& table, const ConditionGroup& group, const Kind& kind) {
  const auto row = [&](const char* what, Cell n, bool begins, bool beside, auto cell_of) {
    Row out{{begins ? group.label : "", what, std::move(n)}, begins, beside};
    for (const Quantity q : kind.quantities) out.cells.push_back(cell_of(q));
    table.rows.push_back(std::move(out));
  };
  row("mean ± U", count_cell(group.summary.counted), true, false,
      [&](Quantity q) { return expanded_cell(group.of(q)); });
  row("scatter sd", "", false, false, [&](Quantity q) { return sd_cell(group.of(q).scatter_sd); });
  if (!group.thesis) return;
  row("thesis, mean ± sd", count_cell(group.thesis->*kind.n), false, true,
      [&](Quantity q) { return thesis_cell(*group.thesis, q); });
  row("difference", "", false, true, [&](Quantity q) { return difference_cell(group, q); });
}

/// Of the conditions of one spin.
Table table_of(const std::vector<const ConditionGroup*>& groups, const Kind& kind, int number) {
  const std::string& phrase = groups.front()->spin_phrase;
  Table table{fmt::format("{}_{}", kind.key, number),
              fmt::format("{}{}{}", kind.title, phrase.empty() ? "" : ", ", phrase),
              {text_column("condition"), text_column("what", ""), number_column("n")}};
  for (const Quantity q : kind.quantities) table.columns.push_back(quantity_column(q));
  for (const ConditionGroup* group : groups) add_rows(table, *group, kind);
  if (std::ranges::any_of(groups, [](const ConditionGroup* group) { return group->thesis != nullptr; }))
    table.title +=
        fmt::format(" (beside the thesis's Table {})", first_table(groups.front()->spin) + kind.offset);
  return table;
}

/// Expanded over total standard uncertainty.
Cell coverage_cell(const host::QuantitySummary& s) {
  if (!s.expanded_uncertainty || !s.total_sd || !(*s.total_sd > 0.0)) return "-";
  const double k = *s.expanded_uncertainty / *s.total_sd;
  return {fmt::format("{:.2f}", k), k};
}

Table uncertainty_table(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  Table table{
      "uncertainty_" + group.key,
      "Expanded uncertainties: " + group.label,
      {text_column("quantity"), text_column("unit"), number_column("n"), number_column("mean"),
       number_column("scatter_sd", "scatter", "sd"), number_column("standard_error", "of the mean", "sd"),
       number_column("shared_sd", "shared part", "sd"), number_column("total_sd", "combined", "u"),
       number_column("degrees_of_freedom", "degrees of freedom"),
       number_column("coverage_factor", "coverage factor", "k"),
       number_column("expanded_uncertainty", "expanded", "U")}};
  for (const Quantity q : quantities) {
    const host::QuantitySummary& s = group.of(q);
    if (s.n == 0) continue;
    const bool has_freedom = s.degrees_of_freedom || s.total_sd;
    table.rows.push_back(
        {{label_of(q).words, label_of(q).unit, count_cell(s.n), number_cell(s.mean, s.expanded_uncertainty),
          sd_cell(s.scatter_sd), sd_cell(s.standard_error), sd_cell(s.shared_sd), sd_cell(s.total_sd),
          has_freedom ? freedom_cell(s.degrees_of_freedom) : "-", coverage_cell(s),
          sd_cell(s.expanded_uncertainty)}});
  }
  return table;
}

Table outlier_table(const Content& content) {
  Table table{.key = "outliers",
              .title = "Shots that stand apart",
              .columns = {text_column("condition"), text_column("shot"), text_column("quantity"),
                          number_column("sds", "from the others' mean", "their sd")},
              .notes = {"They count all the same: no shot is left out for what it reads."}};
  for (const ConditionGroup& group : content.conditions)
    for (const host::SeriesOutlier& o : group.summary.outliers)
      table.rows.push_back(
          {{group.label, o.shot, label_of(o.quantity).words, Cell{fmt::format("{:+.1f}", o.sds), o.sds}}});
  return table;
}

host::Series series_of(const ConditionGroup& group) {
  host::Series series;
  for (const ReportShot& each : group.counted) series.add(*each.in_series);
  return series;
}

/// Conditions of one spin and angle, each less the one before it.
Table differences_table(const Content& content, const std::vector<Quantity>& quantities) {
  Table table{.key = "differences",
              .title = "Differences of conditions with the same spin and angle",
              .columns = {text_column("less", "condition less the other"), text_column("quantity"),
                          text_column("unit"), number_column("difference", "difference ± U"),
                          text_column("decided", "told apart")},
              .notes = {"What both share, as a calibration, cancels as far as it does (B. L. Welch, 1947)."}};
  std::optional<host::Series> before;  // of the condition before, where it was compared
  for (std::size_t i = 1; i < content.conditions.size(); ++i) {
    const ConditionGroup &other = content.conditions[i - 1], &group = content.conditions[i];
    const bool alike = group.spin == other.spin && group.angle == other.angle;
    if (!alike) before.reset();
    if (!alike) continue;
    host::Series own = series_of(group);
    const host::Comparison found = host::compare(own, before ? *before : series_of(other));
    before = std::move(own);
    bool begins = true;
    for (const Quantity q : quantities) {
      const auto& d = found.of(q);
      if (!d) continue;
      table.rows.push_back(
          {{begins ? group.label + " less " + other.label : "", label_of(q).words, label_of(q).unit,
            expanded_cell(d->difference, d->expanded_uncertainty), d->decided ? "yes" : "no"},
           begins,
           false});
      begins = false;
    }
  }
  return table;
}

/// By spin, in the order of the conditions.
void add_tables(Section& section, const Content& content) {
  std::vector<std::vector<const ConditionGroup*>> spins;
  for (const ConditionGroup& group : content.conditions) {
    if (spins.empty() || spins.back().front()->spin != group.spin) spins.emplace_back();
    spins.back().push_back(&group);
  }
  for (std::size_t i = 0; i < spins.size(); ++i)
    for (const Kind& kind : kinds(content.input.all))
      section.blocks.emplace_back(table_of(spins[i], kind, static_cast<int>(i) + 1));
}

std::vector<Quantity> with_budget(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  std::vector<Quantity> out;
  for (const Quantity q : quantities)
    if (!group.of(q).budget.empty()) out.push_back(q);
  return out;
}

/// What no uncertainty is stated of, so that it is not in the combined one: what an error of it would do.
struct Omitted {
  const char* words;
  void (*change)(reduction::Frame& frame);
};

constexpr Omitted kOmitted[] = {
    {"not included: clock's rate off by 100 ppm",
     [](reduction::Frame& frame) {
       for (reduction::BallImage& image : frame.images) image.time_s *= 1.0 + 1e-4;
     }},
    {"not included: inclination off by 1°", [](reduction::Frame& frame) { frame.surface_angle_deg += 1.0; }}};

/// By how much each moves the mean of the shots that can be reduced again: a row for each.
void add_omitted(Table& table, const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  std::array<std::array<reduction::RunningStatistics, reduction::kQuantityCount>, std::size(kOmitted)> moves;
  for (const ReportShot& each : group.counted) {
    const auto frame = host::matched_frame(*each.shot);
    if (!frame) continue;
    const auto as_it_is = reduction::reduce(*frame, reduction::Estimator::best);
    if (!as_it_is) continue;
    for (std::size_t k = 0; k < moves.size(); ++k) {
      reduction::Frame other = *frame;
      kOmitted[k].change(other);
      const auto changed = reduction::reduce(other, reduction::Estimator::best);
      for (const Quantity q : quantities)
        if (changed && changed->value[q] && as_it_is->value[q])
          moves[k][static_cast<std::size_t>(q)].add(*changed->value[q] - *as_it_is->value[q]);
    }
  }
  for (std::size_t k = 0; k < moves.size(); ++k) {
    Row row{{kOmitted[k].words}, k == 0, true};
    for (const Quantity q : quantities) {
      const auto& of = moves[k][static_cast<std::size_t>(q)];
      row.cells.push_back(of.count() > 0 ? sd_cell(std::abs(of.mean())) : "-");
    }
    table.rows.push_back(std::move(row));
  }
}

/// Sources down, quantities across: the effect of each on the mean.
Table overview(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  Table table{"overview_" + group.key,
              "Effects on the means, one standard deviation: " + group.label,
              {text_column("source")}};
  std::vector<std::string> sources;
  for (const Quantity q : quantities) {
    table.columns.push_back(quantity_column(q));
    for (const BudgetLine& line : group.of(q).budget)
      if (std::ranges::find(sources, line.source) == sources.end()) sources.push_back(line.source);
  }
  for (const std::string& source : sources) {
    Row row{{source}};
    for (const Quantity q : quantities) {
      const auto& budget = group.of(q).budget;
      const auto line = std::ranges::find(budget, source, &BudgetLine::source);
      row.cells.push_back(line == budget.end() ? "-" : sd_cell(line->effect));
    }
    table.rows.push_back(std::move(row));
  }
  Row total{{"combined"}, true, false};
  for (const Quantity q : quantities) total.cells.push_back(sd_cell(group.of(q).total_sd));
  table.rows.push_back(std::move(total));
  add_omitted(table, group, quantities);
  return table;
}

Row budget_row(const BudgetLine& line, std::string quantity, bool begins) {
  const auto digits = [](double number, int count) {
    return Cell{fmt::format("{:.{}g}", number, count), number};
  };
  return {
      {std::move(quantity), line.source, line.type == host::EvaluationType::a ? "A" : "B",
       line.shared ? "yes" : "no", line.input_sd > 0.0 ? digits(line.input_sd, 2) : "-", line.input_unit,
       line.sensitivity ? digits(*line.sensitivity, 3) : "-", sd_cell(line.effect),
       Cell{fmt::format("{:.1f} %", 100.0 * line.share), line.share}, freedom_cell(line.degrees_of_freedom)},
      begins,
      false};
}

Table detailed(const ConditionGroup& group, const std::vector<Quantity>& quantities) {
  Table table{"budget_" + group.key,
              "Budget of each quantity: " + group.label,
              {text_column("quantity"), text_column("source"), text_column("type"), text_column("shared"),
               number_column("input_sd", "sd of the source"), text_column("input_unit", "its unit"),
               number_column("sensitivity"), number_column("effect", "effect", "sd"),
               number_column("share", "share of variance"),
               number_column("degrees_of_freedom", "degrees of freedom")}};
  for (const Quantity q : quantities) {
    bool first = true;
    for (const BudgetLine& line : group.of(q).budget) {
      table.rows.push_back(budget_row(line, first ? axis_name(q) : "", first));
      first = false;
    }
  }
  return table;
}

}  // namespace

Section results(const Content& content) {
  Section section{"results", "Results"};
  if (content.conditions.empty()) {
    section.blocks.emplace_back(Paragraph{"none", "No shot was fired."});
    return section;
  }
  section.blocks.emplace_back(
      Paragraph{"meaning",
                "U is the expanded uncertainty of the mean: the half width of an interval that holds the "
                "quantity's true mean with a probability of 95 %, everything known to be uncertain included "
                "(JCGM 100:2008). Scatter sd: of single shots about their mean. Angles, speeds and spins are "
                "those when the ball's centre is one radius above the surface; x along the surface in the "
                "direction of travel, y up from it, backspin positive."});
  for (const ConditionGroup& group : content.conditions)
    if (!group.summary.until_known.empty())
      section.blocks.emplace_back(Paragraph{
          "until_known_" + group.key, group.label + ": " + host::sequential_words(group.summary) + "."});
  add_tables(section, content);
  const auto quantities = quantities_of(content.input);
  for (const ConditionGroup& group : content.conditions)
    if (!group.counted.empty()) section.blocks.emplace_back(uncertainty_table(group, quantities));
  Table differences = differences_table(content, quantities);
  if (!differences.rows.empty()) section.blocks.emplace_back(std::move(differences));
  Table outliers = outlier_table(content);
  if (!outliers.rows.empty()) section.blocks.emplace_back(std::move(outliers));
  return section;
}

Section budgets(const Content& content) {
  Section section{"budgets", "Uncertainty budgets"};
  const bool details = content.input.all || content.conditions.size() == 1;
  for (const ConditionGroup& group : content.conditions) {
    const auto quantities = with_budget(group, quantities_of(content.input));
    if (quantities.empty()) continue;
    section.blocks.emplace_back(overview(group, quantities));
    if (details) section.blocks.emplace_back(detailed(group, quantities));
  }
  if (section.blocks.empty()) {
    section.blocks.emplace_back(
        Paragraph{"none", "No shot counts: there is nothing to state an uncertainty of."});
  } else {
    section.blocks.insert(
        section.blocks.begin(),
        Paragraph{
            "meaning",
            "Type A: evaluated from scatter; type B: by other means. Shared: the same for all shots "
            "with this rig, ball and calibration, so that more shots do not make it smaller. Not included "
            "are the rate of the rig's clock and the inclination of the surface, of which no uncertainty is "
            "stated: the last rows say what an error of them would do to each mean."});
  }
  return section;
}

}  // namespace strobe::report
