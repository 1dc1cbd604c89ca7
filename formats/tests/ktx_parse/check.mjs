// Reads each pack NAME.ktx2 of a folder with ktx-parse and compares it with NAME.json and NAME.texels.
// Writing the pack again must give the same bytes, so ktx-parse agrees on every rule of the layout.
import assert from 'node:assert/strict';
import { readFileSync, readdirSync } from 'node:fs';
import { join } from 'node:path';
import { decompress } from 'fzstd';
import { read, write } from 'ktx-parse';

function check(folder, name) {
  const file = new Uint8Array(readFileSync(join(folder, `${name}.ktx2`)));
  const expected = JSON.parse(readFileSync(join(folder, `${name}.json`), 'utf8'));
  const texels = readFileSync(join(folder, `${name}.texels`));
  const container = read(file);

  for (const [field, value] of Object.entries(expected.header)) {
    assert.equal(container[field], value, field);
  }
  assert.equal(container.globalData, null);
  assert.equal(container.levels.length, expected.header.levelCount);
  // The finest level first.
  const levels = container.levels.map((level) => {
    const data = container.supercompressionScheme === 2 ? decompress(level.levelData) : level.levelData;
    assert.equal(level.uncompressedByteLength, data.length);
    return data;
  });
  assert.ok(texels.equals(Buffer.concat(levels)), 'texels');

  const entries = Object.fromEntries(
    Object.entries(container.keyValue).map(([key, value]) => [
      key,
      typeof value === 'string' ? value : Buffer.from(value).toString('hex'),
    ]),
  );
  assert.deepEqual(entries, expected.entries);
  assert.ok(Buffer.from(write(container, { keepWriter: true })).equals(file), 'bytes after writing again');
}

const folder = process.argv[2];
const names = readdirSync(folder).filter((file) => file.endsWith('.json')).map((file) => file.slice(0, -5));
for (const name of names) {
  try {
    check(folder, name);
  } catch (error) {
    console.error(`${name}: ${error.stack}`);
    process.exit(1);
  }
}
console.log(`${names.length} packs`);
