// The sequencer's image in the emulator, from the wire and from the pins.
//   tests/sequencer/run BUILD [--trains N] [--seed S] [--only PART]
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { parseArgs } from 'node:util';

import { Chip, CYCLES_PER_US, PIN } from './chip.mjs';
import { Host, REQUEST, frame } from './host.mjs';
import { Draw, MIN_DELAY, clock_origin, compare, draw_train, length_of, measured } from './trains.mjs';

const { values: options } = parseArgs({
  options: { trains: { type: 'string', default: '200' }, seed: { type: 'string', default: '1' }, only: { type: 'string', default: '' } },
});
const trains = Number(options.trains), seed = Number(options.seed);
const image = readFileSync(`${process.env.STROBE_BUILD_DIR}/share/strobe/sequencer/strobe-sequencer.bin`);
const us = n => Math.round(n * CYCLES_PER_US);
const REPLY_AFTER_US = 100; // kReplyAfter of the protocol
const PULSE = 100_000; // longest on-time asked for [us]

function powered(number = seed) {
  const chip = new Chip(image, number), host = new Host(chip);
  chip.run_until(us(3000));
  return { chip, host };
}

// Ready to be armed.
function ready(number = seed) {
  const { chip, host } = powered(number);
  host.keep_beating();
  assert.equal(host.reset().phase, 'idle');
  assert.equal(host.limits(Array(6).fill(PULSE)).refusal, 'none');
  return { chip, host, origin: clock_origin(chip, host) };
}

function arm({ host }, tracks, gated = false) {
  assert.equal(host.load(tracks), null);
  const reply = host.arm(tracks, gated);
  assert.equal(reply?.phase, 'armed', `refused: ${reply?.refusal}`);
  assert.notEqual(reply.challenge, 0);
  return reply.challenge;
}

// Begins 1.1 ms from now. Returns when, in cycles.
function start({ chip, host, origin }, challenge, gate_from, gate_until) {
  const at = chip.cycle - origin + us(1100);
  const reply = host.start(challenge, at, gate_from, gate_until);
  assert.equal(reply?.refusal, 'none');
  return at + origin;
}

const inactive_from = (chip, cycle) => {
  assert.equal(chip.outputs ?? 0, 0);
  assert.ok(chip.log.every(entry => entry.cycle <= cycle || !entry.outputs), 'active afterwards');
};
// Shutter and all lamps on for a long time.
const LONG = [[{ delay: us(100), levels: 0b000011 }, { delay: us(60_000), levels: 0 }],
  [{ delay: us(100), levels: 0b111100 }, { delay: us(60_000), levels: 0 }]];

function playing(number) {
  const rig = ready(number);
  const begins = start(rig, arm(rig, LONG));
  rig.chip.run_until(begins + us(300));
  assert.equal(rig.chip.outputs, 0b111111);
  return rig;
}

