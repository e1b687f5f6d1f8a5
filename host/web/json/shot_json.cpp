#include "host/web/json/shot_json.hpp"

#include <fmt/format.h>

#include <array>
#include <nlohmann/json.hpp>

#include "common/messages/parsed_json.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/config/notes.hpp"
#include "host/session/shot_table.hpp"
#include "host/view/series_view.hpp"

namespace strobe::web {
namespace {

using messages::or_null;
using nlohmann::ordered_json;
using reduction::kQuantityCount;
using reduction::Quantity;

ordered_json word_or_null(const std::string& word) {
  return word.empty() ? ordered_json() : ordered_json(word);
}

std::vector<std::string> names_of(const reduction::FlagSet& flags) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i)
    if (flags.has(static_cast<reduction::Flag>(i))) names.emplace_back(reduction::kFlagNames[i]);
  return names;
}

}  // namespace

ShotRow shot_row(const host::Shot& result, std::string name, std::string utc, std::string_view digitization) {
  const reduction::Readout& readout = result.readout;
  ShotRow row;
  row.name = std::move(name);
  row.key = {result.boot_id, result.shot_id};
  row.utc = std::move(utc);
  row.dry = result.dry;
  row.rejected = result.rejected;
  row.flags = names_of(readout.flags);
  if (readout.regime) row.regime = strobe::name(*readout.regime);
  row.digitization = digitization;
  row.value = readout.value;
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    row.total_sd[q] = reduction::total_sd(readout, q);
  }
  if (const auto spin = readout.record.find("spin"); spin != readout.record.end()) row.spin = spin->second;
  row.angle_deg = host::note_number(readout.record, "angle_deg");
  return row;
}

ordered_json values_json(const reduction::Quantities& value, const reduction::Quantities& total_sd) {
  ordered_json values = ordered_json::object();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    values[std::string(name(q))] = {{"value", or_null(value[q])}, {"sd", or_null(total_sd[q])}};
  }
  return values;
}

ordered_json shot_json(const ShotRow& row, const std::optional<std::string>& session) {
  return {{"session", or_null(session)},
          {"name", row.name},
          {"boot_id", fmt::format("{:x}", static_cast<std::uint64_t>(row.key.boot_id))},
          {"shot_id", row.key.shot_id},
          {"utc", row.utc},
          {"dry", row.dry},
          {"counted", !row.dry && !row.rejected},
          {"rejected", or_null(row.rejected)},
          {"flags", row.flags},
          {"regime", word_or_null(row.regime)},
          {"digitization", word_or_null(row.digitization)},
          {"values", values_json(row.value, row.total_sd)},
          {"spin", word_or_null(row.spin)},
          {"angle_deg", or_null(row.angle_deg)}};
}

ordered_json quantities_json() {
  ordered_json quantities = ordered_json::array();
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto q = static_cast<Quantity>(i);
    quantities.push_back({{"name", name(q)},
                          {"label", host::kQuantityLabels[i].words},
                          {"unit", host::kQuantityLabels[i].unit},
                          {"essential", host::is_essential(q)}});
  }
  return quantities;
}

}  // namespace strobe::web
