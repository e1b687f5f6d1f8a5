// Sessions that nobody fired, for what needs many shots.
import { copyFile, mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';

const minute = 60_000;

/// A session of `count` shots, one a minute, in the folder `to`: rows like the first one of the real session `from`, each with
/// numbers of its own; every tenth is rejected.
export async function manyShots(from, to, count) {
  await mkdir(to, { recursive: true });
  for (const file of ['rig.toml', 'plan.toml', 'results.csv-metadata.json']) await copyFile(join(from, file), join(to, file));
  const [header, first] = (await readFile(join(from, 'results.csv'), 'utf8')).split('\n');
  const names = header.split(',');
  if (names[0] !== 'utc' || names[2] !== 'shot_id' || names[3] !== 'rejected') throw new Error(`results.csv begins ${header}`);
  const cells = first.split(',');  // numbers come before the texts that may hold commas
  const shotFromEnd = names.length - names.indexOf('shot');
  const begin = Date.parse(cells[0]);
  const rows = Array.from({ length: count }, (_, i) => {
    const row = [...cells];
    row[0] = new Date(begin + i * minute).toISOString();
    row[2] = row[row.length - shotFromEnd] = `${i + 1}`;
    row[3] = i % 10 === 9 ? 'ambiguous' : '';
    for (const name of ['vx_td_mps', 'vx_lo_mps', 'e', 'mu']) {
      const column = names.indexOf(name);
      row[column] = `${Number(cells[column]) * (1 + 0.01 * Math.sin(1.7 * i))}`;
    }
    return row.join(',');
  });
  await writeFile(join(to, 'results.csv'), [header, ...rows, ''].join('\n'));
}
