// Strangers on the bus: nothing that they send is executed, answered or harmful, however fast they send it.
#include <algorithm>
#include <atomic>
#include <string>
#include <thread>

#include "common/authentication/key_file.hpp"
#include "common/authentication/seal.hpp"
#include "common/messages/channels.hpp"
#include "firmware/publisher/command_feed.hpp"
#include "host/messages/lcm_link.hpp"
#include "tests/hil/raw_host.hpp"
#include "tests/support/private_network.hpp"
#include "tests/support/sealed_sender.hpp"
#include "tests/support/skip.hpp"

#include "tests/hil/expectations.hpp"
#include "tests/support/string_from.hpp"

using namespace strobe;
using namespace strobe::hil;
using namespace strobe::testing;
using namespace std::chrono_literals;
using strobe::authentication::Key;
using strobe_msgs::command_t;
using strobe_msgs::event_t;

namespace {

constexpr int kRounds = 4;

std::size_t count_of(const std::string& text, const std::string& what) {
  std::size_t count = 0;
  for (std::size_t at = text.find(what); at != text.npos; at = text.find(what, at + 1)) ++count;
  return count;
}

std::int64_t rejected_by(const strobe_msgs::status_t& status) {
  return std::int64_t{status.rejected_forged} + status.rejected_malformed + status.rejected_oversized +
         status.rejected_stale + status.rejected_other_rig + status.rejected_replayed;
}

/// Ends the bench: as many balls as the operator asked for, and one more for each shot that the firmware itself
/// calls aborted (a machine that stands still does that) or whose readout is rejected for what truly happened.
void check_balls(RigFixture& bench, Process& fire, int asked) {
  const auto shots = read_log(bench.journal()).shots;
  const auto told = readouts(fire.out());
  LONGS_EQUAL(shots.size(), told.size());
  for (std::size_t i = 0; i < told.size(); ++i) {
    CHECK_TRUE(told[i].at("verified").get<bool>());
    CHECK_EQUAL(shots[i].aborted != 0, has_flag(told[i], "shot_aborted"));
    CHECK_FALSE(has_flag(told[i], "no_photograph"));
  }
  const std::size_t again = count_of(fire.err(), "firing again, retry");
  LONGS_EQUAL(told.size(), static_cast<std::size_t>(asked) + again);
  const auto never_thrown = std::count_if(shots.begin(), shots.end(), [](const strobe_msgs::shot_t& shot) {
    return shot.trigger_ns == strobe_msgs::event_t::NO_TIME;
  });
  LONGS_EQUAL(static_cast<long>(told.size()) - never_thrown, bench.finish().rises("TRIGGER"));
}

}  // namespace

TEST_GROUP(Stranger){};

