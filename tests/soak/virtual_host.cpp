#include "tests/soak/virtual_host.hpp"

#include <strobe_msgs/event_t.hpp>

#include "common/messages/channels.hpp"

namespace strobe::soak {

namespace {

// As in `strobe fire`: the first status may take half a second, what is missing is waited for ten seconds.
constexpr std::int64_t kSecond_ns = 1'000'000'000;
constexpr std::int64_t kLinger_ns = 10 * kSecond_ns;

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
  for (const host::SequenceRange& range : follower_.session().ledger().due(now_ns))
    send_(maker_.resend(range));
  if (!campaign_.finished()) {
    const auto heard = follower_.heard(now_ns);
    if (heard || now_ns - started_ns_ > kSecond_ns) campaign_.step(heard, now_ns);
    if (campaign_.finished()) finished_ns_ = now_ns;
  } else {
    collect(now_ns);
  }
  for (const auto& command : campaign_.take_commands()) send_(command);
  for (std::string& text : campaign_.take_notices()) notices_.push_back(std::move(text));
}

void VirtualHost::collect(std::int64_t now_ns) {
  if (finished_ns_ == 0) finished_ns_ = now_ns;
  const host::EventLedger& events = follower_.session().ledger();
  const bool settled = now_ns - finished_ns_ > kSecond_ns / 2;
  if ((settled && events.complete()) || now_ns - finished_ns_ > kLinger_ns || !follower_.heard(now_ns))
    ended_ = true;
}

}  // namespace strobe::soak
