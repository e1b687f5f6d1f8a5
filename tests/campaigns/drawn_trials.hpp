// The first trials of a campaign as a test: a handful, for the thousands are tests/campaigns/run's.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>

#include "tests/campaigns/campaign.hpp"

#include <CppUTest/TestHarness.h>

namespace strobe::campaigns {

inline void expect_nothing_violated(const Verdict& verdict, const std::string& repetition = "this test") {
  const std::string text = complaint(verdict, repetition);
  CHECK_TEXT(text.empty(), (text + verdict.words).c_str());
}

/// From a seed that is printed, or $STROBE_CAMPAIGN_SEED.
inline void expect_nothing_violated(const char* kind, int trials, const Judge& judge) {
  const char* const repeated = std::getenv("STROBE_CAMPAIGN_SEED");
  const std::uint64_t seed = repeated != nullptr ? std::stoull(repeated) : std::random_device{}();
  std::printf("STROBE_CAMPAIGN_SEED=%llu repeats this\n", static_cast<unsigned long long>(seed));
  for (int number = 1; number <= trials; ++number)
    expect_nothing_violated(judged(judge, seed, number), repetition(kind, seed, number));
}

}  // namespace strobe::campaigns
