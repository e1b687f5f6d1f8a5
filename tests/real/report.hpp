// What an evaluation says: tables, JSON, a row of the leaderboard, and whether the bounds hold.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "tests/real/evaluation.hpp"

namespace strobe::real {

/// What a digitizer that is fit for real light keeps, with every alteration.
struct Bounds {
  double recall = 0.97;          ///< of the photographs as they are
  double altered_recall = 0.95;  ///< with each alteration
  double invented_a_picture = 0.1;
  int ghosts = 1;
  int doubles = 0;
  double changed = 0.02;   ///< of the balls: found as they are and not altered, or the other way round
  double centre_px = 1.2;  ///< rms from the annotation, which is good to about .9 px itself
  double diameter_px = 1.5;
  double beyond_3_sd = 0.01;  ///< of the errors in x, y and the diameter, where annotated twice
};

/// One line for each bound that does not hold at the right scale; empty: all do. Where photographs are
/// annotated twice, errors must be no larger there than the annotators' differences, too: no worse than a
/// person.
std::vector<std::string> breaches(const std::vector<Outcome>& outcomes, const Bounds& bounds);

/// Tables of the alterations and of the photographs, and what the annotators differ by; why: a line for each
/// ball missed and each image that is none.
std::string tables(const std::vector<Outcome>& outcomes, const std::vector<Photograph>& photographs,
                   bool why);

/// One object per line: each outcome, each alteration's total, the annotators, and last what does not hold.
std::string json_lines(const std::vector<Outcome>& outcomes, const Bounds& bounds);

/// The table's first two lines, and one of a finder.
std::string leaderboard_head();
std::string leaderboard_row(const std::string& name, const std::vector<Outcome>& outcomes);

/// The text with its table of that name, between "<!-- leaderboard: NAME -->" and "<!-- end of leaderboard
/// -->", replaced. Fails if it has none.
Result<std::string> with_leaderboard(const std::string& text, const std::string& name,
                                     const std::string& table);

}  // namespace strobe::real
