#include "host/view/series_view.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>

#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

using reduction::kQuantityCount;
using reduction::Quantity;
using Lines = std::vector<std::string>;

bool is_row_of(Quantity q, bool all) { return all || is_essential(q); }

std::string label_cells(Quantity q) {
  const QuantityLabel& label = kQuantityLabels[static_cast<std::size_t>(q)];
  return left(label.words, kNameWidth) + left(label.unit, kUnitWidth);
}

std::string cell(const std::optional<double>& number, double uncertainty) {
  return right(number ? rounded(*number, uncertainty) : "-", kNumberWidth);
}

std::string header(std::initializer_list<std::string_view> names) {
  std::string line = left("", kNameWidth) + left("unit", kUnitWidth);
  for (const std::string_view name : names) line += right(name, kNumberWidth);
  return line;
}

/// What the numbers of a row are rounded by.
double digits_of(const QuantitySummary& s) {
  return s.total_sd.value_or(s.shared_known && s.shared_sd > 0.0 ? s.shared_sd
                                                                 : s.standard_error.value_or(0.0));
}

std::string summary_row(const QuantitySummary& s, Quantity q) {
  const double total = digits_of(s);
  const auto shared = s.shared_known ? std::optional(s.shared_sd) : std::nullopt;
  return label_cells(q) + cell(s.mean, total) + cell(s.expanded_uncertainty, total) +
         cell(s.total_sd, total) + cell(s.scatter_sd, total) + cell(s.standard_error, total) +
         cell(shared, total) + right(std::to_string(s.n), 5);
}

void add_outliers(const SeriesSummary& summary, Lines& lines) {
  for (const SeriesOutlier& o : summary.outliers) {
    lines.push_back(fmt::format("! shot {} stands apart in {}: {:+.1f} sd of the others; it counts", o.shot,
                                kQuantityLabels[static_cast<std::size_t>(o.quantity)].words, o.sds));
  }
  if (!summary.outliers.empty())
    lines.push_back(fmt::format("  (Grubbs's test, {:.0f} % for each quantity)", 100.0 * kOutlierLevel));
}

/// The most frequent one first.
void add_culprits(const SeriesSummary& summary, std::size_t width, Lines& lines) {
  std::vector<std::pair<int, std::string>> names;
  int shots = 0;
  for (const auto& [name, times] : summary.culprits) {
    names.emplace_back(times, name);
    shots += times;
  }
  if (shots == 0) return;
  std::ranges::stable_sort(names, std::ranges::greater{}, [](const auto& each) { return each.first; });
  std::string words = fmt::format("! {} aborted for lateness",
                                  shots == 1 ? "1 shot was" : fmt::format("{} shots were", shots));
  for (const auto& [times, name] : names)
    words += fmt::format("{} {} {}", &name == &names.front().second ? ":" : ",", name, times);
  for (std::string& line : wrapped(words, width)) lines.push_back(std::move(line));
}

std::string shots_words(const SeriesSummary& summary) {
  std::string words = fmt::format("{} {} counted", summary.counted, summary.counted == 1 ? "shot" : "shots");
  if (summary.rejected > 0) words += fmt::format(", {} rejected", summary.rejected);
  return words;
}

std::string more_words(const QuantityDifference& d) {
  constexpr int kMax = 10000;  // nobody fires more
  if (!d.more_first) return d.asked > 0.0 ? "no number" : "-";
  if (*d.more_first == 0 && *d.more_second == 0) return "enough";
  if (std::max(*d.more_first, *d.more_second) > kMax) return "more than 10,000";
  const std::string most = d.of_each->most > kMax ? "more than 10,000" : fmt::format("{}", d.of_each->most);
  return fmt::format("{} + {} ({} to {})", *d.more_first, *d.more_second, d.of_each->fewest, most);
}

/// What the further shots are counted for, and how sure their number is.
std::string asked_words(const Comparison& comparison) {
  std::string words;
  double power = kPower;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto& d = comparison.quantities[i];
    if (d) power = d->power;
    if (!d || !d->is_asked) continue;
    const QuantityLabel& label = kQuantityLabels[i];
    words += fmt::format("{}{:g}{}{} in {}", words.empty() ? "" : ", ", d->asked,
                         label.unit.empty() ? "" : " ", label.unit, label.words);
  }
  words += words.empty() ? "the difference found" : "; in others the difference found";
  return fmt::format(
      "(further shots: to find {}, with a probability of {:g} %; in brackets how many of each in all, 95 %, "
      "as "
      "the scatter is known by few)",
      words, 100.0 * power);
}

