// A host of the flash sequencer, after common/flash_sequencer/protocol.hpp alone.
import { crc32 } from 'node:zlib';

import { BYTE_CYCLES, CYCLES_PER_US } from './chip.mjs';

export const REQUEST = { hello: 1, limits: 2, load: 3, arm: 4, start: 5, beat: 6, abort: 7, reset: 8 };
export const PHASE = ['idle', 'armed', 'playing', 'cut'];
export const CAUSE = ['none', 'key', 'estop', 'heartbeat', 'abort', 'underrun', 'overrun'];
export const REFUSAL = [
  'none', 'malformed', 'wrong_phase', 'bad_index', 'foreign_line', 'delay_too_short', 'train_differs', 'ends_active',
  'on_too_long', 'key_off', 'estop_pressed', 'no_heartbeat', 'wrong_challenge', 'too_late',
];
export const INPUT = ['key', 'estop', 'sensor_a', 'sensor_b', 'gate', 'xsync'];
const NO_TICKS = -(2n ** 63n);
const EDGES_A_FRAME = 29;

const crc_of = globalThis.process && crc32 ? bytes => crc32(bytes) >>> 0 : crc_slowly;
function crc_slowly(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte;
    for (let i = 0; i < 8; i++) crc = (crc >>> 1) ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return ~crc >>> 0;
}

export function frame(kind, number, body) {
  const plain = [kind, number, ...body];
  const crc = crc_of(Uint8Array.from(plain));
  for (let i = 0; i < 4; i++) plain.push((crc >>> (8 * i)) & 255);
  const wire = [];
  for (let rest = [...plain, 0]; rest.length;) {
    const zero = rest.indexOf(0);
    if (zero > 253) {
      wire.push(255, ...rest.slice(0, 254));
      rest = rest.slice(254);
    } else {
      wire.push(zero + 1, ...rest.slice(0, zero));
      rest = rest.slice(zero + 1);
    }
  }
  return [...wire, 0];
}

function unframe(wire) {
  const plain = [];
  for (let i = 0; i < wire.length;) {
    const block = wire[i];
    if (block === 0 || i + block > wire.length) return null;
    plain.push(...wire.slice(i + 1, i + block));
    i += block;
    if (block < 255 && i < wire.length) plain.push(0);
  }
  if (plain.length < 6) return null;
  const data = Buffer.from(plain);
  if (crc_of(data.subarray(0, -4)) !== data.readUInt32LE(data.length - 4)) return null;
  return { kind: data[0], number: data[1], body: data.subarray(2, -4) };
}

const ticks = (body, at) => (body.readBigInt64LE(at) === NO_TICKS ? null : Number(body.readBigInt64LE(at)));

function read({ kind, number, body }) {
  if (kind === 0x81) {
    return {
      kind: 'identity', number, version: body[0], boot: body.readBigUInt64LE(1), by_watchdog: body[9],
      max_edges: body.readUInt16LE(10),
    };
  }
  if (kind === 0x82) {
    return {
      kind: 'status', number, answers: body[0], refusal: REFUSAL[body[1]], phase: PHASE[body[2]], cut: CAUSE[body[3]],
      inputs: body[4], outputs: body[5], challenge: body.readUInt32LE(6), received: ticks(body, 10),
      started: ticks(body, 18), burst_started: ticks(body, 26), played: [body.readUInt16LE(34), body.readUInt16LE(36)],
      lost_inputs: body.readUInt16LE(38), next_input: body.readUInt16LE(40),
    };
  }
  if (kind === 0x83) {
    return { kind: 'input', number: body.readUInt16LE(0), line: INPUT[body[2]], active: body[3], time: ticks(body, 4) };
  }
  throw new Error(`reply of kind ${kind}`);
}

const little = (value, size) => Array.from({ length: size }, (_, i) => Number((BigInt(value) >> BigInt(8 * i)) & 255n));

export class Host {
  constructor(chip) {
    this.chip = chip;
    this.number = 0;
    this.wire = [];
    this.replies = [];
    this.inputs = [];
    this.beats = false;
    chip.on_byte = (_, byte) => this.take(byte);
  }

  take(byte) {
    this.first_byte ??= this.chip.cycle - BYTE_CYCLES;
    if (byte !== 0) {
      this.wire.push(byte);
      return;
    }
    const got = unframe(this.wire);
    this.wire = [];
    if (!got) throw new Error('host: a damaged frame came');
    const reply = read(got);
    (reply.kind === 'input' ? this.inputs : this.replies).push(reply);
  }

  // A beat each 4 ms, as long as `beats` is true.
  keep_beating() {
    this.beats = true;
    const beat = () => {
      if (!this.beats) return;
      this.post(REQUEST.beat, []);
      this.chip.at(this.chip.cycle + 4000 * CYCLES_PER_US, beat);
    };
    beat();
  }

  post(kind, body) {
    this.number = (this.number + 1) & 255;
    return { number: this.number, end: this.chip.send(frame(kind, this.number, body)) };
  }

  // Sends a request and runs until its reply is there. Null: none within 20 ms.
  ask(kind, body = []) {
    const { number, end } = this.post(kind, body);
    this.first_byte = null;
    const found = () => this.replies.findIndex(reply => reply.number === number);
    const until = end + 20_000 * CYCLES_PER_US;
    while (found() < 0 && this.chip.cycle < until) this.chip.run_until(this.chip.cycle + 20 * CYCLES_PER_US);
    const reply = found() < 0 ? null : this.replies[found()];
    this.replies = [];
    return reply && { ...reply, sent: end, began: this.first_byte };
  }

  hello() { return this.ask(REQUEST.hello, [2]); }
  reset() { return this.ask(REQUEST.reset); }
  abort() { return this.ask(REQUEST.abort); }
  beat() { return this.ask(REQUEST.beat); }
  limits(max_on_us) { return this.ask(REQUEST.limits, max_on_us.flatMap(us => little(us, 4))); }

  // tracks: two lists of {delay, levels}.
  load(tracks) {
    for (const [track, edges] of tracks.entries()) {
      for (let first = 0; first === 0 || first < edges.length; first += EDGES_A_FRAME) {
        const some = edges.slice(first, first + EDGES_A_FRAME);
        const words = some.flatMap(edge => [...little(edge.delay, 4), ...little(edge.levels, 4)]);
        const reply = this.ask(REQUEST.load, [track, ...little(first, 2), ...words]);
        if (reply?.refusal !== 'none') return reply;
      }
    }
    return null;
  }

  arm(tracks, gated) {
    const words = tracks.flat().flatMap(edge => [...little(edge.delay, 4), ...little(edge.levels, 4)]);
    const crc = crc_of(Uint8Array.from(words));
    const counts = tracks.flatMap(edges => little(edges.length, 2));
    return this.ask(REQUEST.arm, [...counts, ...little(crc, 4), gated ? 1 : 0]);
  }

  start(challenge, at, gate_from = 0, gate_until = 0) {
    return this.ask(REQUEST.start, [challenge, at, gate_from, gate_until].flatMap((value, i) => little(value, i ? 8 : 4)));
  }
}
