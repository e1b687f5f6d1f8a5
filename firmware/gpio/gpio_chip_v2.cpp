#include <dirent.h>
#include <gpiod.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <vector>

#include "firmware/gpio/gpio_chip.hpp"

namespace strobe::firmware {

namespace {

constexpr const char* kConsumer = "strobed";
constexpr std::size_t kMaxLines = 64;        // of one request
constexpr std::size_t kKernelBuffer = 1024;  // the largest that the kernel gives
constexpr std::size_t kEventsRead = 64;      // in one system call
constexpr const char* kDevices = "/dev";

template <typename Type, void (*release)(Type*)>
struct Release {
  void operator()(Type* object) const { release(object); }
};
template <typename Type, void (*release)(Type*)>
using Owned = std::unique_ptr<Type, Release<Type, release>>;

using ChipHandle = Owned<gpiod_chip, gpiod_chip_close>;
using ChipInfo = Owned<gpiod_chip_info, gpiod_chip_info_free>;
using LineInfo = Owned<gpiod_line_info, gpiod_line_info_free>;
using LineSettings = Owned<gpiod_line_settings, gpiod_line_settings_free>;
using LineConfiguration = Owned<gpiod_line_config, gpiod_line_config_free>;
using RequestConfig = Owned<gpiod_request_config, gpiod_request_config_free>;
using Request = Owned<gpiod_line_request, gpiod_line_request_release>;
using EventBuffer = Owned<gpiod_edge_event_buffer, gpiod_edge_event_buffer_free>;

int is_chip(const dirent* entry) { return std::string(entry->d_name).starts_with("gpiochip") ? 1 : 0; }

/// Paths of all chips.
std::vector<std::string> chip_paths() {
  dirent** entries = nullptr;
  const int count = scandir(kDevices, &entries, is_chip, versionsort);
  std::vector<std::string> paths;
  for (int i = 0; i < count; ++i) {
    paths.push_back(std::string(kDevices) + "/" + entries[i]->d_name);
    std::free(entries[i]);
  }
  std::free(entries);
  return paths;
}

ChipHandle open_labelled(const std::string& label) {
  int error = ENOENT;
  for (const std::string& path : chip_paths()) {
    ChipHandle chip(gpiod_chip_open(path.c_str()));
    if (!chip) {
      error = errno;
      continue;
    }
    const ChipInfo info(gpiod_chip_get_info(chip.get()));
    if (info && label == gpiod_chip_info_get_label(info.get())) return chip;
  }
  errno = error;
  return nullptr;
}

ChipHandle open_chip(const std::string& which) {
  if (which.starts_with("/")) return ChipHandle(gpiod_chip_open(which.c_str()));
  const bool is_number = !which.empty() && which.find_first_not_of("0123456789") == std::string::npos;
  const std::string path = std::string(kDevices) + (is_number ? "/gpiochip" : "/") + which;
  if (is_number || gpiod_is_gpiochip_device(path.c_str())) return ChipHandle(gpiod_chip_open(path.c_str()));
  return open_labelled(which);
}

gpiod_line_bias bias_for(const InputLineSpec& line) {
  switch (line.bias) {
    case Bias::as_is:
      break;
    case Bias::pull_up:
      return GPIOD_LINE_BIAS_PULL_UP;
    case Bias::pull_down:
      return GPIOD_LINE_BIAS_PULL_DOWN;
    case Bias::disabled:
      return GPIOD_LINE_BIAS_DISABLED;
  }
  return GPIOD_LINE_BIAS_AS_IS;
}

/// The requests' configuration, made line by line; fails as a whole if memory lacks.
class Configuration {
 public:
  Configuration()
      : settings_(gpiod_line_settings_new()),
        lines_(gpiod_line_config_new()),
        request_(gpiod_request_config_new()) {}

  /// Its settings so far hold for this line.
  bool add(unsigned offset) {
    return settings_ && lines_ &&
           gpiod_line_config_add_line_settings(lines_.get(), &offset, 1, settings_.get()) == 0;
  }
  gpiod_line_settings* settings() const { return settings_.get(); }
  gpiod_line_config* lines() const { return lines_.get(); }

