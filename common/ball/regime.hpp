// What the contact point did during an impact. Plain value; thread-safe, real-time safe.
#pragma once

#include <string_view>

namespace strobe {

enum class Regime {
  slides,  ///< friction was at its limit throughout
  grips,   ///< the contact point came to a stop before lift-off
  unclear  ///< a measurement does not tell; never a model's
};

constexpr std::string_view name(Regime regime) {
  return regime == Regime::slides ? "slides" : regime == Regime::grips ? "grips" : "unclear";
}

}  // namespace strobe
