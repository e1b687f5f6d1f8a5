#include "host/view/timing.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "host/view/text.hpp"

namespace strobe::host {
namespace {

using strobe_msgs::histogram_t;
using strobe_msgs::status_t;

struct Label {
  int quantity;
  std::string_view words;
};
constexpr std::array<Label, 6> kLabels{{{histogram_t::LATENESS, "lateness"},
                                        {histogram_t::ISSUE, "issue call"},
                                        {histogram_t::SKEW, "skew A-B"},
                                        {histogram_t::LAMP_DELAY_A, "lamp delay A"},
                                        {histogram_t::LAMP_DELAY_B, "lamp delay B"},
                                        {histogram_t::PERIOD_ERROR, "period error"}}};
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

}  // namespace strobe::host
