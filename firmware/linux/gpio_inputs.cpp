#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "firmware/gpio/gpio_chip.hpp"
#include "firmware/linux/gpio_inputs.hpp"
#include "firmware/linux/input_bias.hpp"
#include "firmware/linux/rig_lines.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

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

}  // namespace

struct GpioInputs::Impl {
  std::optional<GpioChip> chip;
  std::optional<InputRequest> request;
  std::vector<Input> inputs;   // in the order of their request
  std::vector<pollfd> polled;  // the request's descriptors, in their order, then the wake-up
  std::array<LineEdge, 64> taken;
  std::vector<std::string> warnings;

  Result<void> take(const Rig& rig);
  bool drain(std::size_t i, std::span<Edge> edges, std::size_t& count) noexcept;
  /// What poll(2) has found: 0 nothing, below 0 an error.
  std::optional<std::size_t> take_edges(int ready, std::span<Edge> edges) noexcept;
};

Result<void> GpioInputs::Impl::take(const Rig& rig) {
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

GpioInputs::GpioInputs(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpioInputs::~GpioInputs() = default;

Result<std::unique_ptr<GpioInputs>> GpioInputs::open(const Rig& rig, int wake_fd) {
  auto impl = std::make_unique<Impl>();
  auto chip = open_chip(rig);
  if (!chip) return tl::unexpected(chip.error());
  impl->chip.emplace(std::move(*chip));
  if (auto taken = impl->take(rig); !taken) return tl::unexpected(taken.error());
  impl->polled.push_back({wake_fd, POLLIN, 0});
  return std::unique_ptr<GpioInputs>(new GpioInputs(std::move(impl)));
}

bool GpioInputs::Impl::drain(std::size_t i, std::span<Edge> edges, std::size_t& count) noexcept {
  const std::size_t room = std::min(edges.size() - count, taken.size());
  const auto read = request->read(i, std::span(taken).first(room));
  if (!read) return false;
  for (std::size_t k = 0; k < *read; ++k)
    edges[count++] = {inputs[taken[k].line], taken[k].time, taken[k].active};
  return true;
}

std::optional<std::size_t> GpioInputs::wait(MonoTime until, std::span<Edge> edges) noexcept {
  const timespec timeout = time_left(until);
  return impl_->take_edges(ppoll(impl_->polled.data(), impl_->polled.size(), &timeout, nullptr), edges);
}

std::optional<std::size_t> GpioInputs::poll(MonoTime until, std::span<Edge> edges) noexcept {
  constexpr timespec kAtOnce{};
  SystemClock clock;
  int ready = 0;
  do ready = ppoll(impl_->polled.data(), impl_->polled.size(), &kAtOnce, nullptr);
  while (ready == 0 && clock.now() < until);
  return impl_->take_edges(ready, edges);
}

std::optional<std::size_t> GpioInputs::Impl::take_edges(int ready, std::span<Edge> edges) noexcept {
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

std::optional<bool> GpioInputs::level(Input input) noexcept {
  const auto found = std::find(impl_->inputs.begin(), impl_->inputs.end(), input);
  if (found == impl_->inputs.end()) return std::nullopt;
  return impl_->request->level(static_cast<std::size_t>(found - impl_->inputs.begin()));
}

const std::vector<std::string>& GpioInputs::warnings() const { return impl_->warnings; }

std::int64_t GpioInputs::kernel_overflows() const noexcept { return impl_->request->overflows(); }

}  // namespace strobe::firmware
