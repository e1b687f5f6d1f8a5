// What npm has installed: beside the programs, not in the source tree, where node would look for it.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { join } from 'node:path';

export const build = process.env.STROBE_BUILD_DIR;
if (!build) throw new Error('to be started by tests/browser/run');
const require = createRequire(join(build, 'browser', 'package.json'));

export const { chromium } = require('playwright-core');
export const axeSource = readFileSync(require.resolve('axe-core/axe.min.js'), 'utf8');
