// An RP2040 of rp2040js with the sequencer's image, all in step: processor, clock, PIO blocks, DMA, UART, watchdog.
// Time is in cycles of 8 ns since the chip got power; pins change at a cycle, and what the outputs do is logged with it.
import { createRequire } from 'node:module';

import { Pio } from './pio.mjs';

const { RP2040 } = createRequire(`${process.env.STROBE_BUILD_DIR}/sequencer/`)('rp2040js');

export const CYCLES_PER_US = 125;
export const BYTE_CYCLES = 10 * CYCLES_PER_US; // at 1,000,000 baud: start, 8 bits, stop
export const PIN = {
  outputs: 2, key: 8, estop: 9, sensor_a: 10, sensor_b: 11, gate: 12, xsync: 13, burst: 21, start: 22, led: 25,
};
const FUNCTION_PIO0 = 6;

function boot_crc(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte << 24;
    for (let i = 0; i < 8; i++) crc = (crc << 1) ^ (crc & 0x80000000 ? 0x04c11db7 : 0);
  }
  return crc >>> 0;
}

export class Chip {
  constructor(image, seed) {
    this.image = image;
    this.random = seed >>> 0 || 1;
    this.cycle = 0;
    this.levels = (1 << PIN.key) | (1 << PIN.estop); // key on, e-stop released
    this.log = []; // {cycle, outputs}: as they are from that cycle on; null: they are inputs
    this.resets = [];
    this.hung = false;
    this.to_chip = []; // {cycle, byte}: complete at that cycle
    this.line_busy = 0;
    this.on_byte = () => {}; // (cycle, byte)
    this.plan = []; // {cycle, call}, sorted
    this.boot(false);
  }

  // What the boot ROM does: the first 256 bytes go to RAM, are checked and run.
  boot(by_watchdog) {
    this.began = this.cycle;
    const chip = new RP2040();
    this.chip = chip;
    chip.logger = { debug() {}, info() {}, warn() {}, error: (name, text) => { throw new Error(`${name}: ${text}`); } };
    chip.flash.set(this.image);
    if (boot_crc(this.image.subarray(0, 252)) !== chip.flashView.getUint32(252, true)) {
      throw new Error("boot ROM: the second stage's CRC is wrong");
    }
    chip.sram.set(this.image.subarray(0, 256), 0x41f00);
    chip.core.PC = 0x20041f00;
    chip.core.SP = 0x20041f00;
    const watchdog = chip.peripherals[0x40058];
    watchdog.reason = by_watchdog ? 1 : 0;
    watchdog.onWatchdogTrigger = () => {
      this.bitten = true;
      watchdog.alarm.enable = false;
    };
    this.bitten = false;
    this.couple_core(chip);
    this.couple_uart(chip);
    this.couple_dma(chip.dma);
    this.couple_pins(chip);
  }

  couple_core(chip) {
    chip.ppb.systickAlarm.enable = false; // it loses a cycle each time round
    const read = chip.ppb.readUint32.bind(chip.ppb);
    chip.ppb.readUint32 = offset => (offset === 0x18 ? (0xffffff - (this.cycle - this.began)) & 0xffffff : read(offset));
    chip.peripherals[0x40060] = { // ring oscillator
      readUint32: () => (this.random = (Math.imul(this.random, 1664525) + 1013904223) >>> 0) >>> 31,
      writeUint32Atomic() {},
    };
  }

  couple_uart(chip) {
    const uart = chip.uart[0], read = uart.readUint32.bind(uart), write = uart.writeUint32.bind(uart);
    this.tx_free = 0;
    uart.readUint32 = offset => {
      if (offset === 0x18) return (uart.flags & ~0x80) | (this.tx_free - this.cycle > 32 * BYTE_CYCLES ? 0x20 : 0);
      const value = read(offset);
      if (offset === 0 && uart.rxFIFO.empty) chip.dma.clearDREQ(uart.dreq.rx);
      return value;
    };
    uart.writeUint32 = (offset, value) => {
      if (offset === 0x48) return; // DMACR
      write(offset, value);
    };
    uart.onByte = byte => {
      if (!uart.enabled || uart.baudRate !== 1_000_000) throw new Error(`uart: ${uart.baudRate} baud`);
      this.tx_free = Math.max(this.cycle, this.tx_free) + BYTE_CYCLES;
      this.at(this.tx_free, () => this.on_byte(this.cycle, byte));
    };
  }

