// Trains drawn by a seed, what the pins must do with them, and what they did.
import assert from 'node:assert/strict';

import { CYCLES_PER_US, PIN } from './chip.mjs';

export const MIN_DELAY = 16;
const MOVERS = [0, 1], LAMPS = [2, 3, 4, 5];

export class Draw {
  constructor(seed) {
    this.state = seed >>> 0;
  }
  // [0, 1), by mulberry32
  next() {
    this.state = (this.state + 0x6d2b79f5) >>> 0;
    let t = this.state;
    t = Math.imul(t ^ (t >>> 15), t | 1);
    t ^= t + Math.imul(t ^ (t >>> 7), t | 61);
    return ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
  }
  below(n) {
    return Math.floor(this.next() * n);
  }
}

// At most 200 us: dense ones of the shortest delays, long waits, and all between.
function draw_track(draw, lines, most) {
  const count = draw.below(most + 1), edges = [];
  const longest = [MIN_DELAY + 4, 100, Math.floor((200 * CYCLES_PER_US) / Math.max(1, count))][draw.below(3)];
  for (let i = 0; i < count; i++) {
    let levels = 0;
    if (i < count - 1) for (const line of lines) if (draw.below(2)) levels |= 1 << line;
    edges.push({ delay: MIN_DELAY + draw.below(longest - MIN_DELAY + 1), levels });
  }
  return edges;
}

export function draw_train(draw) {
  for (;;) {
    const tracks = [draw_track(draw, MOVERS, 8), draw_track(draw, LAMPS, 14)];
    if (tracks[0].length + tracks[1].length > 0) return tracks;
  }
}

export const length_of = edges => edges.reduce((sum, edge) => sum + edge.delay, 0);

// For each of the six lines: when it changes, [cycle...]; it begins inactive.
export function planned(tracks, begins) {
  const changes = Array.from({ length: 6 }, () => []);
  tracks.forEach((edges, track) => {
    let levels = 0, cycle = begins[track];
    for (const edge of edges) {
      cycle += edge.delay;
      for (const line of track ? LAMPS : MOVERS) if (((levels ^ edge.levels) >> line) & 1) changes[line].push(cycle);
      levels = edge.levels;
    }
  });
  return changes;
}

export function measured(log, from) {
  const changes = Array.from({ length: 6 }, () => []);
  let levels = 0;
  for (const { cycle, outputs } of log) {
    const now = outputs ?? 0;
    for (let line = 0; line < 6; line++) if (cycle >= from && ((levels ^ now) >> line) & 1) changes[line].push(cycle);
    levels = now;
  }
  return changes;
}

// Every change within a tick of the plan. Returns how many there were, and the largest difference.
export function compare(log, from, tracks, begins) {
  const plan = planned(tracks, begins), did = measured(log, from);
  let edges = 0, worst = 0;
  for (let line = 0; line < 6; line++) {
    assert.equal(did[line].length, plan[line].length, `line ${line} changes ${did[line].length} times, not ${plan[line].length}`);
    plan[line].forEach((cycle, i) => {
      const off = did[line][i] - cycle;
      assert.ok(Math.abs(off) <= 1, `line ${line}, change ${i}: ${off} ticks off`);
      edges += 1;
      if (Math.abs(off) > Math.abs(worst)) worst = off;
    });
  }
  return { edges, worst };
}

// Where the sequencer's clock begins, in cycles: from sensor pulses at cycles of both parities.
export function clock_origin(chip, host) {
  host.inputs = [];
  const pulses = [];
  for (let i = 0; i < 16; i++) {
    const cycle = chip.cycle + 2000 + i * 5001;
    pulses.push(cycle);
    chip.set_pin_at(cycle, PIN.sensor_a, 1);
    chip.set_pin_at(cycle + 1000, PIN.sensor_a, 0);
  }
  chip.run_until(chip.cycle + 6000 * CYCLES_PER_US);
  const stamps = host.inputs.filter(input => input.line === 'sensor_a').map(input => input.time);
  assert.equal(stamps.length, pulses.length);
  const origins = pulses.map((cycle, i) => cycle - stamps[i]);
  assert.ok(Math.max(...origins) - Math.min(...origins) <= 1, `stamps differ: ${origins}`);
  return Math.max(...origins);
}
