#include "host/commands/shot_report.hpp"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "common/messages/json_conversions.hpp"
#include "common/messages/parsed_json.hpp"
#include "host/view/quantities.hpp"
#include "host/view/text.hpp"

namespace strobe::host {
namespace {

using nlohmann::ordered_json;
using reduction::Quantity;

/// As it is called in the session.
std::string within(const StoredSession& session, const std::filesystem::path& file) {
  return file.lexically_relative(session.folder).string();
}

std::string_view kind_of(const Digitization& digitization) {
  if (!digitization.file.empty() && digitization.by_hand) return "corrected";
  return digitization.by_hand ? "hand" : "auto";
}

ordered_json digitization_json(const StoredSession& session, const Digitization& digitization, bool counts) {
  const auto file = [&](const std::filesystem::path& path) {
    return path.empty() ? ordered_json(nullptr) : ordered_json(within(session, path));
  };
  ordered_json json;
  json["digitization"] = kind_of(digitization);
  json["images"] = digitization.frame.images.size();
  json["utc"] = digitization.utc;
  json["who"] = digitization.who.empty() ? ordered_json(nullptr) : ordered_json(digitization.who);
  json["file"] = file(digitization.file);
  json["corrections"] = file(digitization.corrections);
  json["counts"] = counts;
  return json;
}

std::string cell(const reduction::Readout& readout, Quantity quantity) {
  const auto& value = readout.value[quantity];
  if (!value) return right("-", 20);
  const auto sd = readout.sd[quantity];
  return right(rounded(*value, sd.value_or(0.0), sd ? 0 : 3), 11) +
         (sd ? left(fmt::format(" ± {:#.2g}", *sd), 11) : "");
}

}  // namespace

std::string measurement_json(const StoredSession& session, const StoredShot& shot, const ShotResult* before) {
  ordered_json json;
  json["shot"] = shot.name;
  json["utc"] = shot.utc;
  json["counts"] = !shot.result.rejected;
  json["rejected"] = shot.result.rejected ? ordered_json(*shot.result.rejected) : ordered_json(nullptr);
  json["photograph"] =
      shot.photograph ? ordered_json(within(session, *shot.photograph)) : ordered_json(nullptr);
  json["digitizations"] = ordered_json::array();
  for (const Digitization& each : shot.digitizations)
    json["digitizations"].push_back(digitization_json(session, each, &each == &shot.digitizations.back()));
  if (before != nullptr)
    json["before"] = messages::parsed_json<ordered_json>(messages::readout_to_json(before->readout));
  return messages::json_text(json);
}

std::vector<std::string> measurement_lines(const StoredSession& session, const StoredShot& shot) {
  std::vector<std::string> lines;
  lines.push_back(shot.photograph ? "photograph: " + within(session, *shot.photograph)
                                  : "no photograph of it is in the session");
  for (const Digitization& each : shot.digitizations) {
    const bool counts = &each == &shot.digitizations.back();
    std::string line = fmt::format("  {}{} {} images  {}", counts ? "* " : "  ", left(kind_of(each), 10),
                                   each.frame.images.size(), each.utc);
    if (!each.who.empty()) line += " by " + each.who;
    if (!each.file.empty()) line += "  " + within(session, each.file);
    lines.push_back(line + (counts && shot.digitizations.size() > 1 ? "  (counts)" : ""));
  }
  if (shot.digitizations.empty()) lines.push_back("  not digitized");
  return lines;
}

std::vector<std::string> comparison_lines(const ShotResult& before, const ShotResult& after) {
  std::vector<std::string> lines{left("", 24) + right("before", 11) + left("", 9) + right("after", 13)};
  for (std::size_t i = 0; i < reduction::kQuantityCount; ++i) {
    const auto quantity = static_cast<Quantity>(i);
    if (!before.readout.value[quantity] && !after.readout.value[quantity]) continue;
    const std::string label =
        fmt::format("{}{}{}", kQuantityLabels[i].words, kQuantityLabels[i].unit.empty() ? "" : " ",
                    kQuantityLabels[i].unit);
    lines.push_back(left(label, 24) + left(cell(before.readout, quantity), 22) +
                    cell(after.readout, quantity));
  }
  const auto verdict = [](const ShotResult& result) {
    return result.rejected ? "rejected: " + *result.rejected : "counts";
  };
  lines.push_back("before: " + verdict(before));
  lines.push_back("after:  " + verdict(after));
  return lines;
}

}  // namespace strobe::host
