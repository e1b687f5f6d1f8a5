#include "firmware/sequencer/rp2040_hardware.hpp"

#include <atomic>

#include "firmware/sequencer/chip.hpp"
#include "firmware/sequencer/pio_programs.hpp"
#include "firmware/sequencer/rp2040.hpp"

namespace strobe::sequencer {
namespace {

using namespace flash_sequencer;

constexpr unsigned kMovers = 0, kLamps = 1, kEstopWatch = 2, kKeyWatch = 3;  // machines of PIO0
constexpr unsigned kStartStamps = 3;                                         // of PIO1; the others:
constexpr std::array kStamped = {InputLine::sensor_a, InputLine::sensor_b, InputLine::gate};
constexpr std::array kPolled = {InputLine::key, InputLine::estop, InputLine::xsync};
constexpr std::array kDma = {DmaChannel(0), DmaChannel(1)};  // of the tracks
constexpr Ticks kCloseToStart = ticks_of_us(150);

constexpr std::uint32_t kPlayerShift = pio::kAutopull | pio::kShiftOutRight | pio::kJoinTx;

template <std::size_t size>
void load_program(const PioBlock& pio, const std::array<std::uint16_t, size>& code) {
  for (std::size_t i = 0; i < size; ++i) (pio.INSTR_MEM0 + 4 * i).write(code[i]);
}

void set_machine(const PioBlock& pio, unsigned machine, std::uint32_t exec, std::uint32_t shift,
                 std::uint32_t pins) {
  pio.CLKDIV(machine).write(1U << 16);
  pio.EXECCTRL(machine).write(exec);
  pio.SHIFTCTRL(machine).write(shift);
  pio.PINCTRL(machine).write(pins);
}

/// All outputs of PIO0 driven, and zero.
void drive_outputs() {
  PIO0.INSTR(kKeyWatch).write(pio::mov(pio::To::pins, pio::From::null));
  PIO0.INSTR(kKeyWatch).write(pio::mov(pio::To::osr, pio::From::null, true));
  PIO0.INSTR(kKeyWatch).write(pio::out_all(pio::To::pindirs));
  PIO0.INSTR(kLamps).write(pio::set(pio::To::pins, 0));
  PIO0.INSTR(kLamps).write(pio::set(pio::To::pindirs, 1));
  for (unsigned line = 0; line < kOutputCount; ++line) {
    gpio_ctrl(kFirstOutputPin + line).write(static_cast<std::uint32_t>(Function::pio0));
  }
  gpio_ctrl(kBurstPin).write(static_cast<std::uint32_t>(Function::pio0));
}

void set_up_outputs_pio() {
  using namespace outputs_program;
  load_program(PIO0, kCode);
  const std::uint32_t lamps = pio::out_pins(kFirstOutputPin + 2, 4) | 1U << 26 | kBurstPin << 5;
  set_machine(PIO0, kMovers, pio::wrap(0, 31), kPlayerShift, pio::out_pins(kFirstOutputPin, 2));
  set_machine(PIO0, kLamps, pio::wrap(0, 31), kPlayerShift, lamps);
  for (const auto& [machine, pin] : {std::pair{kEstopWatch, kEstopPin}, std::pair{kKeyWatch, kKeyPin}}) {
    set_machine(PIO0, machine, pio::wrap(kCut, kCut) | pio::jump_pin(pin), pio::kShiftOutRight,
                pio::out_pins(kFirstOutputPin, kOutputCount));
  }
  drive_outputs();
  for (const unsigned machine : {kEstopWatch, kKeyWatch}) {
    PIO0.INSTR(machine).write(pio::jmp(kCut));
    PIO0.CTRL.set(pio_enable(machine));
  }
}

void set_up_stamps_pio() {
  using namespace stamps_program;
  load_program(PIO1, kCode);
  std::uint32_t all = 0;
  for (unsigned machine = 0; machine < 4; ++machine) {
    set_machine(PIO1, machine, pio::wrap(kLow, kWrapTop) | pio::jump_pin(kStartPin),
                pio::kShiftOutRight | pio::kJoinRx, 0);
    PIO1.INSTR(machine).write(pio::mov(pio::To::x, pio::From::null, true));
    PIO1.INSTR(machine).write(pio::jmp(kLow));
    all |= pio_enable(machine) | pio_clkdiv_restart(machine);
  }
  PIO1.CTRL.write(all);  // in the same cycle
}

void watch_by_stamps(unsigned machine, unsigned pin) {
  PIO1.EXECCTRL(machine).write(pio::wrap(stamps_program::kLow, stamps_program::kWrapTop) |
                               pio::jump_pin(pin));
}

bool gate_unheard() {
  const std::uint32_t at = PIO0.ADDR(kLamps).read();
  return at >= outputs_program::kListen && at < outputs_program::kHeardGate;
}

}  // namespace

bool Rp2040Hardware::start() {
  last_systick_ = SYST_CVR.read();
  last_timer_us_ = TIMERAWL.read();
  set_up_outputs_pio();
  set_up_stamps_pio();
  cut();
  if (!calibrate()) return false;
  polled_ = inputs();
  return true;
}

/// All four machines stamp START once: its instant is known, and that they count alike.
bool Rp2040Hardware::calibrate() {
  const Ticks before = now();
  GPIO_OUT_SET.write(bit(kStartPin));
  const Ticks after = now();
  while (now() < after + 100) {
  }
  if ((PIO1.FSTAT.read() & kPioAllRxEmpty) != 0) return false;  // not all have stamped it
  const std::uint32_t count = PIO1.RXF(0).read();
  for (unsigned machine = 1; machine < 4; ++machine) {
    if (PIO1.RXF(machine).read() != count) return false;
  }
  stamps_begin_ = (before + after) / 2 - stamps_program::kCyclesPerCount * std::int64_t{~count};
  for (std::size_t i = 0; i < kStamped.size(); ++i) watch_by_stamps(i, pin_of(kStamped[i]));
  GPIO_OUT_CLR.write(bit(kStartPin));

  const std::uint32_t timer_us = TIMERAWL.read();
  while (TIMERAWL.read() == timer_us) {
  }
  timer_begin_ = now() - ticks_of_us(timer_us + 1 - last_timer_us_);
  return (PIO1.FSTAT.read() & kPioAllRxEmpty) == kPioAllRxEmpty;
}

Ticks Rp2040Hardware::now() {
  const std::uint32_t systick = SYST_CVR.read();
  now_ += (last_systick_ - systick) & 0xffffff;
  last_systick_ = systick;
  return now_;
}

Ticks Rp2040Hardware::ticks_of(std::uint32_t timer_us) {
  // In the middle of the timer's step.
  return timer_begin_ + ticks_of_us(timer_us_ + static_cast<std::int32_t>(timer_us - last_timer_us_)) +
         ticks_of_us(1) / 2;
}

/// The machine counts in every other cycle: the count as it is now gives the upper bits.
Ticks Rp2040Hardware::stamped(std::uint32_t count) {
  using stamps_program::kCyclesPerCount;
  const std::int64_t counts = (now() - stamps_begin_) / kCyclesPerCount;
  const auto ago = static_cast<std::int32_t>(static_cast<std::uint32_t>(counts) - ~count);
  return stamps_begin_ + kCyclesPerCount * (counts - ago);
}

void Rp2040Hardware::poll() {
  const std::uint32_t timer_us = TIMERAWL.read();
  timer_us_ += timer_us - last_timer_us_;
  last_timer_us_ = timer_us;
  take_stamps();
  poll_levels();
  if (waits_ && now() >= start_at_ - kCloseToStart) begin();
  if (!waits_ && gate_wanted_ != gate_open_) keep_gate(gate_wanted_);
}

void Rp2040Hardware::prepare(std::span<Edge> movers, std::span<Edge> lamps) {
  take_stamps();  // the last train's
  GPIO_OUT_CLR.write(bit(kStartPin));
  PIO0.CTRL.clear(pio_enable(kMovers) | pio_enable(kLamps));
  PIO0.INSTR(kLamps).write(pio::set(pio::To::pins, 0));
  watch_by_stamps(kStartStamps, kStartPin);
  load(0, movers, outputs_program::kPlay);
  load(1, lamps, outputs_program::kPlay);
  waits_ = gate_wanted_ = gate_open_ = false;
  progress_ = {};
}

void Rp2040Hardware::load(std::size_t index, std::span<const Edge> edges, unsigned entry) {
  using namespace outputs_program;
  Track& track = tracks_[index];
  track.count = edges.size();
  const unsigned shift = index == kLamps ? 2 : 0;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    track.words[i] = {.delay = edges[i].delay - kEdgeCycles, .levels = edges[i].levels >> shift};
  }
  if (!edges.empty()) track.words[0].delay -= kFirstCycles - kEdgeCycles;