const parts = {
  'a start: outputs driven inactive, cut until a reset, boots differ'() {
    const { chip, host } = powered();
    const one = host.hello();
    assert.equal(one.version, 2);
    assert.equal(one.by_watchdog, 0);
    assert.equal(one.max_edges, 2048);
    assert.deepEqual(chip.log.map(entry => entry.outputs), [0]);
    assert.equal(host.beat().phase, 'cut');
    assert.notEqual(one.boot, powered(seed + 1).host.hello().boot);
    assert.equal(host.reset().phase, 'idle');
  },

  'a start during which an input changes is tried again'() {
    const chip = new Chip(image, seed), host = new Host(chip), start = () => (chip.chip.sio.gpioValue >>> PIN.start) & 1;
    for (const level of [1, 0]) while (start() !== level) chip.run_until(chip.cycle + 1); // the stamps' calibration
    chip.set_pin_at(chip.cycle + 10, PIN.sensor_a, 1);
    chip.set_pin_at(chip.cycle + 40, PIN.sensor_a, 0);
    chip.run_until(chip.cycle + us(40_000));
    assert.equal(chip.resets.length, 1);
    assert.equal(host.hello().by_watchdog, 1);
    assert.equal(host.reset().phase, 'idle');
  },

  'trains: every edge within a tick of the plan'() {
    const rig = ready(), draw = new Draw(seed);
    let edges = 0, worst = 0, late = 0;
    for (let i = 0; i < trains; i++) {
      const tracks = draw_train(draw);
      const challenge = arm(rig, tracks), from = rig.chip.cycle;
      const at = start(rig, challenge);
      rig.chip.run_until(at + Math.max(...tracks.map(length_of)) + us(50));
      const status = rig.host.beat();
      const what = `seed ${seed}, train ${i}`;
      assert.deepEqual([status.phase, status.cut, status.played], ['idle', 'none', tracks.map(track => track.length)], what);
      const began = rig.origin + status.started;
      assert.equal(status.burst_started, status.started, what);
      try {
        const got = compare(rig.chip.log, from, tracks, [began, began]);
        edges += got.edges;
        worst = Math.max(worst, Math.abs(got.worst));
      } catch (error) {
        error.message = `${what}: ${error.message}`;
        throw error;
      }
      late = Math.max(late, Math.abs(began - at));
      rig.chip.log = [];
      if ((i + 1) % 1000 === 0) console.log(`  ${i + 1} trains, ${edges} edges, ${new Date().toISOString()}`);
    }
    return `${trains} trains, ${edges} edges, largest difference ${worst} ticks; the start itself at most ${late} ticks off`;
  },

  'gated trains: from the gate, in its window only'() {
    const rig = ready(), draw = new Draw(seed + 1);
    const count = Math.max(16, Math.ceil(trains / 8));
    let heard = 0, worst = 0;
    for (let i = 0; i < count; i++) {
      const tracks = draw_train(draw);
      if (tracks[1].length === 0) continue;
      const challenge = arm(rig, tracks, true), from = rig.chip.cycle;
      const window = [us(200), us(600)];
      const at = start(rig, challenge, ...window);
      // One edge before the window, still active then in half of them; one in it, or none; one after.
      const in_window = draw.below(4) !== 0, gate = at + us(280) + draw.below(us(250));
      const before = at + us(20) + draw.below(us(100)), long = draw.below(2) ? at + us(250) - before : 40;
      for (const [pulse, width] of [[before, long], ...(in_window ? [[gate, 40]] : []), [at + us(700), 40]]) {
        rig.chip.set_pin_at(pulse, PIN.gate, 1);
        rig.chip.set_pin_at(pulse + width, PIN.gate, 0);
      }
      rig.chip.run_until(at + us(1100));
      const status = rig.host.beat();
      assert.deepEqual([status.phase, status.cut], ['idle', 'none'], `seed ${seed}, gated train ${i}`);
      const began = rig.origin + status.started;
      if (!in_window) {
        assert.equal(status.burst_started, null);
        compare(rig.chip.log, from, [tracks[0], []], [began, 0]);
      } else {
        heard += 1;
        assert.ok(Math.abs(status.burst_started + rig.origin - gate) <= 2, `gate ${status.burst_started + rig.origin - gate}`);
        const got = compare(rig.chip.log, from, tracks, [began, rig.origin + status.burst_started]);
        worst = Math.max(worst, Math.abs(got.worst));
        compare(rig.chip.log, from, tracks, [began, gate]);
      }
      rig.chip.log = [];
    }
    return `${heard} bursts, largest difference ${worst} ticks`;
  },

  // The first flash as soon as can be, the gate in any of the cycles in which the program sees that the window is over.
  'a gate while its window closes begins the whole burst, or none of it'() {
    const rig = ready(), draw = new Draw(seed + 5);
    const tracks = [[], [{ delay: MIN_DELAY, levels: 4 }, { delay: us(2), levels: 0 }]];
    let whole = 0, none = 0;
    for (let i = 0; i < Math.max(100, trains / 4); i++) {
      const challenge = arm(rig, tracks, true), from = rig.chip.cycle;
      const at = start(rig, challenge, us(200), us(400)), gate = at + us(400) + draw.below(us(25));
      rig.chip.set_pin_at(gate, PIN.gate, 1);
      rig.chip.set_pin_at(gate + us(20), PIN.gate, 0);
      rig.chip.run_until(at + us(600));
      const status = rig.host.beat(), what = `seed ${seed}, train ${i}, gate at ${gate - at - us(400)}`;
      assert.deepEqual([status.phase, status.cut], ['idle', 'none'], what);
      if (status.burst_started === null) {
        none += 1;
        compare(rig.chip.log, from, [[], []], [0, 0]);
      } else {
        whole += 1;
        assert.deepEqual(status.played, [0, 2], what);
        compare(rig.chip.log, from, tracks, [0, gate]);
      }
      rig.chip.log = [];
    }
    assert.ok(whole > 10 && none > 10, `${whole} whole, ${none} none`);
    return `${whole} whole, ${none} none`;
  },

  'full tracks of the shortest delays'() {
    const rig = ready();
    const edges = on => Array.from({ length: 2048 }, (_, i) => ({ delay: MIN_DELAY, levels: i % 2 ? 0 : on }));
    const tracks = [edges(0b000011), edges(0b111100)];
    assert.equal(rig.host.load(tracks), null);
    const before = rig.chip.cycle, reply = rig.host.arm(tracks, false);
    assert.equal(reply.refusal, 'none');
    const took = rig.chip.cycle - before, from = rig.chip.cycle;
    const at = start(rig, reply.challenge);
    rig.chip.run_until(at + 2048 * MIN_DELAY + us(50));
    const status = rig.host.beat(), began = rig.origin + status.started;
    assert.deepEqual(status.played, [2048, 2048]);
    assert.equal(status.cut, 'none');
    const got = compare(rig.chip.log, from, tracks, [began, began]);
    return `${got.edges} edges, largest difference ${Math.abs(got.worst)} ticks; ARM answered in ${(took / CYCLES_PER_US / 1000).toFixed(1)} ms`;
  },

  'e-stop and key cut within 1 us, also with the program hung; a glitch does not'() {
    const draw = new Draw(seed + 2);
    let longest = 0;
    for (const pin of ['estop', 'key']) for (const hung of [false, true]) for (let i = 0; i < 3; i++) {
      const { chip, host } = playing();
      const glitch = chip.cycle + draw.below(us(100)), press = glitch + us(20) + draw.below(us(200));
      chip.set_pin_at(glitch, PIN[pin], 0);
      chip.set_pin_at(glitch + us(0.3), PIN[pin], 1);
      chip.run_until(press - 100);
      assert.equal(chip.outputs, 0b111111);
      chip.hung = hung;
      chip.set_pin_at(press, PIN[pin], 0);
      chip.run_until(press + us(5000));
      const last = chip.log.findLast(entry => entry.cycle >= press).cycle;
      assert.ok(last - press <= us(1), `${pin}: after ${last - press} ticks`);
      longest = Math.max(longest, last - press);
      inactive_from(chip, last);
      if (hung) continue;
      assert.deepEqual([host.beat().phase, host.beat().cut], ['cut', pin]);
      assert.equal(host.reset().refusal, pin === 'key' ? 'key_off' : 'estop_pressed');
      chip.set_pin_at(chip.cycle, PIN[pin], 1);
      chip.run_until(chip.cycle + us(1000));
      assert.equal(host.beat().phase, 'cut');
      inactive_from(chip, last);
      assert.deepEqual([host.reset().phase, host.beat().cut], ['idle', 'none']);
      inactive_from(chip, last);
    }
    return `at most ${(longest / CYCLES_PER_US).toFixed(3)} us`;
  },

  'an edge that cannot be fetched in time cuts, and the next train plays'() {
    const rig = ready(), { chip, host } = rig;
    const edges = Array.from({ length: 200 }, (_, i) => ({ delay: us(2), levels: i % 2 ? 0 : 4 })), tracks = [[], edges];
    const at = start(rig, arm(rig, tracks)), dma = chip.chip.dma.channels[1], fetch = dma.scheduleTransfer;
    chip.run_until(at + us(100));
    dma.scheduleTransfer = () => {};
    chip.run_until(at + us(200));
    dma.scheduleTransfer = fetch;
    assert.equal(chip.outputs, 0);
    assert.equal(host.beat().cut, 'underrun');
    assert.equal(host.reset().phase, 'idle');
    const again = start(rig, arm(rig, tracks));
    chip.run_until(again + us(500));
    assert.deepEqual([host.beat().cut, host.beat().played], ['none', [0, 200]]);
  },

  'beats stop, as by an unplugged cable: inactive within 20 ms'() {
    const { chip, host } = playing();
    host.beats = false;
    host.chip.send(frame(REQUEST.beat, 1, []).slice(0, 3)); // in the middle of one
    const stopped = chip.cycle;
    chip.run_until(stopped + us(20_000));
    const last = chip.log.at(-1).cycle;
    inactive_from(chip, last);
    assert.deepEqual([host.beat(), host.beat()].at(-1).cut, 'heartbeat');
    return `${((last - stopped) / CYCLES_PER_US / 1000).toFixed(1)} ms`;
  },

  'the program hangs: a reset within 20 ms makes inputs of all pins, and the start says so'() {
    const { chip, host } = playing();
    const boot = host.hello().boot, hung = chip.cycle;
    chip.hung = true;
    host.beats = false;
    chip.run_until(hung + us(20_000));
    assert.equal(chip.resets.length, 1);
    assert.ok(chip.log.some(entry => entry.cycle === chip.resets[0] && entry.outputs === null));
    inactive_from(chip, chip.resets[0]);
    chip.run_until(hung + us(30_000));
    const again = host.hello();
    assert.equal(again.by_watchdog, 1);
    assert.notEqual(again.boot, boot);
    assert.equal(host.beat().phase, 'cut');
    inactive_from(chip, chip.resets[0]);
    return `${((chip.resets[0] - hung) / CYCLES_PER_US / 1000).toFixed(1)} ms`;
  },

  'nothing fires without beats, arm, challenge, key'() {
    const { chip, host } = powered(), one = [[], [{ delay: 100, levels: 4 }, { delay: 100, levels: 0 }]];
    const refused = (reply, why) => assert.equal(reply?.refusal, why);
    refused(host.load(one), 'wrong_phase');
    assert.equal(host.reset().phase, 'idle');
    host.limits(Array(6).fill(PULSE));
    refused(host.start(1, 10_000_000), 'wrong_phase');
    assert.equal(host.load(one), null);
    refused(host.arm(one, false), 'no_heartbeat');
    host.keep_beating();
    chip.run_until(chip.cycle + us(500));
    refused(host.arm([[], one[1].slice(1)], false), 'train_differs');
    chip.set_pin_at(chip.cycle, PIN.key, 0);
    assert.equal(host.beat().cut, 'key');
    refused(host.reset(), 'key_off');
    chip.set_pin_at(chip.cycle, PIN.key, 1);
    chip.run_until(chip.cycle + us(100));
    assert.equal(host.reset().phase, 'idle');
    const rig = { chip, host, origin: 0 }, challenge = arm(rig, one);
    const now = host.beat().received;
    refused(host.start((challenge ^ 1) >>> 0, now + us(5000)), 'wrong_challenge');
    refused(host.start(challenge, now + us(10)), 'too_late');
    host.abort();
    refused(host.start(challenge, host.beat().received + us(5000)), 'wrong_phase');
    chip.run_until(chip.cycle + us(6000));
    assert.deepEqual(chip.log.map(entry => entry.outputs), [0]);
  },

  'garbage and damaged frames fire nothing and stop nothing'() {
    const draw = new Draw(seed + 3), rig = playing(), { chip, host } = rig;
    const bytes = length => Array.from({ length }, () => draw.below(256));
    for (let i = 0; i < 20; i++) {
      chip.send(bytes(1 + draw.below(300)));
      const whole = frame(1 + draw.below(8), draw.below(256), bytes(draw.below(40)));
      whole[draw.below(whole.length - 1)] ^= 1 << draw.below(8);
      chip.send(whole);
      chip.run_until(chip.line_busy);
      chip.send([0]);
      chip.run_until(chip.line_busy + us(300));
      if (i < 4) assert.equal(chip.outputs, 0b111111);
    }
    host.beats = false;
    chip.run_until(chip.cycle + us(70_000));
    assert.equal(chip.outputs, 0);
    const quiet = chip.cycle;
    for (let i = 0; i < 20; i++) chip.send(bytes(200));
    chip.run_until(chip.line_busy + us(1000));
    chip.send([0]);
    inactive_from(chip, quiet);
    assert.equal(host.hello()?.kind, 'identity');
  },

  'stamps within two ticks, past the wrap of the count, and requests received within 1 us'() {
    const chip = new Chip(image, seed), host = new Host(chip), draw = new Draw(seed + 4);
    chip.run_until(us(100));
    while (!chip.pio[1].machines[0].enabled) chip.run_until(chip.cycle + 1);
    for (const machine of chip.pio[1].machines) machine.x = 1_000_000; // as if it had counted for half a minute
    chip.run_until(us(3000));
    host.reset();
    const origin = clock_origin(chip, host), pulses = [];
    let longest = 0;
    while (chip.cycle < us(40_000)) {
      const line = ['sensor_a', 'sensor_b', 'gate'][draw.below(3)], cycle = chip.cycle + 100 + draw.below(us(100));
      pulses.push({ line, cycle });
      chip.set_pin_at(cycle, PIN[line], 1);
      chip.set_pin_at(cycle + 20 + draw.below(us(100)), PIN[line], 0);
      chip.run_until(cycle + us(400));
    }
    assert.ok(chip.cycle - us(3000) > 2_000_000);
    const got = host.inputs.slice(16);
    assert.equal(got.length, pulses.length);
    got.forEach((input, i) => {
      assert.equal(input.line, pulses[i].line);
      longest = Math.max(longest, Math.abs(input.time + origin - pulses[i].cycle));
      if (i > 0) assert.equal(input.number, got[i - 1].number + 1);
    });
    assert.ok(longest <= 2, `stamps up to ${longest} ticks off`);
    let farthest = 0, soonest = Infinity, latest = 0;
    for (let i = 0; i < 20; i++) {
      chip.run_until(chip.cycle + draw.below(us(200)));
      const reply = host.beat();
      farthest = Math.max(farthest, Math.abs(reply.received + origin - reply.sent));
      soonest = Math.min(soonest, reply.began - reply.sent);
      latest = Math.max(latest, reply.began - reply.sent);
    }
    assert.ok(farthest <= us(1), `received ${farthest} ticks off`);
    // As the stamps of requests are known; a round of the program is below 20 us.
    assert.ok(soonest >= us(REPLY_AFTER_US - 1) && latest <= us(REPLY_AFTER_US + 20), `replies from ${soonest} to ${latest} ticks`);
    return `${pulses.length} stamps, at most ${longest} ticks off; requests at most ${(farthest / CYCLES_PER_US).toFixed(2)} us, replies to them after ${(soonest / CYCLES_PER_US).toFixed(1)} to ${(latest / CYCLES_PER_US).toFixed(1)} us`;
  },

  'key, e-stop and xsync are told with their times'() {
    const { chip, host, origin } = ready(), edges = [];
    host.inputs = [];
    for (const [i, [line, level]] of [['xsync', 1], ['xsync', 0], ['key', 0], ['estop', 0], ['estop', 1], ['key', 1]].entries()) {
      const cycle = chip.cycle + us(100 + 500 * i);
      edges.push({ line, cycle, active: line === 'estop' ? 1 - level : level });
      chip.set_pin_at(cycle, PIN[line], level);
    }
    chip.run_until(chip.cycle + us(6000));
    assert.deepEqual(host.inputs.map(({ line, active }) => ({ line, active })), edges.map(({ line, active }) => ({ line, active })));
    const late = host.inputs.map((input, i) => input.time + origin - edges[i].cycle);
    assert.ok(late.every(ticks => ticks >= 0 && ticks <= us(100)), `${late}`);
    return `at most ${(Math.max(...late) / CYCLES_PER_US).toFixed(1)} us late`;
  },

  'these checks would notice an edge a tick off per edge, a lost cut, a stamp that drifts'() {
    const plays = alter => {
      const rig = ready(), tracks = [[], Array.from({ length: 8 }, (_, i) => ({ delay: 50, levels: i % 2 ? 0 : 4 }))];
      alter(rig.chip.pio);
      const challenge = arm(rig, tracks), from = rig.chip.cycle, at = start(rig, challenge);
      rig.chip.run_until(at + us(100));
      const began = rig.origin + rig.host.beat().started;
      compare(rig.chip.log, from, tracks, [began, began]);
    };
    plays(() => {});
    assert.throws(() => plays(([pio]) => { pio.block.instructions[9] |= 1 << 8; }), /ticks off/);
    assert.throws(() => plays(([pio]) => { pio.block.instructions[6] += 4 << 8; }), /ticks off/);
    const { chip } = playing();
    chip.pio[0].block.instructions[4] = 0xa042; // nothing, instead of zeros
    chip.set_pin_at(chip.cycle + 10, PIN.estop, 0);
    chip.hung = true;
    chip.run_until(chip.cycle + us(5));
    assert.notEqual(chip.outputs, 0);
    const rig = ready();
    rig.chip.pio[1].block.instructions[2] |= 1 << 8; // a cycle more each stamp
    assert.throws(() => clock_origin(rig.chip, rig.host), /stamps differ/);
  },
};

let failed = 0;
for (const [name, part] of Object.entries(parts)) {
  if (!name.includes(options.only)) continue;
  const began = Date.now();
  try {
    const found = part();
    console.log(`ok    ${name}${found ? ` (${found})` : ''} [${((Date.now() - began) / 1000).toFixed(1)} s]`);
  } catch (error) {
    failed += 1;
    console.log(`FAIL  ${name}\n${error.stack}`);
  }
}
process.exitCode = failed ? 1 : 0;
