#include "firmware/linux/gpio_outputs.hpp"

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <vector>

#include "firmware/linux/rig_lines.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

std::vector<Line> lines_of(Output output) {
  switch (output) {
    case Output::trigger:
      return {Line::trigger};
    case Output::strobes:
      return {Line::strobe_a, Line::strobe_b};
    case Output::shutter:
      return {Line::shutter};
  }
  return {};
}

constexpr std::array<Line, 4> kOutputLines{Line::trigger, Line::strobe_a, Line::strobe_b, Line::shutter};

Result<OutputRequest> request(GpioChip& chip, const Rig& rig, Output output) {
  const std::vector<Line> group = lines_of(output);
  std::vector<unsigned> offsets;
  for (const Line which : group) {
    const auto offset = find_line(chip, rig, which);
    if (!offset) return tl::unexpected(offset.error());
    offsets.push_back(*offset);
  }
  auto taken = chip.request_outputs(offsets);
  if (taken) return std::move(*taken);
  const RequestFailure& failure = taken.error();
  return line_failure(rig, group[failure.line], request_error(chip, offsets[failure.line], failure.error));
}

}  // namespace

Result<GpioOutputs> GpioOutputs::open(const Rig& rig) {
  auto chip = open_chip(rig);
  if (!chip) return tl::unexpected(chip.error());
  GpioOutputs outputs(std::move(*chip));
  for (const Output output : kOutputs) {
    auto taken = request(outputs.chip_, rig, output);
    if (!taken) return tl::unexpected(taken.error());
    outputs.requests_[index_of(output)].emplace(std::move(*taken));
  }
  return outputs;
}

bool GpioOutputs::set(Output output, bool active) noexcept {
  const std::array<bool, 2> levels{active, active};
  auto& request = requests_[index_of(output)];
  return request && request->set(std::span(levels).first(output == Output::strobes ? 2 : 1));
}

bool GpioOutputs::set_lamps(Lamps lamps) noexcept {
  const std::array<bool, 2> levels{has_a(lamps), has_b(lamps)};
  auto& request = requests_[index_of(Output::strobes)];
  return request && request->set(levels);
}

bool GpioOutputs::make_inactive() noexcept {
  bool done = true;
  for (const Output output : kOutputs) done = set(output, false) && done;
  return done;
}

bool GpioOutputs::take_back() noexcept {
  bool done = true;
  for (auto& request : requests_) done = request && request->take_back() && done;
  return done;
}

void GpioOutputs::release() noexcept {
  for (auto& request : requests_) request.reset();
}

struct OutputTakeover::Impl {
  struct Target {
    Line which;
    unsigned offset = 0;
    std::optional<OutputRequest> request;
  };
  GpioChip chip;
  std::vector<Target> targets;

  /// Returns what is missing, and whether somebody else holds any of it.
  std::pair<std::string, bool> request_missing();
};

OutputTakeover::OutputTakeover(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OutputTakeover::OutputTakeover(OutputTakeover&&) noexcept = default;
OutputTakeover& OutputTakeover::operator=(OutputTakeover&&) noexcept = default;
OutputTakeover::~OutputTakeover() = default;

Result<OutputTakeover> OutputTakeover::prepare(const Rig& rig) {
  auto chip = open_chip(rig);
  if (!chip) return tl::unexpected(chip.error());
  auto impl = std::make_unique<Impl>(Impl{std::move(*chip), {}});
  for (const Line which : kOutputLines) {
    const auto offset = find_line(impl->chip, rig, which);
    if (!offset) return tl::unexpected(offset.error());
    impl->targets.push_back({which, *offset, {}});
  }
  return OutputTakeover(std::move(impl));
}

std::pair<std::string, bool> OutputTakeover::Impl::request_missing() {
  bool busy = false;
  std::string missing;
  for (Target& target : targets) {
    if (target.request) continue;
    auto taken = chip.request_outputs(std::span(&target.offset, 1));
    if (taken) {
      target.request.emplace(std::move(*taken));
      continue;
    }
    const int error = taken.error().error;
    missing += (missing.empty() ? "" : "; ") + std::string(line_key(target.which)) + ": " +
               request_error(chip, target.offset, error);
    busy = busy || error == EBUSY;
  }
  return {missing, busy};
}

Result<void> OutputTakeover::drive_inactive(Duration patience) {
  // Most let go within milliseconds; and a machine that stands still would use the time up without a try.
  constexpr int kQuickTries = 100;
  SystemClock clock;
  const MonoTime end = clock.now() + patience;
  for (int tries = 1;; ++tries) {
    const auto [missing, busy] = impl_->request_missing();  // whoever holds a line may let it go yet
    if (missing.empty()) return {};
    const bool quick = tries < kQuickTries;
    if (!busy || (!quick && clock.now() >= end)) return fail(missing);
    const timespec pause{0, quick ? 100'000 : 1'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
  }
}

}  // namespace strobe::firmware