  Request request(gpiod_chip* chip, std::size_t event_buffer) const {
    if (!request_ || !lines_) return nullptr;
    gpiod_request_config_set_consumer(request_.get(), kConsumer);
    gpiod_request_config_set_event_buffer_size(request_.get(), event_buffer);
    return Request(gpiod_chip_request_lines(chip, request_.get(), lines_.get()));
  }

 private:
  LineSettings settings_;
  LineConfiguration lines_;
  RequestConfig request_;
};

}  // namespace

struct GpioChip::Impl {
  ChipHandle chip;
  std::string name;
  unsigned line_count = 0;

  /// A request is granted as a whole: the blame is on the first line that somebody else uses.
  static RequestFailure failure(const GpioChip& owner, int error, std::span<const unsigned> offsets) {
    if (error != EBUSY) return {error, 0};
    const auto used = std::find_if(offsets.begin(), offsets.end(),
                                   [&](unsigned offset) { return owner.user_of(offset).has_value(); });
    return {error, used == offsets.end() ? 0 : static_cast<std::size_t>(used - offsets.begin())};
  }
};

GpioChip::GpioChip(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GpioChip::GpioChip(GpioChip&&) noexcept = default;
GpioChip& GpioChip::operator=(GpioChip&&) noexcept = default;
GpioChip::~GpioChip() = default;

tl::expected<GpioChip, int> GpioChip::open(const std::string& which) {
  ChipHandle chip = open_chip(which);
  if (!chip) return tl::unexpected(errno);
  const ChipInfo info(gpiod_chip_get_info(chip.get()));
  if (!info) return tl::unexpected(errno);
  return GpioChip(
      std::make_unique<Impl>(Impl{std::move(chip), gpiod_chip_info_get_name(info.get()),
                                  static_cast<unsigned>(gpiod_chip_info_get_num_lines(info.get()))}));
}

std::string GpioChip::name() const { return impl_->name; }
unsigned GpioChip::line_count() const { return impl_->line_count; }

std::optional<unsigned> GpioChip::find_line(const std::string& name) const {
  const int offset = gpiod_chip_get_line_offset_from_name(impl_->chip.get(), name.c_str());
  if (offset < 0) return std::nullopt;
  return static_cast<unsigned>(offset);
}

std::optional<std::string> GpioChip::user_of(unsigned offset) const {
  const LineInfo info(gpiod_chip_get_line_info(impl_->chip.get(), offset));
  if (!info || !gpiod_line_info_is_used(info.get())) return std::nullopt;
  const char* consumer = gpiod_line_info_get_consumer(info.get());
  return consumer != nullptr ? consumer : "";
}

Bias GpioChip::bias_of(unsigned offset) const {
  const LineInfo info(gpiod_chip_get_line_info(impl_->chip.get(), offset));
  if (!info) return Bias::as_is;
  switch (gpiod_line_info_get_bias(info.get())) {
    case GPIOD_LINE_BIAS_PULL_UP:
      return Bias::pull_up;
    case GPIOD_LINE_BIAS_PULL_DOWN:
      return Bias::pull_down;
    case GPIOD_LINE_BIAS_DISABLED:
      return Bias::disabled;
    default:
      return Bias::as_is;
  }
}

struct OutputRequest::Impl {
  Request request;
  Configuration configuration;
};

OutputRequest::OutputRequest(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OutputRequest::OutputRequest(OutputRequest&&) noexcept = default;
OutputRequest& OutputRequest::operator=(OutputRequest&&) noexcept = default;
OutputRequest::~OutputRequest() = default;

tl::expected<OutputRequest, RequestFailure> GpioChip::request_outputs(std::span<const unsigned> offsets) {
  Configuration configuration;
  for (std::size_t i = 0; i < offsets.size(); ++i) {
    gpiod_line_settings* settings = configuration.settings();
    if (settings == nullptr) return tl::unexpected(RequestFailure{ENOMEM, i});
    gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT);
    gpiod_line_settings_set_output_value(settings, GPIOD_LINE_VALUE_INACTIVE);
    if (!configuration.add(offsets[i])) return tl::unexpected(RequestFailure{errno, i});
  }
  Request request = configuration.request(impl_->chip.get(), 0);
  if (!request) return tl::unexpected(impl_->failure(*this, errno, offsets));
  return OutputRequest(std::make_unique<OutputRequest::Impl>(
      OutputRequest::Impl{std::move(request), std::move(configuration)}));
}

bool OutputRequest::set(std::span<const bool> active) noexcept {
  std::array<gpiod_line_value, kMaxLines> values;
  for (std::size_t i = 0; i < active.size(); ++i)
    values[i] = active[i] ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
  return gpiod_line_request_set_values(impl_->request.get(), values.data()) == 0;
}

bool OutputRequest::take_back() noexcept {
  return gpiod_line_request_reconfigure_lines(impl_->request.get(), impl_->configuration.lines()) == 0;
}

struct InputRequest::Impl {
  std::size_t line_at(unsigned offset) const {
    return static_cast<std::size_t>(std::find(offsets.begin(), offsets.end(), offset) - offsets.begin());
  }

  Request request;
  EventBuffer events;
  std::vector<unsigned> offsets;  // of the specs
  int descriptor = -1;            // one for all lines
  std::uint32_t last_seqno = 0;
  std::int64_t lost = 0;
};

InputRequest::InputRequest(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
InputRequest::InputRequest(InputRequest&&) noexcept = default;
InputRequest& InputRequest::operator=(InputRequest&&) noexcept = default;
InputRequest::~InputRequest() = default;

tl::expected<InputRequest, RequestFailure> GpioChip::request_inputs(std::span<const InputLineSpec> lines) {
  auto impl = std::make_unique<InputRequest::Impl>();
  Configuration configuration;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    gpiod_line_settings* settings = configuration.settings();
    if (settings == nullptr) return tl::unexpected(RequestFailure{ENOMEM, i});
    gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT);
    gpiod_line_settings_set_active_low(settings, lines[i].active_low);
    gpiod_line_settings_set_bias(settings, bias_for(lines[i]));
    gpiod_line_settings_set_edge_detection(
        settings, lines[i].both_edges ? GPIOD_LINE_EDGE_BOTH : GPIOD_LINE_EDGE_RISING);
    gpiod_line_settings_set_event_clock(settings, GPIOD_LINE_CLOCK_MONOTONIC);
    if (!configuration.add(lines[i].offset)) return tl::unexpected(RequestFailure{errno, i});
    impl->offsets.push_back(lines[i].offset);
  }
  impl->events.reset(gpiod_edge_event_buffer_new(kEventsRead));
  if (!impl->events) return tl::unexpected(RequestFailure{ENOMEM, 0});
  impl->request = configuration.request(impl_->chip.get(), kKernelBuffer);
  if (!impl->request) return tl::unexpected(impl_->failure(*this, errno, impl->offsets));
  impl->descriptor = gpiod_line_request_get_fd(impl->request.get());
  return InputRequest(std::move(impl));
}

std::span<const int> InputRequest::descriptors() const noexcept { return {&impl_->descriptor, 1}; }

std::optional<std::size_t> InputRequest::read(std::size_t, std::span<LineEdge> edges) noexcept {
  const std::size_t room = std::min(edges.size(), kEventsRead);
  if (room == 0) return 0;
  const int read = gpiod_line_request_read_edge_events(impl_->request.get(), impl_->events.get(), room);
  if (read <= 0) return std::nullopt;
  const auto count = static_cast<std::size_t>(read);
  for (std::size_t k = 0; k < count; ++k) {
    gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(impl_->events.get(), k);
    // The kernel counts in 32 bits: after four thousand million edges from 0 again.
    const auto seqno = static_cast<std::uint32_t>(gpiod_edge_event_get_global_seqno(event));
    impl_->lost += static_cast<std::uint32_t>(seqno - impl_->last_seqno - 1);
    impl_->last_seqno = seqno;
    edges[k] = {impl_->line_at(gpiod_edge_event_get_line_offset(event)),
                from_ns(static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event))),
                gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE};
  }
  return count;
}

std::optional<bool> InputRequest::level(std::size_t line) noexcept {
  const gpiod_line_value value = gpiod_line_request_get_value(impl_->request.get(), impl_->offsets[line]);
  if (value == GPIOD_LINE_VALUE_ERROR) return std::nullopt;
  return value == GPIOD_LINE_VALUE_ACTIVE;
}

std::int64_t InputRequest::overflows() const noexcept { return impl_->lost; }

}  // namespace strobe::firmware
