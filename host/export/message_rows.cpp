#include "host/export/message_rows.hpp"

#include <array>
#include <string_view>
#include <utility>

namespace strobe::host {

std::string unit_of_field(const std::string& name) {
  // Longer endings first.
  constexpr std::array<std::pair<std::string_view, std::string_view>, 14> kUnits{{
      {"_px_per_m", "{px}/m"},
      {"px_per_m", "{px}/m"},
      {"px_per_m_sd", "{px}/m"},
      {"_px2", "{px}2"},
      {"_px", "{px}"},
      {"_radps", "rad/s"},
      {"_rad", "rad"},
      {"_mps", "m/s"},
      {"_deg", "deg"},
      {"_ns", "ns"},
      {"_us", "us"},
      {"_ms", "ms"},
      {"_cm", "cm"},
      {"_m", "m"},
  }};
  for (const auto& [ending, unit] : kUnits) {
    if (name.ends_with(ending)) return std::string(unit);
  }
  return {};
}

bool is_identifier(std::string_view name) {
  return name.ends_with("boot_id") || name.ends_with("host_id") || name.ends_with("arm_token");
}

std::string identifier_text(std::string_view name, std::int64_t value) {
  return name.ends_with("boot_id") ? fmt::format("{:x}", static_cast<std::uint64_t>(value))
                                   : std::to_string(value);
}

}  // namespace strobe::host
