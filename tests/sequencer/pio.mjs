// A PIO block of rp2040js, driven cycle by cycle as the datasheet says (RP2040 datasheet 3.2 to 3.5): enabled machines
// only, delays, WAIT, autopull with its prefetch, FIFOs joined and flushed. The emulator's own leaves these out.
// Instructions that the sequencer does not use throw.

export const FOREVER = Infinity;
const AUTOPULL = 1 << 17, JOIN_TX = 1 << 30, JOIN_RX = 1 << 31;
const ALWAYS = 0, X_THEN_LESS = 2, Y_THEN_LESS = 4, PIN = 6;

export class Pio {
  // block: of rp2040js; before_access(): drives all blocks up to now; on_pins(cycle, values): its pins changed.
  constructor(block, before_access, on_pins) {
    this.block = block;
    this.machines = block.machines;
    this.cycle = 0;
    this.inputs = 0;
    this.pending = []; // {cycle, pin, level} as the synchronizers pass it on
    this.on_pins = on_pins;
    this.driving = false;
    block.run = () => {};
    const read = block.readUint32.bind(block), write = block.writeUint32.bind(block);
    block.readUint32 = offset => {
      if (!this.driving) before_access();
      return read(offset);
    };
    block.writeUint32 = (offset, value) => {
      if (!this.driving) before_access();
      const shifts = this.machines.map(machine => machine.shiftCtrl), pins = block.pinValues;
      write(offset, value);
      if (block.pinValues !== pins) on_pins(this.cycle, block.pinValues);
      this.machines.forEach((machine, i) => this.join(machine, shifts[i] ^ machine.shiftCtrl));
    };
    for (const machine of this.machines) {
      machine.delay = 0;
      machine.clkDivRestart = () => {};
      const restart = machine.restart.bind(machine);
      machine.restart = () => {
        restart();
        machine.delay = 0;
      };
    }
  }

  join(machine, changed) {
    if (!(changed & (JOIN_TX | JOIN_RX))) return;
    const Fifo = machine.txFIFO.constructor;
    machine.txFIFO = new Fifo(machine.shiftCtrl & JOIN_TX ? 8 : 4);
    machine.rxFIFO = new Fifo(machine.shiftCtrl & JOIN_RX ? 8 : 4);
    machine.updateDMATx();
    machine.updateDMARx();
  }

  // A pin's level as it is from that cycle on; machines see it two cycles later.
  input(cycle, pin, level) {
    this.pending.push({ cycle: cycle + 2, pin, level });
  }

  drive(to) {
    this.driving = true;
    while (this.cycle < to) {
      while (this.pending.length && this.pending[0].cycle <= this.cycle) {
        const { pin, level } = this.pending.shift();
        this.inputs = level ? this.inputs | (1 << pin) : this.inputs & ~(1 << pin);
      }
      const end = this.pending.length ? Math.min(to, this.pending[0].cycle) : to;
      let quiet = end - this.cycle;
      for (const machine of this.machines) quiet = Math.min(quiet, this.quiet(machine));
      if (quiet > 0) {
        for (const machine of this.machines) this.skip(machine, quiet);
        this.cycle += quiet;
      } else {
        this.step();
      }
    }
    this.driving = false;
  }

  step() {
    const before = this.block.pinValues;
    for (const machine of this.machines) if (machine.enabled) this.turn(machine);
    if (this.block.pinValues !== before) this.on_pins(this.cycle, this.block.pinValues);
    this.cycle += 1;
  }

  high(pin) {
    return ((this.inputs >>> pin) & 1) === 1;
  }

  // For how many cycles nothing comes of a machine but its count; inputs stay as they are.
  quiet(machine) {
    if (!machine.enabled) return FOREVER;
    if (machine.delay > 0) return 0;
    if (machine.shiftCtrl & AUTOPULL && machine.outputShiftCount >= 32 && !machine.txFIFO.empty) return 0;
    const { pc } = machine, code = this.block.instructions[pc];
    switch (code >>> 13) {
      case 0: {
        const target = code & 31, condition = (code >> 5) & 7;
        if ((code >> 8) & 31) return 0;
        if (target === pc) {
          if (condition === ALWAYS || (condition === PIN && this.high(machine.jmpPin))) return FOREVER;
          return condition === X_THEN_LESS ? machine.x : 0;
        }
        return this.counts_down(machine) ? Math.max(0, 2 * (machine.x - 1)) : 0;
      }
      case 1:
        return this.high(code & 31) === Boolean(code & 0x80) ? 0 : FOREVER;
      case 3:
        return machine.outputShiftCount >= 32 && this.block.fdebug & (1 << (24 + machine.index)) ? FOREVER : 0;
      case 5: // zeros again and again
        return code === 0xa003 && machine.wrapTop === pc && machine.wrapBottom === pc && this.zero(machine) ? FOREVER : 0;
    }
    return 0;
  }

