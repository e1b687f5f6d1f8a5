// What a series says, for a person: scatter, standard error, what the shots share, and the total;
// differences; budgets. Numbers have two significant digits of their total uncertainty (GUM 7.2.6). Pure;
// thread-safe.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/data/thesis_data.hpp"
#include "common/reduction/readout.hpp"
#include "common/reduction/uncertainty.hpp"
#include "host/series/compare.hpp"
#include "host/series/series.hpp"

namespace strobe::host {

/// Of a person's first reading: not the slip. The court pace is there where shots conform to ITF CS 01/02.
bool is_essential(reduction::Quantity q);

/// Of a series that ended by what it said (SeriesSummary::until_known): that it did, a sentence.
std::string sequential_words(const SeriesSummary& summary);

/// Where at least two shots and half of them have a tilted spin axis, or leave the photograph's plane: by how
/// much, and what to do, a sentence each.
std::vector<std::string> alignment_words(const SeriesSummary& summary);

/// "zero 23: 9 shots counted, 1 rejected", a row for each quantity, and outliers. `all`: every quantity, else
/// the essential ones. Without a counted shot a sentence.
std::vector<std::string> render_summary(const SeriesSummary& summary,
                                        const std::optional<thesis::Condition>& condition, std::size_t width,
                                        bool all = false);

/// The budget's lines of one quantity.
std::vector<std::string> render_budget(const std::string& title, const std::vector<BudgetLine>& lines,
                                       reduction::Quantity q, std::size_t width);

/// Differences of `first` less `second`.
std::vector<std::string> render_comparison(const std::string& first, const std::string& second,
                                           const Comparison& comparison, std::size_t width, bool all = false);

/// Whether draws bear the stated intervals out, a row for each quantity.
std::vector<std::string> render_monte_carlo(const reduction::MonteCarlo& drawn, const std::string& shot,
                                            std::size_t width, bool all = false);

// The thesis's numbers beside one's own. Pure; thread-safe.

/// "thesis zero 23, Tables 2, 5, 8"
std::string thesis_title(const thesis::Condition& condition);

/// What the thesis printed of the quantity; absent: nothing.
std::optional<thesis::MeanSd> thesis_number(const thesis::Condition& condition, reduction::Quantity q);

/// Mean, sd, and how far `mean` is from it in its sds; empty where the thesis has none.
std::string thesis_cells(const thesis::Condition& condition, reduction::Quantity q,
                         const std::optional<double>& mean);

}  // namespace strobe::host