  // Transfers are immediate: what the bus and the DMA take is left out.
  couple_dma(dma) {
    for (const channel of dma.channels) {
      channel.scheduleTransfer = () => {
        if (dma.dreq[channel.treqValue] || channel.treqValue === 0x3f) channel.transfer();
      };
    }
    const read = dma.readUint32.bind(dma);
    dma.readUint32 = offset => (offset === 0x444 ? 0 : read(offset)); // CHAN_ABORT: at once
  }

  couple_pins(chip) {
    this.outputs = null;
    this.pio = chip.pio.map((block, i) => {
      const pio = new Pio(block, () => this.drive(this.cycle), (cycle, values) => i === 0 && this.pio_pins(cycle, values));
      pio.cycle = this.cycle;
      pio.inputs = this.levels;
      return pio;
    });
    const sio = chip.sio, read = sio.readUint32.bind(sio), write = sio.writeUint32.bind(sio);
    sio.readUint32 = offset => {
      if (offset !== 4) return read(offset);
      this.drive(this.cycle);
      return (this.levels | ((this.outputs ?? 0) << PIN.outputs)) >>> 0;
    };
    sio.writeUint32 = (offset, value) => {
      const before = sio.gpioValue;
      write(offset, value);
      if ((before ^ sio.gpioValue) & (1 << PIN.start)) this.loop_back(this.cycle, PIN.start, sio.gpioValue);
    };
    for (let line = 0; line < 6; line++) {
      chip.gpio[PIN.outputs + line].addListener(() => this.pads_changed());
    }
  }

  pads_changed() {
    const { chip } = this;
    const driven = [0, 1, 2, 3, 4, 5].every(line => {
      const pin = chip.gpio[PIN.outputs + line];
      return pin.functionSelect === FUNCTION_PIO0 && pin.outputEnable;
    });
    if (driven && this.outputs === null) this.set_outputs(this.cycle, (chip.pio[0].pinValues >>> PIN.outputs) & 63);
  }

  pio_pins(cycle, values) {
    if (this.outputs !== null) this.set_outputs(cycle, (values >>> PIN.outputs) & 63);
    if (((values >>> PIN.burst) & 1) !== this.burst) {
      this.burst = (values >>> PIN.burst) & 1;
      this.loop_back(cycle, PIN.burst, values);
    }
  }

  loop_back(cycle, pin, values) {
    for (const pio of this.pio) pio.input(cycle, pin, (values >>> pin) & 1);
  }

  set_outputs(cycle, outputs) {
    if (outputs === this.outputs) return;
    this.outputs = outputs;
    this.log.push({ cycle, outputs });
  }

  // PIO0 first: it raises BURST for PIO1 to see.
  drive(to) {
    for (const pio of this.pio) if (pio.cycle < to) pio.drive(to);
  }

  at(cycle, call) {
    let place = this.plan.length;
    while (place > 0 && this.plan[place - 1].cycle > cycle) place--;
    this.plan.splice(place, 0, { cycle, call });
  }

  set_pin_at(cycle, pin, level) {
    this.at(cycle, () => {
      this.drive(cycle);
      this.levels = level ? this.levels | (1 << pin) : this.levels & ~(1 << pin);
      for (const pio of this.pio) pio.input(cycle, pin, level);
    });
  }

  // Bytes to the chip, one after the other from now on. Returns the cycle when the last one is complete.
  send(bytes) {
    for (const byte of bytes) {
      this.line_busy = Math.max(this.line_busy, this.cycle) + BYTE_CYCLES;
      this.at(this.line_busy, () => {
        const uart = this.chip.uart[0];
        if (!uart.enabled || uart.rxFIFO.full) return;
        uart.rxFIFO.push(byte);
        this.chip.dma.setDREQ(uart.dreq.rx);
      });
    }
    return this.line_busy;
  }

  run_until(end) {
    while (this.cycle < end) {
      while (this.plan.length && this.plan[0].cycle <= this.cycle) this.plan.shift().call();
      const cycles = this.hung ? 16 : this.chip.core.executeInstruction();
      this.cycle += cycles;
      this.chip.clock.tick(8 * cycles);
      if (this.bitten) this.reset();
    }
    this.drive(this.cycle);
  }

  reset() {
    this.drive(this.cycle);
    this.resets.push(this.cycle);
    if (this.outputs !== null) this.log.push({ cycle: this.cycle, outputs: null });
    this.hung = false;
    this.boot(true);
  }
}
