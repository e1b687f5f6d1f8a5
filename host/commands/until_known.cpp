#include "host/commands/until_known.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "host/series/select.hpp"
#include "host/text/text.hpp"

namespace strobe::host {
namespace {

/// To its two digits.
std::string two_digits(double number) { return rounded(number, number); }

std::string known_words(const Known& known) {
  const auto name = reduction::name(known.wanted.quantity);
  if (!known.half_width) return fmt::format("{} ± {:.3g} wanted", name, known.wanted_half_width);
  return fmt::format("{} ± {} of {:.3g} wanted", name, two_digits(*known.half_width),
                     known.wanted_half_width);
}

std::string never_words(const Known& known) {
  const auto name = reduction::name(known.wanted.quantity);
  if (known.state == Known::State::no_value)
    return fmt::format("--until-known: none of {} shots tells {}", kMinSequentialShots, name);
  return fmt::format(
      "--until-known: {} ± {:.3g} cannot be had: what all shots share (calibration, ball) makes it ± {} "
      "alone",
      name, known.wanted_half_width, two_digits(known.shared_half_width));
}

bool is_never(const Known& known) {
  return known.state == Known::State::never || known.state == Known::State::no_value;
}

}  // namespace

UntilKnown::UntilKnown(std::vector<Wanted> wanted, std::shared_ptr<const RigFile> rig,
                       std::vector<Shot> earlier)
    : wanted_(std::move(wanted)), rig_(std::move(rig)), shots_(std::move(earlier)) {
  std::erase_if(shots_, [](const Shot& shot) { return shot.rejected || shot.dry; });
  if (!shots_.empty()) judge();
}

void UntilKnown::add(const Shot& result) {
  std::erase_if(shots_, [&](const Shot& shot) { return shot.key() == result.key(); });
  Shot own = result;
  own.rig = rig_;
  shots_.push_back(series_shot(own));
  judge();
}

void UntilKnown::judge() {
  Series series;
  for (const Shot& shot : shots_)
    if (differing_keys({&shots_.back(), &shot}).empty()) series.add(shot);
  const SeriesSummary summary = series.summary("");
  known_.clear();
  for (const Wanted& each : wanted_) known_.push_back(known_so_far(summary, each));
}

bool UntilKnown::enough() const {
  const auto is_known = [](const Known& known) { return known.state == Known::State::known; };
  return !known_.empty() && std::ranges::all_of(known_, is_known);
}

std::string UntilKnown::why_never() const {
  const auto found = std::ranges::find_if(known_, is_never);
  return found == known_.end() ? "" : never_words(*found);
}

std::string UntilKnown::line() const {
  std::string text;
  int more = 0;
  for (const Known& known : known_) {
    text += (text.empty() ? "" : ", ") + known_words(known);
    more = std::max(more, known.more.value_or(kMinSequentialShots - known.n));
  }
  if (more == 0) return text;
  return text + fmt::format("; about {} more {}", more, more == 1 ? "shot" : "shots");
}

}  // namespace strobe::host
