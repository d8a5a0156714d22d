// Decodes a LAZ file with npm's laz-perf: node laz_to_las.js FOLDER-OF-laz-perf IN.laz OUT.las
const fs = require("fs");
const [, , folder, input, output] = process.argv;
const { createLazPerf } = require(require("path").resolve(folder, "node_modules/laz-perf"));

async function decode() {
  const perf = await createLazPerf();
  const file = fs.readFileSync(input);
  const at = perf._malloc(file.length);
  perf.HEAPU8.set(file, at);
  const reader = new perf.LASZip();
  reader.open(at, file.length);
  const count = reader.getCount(), size = reader.getPointLength();
  const point = perf._malloc(size), points = Buffer.alloc(count * size);
  for (let i = 0; i < count; ++i) {
    reader.getPoint(point);
    points.set(perf.HEAPU8.subarray(point, point + size), i * size);
  }
  const head = Buffer.from(file.subarray(0, file.readUInt32LE(96)));
  head[104] &= 0x3f; // not compressed
  if (head[25] >= 4) {
    head.fill(0, 235, 247); // the records behind the points are left out
  }
  fs.writeFileSync(output, Buffer.concat([head, points]));
}

decode();