  const DmaChannel& dma = kDma[index];
  DMA_CHAN_ABORT.write(bit(dma.number));
  while ((DMA_CHAN_ABORT.read() & bit(dma.number)) != 0) {
  }
  PIO0.SHIFTCTRL(index).write(kPlayerShift & ~pio::kJoinTx);  // a change empties the FIFO
  PIO0.SHIFTCTRL(index).write(kPlayerShift);
  PIO0.CTRL.set(pio_restart(index) | pio_clkdiv_restart(index));
  PIO0.INSTR(index).write(pio::jmp(entry));
  PIO0.FDEBUG.write(pio_tx_stall(index));
  if (edges.empty()) return;
  PIO0.TXF(index).write(edges.size() - 1);
  dma.READ_ADDR.write(reinterpret_cast<std::uint32_t>(track.words.data()));
  dma.WRITE_ADDR.write(PIO0.TXF(index).address());
  dma.TRANS_COUNT.write(2 * edges.size());
  std::atomic_signal_fence(std::memory_order_seq_cst);  // the words are written before they are fetched
  dma.CTRL_TRIG.write(kDmaEnable | kDmaHighPriority | kDmaWords | kDmaIncrRead | dma_chain_to(dma.number) |
                      dma_paced_by(kDreqPio0Tx0 + index));
}

