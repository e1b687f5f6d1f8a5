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

void Tables::add(const Verdict& verdict) {
  const int violated = verdict.violations.empty() ? 0 : 1;
  violated_ += violated;
  for (const auto& [title, name] : verdict.rows) {
    Row& row = tables_[title][name];
    ++row.trials;
    row.violated += violated;
    row.counts.resize(verdict.counts.size());
    for (std::size_t k = 0; k < row.counts.size(); ++k) {
      const Count &fresh = verdict.counts[k], before = row.counts[k];
      row.counts[k] = fresh;
      row.counts[k].value = fresh.largest ? std::max(before.value, fresh.value) : before.value + fresh.value;
    }
  }
}

std::string Tables::text() const {
  std::string text;
  for (const auto& [title, rows] : tables_) {
    std::string head = fmt::format("\n| {} | trials | violated |", title), line = "\n|---|---|---|", body;
    for (const Count& count : rows.begin()->second.counts) {
      head += fmt::format(" {} |", count.what);
      line += "---|";
    }
    for (const auto& [name, row] : rows) {
      body += fmt::format("\n| {} | {} | {} |", name, row.trials, row.violated);
      for (const Count& count : row.counts)
        body += fmt::format(" {:.{}f} |", count.value, count.largest ? 2 : 0);
    }
    text += head + line + body + "\n";
  }
  return text;
}

}  // namespace strobe::campaigns
