#include "tests/real/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "common/messages/parsed_json.hpp"

namespace strobe::real {

namespace {

using nlohmann::ordered_json;

/// An alteration at a scale, in the order in which they were asked.
using Case = std::pair<const Alteration*, double>;

std::vector<Case> cases_of(const std::vector<Outcome>& outcomes) {
  std::vector<Case> cases;
  for (const Outcome& outcome : outcomes) {
    const Case each{outcome.alteration, outcome.told};
    if (std::find(cases.begin(), cases.end(), each) == cases.end()) cases.push_back(each);
  }
  return cases;
}

const Alteration* as_is() { return &alterations().front(); }

std::string name_of(const Case& each) {
  if (each.second == 1.0) return std::string(each.first->name);
  return fmt::format("{}, told {:+.0f} %", each.first->name, 100.0 * (each.second - 1.0));
}

/// Of nothing there is none.
std::string known(double value, const char* format) {
  return std::isfinite(value) ? fmt::format(fmt::runtime(format), value) : "-";
}

std::string px(double value) { return known(value, "{:.2f}"); }

std::string figures(const Score& s) {
  return fmt::format("{:5} {:5} {:>7} {:8} {:6} {:7}", s.balls, s.found,
                     known(s.balls ? 100.0 * s.recall() : NAN, "{:.1f}%"), s.invented, s.ghosts, s.doubles);
}

double mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

void add_why(std::string& text, const Outcome& outcome) {
  const std::string place =
      fmt::format("{}, {}", name_of({outcome.alteration, outcome.told}), outcome.photograph->file);
  for (std::size_t i = 0; i < outcome.score.missed.size(); ++i) {
    const Ball& ball = outcome.score.missed[i];
    text += fmt::format("{}: missed ({:.1f}, {:.1f}) d {:.1f}: {}\n", place, ball.x, ball.y, ball.d,
                        outcome.why[i]);
  }
  for (const Stray& stray : outcome.score.strays)
    text += fmt::format("{}: {} ({:.1f}, {:.1f}) d {:.1f}\n", place, stray.what, stray.x, stray.y, stray.d);
}

ordered_json json_of(const Score& s) {
  return {{"pictures", s.pictures},
          {"balls", s.balls},
          {"found", s.found},
          {"invented", s.invented},
          {"ghosts", s.ghosts},
          {"doubles", s.doubles},
          {"centre_rms_px", rms(s.centre_px)},
          {"diameter_rms_px", rms(s.diameter_px)}};
}

ordered_json json_of(const Circle& circle) { return {{"x", circle.x}, {"y", circle.y}, {"d", circle.d}}; }

ordered_json json_of(const Outcome& outcome) {
  ordered_json line{{"photograph", outcome.photograph->file},
                    {"alteration", outcome.alteration->name},
                    {"told", outcome.told}};
  line.update(json_of(outcome.score));
  line["missed"] = line["strays"] = ordered_json::array();
  for (std::size_t i = 0; i < outcome.score.missed.size(); ++i) {
    line["missed"].push_back(json_of(outcome.score.missed[i]));
    line["missed"].back()["why"] = outcome.why[i];
  }
  for (const Stray& stray : outcome.score.strays) {
    line["strays"].push_back(json_of(stray));
    line["strays"].back()["what"] = stray.what;
  }
  return line;
}

/// The alterations at the right scale, summed, and how many balls each changes.
struct AllAltered {
  Score sum;
  std::size_t changed = 0;
};

AllAltered all_altered(const std::vector<Outcome>& outcomes) {
  AllAltered all;
  const Score before = total(outcomes, as_is());
  for (const auto& [alteration, told] : cases_of(outcomes)) {
    if (told != 1.0 || alteration == as_is()) continue;
    const Score score = total(outcomes, alteration);
    all.changed += changed(before, score);
    all.sum += score;
  }
  return all;
}

/// Those of photographs that were annotated twice, and how far these annotations are apart.
struct AnnotatedTwice {
  std::vector<Outcome> outcomes;
  Agreement people;
};

AnnotatedTwice annotated_twice(const std::vector<Outcome>& outcomes) {
  AnnotatedTwice twice;
  std::vector<Photograph> photographs;
  for (const Outcome& outcome : outcomes) {
    if (!outcome.photograph->second) continue;
    twice.outcomes.push_back(outcome);
    if (outcome.alteration == as_is() && outcome.told == 1.0) photographs.push_back(*outcome.photograph);
  }
  twice.people = agreement(photographs);
  return twice;
}

}  // namespace

std::vector<std::string> breaches(const std::vector<Outcome>& outcomes, const Bounds& bounds) {
  std::vector<std::string> all;
  const auto hold = [&](std::string_view where, const char* what, double value, double bound,
                        bool at_most = true) {
    if (at_most ? value > bound : value < bound)
      all.push_back(fmt::format("{}: {} {:.4g}, not {} {:.4g}", where, what, value,
                                at_most ? "at most" : "at least", bound));
  };
  const Score before = total(outcomes, as_is());
  for (const Case& each : cases_of(outcomes)) {
    if (each.second != 1.0) continue;
    const Score s = total(outcomes, each.first);
    const std::string_view where = each.first->name;
    hold(where, "recall", s.recall(), each.first == as_is() ? bounds.recall : bounds.altered_recall, false);
    hold(where, "invented", s.invented, bounds.invented_a_picture * s.pictures);
    hold(where, "ghosts", s.ghosts, bounds.ghosts);
    hold(where, "doubles", s.doubles, bounds.doubles);
    hold(where, "balls changed", static_cast<double>(changed(before, s)), bounds.changed * s.balls);
    hold(where, "centre rms px", rms(s.centre_px), bounds.centre_px);
    hold(where, "diameter rms px", rms(s.diameter_px), bounds.diameter_px);
  }
  const AnnotatedTwice twice = annotated_twice(outcomes);
  const Score score = total(twice.outcomes, as_is());
  hold("annotated twice", "centre rms px", rms(score.centre_px), twice.people.centre_rms_px());
  hold("annotated twice", "diameter rms px", rms(score.diameter_px), twice.people.diameter_rms_px());
  for (const Case& each : cases_of(twice.outcomes)) {
    if (each.second != 1.0) continue;
    const auto [count, of] = beyond_3_sd(total(twice.outcomes, each.first), twice.people);
    hold(each.first->name, "errors beyond 3 sd", count, bounds.beyond_3_sd * of);
  }
  return all;
}

std::string tables(const std::vector<Outcome>& outcomes, const std::vector<Photograph>& photographs,
                   bool why) {
  const auto head = [](const char* what, std::size_t width) {
    return fmt::format("{:{}} balls found  recall invented ghosts doubles", what, width);
  };
  const Score before = total(outcomes, as_is());
  const AnnotatedTwice twice = annotated_twice(outcomes);
  std::string text = head("alteration", 24) + " changed  centre  diameter px  beyond 3 sd\n";
  for (const Case& each : cases_of(outcomes)) {
    const Score s = total(outcomes, each.first, each.second);
    const auto [count, of] = beyond_3_sd(total(twice.outcomes, each.first, each.second), twice.people);
    text += fmt::format("{:24} {} {:7} {:>7}  {:>11}  {:>11}\n", name_of(each), figures(s),
                        changed(before, s), px(rms(s.centre_px)), px(rms(s.diameter_px)),
                        of ? fmt::format("{} of {}", count, of) : "-");
  }
  std::size_t width = 10;
  for (const Photograph& photograph : photographs) width = std::max(width, photograph.file.size());
  text += "\n" + head("photograph", width) + "  centre  diameter  its bias px\n";
  for (const Outcome& outcome : outcomes) {
    const Score& s = outcome.score;
    if (outcome.alteration == as_is() && outcome.told == 1.0)
      text +=
          fmt::format("{:{}} {} {:>7}  {:>8}  {:>11}\n", outcome.photograph->file, width, figures(s),
                      px(rms(s.centre_px)), px(rms(s.diameter_px)), known(mean(s.diameter_px), "{:+.2f}"));
  }
  const Agreement& people = twice.people;
  if (!people.centre_px.empty())
    text += fmt::format(
        "\nannotators: {} balls twice, {} by one only; rms between them: centre {:.2f} px, diameter {:.2f} "
        "px\n",
        people.centre_px.size(), people.only_one, people.centre_rms_px(), people.diameter_rms_px());
  if (why) {
    text += "\n";
    for (const Outcome& outcome : outcomes) add_why(text, outcome);
  }
  return text;
}

std::string json_lines(const std::vector<Outcome>& outcomes, const Bounds& bounds) {
  std::string text;
  const auto add = [&](const ordered_json& line) { text += messages::json_text(line) + "\n"; };
  for (const Outcome& outcome : outcomes) add(json_of(outcome));
  const Score before = total(outcomes, as_is());
  const AnnotatedTwice annotated = annotated_twice(outcomes);
  const Agreement& twice = annotated.people;
  for (const Case& each : cases_of(outcomes)) {
    const Score s = total(outcomes, each.first, each.second);
    ordered_json line{{"total", true}, {"alteration", each.first->name}, {"told", each.second}};
    line.update(json_of(s));
    line["changed"] = changed(before, s);
    const auto [count, of] = beyond_3_sd(total(annotated.outcomes, each.first, each.second), twice);
    line["sds_stated"] = of;
    line["beyond_3_sd"] = count;
    add(line);
  }
  add({{"annotators", true},
       {"balls", twice.centre_px.size()},
       {"centre_rms_px", twice.centre_rms_px()},
       {"diameter_rms_px", twice.diameter_rms_px()},
       {"by_one_only", twice.only_one}});
  add({{"breaches", breaches(outcomes, bounds)}});
  return text;
}

std::string leaderboard_head() {
  return "| program | balls found as they are | invented, ghosts, doubles | centre, diameter rms px | with "
         "all "
         "alterations: found | invented, ghosts, doubles a picture | balls changed |\n"
         "|---|---|---|---|---|---|---|\n";
}

std::string leaderboard_row(const std::string& name, const std::vector<Outcome>& outcomes) {
  const Score s = total(outcomes, as_is());
  const AllAltered altered = all_altered(outcomes);
  const Score& all = altered.sum;
  const auto part = [](double count, int of) { return of ? count / of : NAN; };
  const auto each = [&](int count) { return known(part(count, all.pictures), "{:.2f}"); };
  const auto percent = [&](double count, int of) { return known(100.0 * part(count, of), "{:.1f} %"); };
  return fmt::format("| {} | {} of {}, {} | {}, {}, {} | {}, {} | {} | {}, {}, {} | {} |\n", name, s.found,
                     s.balls, percent(s.found, s.balls), s.invented, s.ghosts, s.doubles,
                     px(rms(s.centre_px)), px(rms(s.diameter_px)), percent(all.found, all.balls),
                     each(all.invented), each(all.ghosts), each(all.doubles),
                     percent(static_cast<double>(altered.changed), all.balls));
}

Result<std::string> with_leaderboard(const std::string& text, const std::string& name,
                                     const std::string& table) {
  const std::string begin = "<!-- leaderboard: " + name + " -->\n";
  const std::size_t from = text.find(begin);
  const std::size_t to = from == std::string::npos ? from : text.find("<!-- end of leaderboard -->", from);
  if (to == std::string::npos) return fail("has no leaderboard \"" + name + "\"");
  return text.substr(0, from + begin.size()) + table + text.substr(to);
}

}  // namespace strobe::real
