#include "tests/fuzz/mutate.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <string_view>

namespace strobe::fuzz {
namespace {

constexpr std::size_t kLongestInput = 1U << 16;
constexpr std::array<std::string_view, 20> kTokens{"nan",
                                                   "inf",
                                                   "-inf",
                                                   "-0",
                                                   "1e309",
                                                   "-1e309",
                                                   "4.9e-324",
                                                   "2147483647",
                                                   "2147483648",
                                                   "-1",
                                                   "9223372036854775807",
                                                   "-9223372036854775808",
                                                   "null",
                                                   "true",
                                                   "[",
                                                   "]",
                                                   "{",
                                                   "}",
                                                   "\"",
                                                   "\n"};

using Random = std::mt19937_64;

std::size_t below(Random& random, std::size_t limit) { return static_cast<std::size_t>(random() % limit); }

void flip_bit(std::string& text, Random& random) {
  char& byte = text[below(random, text.size())];
  byte = static_cast<char>(static_cast<unsigned char>(byte) ^ (1U << below(random, 8)));
}

void repeat_part(std::string& text, Random& random) {
  const std::size_t from = below(random, text.size());
  const std::string part =
      text.substr(from, 1 + below(random, std::min<std::size_t>(64, text.size() - from)));
  text.insert(below(random, text.size() + 1), part);
}

/// A number in the text becomes one at the edge of some range.
void change_number(std::string& text, Random& random) {
  const std::size_t from = text.find_first_of("0123456789", below(random, text.size()));
  if (from == std::string::npos) return;
  const std::size_t to = text.find_first_not_of("0123456789.eE+-", from);
  text.replace(from, (to == std::string::npos ? text.size() : to) - from,
               kTokens[below(random, kTokens.size())]);
}

void step(std::string& text, const std::vector<std::string>& seeds, Random& random) {
  if (text.empty()) {
    text.push_back(static_cast<char>(random()));
    return;
  }
  switch (below(random, 8)) {
    case 0:
      flip_bit(text, random);
      break;
    case 1:
      text[below(random, text.size())] = static_cast<char>(random());
      break;
    case 2:
      text.insert(below(random, text.size() + 1), 1, static_cast<char>(random()));
      break;
    case 3:
      text.erase(below(random, text.size()), 1 + below(random, 16));
      break;
    case 4:
      text.insert(below(random, text.size() + 1), kTokens[below(random, kTokens.size())]);
      break;
    case 5:
      repeat_part(text, random);
      break;
    case 6:
      change_number(text, random);
      break;
    case 7: {
      const std::string& other = seeds[below(random, seeds.size())];
      text.resize(below(random, text.size() + 1));
      text += other.substr(below(random, other.size() + 1));
      break;
    }
  }
  if (text.size() > kLongestInput) text.resize(kLongestInput);
}

}  // namespace

std::string mutated(const std::vector<std::string>& seeds, std::uint64_t seed, std::uint64_t run) {
  std::seed_seq mix{seed, seed >> 32U, run, run >> 32U};
  Random random(mix);
  const std::vector<std::string> nothing{std::string()};
  const std::vector<std::string>& choice = seeds.empty() ? nothing : seeds;
  std::string text = choice[below(random, choice.size())];
  const std::size_t steps = 1 + below(random, 8);
  for (std::size_t i = 0; i < steps; ++i) step(text, choice, random);
  return text;
}

}  // namespace strobe::fuzz
