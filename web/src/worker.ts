// The engine in a thread of its own: requests and files in, progress and answers out.

export interface Ask { module: WebAssembly.Module; request: string; files: File[] }

export type Told =
  | { kind: "doing"; text: string; share: number | null }
  | { kind: "answer"; json: string; content: Uint8Array; memory: number }
  | { kind: "failed"; message: string };

interface Engine {
  memory: WebAssembly.Memory;
  room(length: number): number;
  respond(): number;
  reply(): number;
  content(): number;
  content_length(): number;
}

// Only threads have it.
declare class FileReaderSync { readAsArrayBuffer(blob: Blob): ArrayBuffer }

const scope = self as unknown as {
  onmessage: (event: MessageEvent<Ask>) => void;
  postMessage(told: Told, transfer?: Transferable[]): void;
};

// Files are read in blocks, the last of which are kept: a log of any size takes 64 MB here.
const BLOCK = 1 << 20;
const MOST_BLOCKS = 64;
// Times between words to the page [ms].
const PAUSE = 100;

scope.onmessage = ({ data }) => {
  let engine: Engine;
  // Beyond 2 GB a place in the memory comes as a negative number.
  const bytes = (start: number, length: number) => new Uint8Array(engine.memory.buffer, start >>> 0, length >>> 0);
  const text = (start: number, length: number) => new TextDecoder().decode(bytes(start, length));
  const blocks = new Map<string, Uint8Array>();
  const reader = new FileReaderSync();
  let failure = "";
  let doing = { text: "", rows: 0, passed: 0 };
  let last = 0;

  function block(file: number, place: number): Uint8Array {
    const key = `${file} ${place}`;
    let found = blocks.get(key);
    blocks.delete(key);
    found ??= new Uint8Array(reader.readAsArrayBuffer(
      data.files[file]!.slice(place * BLOCK, (place + 1) * BLOCK),
    ));
    blocks.set(key, found);
    if (blocks.size > MOST_BLOCKS) blocks.delete(blocks.keys().next().value!);
    return found;
  }

  function say(now: number): void {
    last = now;
    const share = doing.rows > 0 ? Math.min(1, doing.passed / doing.rows) : null;
    scope.postMessage({ kind: "doing", text: doing.text, share });
  }

  const page = {
    read(file: number, first: number, into: number, length: number): number {
      try {
        const place = Math.floor(first / BLOCK);
        const from = first - place * BLOCK;
        const part = block(file, place).subarray(from, from + length);
        bytes(into, length).set(part);
        return part.length;
      } catch {
        return -1;
      }
    },
    tell(start: number, length: number, rows: number): void {
      doing = { text: text(start, length), rows, passed: 0 };
      if (performance.now() - last > PAUSE) say(performance.now());
    },
    passed(rows: number): void {
      doing.passed += rows;
      if (performance.now() - last > PAUSE) say(performance.now());
    },
    fail(start: number, length: number): void {
      failure = text(start, length);
    },
  };

  WebAssembly.instantiate(data.module, { page }).then((instance) => {
    engine = instance.exports as unknown as Engine;
    const request = new TextEncoder().encode(data.request);
    const start = engine.room(request.length);
    bytes(start, request.length).set(request);
    const length = engine.respond();
    const json = text(engine.reply(), length);
    const content = bytes(engine.content(), engine.content_length()).slice();
    const memory = engine.memory.buffer.byteLength;
    scope.postMessage({ kind: "answer", json, content, memory }, [content.buffer]);
  }).catch((error: unknown) => {
    scope.postMessage({ kind: "failed", message: failure.replace(/^panicked at [^\n]*\n/, "") || String(error) });
  });
};