std::string agreement_words(const reduction::DrawnNumber& d) {
  switch (d.agrees) {
    case reduction::Agreement::yes:
      return d.digits == 2 ? "yes, to two digits" : "yes, to one digit";
    case reduction::Agreement::no:
      return "NO";
    default:
      return "too few draws to tell";
  }
}

}  // namespace

std::string sequential_words(const SeriesSummary& summary) {
  return fmt::format(
      "--until-known {} decided how many shots there are: ± 95 % is wider than Student's by as much as such "
      "looking asks for",
      summary.until_known);
}

std::vector<std::string> alignment_words(const SeriesSummary& summary) {
  std::vector<std::string> sentences;
  const auto add = [&](const OutOfPlane& of, std::string_view what, std::string_view unit,
                       std::string_view advice) {
    if (of.shots < 2 || 2 * of.shots < summary.counted) return;
    sentences.push_back(fmt::format("{} of {} shots {} {:.2g} {} on average: {}", of.shots, summary.counted,
                                    what, of.sum / of.shots, unit, advice));
  };
  add(summary.tilted, "have a spin axis off the camera's, by", "deg",
      "square up the machine's wheels, or the camera, unless such a spin is meant");
  add(summary.leaving, "leave the photograph's plane, towards the camera with", "m/s",
      "turn the machine, or the camera, unless such a path is meant");
  return sentences;
}

bool is_essential(Quantity q) { return q != Quantity::slip_lo_mps && q != Quantity::court_pace; }

Lines render_summary(const SeriesSummary& summary, const std::optional<thesis::Condition>& condition,
                     std::size_t width, bool all) {
  const std::string name = summary.name.empty() ? "series" : summary.name;
  if (summary.counted == 0) {
    const std::string why =
        summary.rejected > 0 ? fmt::format(": {} rejected", summary.rejected) : std::string(" yet");
    Lines lines{fmt::format("{}: no shot counted{}", name, why)};
    add_culprits(summary, width, lines);
    return fitted(std::move(lines), width);
  }
  Lines lines{name + ": " + shots_words(summary)};
  lines.push_back(header({"mean", "± 95 %", "total sd", "scatter", "std error", "shared"}) + right("n", 5) +
                  (condition ? " " + thesis_title(*condition) : ""));
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const QuantitySummary& s = summary.quantities[i];
    if (s.n == 0 || !(is_row_of(q, all) || q == Quantity::court_pace)) continue;
    lines.push_back(summary_row(s, q) + (condition ? thesis_cells(*condition, q, s.mean) : ""));
  }
  const auto unknown = [](const QuantitySummary& s) { return s.n > 0 && !s.shared_known; };
  if (std::ranges::any_of(summary.quantities, unknown))
    lines.push_back("(a shot came without its uncertainty budget: what the shots share is not known)");
  if (summary.counted == 1)
    lines.push_back("(one shot has no scatter: what it says of itself is above; a series needs two)");
  if (!summary.until_known.empty())
    for (std::string& line : wrapped("(" + sequential_words(summary) + ")", width)) lines.push_back(line);
  add_culprits(summary, width, lines);
  add_outliers(summary, lines);
  for (const std::string& sentence : alignment_words(summary))
    for (std::string& line : wrapped("! " + sentence, width)) lines.push_back(std::move(line));
  return fitted(std::move(lines), width);
}

Lines render_budget(const std::string& title, const std::vector<BudgetLine>& budget, Quantity q,
                    std::size_t width) {
  const QuantityLabel& label = kQuantityLabels[static_cast<std::size_t>(q)];
  const std::string unit(label.unit.empty() ? "1" : label.unit);
  Lines lines{fmt::format("{}: uncertainty of {}, {}", title, label.words, unit),
              left("source", 30) + "type" + right("input sd", 14) + right("sensitivity", 16) +
                  right("effect", 12) + right("share", 9) + right("freedom", 9) + "  shared"};
  double variance = 0.0;
  for (const BudgetLine& line : budget) {
    variance += line.effect * line.effect;
    const std::string input =
        line.input_sd > 0.0 ? fmt::format("{:.3g} {}", line.input_sd, line.input_unit) : "";
    const std::string sensitivity =
        line.sensitivity ? fmt::format("{:+.3g}/{}", *line.sensitivity, line.input_unit) : "";
    lines.push_back(left(line.source, 30) + left(line.type == EvaluationType::a ? " A" : " B", 4) +
                    right(input, 14) + right(sensitivity, 16) +
                    right(fmt::format("{:.2g}", line.effect), 12) +
                    right(fmt::format("{:.1f} %", 100.0 * line.share), 9) +
                    right(line.degrees_of_freedom ? fmt::format("{:.1f}", *line.degrees_of_freedom) : "", 9) +
                    (line.shared ? "  yes" : ""));
  }
  lines.push_back(left("total", 64) + right(fmt::format("{:.2g}", std::sqrt(variance)), 12));
  return fitted(std::move(lines), width);
}

