// Campaigns: trials drawn from a seed, each run and judged, counted in tables, and named by the command that repeats it.
// What is tried and what must hold are the judges', in the files beside this one. One thread.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace strobe::campaigns {

/// What chance decides in one trial: the same for the same seed and number.
class Draws {
 public:
  Draws(std::uint64_t seed, int number);
  int number() const { return number_; }
  /// For what draws by itself: another one in each trial.
  std::uint64_t seed() const { return seed_ + static_cast<std::uint64_t>(number_); }

  int between(int least, int most);
  bool chance(double probability);
  int weighted(const std::vector<int>& weights);  ///< which of them
  template <typename Choices>
  auto choice(const Choices& choices) {
    return choices[static_cast<std::size_t>(between(0, static_cast<int>(choices.size()) - 1))];
  }

 private:
  std::uint64_t seed_;
  int number_;
  std::mt19937_64 random_;
};

struct Verdict {
  std::vector<std::string> violations;      ///< what must never be and was, in words
  std::string trial;                        ///< what was done, in a line
  std::string words;                        ///< what the programs said, for who looks for the cause
  std::map<std::string, std::string> rows;  ///< by the title of a table: the row that it counts in
  std::map<std::string, double> counts;     ///< for those rows; tables have their sums
  std::map<std::string, double> largest;    ///< of which tables have the largest

  void count(const std::string& what, double times = 1.0) { counts[what] += times; }
  template <typename... Args>
  void violate(fmt::format_string<Args...> format, Args&&... args) {
    violations.push_back(fmt::format(format, std::forward<Args>(args)...));
  }
};

using Judge = std::function<Verdict(Draws&)>;

/// The verdict; an exception is a violation.
Verdict judged(const Judge& judge, std::uint64_t seed, int number);

/// The command, with the options that the trial depends on.
std::string repetition(const std::string& kind, std::uint64_t seed, int number,
                       const std::string& options = "");

/// All violations, with the command that repeats them; empty: none.
std::string complaint(const Verdict& verdict, const std::string& repetition);

/// The trial and what was counted, in a line.
std::string summary(const Verdict& verdict);

/// How often what came of the trials.
class Tables {
 public:
  void add(const Verdict& verdict);
  std::string text() const;
  int violated() const { return violated_; }

 private:
  struct Row {
    int trials = 0, violated = 0;
    std::map<std::string, double> counts, largest;
  };
  std::map<std::string, std::map<std::string, Row>> tables_;  ///< by title and name
  int violated_ = 0;
};

}  // namespace strobe::campaigns
