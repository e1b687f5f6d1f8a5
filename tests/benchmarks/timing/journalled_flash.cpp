#include "tests/benchmarks/timing/journalled_flash.hpp"

#include <cstdio>
#include <string_view>

namespace strobe::benchmarks::timing {

std::optional<Sample> flash_of(const strobe_msgs::event_t& event, int cpu) {
  using strobe_msgs::event_t;
  if (event.kind == event_t::FLASH)
    return sample_of(from_ns(event.commanded_ns), from_ns(event.issue_start_ns), cpu);
  if (event.kind != event_t::SHOT_ABORTED || !event.detail.starts_with("flash ")) return std::nullopt;
  constexpr std::string_view kWords = " would have been ";
  const std::size_t at = event.detail.find(kWords);
  long late_us = 0;
  if (at == event.detail.npos ||
      std::sscanf(event.detail.c_str() + at + kWords.size(), "%ld us late", &late_us) != 1)
    return std::nullopt;
  const MonoTime then = from_ns(event.device_time_ns);
  return sample_of(then - microseconds(late_us), then, cpu);
}

}  // namespace strobe::benchmarks::timing
