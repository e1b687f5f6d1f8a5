#include "tests/soak/virtual_host.hpp"

#include <strobe_msgs/event_t.hpp>

#include "common/messages/channels.hpp"

namespace strobe::soak {

namespace {

constexpr std::int64_t kSecond_ns =
    1'000'000'000;  // as in `strobe fire`: the first status may take half of it

}  // namespace

VirtualHost::VirtualHost(const HostOrder& order, std::int64_t host_id, HostLog& log, Send send, Done done,
                         std::int64_t now_ns)
    : order_(order),
      log_(log),
      send_(std::move(send)),
      maker_(host_id),
      campaign_(order.campaign, maker_),
      follower_(order.assembly, host_id, "soak"),
      intake_(order.rig, follower_),
      started_ns_(now_ns) {
  for (const auto& [boot_id, sequence] : log_) follower_.session().ledger().add(boot_id, sequence, 0);
  follower_.on_outcome = [this, done = std::move(done)](const host::Outcome& outcome) {
    done(outcome);
    campaign_.on_outcome(outcome);
  };
  follower_.on_event = [this](const strobe_msgs::event_t& event) {
    log_.emplace_back(event.boot_id, event.sequence);
    campaign_.on_event(event);
  };
  follower_.on_notice = [this](const std::string& text) { notices_.push_back(text); };
}

void VirtualHost::receive(const std::string& channel, const std::vector<std::uint8_t>& bytes,
                          std::int64_t now_ns) {
  intake_.receive(channel, bytes.data(), bytes.size(), now_ns);
}

void VirtualHost::turn(std::int64_t now_ns) {
  follower_.time(now_ns);
  if (const auto& status = follower_.session().status()) {
    for (const host::SequenceRange& range : follower_.session().ledger().due(now_ns))
      send_(maker_.resend(status->boot_id, range));
  }
  if (!campaign_.finished()) {
    const auto heard = follower_.heard(now_ns);
    if (heard || now_ns - started_ns_ > kSecond_ns) campaign_.step(heard, now_ns);
  } else {
    collect(now_ns);
  }
  for (const auto& command : campaign_.take_commands()) send_(command);
  for (std::string& text : campaign_.take_notices()) notices_.push_back(std::move(text));
}

void VirtualHost::collect(std::int64_t now_ns) {
  if (!collection_) collection_.emplace(now_ns);
  ended_ = collection_->over(follower_.session(), follower_.heard(now_ns).has_value(), now_ns);
}

}  // namespace strobe::soak
