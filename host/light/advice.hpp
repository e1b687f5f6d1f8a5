// What a photographer would say of a photograph of balls: its measures judged, each in words with what is
// asked for and what mends it. Pure; thread-safe; allocates.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/light/measures.hpp"

namespace strobe::light {

/// wrong: numbers suffer, or images are lost; look_at: it is near that, or more uncertain than need be.
enum class Verdict : std::uint8_t { ok, look_at, wrong };

std::string_view name(Verdict verdict);  ///< "ok", "look at", "wrong"

struct Advice {
  std::string_view what;  ///< one word: exposure, clipping, focus …
  double value = 0.0;
  std::string_view unit{};  ///< "%", "px" …
  std::string asked{};      ///< for; empty: nothing
  Verdict verdict = Verdict::ok;
  std::string words{};   ///< what is seen
  std::string remedy{};  ///< what to do, one line; empty: nothing
};

/// All that the photograph tells, in the order in which a photographer mends it. What it cannot tell is left
/// out.
std::vector<Advice> advise(const LightMeasures& measures);

Verdict worst(const std::vector<Advice>& advice);

/// "underexposed: …; remedy" of what is not ok, the worst first, on one line; empty: all is.
std::string in_short(const std::vector<Advice>& advice);

/// A table for a terminal: a line each, and below it the remedy of what is not ok.
std::vector<std::string> advice_lines(const std::vector<Advice>& advice);

/// {"verdict", "images", "advice": [{"what", "value", "unit", "asked", "verdict", "words", "remedy"}]} on one
/// line.
std::string advice_json(const LightMeasures& measures, const std::vector<Advice>& advice);

}  // namespace strobe::light
