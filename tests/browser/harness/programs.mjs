// Programs under test: what they print as it comes, and an end that leaves nothing behind.
import { spawn } from 'node:child_process';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';

/// Where a program of the build lies.
export const program = (name) => join(process.env.STROBE_BUILD_DIR, 'bin', name);

/// For what must come: only a failure waits so long, however busy the machine.
export const longestWait = 180_000;

/// Polls `condition` until it gives something true, which is returned. `what` is told if it never does.
export async function until(condition, what, wait = longestWait) {
  const end = Date.now() + wait;
  for (;;) {
    const found = await condition();
    if (found) return found;
    if (Date.now() > end) throw new Error(`waited in vain for ${what}`);
    await sleep(20);
  }
}

export class Program {
  #started;
  #arrivals = [];
  /// `console`: its standard input stays open, as of a person who types nothing.
  constructor(command, args, { cwd, env, console = false } = {}) {
    this.name = `${command.split('/').pop()} ${args[0] ?? ''}`;
    this.out = '';
    this.err = '';
    this.status = undefined;  // {code, signal} when it has ended
    this.#started = spawn(command, args, { cwd, env: { ...process.env, ...env }, detached: true, stdio: [console ? 'pipe' : 'ignore', 'pipe', 'pipe'] });
    this.#started.stdout.setEncoding('utf8').on('data', (text) => {
      this.out += text;
      this.#arrivals.push({ length: this.out.length, at: performance.timeOrigin + performance.now() });
    });
    this.#started.stderr.setEncoding('utf8').on('data', (text) => (this.err += text));
    this.#started.on('error', (error) => {
      this.err += error.message;
      this.status = { code: null, signal: null };
    });
    // When its streams are closed, too: all that it printed is there.
    this.#started.on('close', (code, signal) => (this.status = { code, signal }));
  }

  get pid() {
    return this.#started.pid;
  }

  /// The first match in what it prints to `stream` ("out", "err").
  async prints(pattern, stream = 'err') {
    const match = await until(() => this[stream].match(pattern) ?? this.status, `${pattern} from ${this.name}\n${this.err}`);
    const found = this[stream].match(pattern);
    if (!found) throw new Error(`${this.name} ended without ${pattern}: ${JSON.stringify(match)}\n${this.err}`);
    return found;
  }

  /// Objects of the whole lines of JSON on its standard output.
  lines() {
    return this.out.split('\n').slice(0, -1).filter((line) => line.startsWith('{')).map((line) => JSON.parse(line));
  }

  /// With when each was there as a whole, in ms since 1970.
  timedLines() {
    let end = 0;
    return this.out.split('\n').slice(0, -1).map((text) => {
      end += text.length + 1;
      return { text, at: this.#arrivals.find(({ length }) => length >= end).at };
    }).filter(({ text }) => text.startsWith('{')).map(({ text, at }) => ({ line: JSON.parse(text), at }));
  }

  async end() {
    await until(() => this.status, `the end of ${this.name}`);
    return this.status;
  }

  /// To it and all that it has started.
  async kill(signal = 'SIGKILL') {
    if (this.status) return;
    try {
      process.kill(-this.pid, signal);
    } catch (error) {
      if (error.code !== 'ESRCH') throw error;
    }
    await this.end();
  }
}

/// Runs a program to its end; its exit status must be 0.
export async function run(command, args, options) {
  const program = new Program(command, args, options);
  const { code } = await program.end();
  if (code !== 0) throw new Error(`${program.name} ended with ${code}: ${program.err}`);
  return program.out;
}
