#include "common/config/nearest.hpp"

#include <algorithm>
#include <cctype>

namespace strobe::config {
namespace {

/// Lower case, without leading dashes and a value after "=".
std::string bare(const std::string& typed) {
  const std::size_t first = std::min(typed.find_first_not_of('-'), typed.size());
  std::string name = typed.substr(first, typed.find('=', first) - first);
  for (char& c : name) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return name;
}

/// Letters left out, added, changed, or swapped with their neighbour (optimal string alignment).
std::size_t edits(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> least(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        least[i][j] = i + j;
        continue;
      }
      least[i][j] = std::min(
          {least[i - 1][j] + 1, least[i][j - 1] + 1, least[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0u : 1u)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        least[i][j] = std::min(least[i][j], least[i - 2][j - 2] + 1);
    }
  }
  return least[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> nearest(const std::string& typed, const std::vector<std::string>& names) {
  const std::string wanted = bare(typed);
  if (wanted.empty()) return std::nullopt;
  const std::size_t most = std::clamp<std::size_t>(wanted.size() / 3, 1, 3);
  std::optional<std::string> best;
  std::size_t least = most + 1;
  for (const std::string& name : names) {
    const std::string known = bare(name);
    const bool begun = wanted.size() >= 3 && known.starts_with(wanted);
    const std::size_t distance = begun ? 1 : edits(wanted, known);
    if (distance >= least || distance >= known.size()) continue;
    least = distance;
    best = name;
  }
  return best;
}

std::string did_you_mean(const std::string& typed, const std::vector<std::string>& names) {
  const auto meant = nearest(typed, names);
  return meant ? "; did you mean " + *meant + "?" : "";
}

}  // namespace strobe::config
