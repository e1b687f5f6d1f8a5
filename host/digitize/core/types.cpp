#include "host/digitize/core/types.hpp"

#include <array>

namespace strobe::digitize {

namespace {

constexpr std::array<std::string_view, 14> kReasons{
    "few_edges", "wrong_size",    "not_round", "off_path",       "at_border", "saturated", "ghost",
    "duplicate", "below_surface", "no_line",   "line_ambiguous", "no_plate",  "imprecise", "by_hand"};
static_assert(kReasons.size() == static_cast<std::size_t>(Reason::by_hand) + 1);

constexpr std::array<std::string_view, 3> kEfforts{"fast", "standard", "thorough"};
static_assert(kEfforts.size() == static_cast<std::size_t>(Effort::thorough) + 1);

}  // namespace

std::string_view name(Effort effort) { return kEfforts.at(static_cast<std::size_t>(effort)); }

std::optional<Effort> effort_from_name(std::string_view name) {
  for (std::size_t i = 0; i < kEfforts.size(); ++i) {
    if (kEfforts[i] == name) return static_cast<Effort>(i);
  }
  return std::nullopt;
}

std::string_view name(Reason reason) { return kReasons.at(static_cast<std::size_t>(reason)); }

}  // namespace strobe::digitize
