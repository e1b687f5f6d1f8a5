// The screen of `strobe fire` and `strobe live` as lines of text: a pure function of what is to be shown.
// No I/O, no escape codes; thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/view/view_model.hpp"

namespace strobe::host {

/// At most width columns a line; narrow terminals lose the series' columns before the shot's numbers.
std::vector<std::string> render(const ViewModel& model, std::size_t width);

/// Parts of it, for plain output.
std::vector<std::string> render_firmware(const ViewModel& model, std::size_t width);
/// The essential numbers (series_view.hpp) with their total standard uncertainty. `all`: every number, what its uncertainty
/// is made of, and which flashes show the ball.
std::vector<std::string> render_shot(const ShotResult& shot_result, std::size_t width, bool all = false);
/// render_summary() of the series.
std::vector<std::string> render_series(const Series& series,
                                       const std::optional<thesis::Condition>& condition, std::size_t width,
                                       bool all = false);

}  // namespace strobe::host
