#include "tests/campaigns/campaign.hpp"

#include <algorithm>
#include <stdexcept>

namespace strobe::campaigns {

Draws::Draws(std::uint64_t seed, int number) : seed_(seed), number_(number) {
  std::seed_seq words{static_cast<std::uint32_t>(seed), static_cast<std::uint32_t>(seed >> 32),
                      static_cast<std::uint32_t>(number)};
  random_.seed(words);
}

int Draws::between(int least, int most) { return std::uniform_int_distribution<int>(least, most)(random_); }
bool Draws::chance(double probability) { return std::bernoulli_distribution(probability)(random_); }
int Draws::weighted(const std::vector<int>& weights) {
  return std::discrete_distribution<int>(weights.begin(), weights.end())(random_);
}

Verdict judged(const Judge& judge, std::uint64_t seed, int number) {
  Draws draws(seed, number);
  try {
    return judge(draws);
  } catch (const std::runtime_error& error) {
    Verdict verdict;
    verdict.violate("{}", error.what());
    return verdict;
  }
}

std::string repetition(const std::string& kind, std::uint64_t seed, int number, const std::string& options) {
  return fmt::format("strobe-campaign {} --seed {} --only {}{}", kind, seed, number, options);
}

std::string complaint(const Verdict& verdict, const std::string& repetition) {
  std::string text;
  for (const std::string& violation : verdict.violations)
    text += fmt::format("VIOLATION: {} ({}); repeat it: {}\n", violation, verdict.trial, repetition);
  return text;
}

std::string summary(const Verdict& verdict) {
  std::string text = verdict.trial;
  for (const auto* counts : {&verdict.counts, &verdict.largest})
    for (const auto& [what, value] : *counts)
      if (value != 0.0) text += fmt::format("; {}: {:.6g}", what, value);
  return text;
}

void Tables::add(const Verdict& verdict) {
  const int violated = verdict.violations.empty() ? 0 : 1;
  violated_ += violated;
  for (const auto& [title, name] : verdict.rows) {
    Row& row = tables_[title][name];
    ++row.trials;
    row.violated += violated;
    for (const auto& [what, value] : verdict.counts) row.counts[what] += value;
    for (const auto& [what, value] : verdict.largest) row.largest[what] = std::max(row.largest[what], value);
  }
}

std::string Tables::text() const {
  std::string text;
  for (const auto& [title, rows] : tables_) {
    std::string head = fmt::format("\n| {} | trials | violated |", title), line = "\n|---|---|---|", body;
    std::map<std::string, double> counts, largest;  // of all rows, for the columns
    for (const auto& [name, row] : rows) {
      counts.insert(row.counts.begin(), row.counts.end());
      largest.insert(row.largest.begin(), row.largest.end());
    }
    for (const auto* columns : {&counts, &largest})
      for (const auto& [what, any] : *columns) head += fmt::format(" {} |", what), line += "---|";
    for (const auto& [name, row] : rows) {
      body += fmt::format("\n| {} | {} | {} |", name, row.trials, row.violated);
      for (const auto& [what, any] : counts)
        body += fmt::format(" {:.0f} |", row.counts.contains(what) ? row.counts.at(what) : 0.0);
      for (const auto& [what, any] : largest)
        body += fmt::format(" {:.2f} |", row.largest.contains(what) ? row.largest.at(what) : 0.0);
    }
    text += head + line + body + "\n";
  }
  return text;
}

}  // namespace strobe::campaigns
