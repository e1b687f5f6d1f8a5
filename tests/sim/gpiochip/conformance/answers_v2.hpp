// What the parts of kernel_calls_v2.cpp share.
#pragma once

#include <string>

#include "tests/sim/gpiochip/conformance/answers.hpp"
#include "tests/sim/gpiochip/conformance/uapi_v2_client.hpp"

namespace answers {

inline int chip = -1;
inline unsigned line_a = 0, line_b = 0, line_c = 0;

inline std::string text_of(const gpio_v2_line_info& info) {
  constexpr struct {
    std::uint64_t flag;
    const char* name;
  } kFlags[] = {{GPIO_V2_LINE_FLAG_USED, "used"},
                {uapi::v2::kIn, "in"},
                {uapi::v2::kOut, "out"},
                {uapi::v2::kLow, "active-low"},
                {uapi::v2::kRising, "rising"},
                {uapi::v2::kFalling, "falling"},
                {uapi::v2::kDrain, "open-drain"},
                {uapi::v2::kSource, "open-source"},
                {uapi::v2::kUp, "pull-up"},
                {uapi::v2::kDown, "pull-down"},
                {uapi::v2::kNoBias, "bias-disable"},
                {uapi::v2::kRealtime, "realtime"},
                {uapi::v2::kHardwareClock, "hardware-clock"}};
  std::string text;
  for (const auto& flag : kFlags)
    if ((info.flags & flag.flag) != 0) text += std::string(flag.name) + " ";
  for (std::uint32_t i = 0; i < info.num_attrs; ++i)
    if (info.attrs[i].id == GPIO_V2_LINE_ATTR_ID_DEBOUNCE)
      text += "debounce " + std::to_string(info.attrs[i].debounce_period_us) + " us ";
  return text + "consumer '" + info.consumer + "'";
}

inline std::string info_of(unsigned line) {
  gpio_v2_line_info info;
  const int result = uapi::v2::info(chip, line, info);
  return result < 0 ? named(result) : text_of(info);
}

void watch_lines(const char* device);
void drive_edges(const char* answers_fifo);

}  // namespace answers
