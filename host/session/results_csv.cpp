#include "host/session/results_csv.hpp"

#include <fmt/format.h>

#include "host/config/notes.hpp"

namespace strobe::host {
namespace {

using reduction::kQuantityCount;
using reduction::Quantities;
using reduction::Quantity;

std::string csv_field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += c;
  }
  return result + "\"";
}

void add_names(std::string& header, const std::string& prefix) {
  for (const std::string_view name : reduction::kQuantityNames) header += fmt::format(",{}{}", prefix, name);
}

void add_values(std::string& line, const Quantities& values) {
  for (std::size_t i = 0; i < kQuantityCount; ++i) {
    const auto& value = values[static_cast<Quantity>(i)];
    line += value ? fmt::format(",{}", *value) : ",";
  }
}

std::string flag_names(const reduction::FlagSet& flags) {
  std::string names;
  for (std::size_t i = 0; i < reduction::kFlagCount; ++i) {
    const auto flag = static_cast<reduction::Flag>(i);
    if (flags.has(flag)) names += fmt::format("{}{}", names.empty() ? "" : ";", name(flag));
  }
  return names;
}

void add_notes(std::string& line, reduction::Record record) {
  for (const std::string_view key : kNamedNotes) {
    const auto entry = record.find(std::string(key));
    line += ',';
    if (entry != record.end()) line += csv_field(entry->second);
    if (entry != record.end()) record.erase(entry);
  }
  std::string others;
  for (const auto& [key, value] : record)
    others += fmt::format("{}{}={}", others.empty() ? "" : ";", key, value);
  line += fmt::format(",{}", csv_field(others));
}

void add_flashes(std::string& line, const std::optional<reduction::ImagedFlashes>& flashes) {
  line += flashes
              ? fmt::format(",{},{},{}", flashes->first, flashes->last, flashes->misassignment_probability)
              : ",,,";
}

}  // namespace

std::string earlier_results_header() {
  std::string header = "utc,boot_id,shot_id,rejected";
  add_names(header, "");
  add_names(header, "sd_");
  add_names(header, "sd_systematic_");
  header += ",regime,court_pace_conforming,method,mirrored,flags";
  for (const std::string_view key : kNamedNotes) header += fmt::format(",{}", key);
  return header + ",other_notes";
}

std::string results_header() {
  return earlier_results_header() + ",first_flash,last_flash,misassignment_probability";
}

std::string results_line(const ShotResult& shot_result, const std::string& utc) {
  const reduction::Readout& readout = shot_result.readout;
  std::string line = fmt::format("{},{:x},{},{}", utc, static_cast<std::uint64_t>(shot_result.boot_id),
                                 shot_result.shot_id, csv_field(shot_result.rejected.value_or("")));
  add_values(line, readout.value);
  add_values(line, readout.sd);
  add_values(line, readout.sd_systematic);
  line +=
      fmt::format(",{},{},{},{},{}", readout.regime ? name(*readout.regime) : "",
                  readout.court_pace_conforming, readout.method, readout.mirrored, flag_names(readout.flags));
  add_notes(line, readout.record);
  add_flashes(line, readout.flashes);
  return line;
}

}  // namespace strobe::host
