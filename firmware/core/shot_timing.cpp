#include "firmware/core/shot_timing.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>

namespace strobe::firmware {

void ShotTiming::issued(MonoTime commanded, MonoTime start, MonoTime end) noexcept {
  add(TimingQuantity::lateness, start - commanded);
  add(TimingQuantity::issue, end - start);
}

void ShotTiming::seen(const ShotRecord& shot) noexcept {
  const FlashRecord* before = nullptr;
  for (const FlashRecord& flash : shot.flashes) {
    // A sensor may see the other lamp as well: that tells nothing of its own.
    const bool a = known(flash.observed_a) && has_a(flash.lamps);
    const bool b = known(flash.observed_b) && has_b(flash.lamps);
    if (a && b) add(TimingQuantity::skew, flash.observed_a - flash.observed_b);
    if (a && known(flash.issue_end)) add(TimingQuantity::lamp_delay_a, flash.observed_a - flash.issue_end);
    if (b && known(flash.issue_end)) add(TimingQuantity::lamp_delay_b, flash.observed_b - flash.issue_end);
    if (before != nullptr) add_interval(*before, flash);
    before = &flash;
  }
}

/// Of one sensor each, so that what differs between the sensors is not taken for an error of the period.
void ShotTiming::add_interval(const FlashRecord& before, const FlashRecord& flash) noexcept {
  std::int64_t sum_ns = 0;
  int sensors = 0;
  for (const auto observed : {&FlashRecord::observed_a, &FlashRecord::observed_b}) {
    if (!known(before.*observed) || !known(flash.*observed)) continue;
    sum_ns += (flash.*observed - before.*observed).count();
    ++sensors;
  }
  if (sensors == 0) return;
  add(TimingQuantity::period_error, nanoseconds(sum_ns / sensors) - (flash.commanded - before.commanded));
}

namespace {

/// The smallest of 1, 2, 5, 10, 20 ... that is not below it.
std::int64_t round_up(std::int64_t ns) {
  std::int64_t decade = 1;
  while (decade * 10 <= ns) decade *= 10;
  for (const std::int64_t step : {1, 2, 5}) {
    if (step * decade >= ns) return step * decade;
  }
  return 10 * decade;
}

std::int64_t floor_to(std::int64_t value, std::int64_t step) {
  const std::int64_t rest = value % step;
  return value - (rest < 0 ? rest + step : rest);
}

/// Also of the least number, which has no positive counterpart.
std::uint64_t magnitude(Duration value) {
  const auto ns = static_cast<std::uint64_t>(value.count());
  return value < Duration{} ? -ns : ns;
}

}  // namespace

std::size_t TimingHistogram::bin_of(std::uint64_t magnitude_ns) noexcept {
  const int octave = std::max(0, static_cast<int>(std::bit_width(magnitude_ns)) - kStepBits - 1);
  const std::size_t bin =
      (static_cast<std::size_t>(octave) << kStepBits) + static_cast<std::size_t>(magnitude_ns >> octave);
  return std::min(bin, kBins - 1);
}

std::int64_t TimingHistogram::first_of(std::size_t bin) noexcept {
  const std::size_t first_octave = std::size_t{2} << kStepBits;
  if (bin < first_octave) return static_cast<std::int64_t>(bin);
  const std::size_t octave = (bin >> kStepBits) - 1;
  return static_cast<std::int64_t>((bin - (octave << kStepBits)) << octave);
}

std::int64_t TimingHistogram::last_of(std::size_t bin) noexcept { return first_of(bin + 1) - 1; }

void TimingHistogram::add(Duration value) noexcept {
  const bool below = value < Duration{};
  const std::size_t index = bin_of(magnitude(value));
  std::uint32_t& bin = (below ? negative_ : positive_)[index];
  if (bin < std::numeric_limits<std::uint32_t>::max()) {
    ++bin;
    ++in_octave_[below ? 0 : 1][index >> kStepBits];
  }
  min_ = count_ == 0 ? value : std::min(min_, value);
  max_ = count_ == 0 ? value : std::max(max_, value);
  ++count_;
  const double before = static_cast<double>(value.count()) - mean_ns_;
  mean_ns_ += before / static_cast<double>(count_);
  squares_ns2_ += before * (static_cast<double>(value.count()) - mean_ns_);
}

double TimingHistogram::sd_ns() const noexcept {
  return count_ == 0 ? 0.0 : std::sqrt(squares_ns2_ / static_cast<double>(count_));
}

/// From the most negative bin to the most positive: its smallest and largest value, how many are in it. Until
/// the visitor has seen enough (true). Octaves are passed over if skip(how many are in it).
template <typename Skip, typename Visit>
void TimingHistogram::visit_in_order(Skip&& skip, Visit&& visit) const noexcept {
  constexpr std::size_t kSteps = std::size_t{1} << kStepBits;
  for (std::size_t octave = kOctaves; octave-- > 0;) {
    if (skip(in_octave_[0][octave])) continue;
    for (std::size_t bin = (octave + 1) * kSteps; bin-- > octave * kSteps;) {
      if (negative_[bin] > 0 && visit(-last_of(bin), -first_of(bin), negative_[bin])) return;
    }
  }
  for (std::size_t octave = 0; octave < kOctaves; ++octave) {
    if (skip(in_octave_[1][octave])) continue;
    for (std::size_t bin = octave * kSteps; bin < (octave + 1) * kSteps; ++bin) {
      if (positive_[bin] > 0 && visit(first_of(bin), last_of(bin), positive_[bin])) return;
    }
  }
}

Duration TimingHistogram::percentile(double share) const noexcept {
  assert(share >= 0.0 && share <= 1.0);
  if (count_ == 0) return Duration{};
  const auto wanted =
      std::max<std::int64_t>(1, static_cast<std::int64_t>(std::ceil(share * static_cast<double>(count_))));
  std::int64_t seen = 0;
  std::int64_t value = max_.count();
  const auto below_wanted = [&](std::int64_t n) {
    if (seen + n >= wanted) return false;
    seen += n;
    return true;
  };
  visit_in_order(below_wanted, [&](std::int64_t, std::int64_t last, std::uint32_t n) {
    seen += n;
    if (seen < wanted) return false;
    value = last;
    return true;
  });
  return nanoseconds(std::clamp(value, min_.count(), max_.count()));
}

TimingHistogram::Coarse TimingHistogram::coarse() const noexcept {
  Coarse result;
  if (count_ == 0) return result;
  const std::int64_t low = percentile(0.005).count();
  const std::int64_t high = percentile(0.995).count();
  const std::int64_t largest = std::max(std::abs(low), std::abs(high));
  // A bin no wider than a step of the table would show the table.
  const std::int64_t step = last_of(bin_of(static_cast<std::uint64_t>(largest))) -
                            first_of(bin_of(static_cast<std::uint64_t>(largest))) + 1;
  constexpr auto kInner = static_cast<std::int64_t>(Coarse::kMax - 2);
  const std::int64_t width = round_up(std::max((high - low + kInner - 1) / kInner, step == 1 ? 1 : 4 * step));
  result.width = nanoseconds(width);
  result.first = nanoseconds(floor_to(low, width));
  result.count = static_cast<std::size_t>(std::min<std::int64_t>((high - result.first.count()) / width + 1,
                                                                 static_cast<std::int64_t>(Coarse::kMax)));
  const auto empty = [](std::int64_t n) { return n == 0; };
  visit_in_order(empty, [&](std::int64_t first, std::int64_t last, std::uint32_t n) {
    const std::int64_t middle = first + (last - first) / 2;
    const std::int64_t bin = (floor_to(middle, width) - result.first.count()) / width;
    const auto at = std::clamp<std::int64_t>(bin, 0, static_cast<std::int64_t>(result.count) - 1);
    result.bins[static_cast<std::size_t>(at)] += n;
    return false;
  });
  return result;
}

}  // namespace strobe::firmware