void Rp2040Hardware::start(Ticks at, bool gated) {
  start_at_ = at;
  gated_ = gated;
  waits_ = true;
  if (gated) PIO0.INSTR(kLamps).write(pio::jmp(outputs_program::kPlayGated));
  if (tracks_[kMovers].count != 0) PIO0.CTRL.set(pio_enable(kMovers));
  if (tracks_[kLamps].count != 0 && !gated) PIO0.CTRL.set(pio_enable(kLamps));
}

/// The machines wait for START, and the stamp of it says when that was: what is late here is known.
void Rp2040Hardware::begin() {
  const Ticks left = start_at_ - now();
  const std::uint32_t from = last_systick_;
  while (left > static_cast<Ticks>((from - SYST_CVR.read()) & 0xffffff)) {
  }
  GPIO_OUT_SET.write(bit(kStartPin));
  waits_ = false;
}

void Rp2040Hardware::listen_to_gate(bool listens) {
  gate_wanted_ = listens;
  if (!waits_ && gate_wanted_ != gate_open_) keep_gate(listens);
}

void Rp2040Hardware::keep_gate(bool open) {
  gate_open_ = open;
  if (tracks_[kLamps].count == 0) return;
  if (open) {
    take_stamps();  // START's
    watch_by_stamps(kStartStamps, kBurstPin);
    PIO0.CTRL.set(pio_enable(kLamps));
  } else if (gate_unheard()) {
    PIO0.CTRL.clear(pio_enable(kLamps));
    PIO0.INSTR(kLamps).write(pio::mov(pio::To::pins, pio::From::null));  // of an edge that came in between
    PIO0.INSTR(kLamps).write(pio::jmp(outputs_program::kListen));
    PIO0.INSTR(kLamps).write(pio::set(pio::To::pins, 0));
    take_stamps();
    progress_.burst_started = kNoTicks;  // an edge in between does not count
  }
}

Progress Rp2040Hardware::progress() {
  if (cut_) return progress_;
  take_stamps();
  for (std::size_t i = 0; i < kTrackCount; ++i) {
    progress_.played[i] = played(i);
    if (tracks_[i].count != 0 && (PIO0.FDEBUG.read() & pio_tx_stall(i)) != 0) progress_.underrun = true;
  }
  return progress_;
}

/// From the words that the machine took. It holds one more than it has played of, see outputs_program.
std::uint16_t Rp2040Hardware::played(std::size_t index) const {
  const std::size_t count = tracks_[index].count;
  if (count == 0) return 0;
  if (PIO0.ADDR(index).read() == outputs_program::kOver) return static_cast<std::uint16_t>(count);
  std::uint32_t words = 0;
  for (int tries = 0; tries < 16; ++tries) {
    const std::uint32_t queued = PIO0.FLEVEL.read() >> (8 * index) & 0xf;
    const std::uint32_t unread = kDma[index].TRANS_COUNT.read();
    words = 2 * count + 1 - unread - queued;  // the first is the count
    const bool on_its_way = (kDma[index].AL1_CTRL.read() & kDmaBusy) != 0 && queued != 8;
    if (!on_its_way) break;
  }
  return static_cast<std::uint16_t>(words < 2 ? 0 : (words - 2) / 2);
}

