#include "host/session/results_csv.hpp"

#include <fmt/format.h>

#include <span>

#include "host/config/notes.hpp"
#include "host/session/data_dictionary.hpp"
#include "host/session/results_rows.hpp"
#include "host/session/shot_names.hpp"

namespace strobe::host {
namespace {

using reduction::kQuantityCount;
using reduction::Quantities;
using reduction::Quantity;

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

std::vector<std::string> earlier_results_headers() {
  const auto without = [](std::size_t added_later) {
    return csv_header(std::span(results_columns()).first(results_columns().size() - added_later));
  };
  constexpr std::size_t kNames = 2, kFlashes = 3;
  return {without(kNames), without(kNames + kFlashes)};
}

std::string results_header() { return csv_header(results_columns()); }

std::string_view digitization_word(const ShotResult& shot_result) {
  if (!shot_result.frame) return "";
  return shot_result.frame->source == "hand" ? "hand" : "auto";
}

std::string results_line(const ShotResult& shot_result, const std::string& utc, const std::string& shot_name,
                         std::string_view digitization) {
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
  return line + fmt::format(",{},{}", digitization, shot_name);
}

Result<ResultsCsv> ResultsCsv::open(const std::filesystem::path& path) {
  auto file = CsvFile::open(path, results_header(), earlier_results_headers());
  if (!file) return tl::unexpected(file.error());
  const auto rows = read_results_rows(path);
  if (!rows) return tl::unexpected(rows.error());
  std::vector<ShotKey> shots;
  for (const ResultsRow& row : *rows) shots.push_back(row.key);
  return ResultsCsv(std::move(*file), std::move(shots));
}

Result<void> ResultsCsv::add(const ShotResult& shot_result, const std::string& utc) {
  shots_.push_back({shot_result.boot_id, shot_result.shot_id});
  return file_.append(
      results_line(shot_result, utc, shot_names(shots_).back(), digitization_word(shot_result)));
}

}  // namespace strobe::host
