// A bag of ROS 2 in MCAP, its chunk compressed by zstd.
import { Buffer } from "node:buffer";
import * as zlib from "node:zlib";

const u16 = (value) => { const bytes = Buffer.alloc(2); bytes.writeUInt16LE(value); return bytes; };
const u32 = (value) => { const bytes = Buffer.alloc(4); bytes.writeUInt32LE(value); return bytes; };
const u64 = (value) => { const bytes = Buffer.alloc(8); bytes.writeBigUInt64LE(BigInt(value)); return bytes; };
const f64 = (value) => { const bytes = Buffer.alloc(8); bytes.writeDoubleLE(value); return bytes; };
const text = (value) => Buffer.concat([u32(Buffer.byteLength(value)), Buffer.from(value)]);
const record = (code, ...parts) => {
  const content = Buffer.concat(parts);
  return Buffer.concat([Buffer.from([code]), u64(content.length), content]);
};

// Numbers stand at multiples of their size.
function cdr(seconds, nanoseconds, names, ...signals) {
  let bytes = Buffer.concat([u32(seconds), u32(nanoseconds)]);
  const put = (part, size) => {
    const gap = (size - (bytes.length % size)) % size;
    bytes = Buffer.concat([bytes, Buffer.alloc(gap), part]);
  };
  const word = (value) => put(Buffer.concat([u32(value.length + 1), Buffer.from(`${value}\0`)]), 4);
  word("");
  put(u32(names.length), 4);
  names.forEach(word);
  for (const values of signals) {
    put(u32(values.length), 4);
    values.forEach((value) => put(f64(value), 8));
  }
  return Buffer.concat([Buffer.from([0, 1, 0, 0]), bytes]);
}

// Without a compressor, a frame of one block that stands as it is, or several.
function frame(content) {
  const parts = [Buffer.from([0x28, 0xb5, 0x2f, 0xfd, 0xa0]), u32(content.length)];
  const most = 1 << 17;
  for (let at = 0; at < content.length; at += most) {
    const block = content.subarray(at, at + most);
    const head = (block.length << 3) | (at + most >= content.length ? 1 : 0);
    parts.push(u32(head).subarray(0, 3), block);
  }
  return Buffer.concat(parts);
}

// Rows of { t, q, dq, tau } as joint states.
export function bag(names, rows, compress = zlib.zstdCompressSync ?? frame) {
  const magic = Buffer.from("\x89MCAP0\r\n", "latin1");
  const content = Buffer.concat([
    record(3, u16(1), text("sensor_msgs/msg/JointState"), text("ros2msg"), u32(0)),
    record(4, u16(1), u16(1), text("/joint_states"), text("cdr"), u32(0)),
    ...rows.map(({ t, q, dq, tau }, k) => {
      const [seconds, nanoseconds] = [Math.floor(t), Math.round(1e9 * (t % 1))];
      const stamp = u64(BigInt(seconds) * 1_000_000_000n + BigInt(nanoseconds));
      return record(5, u16(1), u32(k), stamp, stamp, cdr(seconds, nanoseconds, names, q, dq, tau));
    }),
  ]);
  const packed = compress(content);
  return Buffer.concat([
    magic, record(1, text("ros2"), text("test")),
    record(6, u64(0), u64(0), u64(content.length), u32(0), text("zstd"), u64(packed.length), packed),
    record(15, u32(0)), record(2, u64(0), u64(0), u32(0)), magic,
  ]);
}
