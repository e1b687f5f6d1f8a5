// What comes over the bus to a host without a key may be a stranger's, and a sealed message may be badly made:
// any sequence is shown, or counted as undecodable, without much memory; with a key, every other packet is bare
// and changes nothing. Input: records of a kind, two bytes of size, and a message behind its
// fingerprint, which is put before it here.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/frame_2_t.hpp>
#include <strobe_msgs/frame_3_t.hpp>
#include <strobe_msgs/frame_4_t.hpp>
#include <strobe_msgs/frame_t.hpp>
#include <strobe_msgs/shot_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "common/messages/channels.hpp"
#include "host/assembly/assemble.hpp"
#include "host/config/rig_file.hpp"
#include "host/loop/host_loop.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/support/host_bench.hpp"

namespace {

using namespace strobe;
using namespace strobe::fuzz;
using messages::Channel;

struct Kind {
  Channel channel;
  std::int64_t fingerprint;
};

const std::array<Kind, 7>& kinds() {
  static const std::array<Kind, 7> all{{{Channel::event, strobe_msgs::event_t::getHash()},
                                        {Channel::status, strobe_msgs::status_t::getHash()},
                                        {Channel::shot, strobe_msgs::shot_t::getHash()},
                                        {Channel::frame, strobe_msgs::frame_2_t::getHash()},
                                        {Channel::frame, strobe_msgs::frame_3_t::getHash()},
                                        {Channel::frame, strobe_msgs::frame_4_t::getHash()},
                                        {Channel::frame, strobe_msgs::frame_t::getHash()}}};
  return all;
}

std::vector<std::uint8_t> with_fingerprint(std::int64_t fingerprint, std::span<const std::uint8_t> body) {
  std::vector<std::uint8_t> bytes;
  for (int shift = 56; shift >= 0; shift -= 8)
    bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint64_t>(fingerprint) >> shift));
  bytes.insert(bytes.end(), body.begin(), body.end());
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const host::RigFile rig = host::read_rig("rig = \"bench\"\n", "rig.toml").value();
  static const authentication::Key key = authentication::Key::random();
  testing::ManualClock clock;
  host::NullTransport transport;
  host::HostLoop loop({"bench", host::assembly_settings(rig), 1, true, key}, transport, clock);
  const authentication::PacketSeal seal(key);
  std::int64_t packets = 0, bare = 0;
  for (std::span<const std::uint8_t> left(data, size); left.size() >= 3;) {
    const Kind& kind = kinds()[left[0] % kinds().size()];
    const std::size_t wanted = std::size_t{left[1]} << 8 | left[2];
    left = left.subspan(3);
    const auto body = left.first(std::min(wanted, left.size()));
    left = left.subspan(body.size());
    const std::string channel = messages::channel_name("bench", kind.channel);
    const std::vector<std::uint8_t> message = with_fingerprint(kind.fingerprint, body);
    loop.receive(channel, seal.seal(channel, message, {2, ++packets}));
    const HostTime heard = loop.last_message();
    clock.now += milliseconds{1};
    loop.receive(channel, message);
    require(loop.last_message() == heard && loop.unverified().sum() == ++bare);
    clock.now += milliseconds{50};
    loop.step();
  }
  clock.now += std::chrono::seconds{100};
  loop.step();
  loop.session().clock().state();
  loop.end_session();
  if (!loop.fault().empty()) std::fprintf(stderr, "a handler threw: %s\n", loop.fault().c_str());
  return 0;
}