TEST(Stranger, IsNeverExecutedAndShowsOnlyInTheCounts) {
  ReadyRig bench;
  RawHost host(bench);
  CHECK(host.wait_status());
  const command_t arm = host.command(command_t::ARM);
  const Key stranger = Key::random();

  Bytes altered = host.sealed(arm, host.key());
  altered[60] ^= 1;
  Bytes cut = host.sealed(arm, host.key());
  cut.pop_back();
  command_t stale = arm;
  stale.boot_id ^= 1;
  const Bytes body = host.body(arm);
  const std::int64_t start_ns = monotonic_now_ns();
  for (int i = 1; i <= kRounds; ++i) {
    host.send_bytes(host.sealed(arm, stranger));
    host.send_bytes(altered);
    host.send_bytes(cut);
    host.send_bytes(body);  // bare
    host.send_bytes(host.sealed(stale, host.key()));
    host.send_bytes(authentication::seal(host.key(), "pitch", body).value());
    host.send_bytes(Bytes(65'000, 1));
    host.send_bytes(Bytes(100'000, 1));
    // No more at a time than the socket holds.
    CHECK(host.wait([&] { return rejected_by(host.status()) >= std::int64_t{8} * i; }, kLongestWait));
  }
  LONGS_EQUAL(0, host.status().arm_token);
  LONGS_EQUAL(2 * kRounds, host.status().rejected_forged);
  LONGS_EQUAL(2 * kRounds, host.status().rejected_malformed);
  LONGS_EQUAL(2 * kRounds, host.status().rejected_oversized);
  LONGS_EQUAL(kRounds, host.status().rejected_stale);
  LONGS_EQUAL(kRounds, host.status().rejected_other_rig);
  LONGS_EQUAL(0, host.status().rejected_replayed);
  CHECK_FALSE(host.saw(event_t::ARMED));
  CHECK_FALSE(host.saw(event_t::REFUSED));

  const std::int64_t token = host.arm();  // and the host itself is still heard
  CHECK(token != 0);
  const command_t fire = host.fire_command(token, true);
  host.send(fire);
  CHECK(host.wait([&] { return host.shots().size() == 1; }, kLongestWait));
  for (int i = 0; i < kRounds; ++i) host.send(fire);
  CHECK(host.wait([&] { return host.status().rejected_replayed >= kRounds; }, kLongestWait));
  LONGS_EQUAL(1, host.shots().size());
  LONGS_EQUAL(kRounds, host.status().rejected_replayed);
  CHECK_FALSE(host.saw(event_t::REFUSED));

  const auto key = authentication::make_key_file(bench.folder() / "another.key").value();
  const auto fired = bench.refused(bench.fire(1, 0, {"--key-file", key.path}), "another key");
  CHECK_TEXT(fired.status == ExitStatus({1, 0}), fired.err.c_str());
  STRCMP_CONTAINS("another key", fired.err.c_str());
  CHECK_TEXT(fired.err.find(key.key.fingerprint()) != std::string::npos, fired.err.c_str());

  // A line in ten seconds, however long all this took.
  const std::int64_t took_s = (monotonic_now_ns() - start_ns) / 1'000'000'000;
  const auto lines = static_cast<std::int64_t>(count_of(bench.log(), "commands ignored"));
  CHECK_TEXT(lines >= 1 && lines <= 2 + took_s / 10, bench.log().c_str());
  LONGS_EQUAL(0, bench.finish().rises("TRIGGER"));
}

TEST(Stranger, WhoForgesAbortedShotsHasNoneFiredAgain) {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  ReadyRig bench(options);
  RawHost ear(bench);
  CHECK(ear.wait_status());
  lcm::LCM lcm(bench.lcm_url());
  const std::string channel = messages::channel_name("bench", messages::Channel::shot);
  const auto send = [&](const Bytes& packet) {
    lcm.publish(channel, packet.data(), static_cast<unsigned>(packet.size()));
  };
  SealedSender stranger(Key::random()), lab(ear.key());
  auto fire = bench.start(bench.fire(2, 0));
  std::size_t heard = 0;
  int forged = 0;
  std::int64_t host = 0;
  const auto forge = [&](const event_t& started) {
    strobe_msgs::shot_t shot{};
    shot.schema_version = strobe_msgs::shot_t::SCHEMA_VERSION;
    shot.boot_id = started.boot_id;
    shot.shot_id = started.shot_id;
    shot.host_id = host;
    shot.aborted = true;
    shot.abort_reason = "a stranger says so";
    Bytes altered = lab.packet(channel, shot);
    altered[20] ^= 1;
    send(messages::encode(shot));
    send(stranger.packet(channel, shot));
    send(altered);
    ++forged;
  };
  const auto ended = [&] {
    for (; heard < ear.events().size(); ++heard) {
      const event_t& event = ear.events()[heard];
      if (event.kind == event_t::ARMED) host = std::stoll(event.detail, nullptr, 16);
      if (event.kind == event_t::SHOT_STARTED) forge(event);
    }
    return fire.err().find("fired again; session in") != std::string::npos;
  };
  CHECK_TEXT(ear.wait(ended, kLongestWait), fire.err().c_str());
  CHECK_TEXT(fire.wait(30s) == ExitStatus({0, 0}), fire.err().c_str());
  CHECK(forged >= 2);
  CHECK_TEXT(fire.err().find("a stranger says so") == std::string::npos, fire.err().c_str());
  STRCMP_CONTAINS("packets ignored that are not the lab's", fire.err().c_str());
  check_balls(bench, fire, 2);
}

TEST(Stranger, WhoPlaysALogBackWhileShotsAreFiredHasNoBallMoreThrown) {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  std::vector<std::pair<std::string, Bytes>> packets;
  {
    ReadyRig yesterday(options);
    const auto fired = ran(yesterday.fire(1, 0));
    for (const auto& file : std::filesystem::directory_iterator(yesterday.session())) {
      if (!file.path().filename().string().starts_with("host-")) continue;
      lcm::LogFile log(file.path(), "r");
      while (const lcm::LogEvent* event = log.readNextEvent()) {
        const auto* bytes = static_cast<const std::uint8_t*>(event->data);
        packets.emplace_back(event->channel, Bytes(bytes, bytes + event->datalen));
      }
    }
  }
  CHECK(packets.size() > 50);
  ReadyRig bench(options);
  auto fire = bench.start(bench.fire(2, 0));
  std::atomic<int> rounds = 0;
  {
    std::jthread player([&](const std::stop_token& stop) {
      lcm::LCM lcm(bench.lcm_url());
      for (std::size_t at = 0; !stop.stop_requested(); at = (at + 1) % packets.size()) {
        const auto& [channel, packet] = packets[at];
        lcm.publish(channel, packet.data(), static_cast<unsigned>(packet.size()));
        if (at + 1 == packets.size()) ++rounds;
        std::this_thread::sleep_for(200us);
      }
    });
    CHECK_TEXT(fire.wait(kLongestWait) == ExitStatus({0, 0}), fire.err().c_str());
  }
  CHECK(rounds >= 1);
  check_balls(bench, fire, 2);
}

TEST_GROUP(Flood){};

TEST(Flood, OfTheBusDuringAShotCostsNoEvent) {
  RigFixtureOptions options;
  options.rig_edits = kShortExposure;
  options.sim_options = {"--time", "real"};  // rig time would wait for programs that a flood never lets sleep
  ReadyRig bench(options);
  RawHost host(bench);
  CHECK(host.wait_status());
  const command_t disarm = host.command(command_t::DISARM);
  host.send(disarm);
  // Else it may come after the flood has begun, and stop what is reset by then.
  CHECK(host.wait([&] { return host.status().state == strobe_msgs::status_t::STOPPED; }, kLongestWait));
  std::int64_t packets = 0;
  {
    auto fire = bench.start(bench.fire(1, kRetriesInRealTime));
    // When the person gave the command is judged by the newest status: one that the flood kept waiting would put it before
    // the stop, and the reset is refused.
    const auto armed = [&] { return host.status().state != strobe_msgs::status_t::STOPPED && host.status().state != strobe_msgs::status_t::IDLE; };
    CHECK_TEXT(host.wait(armed, kLongestWait), fire.err().c_str());
    Flooder flooder(bench.lcm_url(), "bench", host.sealed(disarm, host.key()));
    const bool read = fire.wait_for_out("vx_td_mps", 60s);
    packets = flooder.stop();
    const auto ended = fire.wait(30s);
    if (count_of(fire.err(), " us late") > std::size_t{kRetriesInRealTime})
      return skip("the machine made each of the shots late");
    CHECK_TEXT(read, fire.err().c_str());
    CHECK_TEXT(ended == ExitStatus({0, 0}), fire.err().c_str());
    CHECK_TEXT(fire.err().find("still missing") == std::string::npos, fire.err().c_str());
  }
  const auto journalled = read_log(bench.journal()).events;
  CHECK_COMPARE(packets, >, static_cast<std::int64_t>(10 * journalled.size()));  // how many depends on the machine
  for (std::size_t i = 0; i < journalled.size(); ++i)
    LONGS_EQUAL(static_cast<std::int64_t>(i) + 1, journalled[i].sequence);
  bench.finish();
}

TEST_GROUP(CommandFeed) {
  const std::string url = private_lcm_url();
  const std::string channel = messages::channel_name("bench", messages::Channel::command);
  lcm::LCM lcm{url};
  std::unique_ptr<firmware::CommandFeed> feed = std::move(firmware::CommandFeed::open(url, channel)).value();
  RawSender sender{url};
  std::vector<Bytes> messages_in;
  int oversized = 0;

  /// Takes messages in until the mark comes.
  void receive() {
    const Bytes mark{'m', 'a', 'r', 'k'};
    sender.send(RawSender::whole(channel, mark));
    std::stop_source stop;
    const auto end = std::chrono::steady_clock::now() + 10s;
    feed->run(stop.get_token(), {[&](std::span<const std::uint8_t> message) {
                                   messages_in.emplace_back(message.begin(), message.end());
                                   if (messages_in.back() == mark) stop.request_stop();
                                 },
                                 [&] { ++oversized; },
                                 [&] {
                                   if (std::chrono::steady_clock::now() > end) stop.request_stop();
                                 }});
  }
};

TEST(CommandFeed, TakesInWhatLcmSends) {
  const Bytes message(300, 7);
  lcm.publish(channel, message.data(), 300);
  receive();
  LONGS_EQUAL(2, messages_in.size());
  CHECK_EQUAL(message, messages_in[0]);
}

TEST(CommandFeed, TakesInNoOtherChannel) {
  for (const char* other : {"STROBE/bench/EVENT", "STROBE/bench/COMMANDS", "STROBE/rig/COMMAND", "X"})
    sender.send(RawSender::whole(other, {1, 2, 3}));
  receive();
  LONGS_EQUAL(1, messages_in.size());
}

TEST(CommandFeed, CountsWhatLcmSendsInPartsAsOversized) {
  const Bytes message(200'000, 7);
  lcm.publish(channel, message.data(), 200'000);
  receive();
  LONGS_EQUAL(1, oversized);
  LONGS_EQUAL(1, messages_in.size());
}

TEST(CommandFeed, IsNotHarmedByDatagramsThatHarmLcm) {
  const auto part = [&](std::vector<std::uint8_t> header) {
    Bytes datagram{'L', 'C', '0', '3', 0, 0, 0, 9};
    datagram.insert(datagram.end(), header.begin(), header.end());
    datagram.insert(datagram.end(), channel.begin(), channel.end());
    datagram.resize(datagram.size() + 100);
    return datagram;
  };
  sender.send(part({0, 0, 1, 0, 0xff, 0xff, 0xff, 0xf0, 0, 0, 0, 2}));  // an offset that wraps around
  sender.send(part({0x0f, 0xff, 0xff, 0xff, 0, 0, 0, 0, 0, 0, 0, 2}));  // a quarter of a gigabyte to come
  sender.send(part({0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 2}));              // a second part without a first
  Bytes endless{'L', 'C', '0', '2', 0, 0, 0, 1};
  endless.resize(60'000, 'x');  // a channel without an end
  sender.send(endless);
  sender.send({'L', 'C', '0', '2'});
  sender.send({'L', 'C', '0', '3', 0, 0});
  sender.send({});
  sender.send(RawSender::whole(channel, {}));
  receive();
  LONGS_EQUAL(2, messages_in.size());
  LONGS_EQUAL(0, messages_in[0].size());
  LONGS_EQUAL(1, oversized);  // the one that begins a larger message
}

TEST_GROUP(LcmLink) {
  const std::string url = private_lcm_url();
  std::vector<std::pair<std::string, Bytes>> received;
  std::unique_ptr<host::LcmLink> link = host::LcmLink::open(url, "bench").value();
  lcm::LCM lcm{url};

  void send(const std::string& channel, const Bytes& message) {
    lcm.publish(channel, message.data(), static_cast<unsigned>(message.size()));
  }
  bool receive(std::size_t messages) {
    for (int i = 0; i < 500 && received.size() < messages; ++i) {
      link->receive(20ms, {}, [this](const std::string& channel, std::span<const std::uint8_t> bytes) {
        received.emplace_back(channel, Bytes(bytes.begin(), bytes.end()));
      });
    }
    return received.size() >= messages;
  }
};

TEST(LcmLink, TakesInWhatLcmSendsSmallAndInParts) {
  Bytes large(200'000);
  for (std::size_t i = 0; i < large.size(); ++i) large[i] = static_cast<std::uint8_t>(i * i >> 3);
  send("STROBE/bench/EVENT", {1, 2, 3});
  send("STROBE/bench/SHOT", large);
  send("STROBE/bench/STATUS", {});
  CHECK(receive(3));
  CHECK_EQUAL(std::pair(std::string("STROBE/bench/EVENT"), Bytes({1, 2, 3})), received[0]);
  CHECK_EQUAL(std::pair(std::string("STROBE/bench/SHOT"), large), received[1]);
  CHECK(received[2].second.empty());
}

TEST(LcmLink, TakesInNeitherCommandsNorOtherRigs) {
  send("STROBE/bench/COMMAND", {1});
  send("STROBE/bench2/EVENT", {2});
  send("STROBE/benc/EVENT", {3});
  send("STROBE/bench/COMMAND", Bytes(200'000));
  send("STROBE/bench/EVENT", {4});
  CHECK(receive(1));
  CHECK_EQUAL(Bytes{4}, received[0].second);
}
