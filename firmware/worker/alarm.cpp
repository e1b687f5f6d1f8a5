#include "firmware/worker/alarm.hpp"

#include <lcm/lcm-cpp.hpp>

#include "common/messages/channels.hpp"
#include "firmware/linux/system_clock.hpp"
#include "firmware/publisher/lcm_bus.hpp"
#include "firmware/publisher/messages.hpp"
#include "firmware/publisher/receiver.hpp"

namespace strobe::firmware {

struct Alarm::Network {
  Network(const Rig& rig, const Options& options, std::int64_t boot)
      : lcm(options.lcm_url),
        bus(lcm),
        // The worker's numbers may all be used.
        sealed(bus, options.key.value(), random_id()),
        channel(messages::channel_name(rig.name, messages::Channel::status)),
        boot_id(boot) {}

  lcm::LCM lcm;
  LcmBus bus;
  SealedBus sealed;
  std::string channel;
  std::int64_t boot_id;
  SystemClock clock;
  ShotTiming timing;
  HistogramMessages histograms;
};

Alarm::Alarm(const Rig& rig, const Options& options, std::int64_t boot_id) {
  if (boot_id == 0 || !options.key) return;
  network_ = std::make_unique<Network>(rig, options, boot_id);
  if (!network_->lcm.good()) network_.reset();
}

Alarm::~Alarm() = default;

void Alarm::tell(const std::string& message) {
  if (!network_) return;
  StatusParts parts;
  parts.boot_id = network_->boot_id;
  parts.clocks = read_clocks(network_->clock, system_wall_ns, system_boot_time_ns);
  parts.loop.state = State::fault;
  strobe_msgs::status_t status = to_message(parts, network_->timing, network_->histograms);
  status.message = message;
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(status.getEncodedSize()));
  status.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  network_->sealed.publish(network_->channel, bytes);
}

}  // namespace strobe::firmware
