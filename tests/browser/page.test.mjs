// The page in headless Chromium: a series as it is fired, then what is left of it.
import { archive } from './archive.mjs';
import { commissioning } from './commissioning.mjs';
import { corrections } from './corrections.mjs';
import { edits } from './edits.mjs';
import { series } from './series.mjs';

series();
commissioning();
archive();
corrections();
edits();
