// A simulated rig: strobe-sim runs strobed on a chip of its own; its camera delivers photographs. Beside it the commands of
// strobe that serve the page.
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { Program, program, run } from './programs.mjs';

let rigs = 0;

function randomLcmUrl() {
  const draw = (from, to) => from + Math.floor(Math.random() * (to - from));
  return `udpm://239.255.${draw(1, 255)}.${draw(1, 255)}:${draw(20000, 60000)}?ttl=0&recv_buf_size=2097152`;
}

/// $STROBE_HIL_WAKE_AHEAD is 0 where another rig runs beside this one: two loops that are awake before each flash would leave
/// no core to anything else.
async function wakeAhead(file) {
  const wanted = process.env.STROBE_HIL_WAKE_AHEAD;
  if (wanted === undefined) return;
  await writeFile(file, (await readFile(file, 'utf8')).replace(/^wake_ahead_us = .*$/m, `wake_ahead_us = ${wanted}`));
}

/// A strobe that serves the page: where, and what it prints.
export class Host extends Program {
  constructor(words, options) {
    super(program('strobe'), words, options);
  }
  /// Once it is served.
  async address() {
    const [url] = await this.prints(/http:\/\/\S+/);
    return new URL(url);
  }
}

/// `strobe live --web` of a folder of sessions, without a rig.
export function archive(sessions, { address = '127.0.0.1:0', more = [] } = {}) {
  return new Host(['live', '--lcm-url', randomLcmUrl(), '--web', address, '--sessions', sessions, ...more]);
}

export class Rig {
  /// `scene`: shipped; `photographs`: false for the simulated tablet operator.
  static async start(folder, { scene = 'zero_23', seed = 7, photographs = true } = {}) {
    const rig = new Rig();
    rig.folder = join(folder, `rig-${++rigs}`);
    rig.sessions = join(rig.folder, 'sessions');
    rig.session = join(rig.sessions, 'today');
    rig.file = join(rig.folder, 'rig.toml');
    rig.lcmUrl = randomLcmUrl();
    rig.photographs = photographs;
    await mkdir(rig.session, { recursive: true });
    const camera = photographs ? ['--photographs', join(rig.folder, 'camera')] : [];
    await run(program('strobe-sim'), ['run', '--scene', scene, ...camera, '--write-rig', rig.file]);
    await wakeAhead(rig.file);
    rig.sim = new Program(program('strobe-sim'), [
      'run', '--scene', scene, '--seed', `${seed}`, ...camera, '--lcm-url', rig.lcmUrl, '--chip-dir', join(rig.folder, 'chip'), '--',
      program('strobed'), '--config', rig.file, '--session', rig.session, '--lcm-url', rig.lcmUrl, '--allow-no-rt',
    ]);
    await rig.sim.prints(/strobed: ready/);
    return rig;
  }

  /// In the rig's time, but for its server; `machineTime`: for measuring how long it takes.
  #host(words, { address = '127.0.0.1:0', more = [], machineTime = false }, options = {}) {
    const env = machineTime ? {} : { LD_PRELOAD: join(process.env.STROBE_BUILD_DIR, 'lib', 'libstrobe-gpiochip.so'), STROBE_GPIOCHIP_DIR: join(this.folder, 'chip') };
    return new Host([...words, '--rig', this.file, '--lcm-url', this.lcmUrl, '--web', address, ...more], { ...options, env });
  }

  /// A series with the page.
  fire(shots, { session = this.session, ...options } = {}) {
    return this.#host(['fire', '--shots', `${shots}`, '--retries', '0', '--session', session, '--json'], options);
  }

  live(options = {}) {
    return this.#host(['live', '--sessions', this.sessions, '--json'], options);
  }

  /// Steps of commissioning, confirmed on the page or by nobody.
  commission(steps) {
    const only = steps.flatMap((step) => ['--only', step]);
    return this.#host(['commission', '--session', join(this.sessions, 'commissioning'), '--json', '--wait', '180', ...only], {}, { console: true });
  }

  /// From outside, as a person turns a key: "KEY=0".
  drive(lineAndLevel) {
    return run(program('strobe-sim'), ['drive', '--chip-dir', join(this.folder, 'chip'), lineAndLevel]);
  }

  async end() {
    await this.sim.kill('SIGTERM');
  }
}
