#include "tests/studies/digitize/reliability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace strobe::studies::digitize {

namespace {

constexpr std::array<double, 9> kUpTo{0.2, 0.5, 0.8, 0.9, 0.95, 0.99, 0.999, 0.9999, 1.0};

}  // namespace

void Reliability::add(double probability, Is what) {
  classes_.resize(kUpTo.size());
  std::size_t at = 0;
  while (at + 1 < kUpTo.size() && probability >= kUpTo[at]) ++at;
  Class& of = classes_[at];
  ++of.images;
  of.stated += probability;
  of.balls += what == Is::ball ? 1 : 0;
  of.others += what == Is::other_ball ? 1 : 0;
}

void Reliability::add(const Reliability& other) {
  classes_.resize(kUpTo.size());
  for (std::size_t i = 0; i < other.classes_.size(); ++i) {
    classes_[i].images += other.classes_[i].images;
    classes_[i].balls += other.classes_[i].balls;
    classes_[i].others += other.classes_[i].others;
    classes_[i].stated += other.classes_[i].stated;
  }
}

void Reliability::print() const {
  constexpr double kZ = 1.96;
  fmt::print("\n{:<18} {:>7} {:>7} {:>11} {:>8} {:>16} {:>8}\n", "stated probability", "images", "balls",
             "2nd ball's", "share", "95 %", "stated");
  for (std::size_t i = 0; i < classes_.size(); ++i) {
    const Class& of = classes_[i];
    if (of.images == 0) continue;
    const double n = of.images, share = of.balls / n, wide = 1.0 + kZ * kZ / n;
    const double middle = (share + 0.5 * kZ * kZ / n) / wide;
    const double half = kZ * std::sqrt(share * (1.0 - share) / n + 0.25 * kZ * kZ / (n * n)) / wide;
    fmt::print("{:<18} {:>7} {:>7} {:>11} {:>8.4f} {:>7.4f} - {:.4f} {:>8.4f}\n",
               fmt::format("{:g} to {:g}", i == 0 ? 0.0 : kUpTo[i - 1], kUpTo[i]), of.images, of.balls,
               of.others, share, middle - half, std::min(1.0, middle + half), of.stated / n);
  }
}

}  // namespace strobe::studies::digitize