void Rp2040Hardware::cut() {
  PIO0.INSTR(kKeyWatch).write(pio::jmp(outputs_program::kCut));
  PIO0.CTRL.clear(pio_enable(kMovers) | pio_enable(kLamps));
  if (!cut_) (void)progress();  // as it is now
  cut_ = true;
  for (const DmaChannel& dma : kDma) DMA_CHAN_ABORT.write(bit(dma.number));
  waits_ = gate_wanted_ = gate_open_ = false;
}

bool Rp2040Hardware::release() {
  if ((inputs() & (bit(InputLine::key) | bit(InputLine::estop))) != bit(InputLine::key)) {
    return false;
  }
  for (const unsigned machine : {kEstopWatch, kKeyWatch}) {
    PIO0.INSTR(machine).write(pio::jmp(outputs_program::kWatch));
  }
  cut_ = false;
  for (Track& track : tracks_) track.count = 0;
  progress_ = {};
  return true;
}

CutCause Rp2040Hardware::cut_by_itself() {
  if (cut_) {
    const std::uint8_t levels = inputs();
    if ((levels & bit(InputLine::estop)) != 0) return CutCause::estop;
    return (levels & bit(InputLine::key)) == 0 ? CutCause::key : CutCause::none;
  }
  if (PIO0.ADDR(kEstopWatch).read() == outputs_program::kCut) return CutCause::estop;
  return PIO0.ADDR(kKeyWatch).read() == outputs_program::kCut ? CutCause::key : CutCause::none;
}

std::uint8_t Rp2040Hardware::inputs() {
  const std::uint32_t levels = (GPIO_IN.read() >> kFirstInputPin) & (bit(kInputCount) - 1);
  return static_cast<std::uint8_t>(levels ^ bit(InputLine::estop));
}

std::uint8_t Rp2040Hardware::outputs() {
  return static_cast<std::uint8_t>((GPIO_IN.read() >> kFirstOutputPin) & (bit(kOutputCount) - 1));
}

void Rp2040Hardware::take_stamps() {
  for (unsigned machine = 0; machine < 4; ++machine) {
    while ((PIO1.FSTAT.read() & pio_rx_empty(machine)) == 0) {
      const Ticks time = stamped(PIO1.RXF(machine).read());
      if (machine != kStartStamps) {
        push_input({.line = kStamped[machine], .active = 1, .time = time});
      } else if (progress_.started == kNoTicks) {
        progress_.started = time;
        if (!gated_) progress_.burst_started = time;
      } else {
        progress_.burst_started = time - outputs_program::kGateToBurst;
      }
    }
    if ((PIO1.FDEBUG.read() & pio_rx_stall(machine)) == 0) continue;
    PIO1.FDEBUG.write(pio_rx_stall(machine));
    ++lost_inputs_;
  }
}

void Rp2040Hardware::poll_levels() {
  const std::uint8_t levels = inputs();
  for (const InputLine line : kPolled) {
    const std::uint8_t mask = bit(line);
    if (((levels ^ polled_) & mask) == 0) continue;
    push_input({.line = line, .active = static_cast<std::uint8_t>((levels & mask) != 0), .time = now()});
  }
  polled_ = levels;
}

void Rp2040Hardware::push_input(const InputEdge& edge) {
  if (end_input_ - first_input_ == inputs_.size()) {
    ++lost_inputs_;
    return;
  }
  std::size_t place = end_input_++;
  for (; place != first_input_ && inputs_[(place - 1) % inputs_.size()].time > edge.time; --place) {
    inputs_[place % inputs_.size()] = inputs_[(place - 1) % inputs_.size()];
  }
  inputs_[place % inputs_.size()] = edge;
}

bool Rp2040Hardware::pop_input(InputEdge& edge) {
  if (first_input_ == end_input_) return false;
  edge = inputs_[first_input_++ % inputs_.size()];
  return true;
}

std::uint32_t Rp2040Hardware::random() { return random_bits(); }

}  // namespace strobe::sequencer
