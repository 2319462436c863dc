// Prints the lights of a .usda file as another program reads them: three.js, of npm. By ./dev usd.
//
// Usage: node tests/viewer/read_usd_lights.mjs NODE_MODULES FILE
// Position and direction are in the world. three.js knows cones by an older name and takes spots for points.

import { readFileSync } from 'node:fs';
import { pathToFileURL } from 'node:url';

const [modules, file] = process.argv.slice(2);
const loader = `${modules}/three/examples/jsm/loaders/USDLoader.js`;
const { USDLoader } = await import(pathToFileURL(loader));

const rounded = (values) => values.map((v) => +v.toFixed(5)).join(' ');
const group = new USDLoader().parse(readFileSync(file, 'utf8'));
group.updateMatrixWorld(true);
let count = 0;
group.traverse((object) => {
  if (!object.isLight) return;
  const m = object.matrixWorld.elements;
  console.log(`${object.name}: ${object.type}, colour ${rounded(object.color.toArray())}, intensity ${object.intensity}, ` +
    `at ${rounded(m.slice(12, 15))}, towards ${rounded([-m[8], -m[9], -m[10]])}`);
  ++count;
});
if (count === 0) {
  console.error(`${file}: no lights`);
  process.exit(1);
}
