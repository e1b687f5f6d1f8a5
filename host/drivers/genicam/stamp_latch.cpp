#include "host/drivers/genicam/stamp_latch.hpp"

#include <poll.h>

#include <charconv>
#include <cmath>
#include <vector>

#include "host/clock/machine_clock.hpp"

namespace strobe::genicam {
namespace {

// GigE Vision 2.0, 28.2: bootstrap registers.
constexpr std::uint32_t kTicksHigh = 0x093C, kTicksLow = 0x0940;
constexpr std::uint32_t kControl = 0x0944, kLatch = 2;
constexpr std::uint32_t kValueHigh = 0x0948, kValueLow = 0x094C;
constexpr std::uint64_t kMaxTicks_per_s = 10'000'000'000;
constexpr int kApart_ms = 30;
// Of a feature that says nothing of its steps.
constexpr Duration kUnknownResolution = microseconds{1};

std::optional<std::uint64_t> whole_number(const Result<std::string>& text) {
  std::uint64_t number = 0;
  if (!text) return std::nullopt;
  const char* end = text->data() + text->size();
  const auto [at, fault] = std::from_chars(text->data(), end, number);
  if (fault != std::errc{} || at != end) return std::nullopt;
  return number;
}

std::optional<std::uint64_t> long_register(const Camera& camera, std::uint32_t high, std::uint32_t low) {
  const auto upper = camera.read_register(high);
  const auto lower = camera.read_register(low);
  if (!upper || !lower) return std::nullopt;
  return std::uint64_t{*upper} << 32 | *lower;
}

}  // namespace

std::optional<StampLatch> StampLatch::find(Camera& camera) {
  std::vector<StampLatch> ways;
  const auto add = [&](std::string command, std::string value, std::optional<std::uint64_t> ticks_per_s,
                       Duration resolution) {
    if (ticks_per_s && (*ticks_per_s == 0 || *ticks_per_s > kMaxTicks_per_s)) return;
    StampLatch way;
    way.command_ = std::move(command);
    way.value_ = std::move(value);
    way.ticks_per_s_ = ticks_per_s.value_or(0);
    way.resolution_ = ticks_per_s ? from_seconds(1.0 / static_cast<double>(*ticks_per_s)) : resolution;
    if (way.resolution_ < Duration{1}) way.resolution_ = Duration{1};
    ways.push_back(std::move(way));
  };
  if (camera.is_gige()) {
    // What Aravis reckons the frames' stamps by, too.
    if (const auto ticks = long_register(camera, kTicksHigh, kTicksLow)) add("", "", ticks, {});
    if (const auto ticks = whole_number(camera.get("GevTimestampTickFrequency")))
      add("GevTimestampControlLatch", "GevTimestampValue", ticks, {});
  }
  const auto step_ns = whole_number(camera.get("TimestampIncrement")).value_or(0);
  const bool known = step_ns > 0 && step_ns < 1'000'000'000;
  const Duration resolution = known ? Duration{static_cast<std::int64_t>(step_ns)} : kUnknownResolution;
  for (const char* value : {"TimestampLatchValue", "Timestamp"}) add("TimestampLatch", value, {}, resolution);
  for (const StampLatch& way : ways) {
    if (way.goes_right(camera)) return way;
  }
  return std::nullopt;
}

bool StampLatch::latch(Camera& camera) const {
  if (command_.empty()) return camera.write_register(kControl, kLatch);
  return camera.kind(command_) == Kind::command && camera.execute(command_).has_value();
}

std::optional<std::uint64_t> StampLatch::latched(const Camera& camera) const {
  return command_.empty() ? long_register(camera, kValueHigh, kValueLow) : whole_number(camera.get(value_));
}

std::optional<host::ClockExchange> StampLatch::exchange(Camera& camera) const {
  host::ClockExchange exchange;
  exchange.before = host::steady_now();
  const bool good = latch(camera);
  exchange.after = host::steady_now();
  if (!good) return std::nullopt;
  const auto value = latched(camera);
  if (!value) return std::nullopt;
  std::uint64_t stamp_ns = *value;
  // As Aravis reckons, so that frames' stamps are rounded alike.
  if (ticks_per_s_ != 0)
    stamp_ns = *value / ticks_per_s_ * 1'000'000'000 +
               *value % ticks_per_s_ * std::uint64_t{1'000'000'000} / ticks_per_s_;
  if (stamp_ns >= kMaxStamp_ns) return std::nullopt;
  exchange.camera_ns = static_cast<std::int64_t>(stamp_ns);
  return exchange;
}

bool StampLatch::goes_right(Camera& camera) const {
  const auto first = exchange(camera);
  poll(nullptr, 0, kApart_ms);
  const auto second = exchange(camera);
  if (!first || !second) return false;
  const double passed_s = to_seconds(Duration{second->camera_ns - first->camera_ns});
  const double least_s = to_seconds(second->before - first->after),
               most_s = to_seconds(second->after - first->before);
  const double rounding_s = to_seconds(resolution_);
  return passed_s > 0.99 * least_s - rounding_s && passed_s < 1.01 * most_s + rounding_s;
}

}  // namespace strobe::genicam
