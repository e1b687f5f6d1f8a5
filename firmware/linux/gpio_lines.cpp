#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "firmware/linux/gpio_chip.hpp"
#include "firmware/linux/gpio_lines.hpp"
#include "firmware/linux/input_bias.hpp"
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

struct InputLine {
  Input input;
  Line line;
  bool both_edges;
};
constexpr std::array<InputLine, 6> kInputs{{{Input::estop, Line::estop, true},
                                            {Input::key, Line::key, true},
                                            {Input::gate, Line::gate, false},
                                            {Input::sensor_a, Line::sensor_a, false},
                                            {Input::sensor_b, Line::sensor_b, false},
                                            {Input::xsync, Line::xsync, true}}};

timespec until_timeout(MonoTime until) {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  const std::int64_t left =
      std::max<std::int64_t>(0, to_ns(until) - (now.tv_sec * 1'000'000'000 + now.tv_nsec));
  return {left / 1'000'000'000, left % 1'000'000'000};
}

}  // namespace

struct GpioLines::Impl {
  std::optional<GpioChip> chip;
  std::array<std::optional<OutputRequest>, kOutputs.size()> outputs;
  std::optional<InputRequest> request;
  std::vector<Input> inputs;   // in the order of their request
  std::vector<pollfd> polled;  // the request's descriptors, in their order, then the wake-up
  std::array<LineEdge, 64> taken;
  std::vector<std::string> warnings;

  Result<void> take_outputs(const Rig& rig);
  Result<void> take_inputs(const Rig& rig);
  bool drain(std::size_t i, std::span<Edge> edges, std::size_t& count) noexcept;
  /// What poll(2) has found: 0 nothing, below 0 an error.
  std::optional<std::size_t> take(int ready, std::span<Edge> edges) noexcept;
};

Result<void> GpioLines::Impl::take_outputs(const Rig& rig) {
  for (const Output output : kOutputs) {
    const std::vector<Line> group = lines_of(output);
    std::vector<OutputLineSpec> specs;
    for (const Line which : group) {
      const auto offset = find_line(*chip, rig, which);
      if (!offset) return tl::unexpected(offset.error());
      specs.push_back({*offset, rig.line(which).active_low});
    }
    auto taken_lines = chip->request_outputs(specs);
    if (!taken_lines) {
      const RequestFailure& failure = taken_lines.error();
      return line_failure(rig, group[failure.line],
                          request_error(*chip, specs[failure.line].offset, failure.error));
    }
    outputs[index_of(output)].emplace(std::move(*taken_lines));
  }
  return {};
}

Result<void> GpioLines::Impl::take_inputs(const Rig& rig) {
  std::vector<InputLineSpec> specs;
  std::vector<Line> lines;
  for (const InputLine& input : kInputs) {
    if (!rig.line(input.line).fitted) continue;
    const auto offset = find_line(*chip, rig, input.line);
    if (!offset) return tl::unexpected(offset.error());
    const LineConfig& config = rig.line(input.line);
    specs.push_back({*offset, config.active_low, input.both_edges, config.bias});
    lines.push_back(input.line);
    inputs.push_back(input.input);
  }
  auto taken_lines = request_biased(*chip, rig, lines, specs);
  if (!taken_lines) return tl::unexpected(taken_lines.error());
  request.emplace(std::move(taken_lines->request));
  warnings = std::move(taken_lines->warnings);
  for (const int descriptor : request->descriptors()) polled.push_back({descriptor, POLLIN, 0});
  return {};
}

GpioLines::GpioLines(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpioLines::~GpioLines() = default;

Result<std::unique_ptr<GpioLines>> GpioLines::open(const Rig& rig, int wake_fd) {
  auto impl = std::make_unique<Impl>();
  auto chip = open_chip(rig);
  if (!chip) return tl::unexpected(chip.error());
  impl->chip.emplace(std::move(*chip));
  if (auto taken = impl->take_outputs(rig); !taken) return tl::unexpected(taken.error());
  if (auto taken = impl->take_inputs(rig); !taken) return tl::unexpected(taken.error());
  impl->polled.push_back({wake_fd, POLLIN, 0});
  return std::unique_ptr<GpioLines>(new GpioLines(std::move(impl)));
}

bool GpioLines::set(Output output, bool active) noexcept {
  const std::array<bool, 2> levels{active, active};
  auto& request = impl_->outputs[index_of(output)];
  return request && request->set(std::span(levels).first(output == Output::strobes ? 2 : 1));
}

bool GpioLines::set_lamps(Lamps lamps) noexcept {
  const std::array<bool, 2> levels{has_a(lamps), has_b(lamps)};
  auto& request = impl_->outputs[index_of(Output::strobes)];
  return request && request->set(levels);
}

void GpioLines::release_outputs() noexcept {
  for (auto& request : impl_->outputs) request.reset();
}

bool GpioLines::Impl::drain(std::size_t i, std::span<Edge> edges, std::size_t& count) noexcept {
  const std::size_t room = std::min(edges.size() - count, taken.size());
  const auto read = request->read(i, std::span(taken).first(room));
  if (!read) return false;
  for (std::size_t k = 0; k < *read; ++k)
    edges[count++] = {inputs[taken[k].line], taken[k].time, taken[k].active};
  return true;
}

std::optional<std::size_t> GpioLines::wait(MonoTime until, std::span<Edge> edges) noexcept {
  const timespec timeout = until_timeout(until);
  return impl_->take(ppoll(impl_->polled.data(), impl_->polled.size(), &timeout, nullptr), edges);
}

std::optional<std::size_t> GpioLines::poll(MonoTime until, std::span<Edge> edges) noexcept {
  constexpr timespec kAtOnce{};
  SystemClock clock;
  int ready = 0;
  do ready = ppoll(impl_->polled.data(), impl_->polled.size(), &kAtOnce, nullptr);
  while (ready == 0 && clock.now() < until);
  return impl_->take(ready, edges);
}

std::optional<std::size_t> GpioLines::Impl::take(int ready, std::span<Edge> edges) noexcept {
  if (ready == 0 || (ready < 0 && errno == EINTR)) return 0;
  bool well = ready > 0;
  std::size_t count = 0;
  for (std::size_t i = 0; well && i + 1 < polled.size(); ++i) {
    if (polled[i].revents != 0) well = drain(i, edges, count);
  }
  if (polled.back().revents != 0) {
    std::uint64_t wakes = 0;
    if (read(polled.back().fd, &wakes, sizeof wakes) < 0) wakes = 0;  // emptied by whoever was first
  }
  if (!well) {
    const timespec pause{0, 10'000'000};  // broken inputs poll as ready for ever: do not spin on them
    clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
    return std::nullopt;
  }
  std::sort(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(count),
            [](const Edge& a, const Edge& b) { return a.time < b.time; });
  return count;
}

std::optional<bool> GpioLines::level(Input input) noexcept {
  const auto found = std::find(impl_->inputs.begin(), impl_->inputs.end(), input);
  if (found == impl_->inputs.end()) return std::nullopt;
  return impl_->request->level(static_cast<std::size_t>(found - impl_->inputs.begin()));
}

const std::vector<std::string>& GpioLines::warnings() const { return impl_->warnings; }

std::int64_t GpioLines::kernel_overflows() const noexcept { return impl_->request->overflows(); }

struct OutputTakeover::Impl {
  struct Target {
    Line which;
    OutputLineSpec spec;
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
    impl->targets.push_back({which, {*offset, rig.line(which).active_low}, {}});
  }
  return OutputTakeover(std::move(impl));
}

std::pair<std::string, bool> OutputTakeover::Impl::request_missing() {
  bool busy = false;
  std::string missing;
  for (Target& target : targets) {
    if (target.request) continue;
    auto taken = chip.request_outputs(std::span(&target.spec, 1));
    if (taken) {
      target.request.emplace(std::move(*taken));
      continue;
    }
    const int error = taken.error().error;
    missing += (missing.empty() ? "" : "; ") + std::string(line_key(target.which)) + ": " +
               request_error(chip, target.spec.offset, error);
    busy = busy || error == EBUSY;
  }
  return {missing, busy};
}

Result<void> OutputTakeover::drive_inactive(Duration patience) {
  const timespec pause{0, 100'000};
  constexpr int kMinTries = 100;  // a machine that stands still uses the time up without a try
  SystemClock clock;
  const MonoTime end = clock.now() + patience;
  for (int tries = 1;; ++tries) {
    const auto [missing, busy] = impl_->request_missing();  // whoever holds a line may let it go yet
    if (missing.empty()) return {};
    const bool patient = clock.now() < end || tries < kMinTries;
    if (!busy || !patient) return fail(missing);
    clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
  }
}

}  // namespace strobe::firmware
