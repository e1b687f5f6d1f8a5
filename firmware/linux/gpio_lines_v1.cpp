#include <gpiod.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "firmware/linux/gpio_lines.hpp"
#include "firmware/linux/system_clock.hpp"

namespace strobe::firmware {

namespace {

constexpr const char* kConsumer = "strobed";
constexpr std::size_t kKernelBuffer = 16;

struct ChipCloser {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using ChipHandle = std::unique_ptr<gpiod_chip, ChipCloser>;

std::string place(const Rig& rig, std::uint32_t line, const std::string& key) {
  return rig.file_name + ":" + std::to_string(line) + ": " + key + ": ";
}

tl::unexpected<Error> line_failure(const Rig& rig, Line which, const std::string& what) {
  return fail(place(rig, rig.line(which).file_line, std::string("lines.") + line_key(which)) + what);
}

Result<ChipHandle> open_chip(const Rig& rig) {
  ChipHandle chip(gpiod_chip_open_lookup(rig.chip.c_str()));
  if (chip) return chip;
  const int error = errno;
  const char* hint = error == EACCES ? " (the user must be allowed to open it, e.g. by the group gpio)" : "";
  return fail(place(rig, rig.chip_file_line, "chip.name") + "cannot open \"" + rig.chip +
              "\": " + std::strerror(error) + hint);
}

Result<gpiod_line*> find_line(gpiod_chip* chip, const Rig& rig, Line which) {
  const LineConfig& config = rig.line(which);
  if (config.offset >= 0) {
    const unsigned count = gpiod_chip_num_lines(chip);
    if (config.offset >= count) {
      return line_failure(rig, which,
                          "no offset " + std::to_string(config.offset) + " on " + gpiod_chip_name(chip) +
                              ", which has " + std::to_string(count) + " lines");
    }
    gpiod_line* line = gpiod_chip_get_line(chip, static_cast<unsigned>(config.offset));
    if (line == nullptr) return line_failure(rig, which, std::strerror(errno));
    return line;
  }
  gpiod_line* line = gpiod_chip_find_line(chip, config.name.c_str());
  if (line == nullptr) {
    return line_failure(rig, which, "no line named \"" + config.name + "\" on " + gpiod_chip_name(chip));
  }
  return line;
}

std::string request_error(gpiod_line* line, int error) {
  std::string what =
      "cannot take line " + std::to_string(gpiod_line_offset(line)) + ": " + std::strerror(error);
  if (error == EBUSY && gpiod_line_update(line) == 0 && gpiod_line_consumer(line) != nullptr) {
    what += std::string(" (used by ") + gpiod_line_consumer(line) + ")";
  }
  return what;
}

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
  struct OutputGroup {
    gpiod_line_bulk bulk = GPIOD_LINE_BULK_INITIALIZER;
    // A v1 request has one active-low flag for all its lines, so levels are inverted here and not in the
    // kernel.
    std::array<int, 2> active{};
    std::array<int, 2> inactive{};
  };
  struct InputHandle {
    Input input = Input::key;
    gpiod_line* line = nullptr;
  };

  ChipHandle chip;
  std::array<OutputGroup, kOutputs.size()> outputs;
  std::vector<InputHandle> inputs;
  std::vector<pollfd> polled;  // the inputs', in their order, then the wake-up
  std::int64_t overflows = 0;

