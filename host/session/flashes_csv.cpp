#include "host/session/flashes_csv.hpp"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>

namespace strobe::host {
namespace {

std::string instant(std::int64_t ns) {
  return ns == strobe_msgs::flash_t::NO_TIME ? std::string() : std::to_string(ns);
}

std::string_view lamps_word(int lamps) { return lamps == 1 ? "a" : lamps == 2 ? "b" : "ab"; }

/// The shot of a line. Returns nullopt if the line has none.
std::optional<ShotKey> shot_of(std::string_view line) {
  std::uint64_t boot = 0;
  std::int32_t shot = 0;
  const char* end = line.data() + line.size();
  const auto first = std::from_chars(line.data(), end, boot, 16);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != ',') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, shot);
  if (second.ec != std::errc() || second.ptr == end || *second.ptr != ',') return std::nullopt;
  return ShotKey{static_cast<std::int64_t>(boot), shot};
}

}  // namespace

std::string flashes_header() {
  return "boot_id,shot_id,flash_index,lamps,commanded_ns,issue_start_ns,issue_end_ns,observed_a_ns,"
         "observed_b_ns,extra_edges";
}

std::string flashes_lines(const strobe_msgs::shot_t& shot) {
  std::string lines;
  for (const auto& flash : shot.flashes) {
    lines += fmt::format("{:x},{},{},{},{},{},{},{},{},{}\n", static_cast<std::uint64_t>(shot.boot_id),
                         shot.shot_id, flash.flash_index, lamps_word(flash.lamps), flash.commanded_ns,
                         instant(flash.issue_start_ns), instant(flash.issue_end_ns),
                         instant(flash.observed_a_ns), instant(flash.observed_b_ns), flash.extra_edges);
  }
  return lines;
}

Result<FlashesCsv> FlashesCsv::open(const std::filesystem::path& path) {
  auto file = CsvFile::open(path, flashes_header());
  if (!file) return tl::unexpected(file.error());
  std::set<ShotKey> known;
  std::ifstream lines(path);
  for (std::string line; std::getline(lines, line);) {
    if (const auto key = shot_of(line)) known.insert(*key);
  }
  return FlashesCsv(std::move(*file), std::move(known));
}

Result<void> FlashesCsv::add(const strobe_msgs::shot_t& shot) {
  if (!known_.insert({shot.boot_id, shot.shot_id}).second || shot.flashes.empty()) return {};
  std::string lines = flashes_lines(shot);
  lines.pop_back();  // the file ends each append itself
  return file_.append(lines);
}

}  // namespace strobe::host
