// What was foretold of a series, beside what it became. A promise is what `strobe design --json` printed; a
// session keeps it as design.json. Thread-safe; allocates. Source of the test: a sample's variance over a
// known one is chi squared over its degrees of freedom.
#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "common/reduction/readout.hpp"
#include "common/result.hpp"
#include "host/design/prediction.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

inline constexpr const char* kDesignFile = "design.json";

/// Without budgets. Index: Quantity.
using Promise = std::array<std::optional<PredictedQuantity>, reduction::kQuantityCount>;

/// Fails for what `strobe design --json` has not printed, with "FILE: what".
Result<Promise> parse_promise(std::string_view text, const std::string& file);
/// The session's; absent: it has none. Fails as parse_promise() does.
Result<std::optional<Promise>> promise_of(const std::filesystem::path& session);

/// One quantity of a series of two or more shots.
struct Kept {
  reduction::Quantity quantity{};
  int n = 0;
  double promised_sd = 0.0, shot_sd = 0.0;       ///< one shot's total standard uncertainty; of the shots: rms
  double promised_scatter = 0.0, scatter = 0.0;  ///< of the shots about their mean
  double promised_expanded = 0.0, expanded = 0.0;  ///< half width of the mean's 95 % interval, at n shots
  /// Shots scatter more than was promised, by what chance does once in a hundred series that keep all
  /// promises; or state an uncertainty more than a quarter larger.
  bool scatter_missed = false, sd_missed = false;
};

inline constexpr double kPromiseLevel = 0.01;
inline constexpr double kPromiseMargin = 1.25;

/// Of the quantities that were promised and that the series has.
std::vector<Kept> kept(const Promise& promise, const SeriesSummary& summary, std::span<const Shot> shots);

/// A line for each; empty without any.
std::vector<std::string> render_kept(const std::vector<Kept>& kept, std::size_t width);
nlohmann::ordered_json kept_json(const std::vector<Kept>& kept);

}  // namespace strobe::host
