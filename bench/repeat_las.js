// Repeats a LAS file in a grid, to measure clouds of any size:
//
//   node bench/repeat_las.js IN.las COPIES OUT.las
//
// Copies lie beside each other, five in a row, each as far from the next as the file is wide and
// deep. All values but x and y are those of the input. LAZ files are decoded first:
// node scripts/laz_to_las.js FOLDER-OF-laz-perf IN.laz OUT.las
const fs = require("fs");

const COLUMNS = 5;
const [, , input, copies, output] = process.argv;
if (!(Number(copies) >= 1) || output === undefined) {
  console.error("usage: node bench/repeat_las.js IN.las COPIES OUT.las");
  process.exit(2);
}
const file = fs.readFileSync(input);
if (file.toString("latin1", 0, 4) !== "LASF" || file[104] > 10) {
  console.error(`${input}: no uncompressed LAS file`);
  process.exit(1);
}
const begin = file.readUInt32LE(96), size = file.readUInt16LE(105);
const is14 = file[25] >= 4;
const count = is14 ? Number(file.readBigUInt64LE(247)) : file.readUInt32LE(107);
const head = Buffer.from(file.subarray(0, begin));
const total = count * copies;
head.writeUInt32LE(total <= 0xffffffff ? total : 0, 107);
head.fill(0, 111, 131); // numbers of points by return
if (is14) {
  head.writeBigUInt64LE(BigInt(total), 247);
}
// Bounds and scales are doubles: largest x, smallest x, largest y, smallest y from byte 179 on
const scale = [file.readDoubleLE(131), file.readDoubleLE(139)];
const extent = [file.readDoubleLE(179) - file.readDoubleLE(187), file.readDoubleLE(195) - file.readDoubleLE(203)];
const step = [Math.round(extent[0] / scale[0]), Math.round(extent[1] / scale[1])];
const rows = Math.ceil(copies / COLUMNS), columns = Math.min(copies, COLUMNS);
head.writeDoubleLE(file.readDoubleLE(179) + (columns - 1) * step[0] * scale[0], 179);
head.writeDoubleLE(file.readDoubleLE(195) + (rows - 1) * step[1] * scale[1], 195);

const points = Buffer.from(file.subarray(begin, begin + count * size));
const out = fs.openSync(output, "w");
fs.writeSync(out, head);
for (let copy = 0, column = 0, row = 0; copy < copies; ++copy) {
  const x = copy % COLUMNS, y = Math.floor(copy / COLUMNS);
  for (let at = 0; at < points.length; at += size) { // from the copy before
    points.writeInt32LE(points.readInt32LE(at) + (x - column) * step[0], at);
    points.writeInt32LE(points.readInt32LE(at + 4) + (y - row) * step[1], at + 4);
  }
  for (let written = 0; written < points.length;) {
    written += fs.writeSync(out, points, written);
  }
  column = x;
  row = y;
}
fs.closeSync(out);