  Result<void> take_outputs(const Rig& rig);
  Result<void> take_inputs(const Rig& rig);
  bool drain(std::size_t i, std::span<Edge> edges, std::size_t& count) noexcept;
  /// What poll(2) has found: 0 nothing, below 0 an error.
  std::optional<std::size_t> take(int ready, std::span<Edge> edges) noexcept;
};

Result<void> GpioLines::Impl::take_outputs(const Rig& rig) {
  for (const Output output : kOutputs) {
    OutputGroup& group = outputs[index_of(output)];
    std::size_t n = 0;
    for (const Line which : lines_of(output)) {
      auto line = find_line(chip.get(), rig, which);
      if (!line) return tl::unexpected(line.error());
      gpiod_line_bulk_add(&group.bulk, *line);
      group.inactive[n] = rig.line(which).active_low ? 1 : 0;
      group.active[n] = 1 - group.inactive[n];
      ++n;
    }
    if (gpiod_line_request_bulk_output(&group.bulk, kConsumer, group.inactive.data()) != 0) {
      const int error = errno;
      return line_failure(rig, lines_of(output).front(),
                          request_error(gpiod_line_bulk_get_line(&group.bulk, 0), error));
    }
  }
  return {};
}

Result<void> GpioLines::Impl::take_inputs(const Rig& rig) {
  for (const InputLine& input : kInputs) {
    if (!rig.line(input.line).fitted) continue;
    auto line = find_line(chip.get(), rig, input.line);
    if (!line) return tl::unexpected(line.error());
    const gpiod_line_request_config config{
        kConsumer,
        input.both_edges ? GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES : GPIOD_LINE_REQUEST_EVENT_RISING_EDGE,
        rig.line(input.line).active_low ? static_cast<int>(GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW) : 0};
    if (gpiod_line_request(*line, &config, 0) != 0) {
      const int error = errno;
      return line_failure(rig, input.line, request_error(*line, error));
    }
    inputs.push_back({input.input, *line});
    polled.push_back({gpiod_line_event_get_fd(*line), POLLIN, 0});
  }
  return {};
}

GpioLines::GpioLines(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpioLines::~GpioLines() = default;

Result<std::unique_ptr<GpioLines>> GpioLines::open(const Rig& rig, int wake_fd) {
  auto impl = std::make_unique<Impl>();
  auto chip = open_chip(rig);
  if (!chip) return tl::unexpected(chip.error());
  impl->chip = std::move(*chip);
  if (auto taken = impl->take_outputs(rig); !taken) return tl::unexpected(taken.error());
  if (auto taken = impl->take_inputs(rig); !taken) return tl::unexpected(taken.error());
  impl->polled.push_back({wake_fd, POLLIN, 0});
  return std::unique_ptr<GpioLines>(new GpioLines(std::move(impl)));
}

bool GpioLines::set(Output output, bool active) noexcept {
  Impl::OutputGroup& group = impl_->outputs[index_of(output)];
  return gpiod_line_set_value_bulk(&group.bulk, active ? group.active.data() : group.inactive.data()) == 0;
}

bool GpioLines::set_lamps(Lamps lamps) noexcept {
  Impl::OutputGroup& group = impl_->outputs[index_of(Output::strobes)];
  const std::array<int, 2> levels{(has_a(lamps) ? group.active : group.inactive)[0],
                                  (has_b(lamps) ? group.active : group.inactive)[1]};
  return gpiod_line_set_value_bulk(&group.bulk, levels.data()) == 0;
}

void GpioLines::release_outputs() noexcept {
  for (Impl::OutputGroup& group : impl_->outputs) gpiod_line_release_bulk(&group.bulk);
}

bool GpioLines::Impl::drain(std::size_t i, std::span<Edge> edges, std::size_t& count) noexcept {
  const std::size_t room = std::min(edges.size() - count, kKernelBuffer);
  if (room == 0) return true;
  std::array<gpiod_line_event, kKernelBuffer> events{};
  const int read =
      gpiod_line_event_read_fd_multiple(polled[i].fd, events.data(), static_cast<unsigned>(room));
  if (read <= 0) return false;
  if (static_cast<std::size_t>(read) == kKernelBuffer) ++overflows;
  for (std::size_t k = 0; k < static_cast<std::size_t>(read); ++k) {
    edges[count++] = {inputs[i].input, from_ns(events[k].ts.tv_sec * 1'000'000'000 + events[k].ts.tv_nsec),
                      events[k].event_type == GPIOD_LINE_EVENT_RISING_EDGE};
  }
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
  for (std::size_t i = 0; well && i < inputs.size(); ++i) {
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
  for (const Impl::InputHandle& handle : impl_->inputs) {
    if (handle.input != input) continue;
    const int value = gpiod_line_get_value(handle.line);
    if (value < 0) return std::nullopt;
    return value == 1;
  }
  return std::nullopt;
}

std::int64_t GpioLines::kernel_overflows() const noexcept { return impl_->overflows; }

struct OutputTakeover::Impl {
  struct Target {
    Line which;
    gpiod_line* line;
    int inactive;
    bool taken = false;
  };
  ChipHandle chip;
  std::vector<Target> targets;
};

OutputTakeover::OutputTakeover(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OutputTakeover::OutputTakeover(OutputTakeover&&) noexcept = default;
OutputTakeover& OutputTakeover::operator=(OutputTakeover&&) noexcept = default;
OutputTakeover::~OutputTakeover() = default;

Result<OutputTakeover> OutputTakeover::prepare(const Rig& rig) {
  auto impl = std::make_unique<Impl>();
  auto chip = open_chip(rig);
  if (!chip) return tl::unexpected(chip.error());
  impl->chip = std::move(*chip);
  for (const Line which : kOutputLines) {
    auto line = find_line(impl->chip.get(), rig, which);
    if (!line) return tl::unexpected(line.error());
    impl->targets.push_back({which, *line, rig.line(which).active_low ? 1 : 0});
  }
  return OutputTakeover(std::move(impl));
}

Result<void> OutputTakeover::drive_inactive(Duration patience) {
  const timespec pause{0, 100'000};
  constexpr int kMinTries = 100;  // a machine that stands still uses the time up without a try
  SystemClock clock;
  const MonoTime end = clock.now() + patience;
  for (int tries = 1;; ++tries) {
    bool others = false;  // whoever holds a line may let it go yet
    std::string missing;
    for (Impl::Target& target : impl_->targets) {
      if (!target.taken)
        target.taken = gpiod_line_request_output(target.line, kConsumer, target.inactive) == 0;
      if (!target.taken) {
        const int error = errno;
        missing += (missing.empty() ? "" : "; ") + std::string(line_key(target.which)) + ": " +
                   request_error(target.line, error);
        others = others || error == EBUSY;
      }
    }
    if (missing.empty()) return {};
    const bool patient = clock.now() < end || tries < kMinTries;
    if (!others || !patient) return fail(missing);
    clock_nanosleep(CLOCK_MONOTONIC, 0, &pause, nullptr);
  }
}

std::vector<LineReport> inspect_lines(const Rig& rig) {
  std::vector<LineReport> reports;
  auto chip = open_chip(rig);
  reports.push_back({"chip.name", chip ? "" : chip.error().message});
  if (!chip) return reports;
  for (std::size_t i = 1; i < kLineCount; ++i) {
    const auto which = static_cast<Line>(i);
    if (!rig.line(which).fitted) continue;
    LineReport report{std::string("lines.") + line_key(which), ""};
    auto line = find_line(chip->get(), rig, which);
    if (!line) {
      report.fault = line.error().message;
    } else if (gpiod_line_is_used(*line)) {
      report.fault = line_failure(rig, which, request_error(*line, EBUSY)).value().message;
    }
    reports.push_back(report);
  }
  return reports;
}

}  // namespace strobe::firmware
