#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <vector>

#include "firmware/gpio/gpio_chip.hpp"

namespace strobe::firmware {

namespace {

constexpr const char* kConsumer = "strobed";
constexpr std::size_t kKernelBuffer = 16;
constexpr std::array<int, GPIOD_LINE_BULK_MAX_LINES> kAllInactive{};

struct ChipCloser {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using ChipHandle = std::unique_ptr<gpiod_chip, ChipCloser>;

int flags_of(const InputLineSpec& line) {
  int flags = line.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  if (line.bias == Bias::pull_up) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
  if (line.bias == Bias::pull_down) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
  if (line.bias == Bias::disabled) flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
  return flags;
}

}  // namespace

struct GpioChip::Impl {
  ChipHandle chip;
};

GpioChip::GpioChip(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpioChip::GpioChip(GpioChip&&) noexcept = default;
GpioChip& GpioChip::operator=(GpioChip&&) noexcept = default;
GpioChip::~GpioChip() = default;

tl::expected<GpioChip, int> GpioChip::open(const std::string& which) {
  ChipHandle chip(gpiod_chip_open_lookup(which.c_str()));
  if (!chip) return tl::unexpected(errno);
  return GpioChip(std::make_unique<Impl>(Impl{std::move(chip)}));
}

std::string GpioChip::name() const { return gpiod_chip_name(impl_->chip.get()); }
unsigned GpioChip::line_count() const { return gpiod_chip_num_lines(impl_->chip.get()); }

std::optional<unsigned> GpioChip::find_line(const std::string& name) const {
  gpiod_line* line = gpiod_chip_find_line(impl_->chip.get(), name.c_str());
  if (line == nullptr) return std::nullopt;
  return gpiod_line_offset(line);
}

std::optional<std::string> GpioChip::user_of(unsigned offset) const {
  gpiod_line* line = gpiod_chip_get_line(impl_->chip.get(), offset);
  if (line == nullptr || gpiod_line_update(line) != 0 || !gpiod_line_is_used(line)) return std::nullopt;
  const char* consumer = gpiod_line_consumer(line);
  return consumer != nullptr ? consumer : "";
}

Bias GpioChip::bias_of(unsigned offset) const {
  gpiod_line* line = gpiod_chip_get_line(impl_->chip.get(), offset);
  if (line == nullptr || gpiod_line_update(line) != 0) return Bias::as_is;
  switch (gpiod_line_bias(line)) {
    case GPIOD_LINE_BIAS_PULL_UP:
      return Bias::pull_up;
    case GPIOD_LINE_BIAS_PULL_DOWN:
      return Bias::pull_down;
    case GPIOD_LINE_BIAS_DISABLE:
      return Bias::disabled;
    default:
      return Bias::as_is;
  }
}

struct OutputRequest::Impl {
  ~Impl() { gpiod_line_release_bulk(&bulk); }

  gpiod_line_bulk bulk = GPIOD_LINE_BULK_INITIALIZER;
};

OutputRequest::OutputRequest(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OutputRequest::OutputRequest(OutputRequest&&) noexcept = default;
OutputRequest& OutputRequest::operator=(OutputRequest&&) noexcept = default;
OutputRequest::~OutputRequest() = default;

tl::expected<OutputRequest, RequestFailure> GpioChip::request_outputs(std::span<const unsigned> offsets) {
  gpiod_line_bulk bulk = GPIOD_LINE_BULK_INITIALIZER;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    gpiod_line* line = gpiod_chip_get_line(impl_->chip.get(), offsets[i]);
    if (line == nullptr) return tl::unexpected(RequestFailure{errno, i});
    gpiod_line_bulk_add(&bulk, line);
  }
  if (gpiod_line_request_bulk_output(&bulk, kConsumer, kAllInactive.data()) != 0)
    return tl::unexpected(RequestFailure{errno, 0});
  auto impl = std::make_unique<OutputRequest::Impl>();
  impl->bulk = bulk;
  return OutputRequest(std::move(impl));
}

bool OutputRequest::set(std::span<const bool> active) noexcept {
  std::array<int, GPIOD_LINE_BULK_MAX_LINES> levels;
  std::copy(active.begin(), active.end(), levels.begin());
  return gpiod_line_set_value_bulk(&impl_->bulk, levels.data()) == 0;
}

bool OutputRequest::take_back() noexcept {
  return gpiod_line_set_direction_output_bulk(&impl_->bulk, kAllInactive.data()) == 0;
}

struct InputRequest::Impl {
  ~Impl() {
    for (gpiod_line* line : lines) gpiod_line_release(line);
  }

  std::vector<gpiod_line*> lines;
  std::vector<int> descriptors;  // one for each line
  std::int64_t overflows = 0;
};

InputRequest::InputRequest(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
InputRequest::InputRequest(InputRequest&&) noexcept = default;
InputRequest& InputRequest::operator=(InputRequest&&) noexcept = default;
InputRequest::~InputRequest() = default;

tl::expected<InputRequest, RequestFailure> GpioChip::request_inputs(std::span<const InputLineSpec> lines) {
  auto impl = std::make_unique<InputRequest::Impl>();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const gpiod_line_request_config config{
        kConsumer,
        lines[i].both_edges ? GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES : GPIOD_LINE_REQUEST_EVENT_RISING_EDGE,
        flags_of(lines[i])};
    gpiod_line* line = gpiod_chip_get_line(impl_->chip.get(), lines[i].offset);
    if (line == nullptr || gpiod_line_request(line, &config, 0) != 0)
      return tl::unexpected(RequestFailure{errno, i});
    impl->lines.push_back(line);
    impl->descriptors.push_back(gpiod_line_event_get_fd(line));
  }
  return InputRequest(std::move(impl));
}

std::span<const int> InputRequest::descriptors() const noexcept { return impl_->descriptors; }

std::optional<std::size_t> InputRequest::read(std::size_t descriptor, std::span<LineEdge> edges) noexcept {
  const std::size_t room = std::min(edges.size(), kKernelBuffer);
  if (room == 0) return 0;
  std::array<gpiod_line_event, kKernelBuffer> events{};
  const int read = gpiod_line_event_read_fd_multiple(impl_->descriptors[descriptor], events.data(),
                                                     static_cast<unsigned>(room));
  if (read <= 0) return std::nullopt;
  const auto count = static_cast<std::size_t>(read);
  if (count == kKernelBuffer) ++impl_->overflows;
  for (std::size_t k = 0; k < count; ++k)
    edges[k] = {descriptor, from_ns(events[k].ts.tv_sec * 1'000'000'000 + events[k].ts.tv_nsec),
                events[k].event_type == GPIOD_LINE_EVENT_RISING_EDGE};
  return count;
}

std::optional<bool> InputRequest::level(std::size_t line) noexcept {
  const int value = gpiod_line_get_value(impl_->lines[line]);
  if (value < 0) return std::nullopt;
  return value == 1;
}

std::int64_t InputRequest::overflows() const noexcept { return impl_->overflows; }

}  // namespace strobe::firmware
