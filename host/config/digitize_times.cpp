#include "host/config/digitize_times.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "common/messages/parsed_json.hpp"

namespace strobe::host {

namespace {

constexpr std::size_t kMaxFlashes = 100'000;
constexpr double kLongest_s = 1e9;
constexpr double kShortestInterval_s = 1e-9;

/// What is wrong with it, or an empty text.
std::string read_times(const nlohmann::json& line, std::vector<double>& times_s) {
  const nlohmann::json* list = &line;
  if (line.is_object()) {
    const auto found = line.find("flash_times_s");
    if (found == line.end()) return "no flash_times_s";
    list = &*found;
  }
  if (!list->is_array()) return "must be an array of seconds, or an object with flash_times_s";
  if (list->empty() || list->size() > kMaxFlashes) return "must be 1 to 100000 flashes";
  for (std::size_t i = 0; i < list->size(); ++i) {
    const auto& time = (*list)[i];
    if (time.is_null()) continue;  // a flash that no sensor saw
    if (!time.is_number()) return fmt::format("flash {} is not a number", i);
    const double seconds = time.get<double>();
    if (!(std::abs(seconds) <= kLongest_s)) return fmt::format("flash {} is beyond 1e9 s", i);
    if (!times_s.empty() && !(seconds - times_s.back() >= kShortestInterval_s))
      return fmt::format("flash {} is not after the one before", i);
    times_s.push_back(seconds);
  }
  if (times_s.empty()) return "no flash was seen";
  return {};
}

}  // namespace

Result<std::vector<std::vector<double>>> parse_flash_times(const std::string& text, const std::string& file) {
  std::vector<std::vector<double>> all;
  std::istringstream lines(text);
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos) continue;
    const auto parsed = messages::parsed_json<nlohmann::json>(line);
    const std::string wrong = parsed.is_discarded() ? "is not JSON" : read_times(parsed, all.emplace_back());
    if (!wrong.empty()) return fail(fmt::format("{}:{}: {}", file, number, wrong));
  }
  if (all.empty()) return fail(file + ": no flashes");
  return all;
}

std::vector<double> even_flashes(double period_s) {
  constexpr int kFlashes = 166;  // half a second of 20,000 a minute
  std::vector<double> times_s;
  for (int i = 0; i < kFlashes; ++i) times_s.push_back(i * period_s);
  return times_s;
}

std::vector<double> plan_flashes(const ShotPlan& plan) {
  // By the plan file's microseconds, so that its numbers are rounded once.
  const auto seconds = [](Duration d) { return std::chrono::duration<double, std::micro>(d).count() * 1e-6; };
  if (plan.code.empty()) return even_flashes(seconds(plan.period));
  std::vector<double> times_s;
  for (const CodedFlash& flash : plan.code) times_s.push_back(seconds(flash.offset));
  return times_s;
}

void count_from_first_image(reduction::Frame& frame) {
  const auto timed = std::ranges::find_if(
      frame.images, [](const reduction::BallImage& image) { return !std::isnan(image.time_s); });
  if (timed == frame.images.end()) return;
  const reduction::BallImage first = *timed;
  for (reduction::BallImage& image : frame.images) {
    image.time_s -= first.time_s;
    if (image.flash_index && first.flash_index) *image.flash_index -= *first.flash_index;
  }
}

}  // namespace strobe::host
