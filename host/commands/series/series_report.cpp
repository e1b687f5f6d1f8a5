#include "host/commands/series/series_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "common/data/thesis_data.hpp"
#include "common/messages/parsed_json.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/commands/command.hpp"
#include "host/commands/terminal.hpp"
#include "host/config/notes.hpp"
#include "host/series/from_session.hpp"
#include "host/view/series_json.hpp"
#include "host/view/series_view.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

constexpr std::uint64_t kSeed = 1;

void print_json(const ordered_json& object) { print({messages::json_text(object)}); }

/// The thesis's row where all shots have one spin and angle.
std::optional<thesis::Condition> condition_of(const std::vector<SeriesShot>& shots) {
  std::optional<std::string> spin;
  std::optional<double> angle;
  for (const SeriesShot& shot : shots) {
    const auto note = shot.readout.record.find("spin");
    const auto its_angle = note_number(shot.readout.record, "angle_deg");
    if (note == shot.readout.record.end() || !its_angle) return std::nullopt;
    if ((spin && *spin != note->second) || (angle && *angle != *its_angle)) return std::nullopt;
    spin = note->second;
    angle = its_angle;
  }
  return spin ? thesis::shipped_condition(*spin, *angle) : std::nullopt;
}

Series series_of(const std::vector<SeriesShot>& shots) {
  Series series;
  for (const SeriesShot& shot : shots) series.add(shot);
  return series;
}

std::string group_name(const ShotGroup& group, const std::vector<NamedSession>& sessions) {
  if (!group.name.empty()) return group.name;
  std::string names;
  for (const NamedSession& session : sessions) names += (names.empty() ? "" : " + ") + session.name;
  return names;
}

/// Which shots there are, for a person.
std::vector<std::string> shot_lines(const ShotGroup& group) {
  std::string counted;
  std::vector<std::string> lines;
  for (const SeriesShot& shot : group.shots) {
    if (shot.rejected)
      lines.push_back(fmt::format("  shot {} rejected: {}", shot.full_name(), *shot.rejected));
    else
      counted += (counted.empty() ? "" : ", ") + shot.full_name();
  }
  if (!counted.empty()) lines.insert(lines.begin(), "  shots " + counted);
  return lines;
}

ordered_json shots_json(const ShotGroup& group) {
  ordered_json shots = ordered_json::array();
  for (const SeriesShot& shot : group.shots) {
    shots.push_back({{"shot", shot.name},
                     {"session", shot.session},
                     {"rejected", shot.rejected ? ordered_json(*shot.rejected) : ordered_json()}});
  }
  return shots;
}

class SeriesPrinter {
 public:
  SeriesPrinter(const std::vector<NamedSession>& sessions, const SelectedShots& selected,
                const SeriesReportSettings& settings)
      : sessions_(sessions), selected_(selected), settings_(settings) {}

  Result<void> run() {
    if (!settings_.json) head();
    for (const ShotGroup& group : selected_.groups) put(group);
    if (!settings_.compare) return {};
    const auto first = find(settings_.compare->first), second = find(settings_.compare->second);
    if (!first) return tl::unexpected(first.error());
    if (!second) return tl::unexpected(second.error());
    put(**first, **second);
    return {};
  }

 private:
  void head() const {
    std::string left_out;
    for (const std::string& name : selected_.left_out) left_out += (left_out.empty() ? "" : ", ") + name;
    if (!left_out.empty()) print({"left out as asked: shot " + left_out});
    if (selected_.other > 0) print({fmt::format("{} shots have other notes", selected_.other)});
    if (selected_.groups.empty()) print({"no shots"});
  }

  void put(const ShotGroup& group) {
    const std::string name = group_name(group, sessions_);
    const SeriesSummary summary = summarize(name, group.shots);
    const auto condition = condition_of(group.shots);
    if (settings_.json) {
      ordered_json object = series_json(summary, condition);
      object["shots"] = shots_json(group);
      object["left_out"] = selected_.left_out;
      if (settings_.draws > 0) object["monte_carlo"] = drawn_json(group);
      return print_json(object);
    }
    print(render_summary(summary, condition, kPlainWidth, settings_.all));
    print(shot_lines(group));
    if (settings_.budget) {
      const auto& lines = summary.quantities[static_cast<std::size_t>(*settings_.budget)].budget;
      print(render_budget(name + ", mean", lines, *settings_.budget, kPlainWidth));
    }
    if (settings_.draws > 0) print_drawn(group);
    print({""});
  }

  void put(const ShotGroup& first, const ShotGroup& second) const {
    const Comparison comparison =
        compare(series_of(first.shots), series_of(second.shots), settings_.difference);
    if (settings_.json) return print_json(comparison_json(first.name, second.name, comparison));
    print(render_comparison(first.name, second.name, comparison, kPlainWidth, settings_.all));
  }

  Result<const ShotGroup*> find(const std::string& name) const {
    std::string names;
    for (const ShotGroup& group : selected_.groups) {
      if (group.name == name) return &group;
      names += (names.empty() ? "\"" : ", \"") + group.name + "\"";
    }
    return fail(fmt::format("--compare: no series \"{}\" among {}", name, names.empty() ? "none" : names));
  }

  /// Of the stored shot of that name.
  std::optional<reduction::MonteCarlo> drawn(const SeriesShot& wanted) const {
    for (const NamedSession& session : sessions_) {
      if (!wanted.session.empty() && wanted.session != session.name) continue;
      for (const StoredShot& stored : session.session.shots) {
        if (stored.name != wanted.name) continue;
        const auto frame = matched_frame(stored);
        if (!frame) return std::nullopt;
        const auto result = reduction::monte_carlo(*frame, settings_.draws, kSeed);
        return result ? std::optional(*result) : std::nullopt;
      }
    }
    return std::nullopt;
  }

  ordered_json drawn_json(const ShotGroup& group) const {
    ordered_json all = ordered_json::array();
    for (const SeriesShot& shot : group.shots) {
      if (shot.rejected) continue;
      const auto result = drawn(shot);
      ordered_json object = result ? monte_carlo_json(*result) : ordered_json::object();
      object["shot"] = shot.full_name();
      all.push_back(std::move(object));
    }
    return all;
  }

  void print_drawn(const ShotGroup& group) const {
    for (const SeriesShot& shot : group.shots) {
      if (shot.rejected) continue;
      const auto result = drawn(shot);
      if (result) print(render_monte_carlo(*result, shot.full_name(), kPlainWidth, settings_.all));
    }
  }

  const std::vector<NamedSession>& sessions_;
  const SelectedShots& selected_;
  const SeriesReportSettings& settings_;
};

}  // namespace

Result<void> report_series(const std::vector<NamedSession>& sessions, const SelectedShots& selected,
                           const SeriesReportSettings& settings) {
  return SeriesPrinter(sessions, selected, settings).run();
}

}  // namespace strobe::host