  zero(machine) {
    return ((this.block.pinValues >>> machine.outBase) & ((1 << machine.outCount) - 1)) === 0;
  }

  // Two instructions in turn: a JMP PIN, and a decrement that jumps to it.
  counts_down(machine) {
    const { instructions } = this.block, at = instructions[machine.pc];
    const looks = code => code >>> 5 === PIN; // and no delay
    const first = looks(at) ? machine.pc : at & 31;
    if (!looks(instructions[first])) return false;
    const second = this.high(machine.jmpPin) ? instructions[first] & 31 : first + 1;
    if (instructions[second] !== ((X_THEN_LESS << 5) | first)) return false;
    machine.loop = [first, second];
    return machine.pc === first || machine.pc === second;
  }

  skip(machine, cycles) {
    if (!machine.enabled) return;
    const code = this.block.instructions[machine.pc];
    if (code >>> 13 !== 0 || ((code & 31) === machine.pc && ((code >> 5) & 7) !== X_THEN_LESS)) return;
    if ((code & 31) === machine.pc) {
      machine.x -= cycles;
      return;
    }
    const [first, second] = machine.loop;
    const from = machine.pc === first ? 0 : 1;
    machine.x -= (from + cycles) >> 1;
    if (cycles & 1) machine.pc = from ? first : second;
  }

  turn(machine) {
    if (machine.delay > 0) {
      machine.delay -= 1;
    } else {
      const code = this.block.instructions[machine.pc];
      if (this.execute(machine, code)) machine.delay = (code >> 8) & 31;
      if (code >>> 13 === 3) return;
    }
    this.prefetch(machine);
  }

  prefetch(machine) {
    if (!(machine.shiftCtrl & AUTOPULL) || machine.outputShiftCount < 32 || machine.txFIFO.empty) return;
    machine.outputShiftReg = machine.txFIFO.pull();
    machine.outputShiftCount = 0;
    machine.updateDMATx();
  }

  // False: it stalls.
  execute(machine, code) {
    switch (code >>> 13) {
      case 0: {
        if (this.condition(machine, (code >> 5) & 7)) machine.pc = code & 31;
        else machine.nextPC();
        return true;
      }
      case 1:
        if ((code >> 5) & 3) throw new Error(`pio: WAIT ${code.toString(16)}`);
        if (this.high(code & 31) !== Boolean(code & 0x80)) return false;
        machine.nextPC();
        return true;
      case 3:
        return this.out(machine, code);
      default:
        if (code >>> 13 === 2 || code >>> 13 === 6) throw new Error(`pio: instruction ${code.toString(16)}`);
        machine.updatePC = true;
        machine.executeInstruction(code);
        if (machine.updatePC) machine.nextPC();
        return true;
    }
  }

  condition(machine, condition) {
    switch (condition) {
      case ALWAYS:
        return true;
      case X_THEN_LESS: {
        const before = machine.x;
        machine.x = (before - 1) >>> 0;
        return before !== 0;
      }
      case Y_THEN_LESS: {
        const before = machine.y;
        machine.y = (before - 1) >>> 0;
        return before !== 0;
      }
      case PIN:
        return this.high(machine.jmpPin);
    }
    throw new Error(`pio: JMP condition ${condition}`);
  }

  out(machine, code) {
    if (!(machine.shiftCtrl & AUTOPULL)) throw new Error('pio: OUT without autopull');
    if (machine.outputShiftCount >= 32) {
      if (machine.txFIFO.empty) this.block.fdebug |= 1 << (24 + machine.index);
      this.prefetch(machine);
      return false;
    }
    machine.outInstruction(code & 0xff);
    this.prefetch(machine);
    machine.nextPC();
    return true;
  }
}