Lines render_comparison(const std::string& first, const std::string& second, const Comparison& comparison,
                        std::size_t width, bool all) {
  Lines lines{fmt::format("{} less {}", first, second),
              header({"difference", "± 95 %", "total sd", "std error", "shared", "p"}) + "  further shots"};
  bool any = false;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& d = comparison.of(q);
    if (!d || !is_row_of(q, all)) continue;
    any = true;
    lines.push_back(label_cells(q) + cell(d->difference, d->total_sd) +
                    cell(d->expanded_uncertainty, d->total_sd) + cell(d->total_sd, d->total_sd) +
                    cell(d->standard_error, d->total_sd) + cell(d->shared_sd, d->total_sd) +
                    right(fmt::format("{:.2g}", d->p_value), kNumberWidth) + "  " + left(more_words(*d), 22) +
                    (d->decided ? "differs" : "not decided"));
  }
  if (!any)
    return fitted({fmt::format("{} less {}: two counted shots of each are needed", first, second)}, width);
  for (std::string& line : wrapped(asked_words(comparison), width)) lines.push_back(std::move(line));
  return fitted(std::move(lines), width);
}

Lines render_monte_carlo(const reduction::MonteCarlo& drawn, const std::string& shot, std::size_t width,
                         bool all) {
  Lines lines{fmt::format("shot {}: {} draws, seed {}", shot, drawn.draws, drawn.seed),
              header({"mean", "sd", "2.5 %", "97.5 %", "tolerance"}) + "  stated interval holds"};
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    const auto& d = drawn.of(q);
    if (!d || !is_row_of(q, all)) continue;
    lines.push_back(label_cells(q) + cell(d->mean, d->sd) + cell(d->sd, d->sd) + cell(d->low, d->sd) +
                    cell(d->high, d->sd) + right(fmt::format("{:.1g}", d->tolerance), kNumberWidth) + "  " +
                    agreement_words(*d));
  }
  return fitted(std::move(lines), width);
}

namespace {

/// The thesis's column of each quantity, in the order of Quantity; null: it has none.
using C = thesis::Condition;
constexpr std::array<thesis::MeanSd C::*, reduction::kQuantityCount> kThesisColumns{&C::theta_in_deg,
                                                                                    &C::theta_out_deg,
                                                                                    &C::vx_td_mps,
                                                                                    &C::vy_td_mps,
                                                                                    &C::v_td_mps,
                                                                                    &C::omega_td_radps,
                                                                                    &C::vx_lo_mps,
                                                                                    &C::vy_lo_mps,
                                                                                    &C::v_lo_mps,
                                                                                    &C::omega_lo_radps,
                                                                                    nullptr,
                                                                                    &C::e,
                                                                                    &C::mu,
                                                                                    &C::dwell_time_ms,
                                                                                    &C::dwell_distance_cm,
                                                                                    nullptr};

/// Tables 2-4 hold the incoming, 5-7 the rebounding ball, 8-10 the parameters; one each for zero, top, back
/// spin.
int first_table(const thesis::Condition& c) { return c.spin == "top" ? 3 : c.spin == "back" ? 4 : 2; }

}  // namespace

std::string thesis_title(const thesis::Condition& condition) {
  const int table = first_table(condition);
  return fmt::format("thesis {} {}, Tables {}, {}, {}", condition.spin, condition.angle_label_deg, table,
                     table + 3, table + 6);
}

std::optional<thesis::MeanSd> thesis_number(const thesis::Condition& condition, reduction::Quantity q) {
  const auto column = kThesisColumns[static_cast<std::size_t>(q)];
  return column ? std::optional(condition.*column) : std::nullopt;
}

std::string thesis_cells(const thesis::Condition& condition, reduction::Quantity q,
                         const std::optional<double>& mean) {
  const auto printed = thesis_number(condition, q);
  if (!printed) return "";
  std::string cells = right(fmt::format("{:.2f}", printed->mean), kNumberWidth) +
                      right(fmt::format("± {:.2f}", printed->sd), kNumberWidth);
  if (mean && printed->sd > 0.0)
    cells += right(fmt::format("{:+.1f} sd", (*mean - printed->mean) / printed->sd), 10);
  return cells;
}

}  // namespace strobe::host
