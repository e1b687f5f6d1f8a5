// What comes down the line to a flash sequencer: any bytes leave it in a state of its own, with no output driven that was
// not armed. Input: sequencer_line.hpp's; 80 us pass with each frame, a second with number 255.
#include <cstddef>
#include <cstdint>

#include "common/flash_sequencer/controller.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/fuzz/sequencer_line.hpp"

namespace {

using namespace strobe::flash_sequencer;
using strobe::fuzz::require;

struct Bench final : Hardware {
  Ticks time = 0;
  bool released = false, prepared = false;
  Ticks now() override { return time; }
  void prepare(std::span<Edge> movers, std::span<Edge> lamps) override {
    require(released && movers.size() <= kMaxEdges && lamps.size() <= kMaxEdges);
    for (const auto track : {movers, lamps})
      require(track.empty() || track.back().levels == 0);
    prepared = true;
  }
  void start(Ticks at, bool) override {
    require(released && prepared && at >= time);
    prepared = false;
  }
  void listen_to_gate(bool) override {}
  Progress progress() override { return {}; }
  void cut() override { released = prepared = false; }
  bool release() override { return released = true; }
  CutCause cut_by_itself() override { return CutCause::none; }
  std::uint8_t inputs() override { return bit(InputLine::key); }
  std::uint8_t outputs() override { return 0; }
  bool pop_input(InputEdge&) override { return false; }
  std::uint16_t lost_inputs() override { return 0; }
  std::uint32_t random() override { return 1; }
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bench bench;
  Controller controller(bench, 1, false);
  Decoder decoder;
  Frame reply;
  for (const std::uint8_t byte : strobe::fuzz::sequencer_line({data, size})) {
    const Frame* request = decoder.take(byte);
    if (request != nullptr) bench.time += ticks_of_us(request->number == 255 ? 1'000'000 : 80);
    if (request != nullptr && controller.answer(*request, bench.time, reply)) {
      require(read_status(reply) || read_identity(reply));
      require(reply.number == request->number);
    }
    controller.turn();
    require(controller.phase() != Phase::cut || !bench.released);
  }
  return 0;
}
