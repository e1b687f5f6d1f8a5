#include "host/view/timing.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>

#include "common/messages/parsed_json.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::histogram_t;
using strobe_msgs::status_t;

struct Label {
  int quantity;
  std::string_view words;
  std::string_view key;
};
constexpr std::array<Label, 6> kLabels{{{histogram_t::LATENESS, "lateness", "lateness_us"},
                                        {histogram_t::ISSUE, "issue call", "issue_us"},
                                        {histogram_t::SKEW, "skew A-B", "skew_us"},
                                        {histogram_t::LAMP_DELAY_A, "lamp delay A", "lamp_delay_a_us"},
                                        {histogram_t::LAMP_DELAY_B, "lamp delay B", "lamp_delay_b_us"},
                                        {histogram_t::PERIOD_ERROR, "period error", "period_error_us"}}};
constexpr std::size_t kQuantityWidth = 13;
constexpr std::size_t kFigureWidth = 9;

std::string number(double us) {
  if (!std::isfinite(us)) return right("-", kFigureWidth);
  return right(std::abs(us) < 1000.0 ? fmt::format("{:.2f}", us) : fmt::format("{:.0f}", us), kFigureWidth);
}

/// Heights by the logarithm: the single late flash among ten thousand must be seen.
std::string bars(const histogram_t& histogram) {
  constexpr std::array<std::string_view, 9> kBars{" ", "▁", "▂", "▃", "▄", "▅", "▆", "▇", "█"};
  std::int64_t most = 1;
  for (const std::int64_t n : histogram.bins) most = std::max(most, n);
  std::string text;
  for (const std::int64_t n : histogram.bins) {
    const double share = n <= 0 ? 0.0 : most == 1 ? 1.0 : std::log(double(n)) / std::log(double(most));
    text += kBars[n <= 0 ? 0 : 1 + static_cast<std::size_t>(std::lround(7.0 * share))];
  }
  return text;
}

nlohmann::ordered_json histogram_json(const histogram_t* h) {
  if (h == nullptr) return nullptr;
  return {{"n", h->count},
          {"mean", h->mean_us},
          {"sd", h->sd_us},
          {"min", h->min_us},
          {"p50", h->p50_us},
          {"p99", h->p99_us},
          {"p99_9", h->p999_us},
          {"max", h->max_us},
          {"bin_first", h->bin_first_us},
          {"bin_width", h->bin_width_us},
          {"bins", h->bins}};
}

std::string line_of(std::string_view words, const histogram_t& h) {
  std::string line = left(words, kQuantityWidth);
  for (const double us : {h.mean_us, h.sd_us, h.min_us, h.p50_us, h.p99_us, h.p999_us, h.max_us})
    line += number(us);
  line += right(std::to_string(h.count), kFigureWidth);
  if (h.bins.empty()) return line;
  return line + fmt::format("  {:.6g} [{}] {:.6g}", h.bin_first_us, bars(h),
                            h.bin_first_us + h.bin_width_us * static_cast<double>(h.bins.size()));
}

}  // namespace

const histogram_t* histogram_of(const status_t& status, int quantity) {
  for (const histogram_t& histogram : status.histograms) {
    if (histogram.quantity == quantity && histogram.count > 0) return &histogram;
  }
  return nullptr;
}

std::string clock_line(const ClockState& clock, double status_age_s) {
  std::string line = fmt::format("clock: heartbeat {:.1f} s ago", std::max(0.0, status_age_s));
  if (clock.latency_s) {
    line += fmt::format(", {:+.2f} ms after the fastest; worst {:+.2f} ms", *clock.latency_s * 1e3,
                        clock.worst_latency_s * 1e3);
  }
  if (clock.drift_ppm) line += fmt::format("   drift {:.1f} ppm", *clock.drift_ppm);
  return clock.suspect ? line + "   SUSPECT: no clock drifts like this" : line;
}

std::vector<std::string> render_timing(const status_t& status) {
  std::vector<std::string> lines;
  for (const Label& label : kLabels) {
    if (const histogram_t* histogram = histogram_of(status, label.quantity))
      lines.push_back(line_of(label.words, *histogram));
  }
  if (lines.empty()) return lines;
  std::string header = left("timing, us", kQuantityWidth);
  for (const std::string_view name : {"mean", "sd", "min", "p50", "p99", "p99.9", "max", "n"})
    header += right(name, kFigureWidth);
  lines.insert(lines.begin(), header);
  return lines;
}

std::string timing_json(const status_t& status, const ClockState& clock, int after_shot,
                        const authentication::UnverifiedCounts& unverified) {
  nlohmann::ordered_json timing;
  for (const Label& label : kLabels)
    timing[std::string(label.key)] = histogram_json(histogram_of(status, label.quantity));
  nlohmann::ordered_json rejected;
  for (const RejectedCommandLabel& label : kRejectedCommandLabels)
    rejected[std::string(label.key)] = status.*label.count;
  nlohmann::ordered_json ignored;
  for (std::size_t i = 0; i < authentication::kUnverifiedCount; ++i) {
    const auto why = static_cast<authentication::Unverified>(i);
    ignored[authentication::name(why)] = unverified[why];
  }
  const nlohmann::ordered_json json{
      {"timing_after_shot", after_shot},
      {"boot_id", fmt::format("{:x}", static_cast<std::uint64_t>(status.boot_id))},
      {"timing", timing},
      {"clock",
       {{"heartbeats", clock.heartbeats},
        {"drift_ppm", messages::or_null(clock.drift_ppm)},
        {"latency_s", messages::or_null(clock.latency_s)},
        {"worst_latency_s", clock.worst_latency_s},
        {"suspect", clock.suspect}}},
      {"rejected", rejected},
      {"unverified", ignored}};
  return messages::json_text(json);
}

}  // namespace strobe::host
