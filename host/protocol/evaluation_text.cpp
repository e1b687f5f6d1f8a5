#include "host/protocol/evaluation_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "host/protocol/formula_check.hpp"
#include "host/session/shot_table.hpp"
#include "host/text/text.hpp"

namespace strobe::protocol {
namespace {

using Lines = std::vector<std::string>;

constexpr std::size_t kWidth = 100;
constexpr std::size_t kBudgetLines = 3;

std::string plural(int count, std::string_view what) {
  return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

/// A paragraph under a heading, its lines broken and set in.
void add(Lines& lines, const std::string& heading, const Lines& sentences) {
  if (sentences.empty()) return;
  lines.push_back("");
  lines.push_back(heading);
  for (const std::string& sentence : sentences)
    for (const std::string& line : host::wrapped(sentence, kWidth - 2)) lines.push_back("  " + line);
}

std::string with_unit(const std::string& text, const std::string& unit) {
  return unit.empty() ? text : text + " " + unit;
}

std::string source_text(const ProtocolSource& source) {
  const std::string_view read = source.read == SourceRead::whole ? "The document was read."
                                : source.read == SourceRead::summary
                                    ? "Its numbers were read as others state them: "
                                    : "It was not read, and verdicts are withheld: ";
  return fmt::format("{}{}. {}{}", source.document, source.edition.empty() ? "" : ", " + source.edition, read,
                     source.where);
}

/// "v_td_mps (speed in, m/s)"; of an input its name.
std::string quantity_text(const std::string& name) {
  const auto q = quantity_of(name);
  if (!q) return name;
  const host::QuantityLabel& label = host::kQuantityLabels[static_cast<std::size_t>(*q)];
  return fmt::format("{} ({}{}{})", name, label.words, label.unit.empty() ? "" : ", ", label.unit);
}

Lines course_text(const Protocol& p) {
  Lines lines;
  const int balls = p.balls, positions = static_cast<int>(p.positions.size());
  const std::string ball = p.ball_kind.empty() ? "ball" : p.ball_kind + " ball";
  lines.push_back(fmt::format(
      "{}, each {} times at {}: {} that count.", plural(balls, ball), p.repeats,
      positions == 1 ? "one position" : fmt::format("each of the positions {}", fmt::join(p.positions, ", ")),
      plural(balls * positions * p.repeats, "shot")));
  lines.push_back(p.impact.kind == ImpactKind::dropped
                      ? fmt::format("The ball is dropped, its lowest point {} m above the surface.",
                                    p.impact.drop_height_m)
                      : fmt::format("The ball is thrown at {} m/s, {} degrees to the surface, {}.",
                                    p.impact.speed_mps, p.impact.angle_deg,
                                    p.impact.spin_radps == 0.0
                                        ? "without spin"
                                        : fmt::format("with a spin of {} rad/s", p.impact.spin_radps)));
  if (p.discarded > 0)
    lines.push_back(fmt::format("The first {} of each ball condition it, and do not count.",
                                plural(p.discarded, "impact")));
  if (p.balls > 1)
    lines.push_back(p.drawn_order ? "The order of the balls at each position is drawn by the run's seed."
                                  : "The balls come in the order of their numbers.");
  for (const Conformance& c : p.conforms)
    lines.push_back(fmt::format("A shot counts if {} is {}.", quantity_text(c.quantity), words(c.allowed)));
  lines.push_back(
      fmt::format("A shot that does not, or that gives no readout, is fired again; at most {} in all.",
                  plural(p.replacements, "shot")));
  return lines;
}

Lines inputs_text(const Protocol& p) {
  Lines lines;
  for (const Input& input : p.inputs) {
    std::string line = fmt::format("{}: {}", input.name, with_unit(input.words + ",", input.unit));
    if (line.back() == ',') line.pop_back();
    if (std::isfinite(input.allowed.low) || std::isfinite(input.allowed.high))
      line += ", " + words(input.allowed);
    line += fmt::format("; standard uncertainty {}", input.sd);
    if (input.value) line += fmt::format("; {} unless noted", *input.value);
    lines.push_back(line + ".");
  }
  return lines;
}

Lines computed_text(const Protocol& p) {
  Lines lines;
  for (const Computed& c : p.computed)
    lines.push_back(fmt::format("{} = {}   ({}, {}{}{})", c.name, c.formula.text, c.words,
                                c.level == Level::test ? "of the " : "of each ", name(c.level),
                                c.unit.empty() ? "" : ", in " + c.unit));
  return lines;
}

const Computed& number_asked_for(const Protocol& p, const std::string& name) {
  return *std::ranges::find(p.computed, name, &Computed::name);
}

std::string requirement_text(const Protocol& p, const Requirement& r) {
  const Computed& c = number_asked_for(p, r.name);
  std::string text = fmt::format(
      "{} ({})", c.words, c.level == Level::test ? "of the test" : fmt::format("of each {}", name(c.level)));
  if (!r.clause.empty()) text += ", " + r.clause;
  if (r.categories.empty()) {
    text += ": must be " + with_unit(words(r.limits), c.unit) + ". ";
  } else {
    Lines categories;
    for (const Category& one : r.categories) categories.push_back(one.name + " " + words(one.range));
    text += fmt::format(": {}. ", fmt::join(categories, "; "));
  }
  if (r.rule == DecisionRule::simple) return text + "Decided by the value alone; the risk is told.";
  if (!r.categories.empty())
    return text + fmt::format(
                      "A category is stated where it is right with a probability of at least {} %; else the "
                      "result is inconclusive.",
                      100.0 * (1.0 - r.risk));
  return text + fmt::format(
                    "It passes or fails where that is wrong with a probability of at most {} %; else the "
                    "result is inconclusive.",
                    100.0 * r.risk);
}

std::string place_text(const Cell& cell) { return cell.position.empty() ? "" : ", " + words(cell); }

std::string value_text(const Protocol& p, const Value& value) {
  const Computed& c = number_asked_for(p, value.name);
  std::string text = fmt::format("{}{}: {}", c.words, place_text(value.cell),
                                 value.sd > 0.0 ? host::rounded(value.value, value.expanded) + " ± " +
                                                      host::rounded(value.expanded, value.expanded)
                                                : fmt::format("{:.6g}", value.value));
  text = with_unit(text, c.unit);
  if (value.degrees_of_freedom)
    text += fmt::format(" ({:.3g} degrees of freedom)", *value.degrees_of_freedom);
  Lines parts;
  for (std::size_t i = 0; i < std::min(kBudgetLines, value.budget.size()); ++i)
    parts.push_back(fmt::format("{} {:.0f} %", value.budget[i].source, 100.0 * value.budget[i].share));
  return parts.empty() ? text : fmt::format("{}: {}", text, fmt::join(parts, ", "));
}

/// Shots that all meet a requirement are one line.
Lines verdicts_text(const Protocol& p, const Evaluation& e) {
  Lines lines;
  for (const Requirement& r : p.requirements) {
    int passed = 0;
    for (const Verdict& v : e.verdicts) {
      if (v.requirement != r.name) continue;
      if (!v.shot.empty() && v.outcome == Outcome::pass && v.category.empty()) {
        ++passed;
        continue;
      }
      std::string line = fmt::format("{}: {}: {}", number_asked_for(p, r.name).words,
                                     v.category.empty() ? std::string(name(v.outcome)) : v.category, v.why);
      if (v.risk) line += "; risk " + percent(*v.risk);
      lines.push_back(std::move(line));
    }
    if (passed > 0)
      lines.push_back(fmt::format("{}: pass: {}, must be {}", number_asked_for(p, r.name).words,
                                  plural(passed, "shot"), words(r.limits)));
  }
  return lines;
}

}  // namespace

std::vector<std::string> explanation(const Protocol& p) {
  Lines lines{p.title + " (" + p.name + ")"};
  add(lines, "Follows", {source_text(p.source)});
  add(lines, "Shots", course_text(p));
  add(lines, "To be noted with the shots (strobe fire --note NAME=VALUE)", inputs_text(p));
  add(lines, "Before the first shot", p.preparation);
  add(lines, "Computed, each with its uncertainty", computed_text(p));
  Lines decided;
  for (const Requirement& r : p.requirements) decided.push_back(requirement_text(p, r));
  if (p.source.read == SourceRead::not_read)
    decided = {"Nothing: " + p.source.document + " was not read by those who wrote this protocol."};
  else if (decided.empty())
    decided = {"Nothing: values are told with their uncertainty."};
  add(lines, "Decided", decided);
  add(lines, "Not measured here", p.not_measured);
  if (!p.report.empty()) add(lines, "The report says", {p.report});
  return lines;
}

std::vector<std::string> text(const Protocol& p, const Evaluation& e) {
  Lines lines;
  add(lines, p.title, {fmt::format("{}: {}", name(e.outcome), e.why)});
  lines.erase(lines.begin());
  add(lines, "Requirements", verdicts_text(p, e));
  Lines values, left;
  for (const Value& value : e.values)
    if (value.shot.empty()) values.push_back(value_text(p, value));
  add(lines, "Values ± U (95 %), and the largest parts of their variance", values);
  for (const UsedShot& shot : e.shots)
    if (shot.use != Use::counts) left.push_back(fmt::format("shot {}: {}", shot.shot, shot.why));
  add(lines, "Shots that do not count", left);
  left.clear();
  for (const Block& block : e.blocks) left.push_back(block.words);
  add(lines, "Left to fire", left);
  return lines;
}

}  // namespace strobe::protocol
