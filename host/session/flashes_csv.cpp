#include "host/session/flashes_csv.hpp"

#include <fmt/format.h>

#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>

#include "host/session/data_dictionary.hpp"

namespace strobe::host {
namespace {

std::string instant(std::int64_t ns) {
  return ns == strobe_msgs::flash_t::NO_TIME ? std::string() : std::to_string(ns);
}

std::string_view lamps_word(int lamps) { return lamps == 1 ? "a" : lamps == 2 ? "b" : "ab"; }

/// The number before the next comma, which `text` then follows. Returns nullopt if there is none.
template <typename Number>
std::optional<Number> take_number(std::string_view& text, int base) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, number, base);
  if (read.ec != std::errc() || read.ptr == end || *read.ptr != ',') return std::nullopt;
  text = std::string_view(read.ptr + 1, end);
  return number;
}

}  // namespace

std::string flashes_header() { return csv_header(flashes_columns()); }

namespace {

std::string flash_line(const strobe_msgs::shot_t& shot, const strobe_msgs::flash_t& flash) {
  return fmt::format("{:x},{},{},{},{},{},{},{},{},{}\n", static_cast<std::uint64_t>(shot.boot_id),
                     shot.shot_id, flash.flash_index, lamps_word(flash.lamps), flash.commanded_ns,
                     instant(flash.issue_start_ns), instant(flash.issue_end_ns), instant(flash.observed_a_ns),
                     instant(flash.observed_b_ns), flash.extra_edges);
}

}  // namespace

std::string flashes_lines(const strobe_msgs::shot_t& shot) {
  std::string lines;
  for (const auto& flash : shot.flashes) lines += flash_line(shot, flash);
  return lines;
}

std::set<FlashesCsv::FlashKey> FlashesCsv::flashes_in(std::istream& lines) {
  std::set<FlashKey> known;
  for (std::string line; std::getline(lines, line);) {
    std::string_view rest = line;
    const auto boot = take_number<std::uint64_t>(rest, 16);
    const auto shot = boot ? take_number<std::int32_t>(rest, 10) : std::nullopt;
    const auto flash = shot ? take_number<std::int32_t>(rest, 10) : std::nullopt;
    if (flash) known.insert({ShotKey{static_cast<std::int64_t>(*boot), *shot}, *flash});
  }
  return known;
}

Result<FlashesCsv> FlashesCsv::open(const std::filesystem::path& path) {
  auto file = CsvFile::open(path, flashes_header());
  if (!file) return tl::unexpected(file.error());
  std::ifstream lines(path);
  auto known = flashes_in(lines);
  if (!lines.is_open() || lines.bad()) return fail(path.string() + ": cannot be read");
  return FlashesCsv(std::move(*file), std::move(known));
}

Result<void> FlashesCsv::add(const strobe_msgs::shot_t& shot) {
  std::string lines;
  for (const auto& flash : shot.flashes) {
    if (known_.insert({{shot.boot_id, shot.shot_id}, flash.flash_index}).second)
      lines += flash_line(shot, flash);
  }
  if (lines.empty()) return {};
  lines.pop_back();  // the file ends each append itself
  return file_.append(lines);
}

}  // namespace strobe::host
