// What a packet of telemetry costs under the lab's key: sealed by its sender, checked by each host; and what a
// stranger's packet costs a host. Run on a quiet machine.
#include <benchmark/benchmark.h>

#include <strobe_msgs/event_t.hpp>
#include <strobe_msgs/status_t.hpp>
#include <vector>

#include "common/authentication/packet_seal.hpp"
#include "common/messages/encode.hpp"
#include "host/messages/packet_check.hpp"
#include "tests/host/synthetic_shot.hpp"

namespace {

using namespace strobe;

constexpr const char* kChannel = "STROBE/bench/EVENT";

std::vector<std::uint8_t> event() {
  strobe_msgs::event_t message{};
  message.detail = "some words";
  return messages::encode(message);
}

std::vector<std::uint8_t> shot() { return messages::encode(host_test::make_shot({}).shot); }

std::vector<std::uint8_t> status() {
  strobe_msgs::status_t message{};
  return messages::encode(message);
}

void seal(benchmark::State& state, const std::vector<std::uint8_t>& message) {
  const authentication::PacketSeal lab(authentication::Key::random());
  std::int64_t sequence = 0;
  for (auto _ : state) benchmark::DoNotOptimize(lab.seal(kChannel, message, {1, ++sequence}));
  state.counters["bytes"] = static_cast<double>(message.size());
}

/// The check with its replay window: each packet is another.
void check(benchmark::State& state, const std::vector<std::uint8_t>& message) {
  const authentication::Key key = authentication::Key::random();
  const authentication::PacketSeal lab(key);
  std::vector<std::vector<std::uint8_t>> packets;
  for (std::int64_t i = 1; i <= 4096; ++i) packets.push_back(lab.seal(kChannel, message, {1, i}));
  host::PacketCheck host(key, 2);
  std::size_t next = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(host.open(kChannel, packets[next]));
    next = (next + 1) % packets.size();
  }
}

void strangers(benchmark::State& state, const std::vector<std::uint8_t>& packet) {
  host::PacketCheck host(authentication::Key::random(), 2);
  for (auto _ : state) benchmark::DoNotOptimize(host.open(kChannel, packet));
}

BENCHMARK_CAPTURE(seal, event, event());
BENCHMARK_CAPTURE(seal, status, status());
BENCHMARK_CAPTURE(seal, shot, shot());
BENCHMARK_CAPTURE(check, event, event());
BENCHMARK_CAPTURE(check, status, status());
BENCHMARK_CAPTURE(check, shot, shot());
BENCHMARK_CAPTURE(strangers, unsealed, event());

}  // namespace
