// Asks the engine, one thing at a time; what is under way is ended by ending its thread.
import EngineWorker from "./worker?worker&inline";
import type { Told } from "./worker";
import type { Problem } from "./answers";

declare global {
  // The engine, gzipped and in base64: from the script engine.js.
  var ENGINE: string | undefined;
}

export class Refused extends Error {
  constructor(readonly problem: Problem) {
    super(problem.message);
  }
}

export class Cancelled extends Error {}

export type Doing = (text: string, share: number | null) => void;

let compiled: Promise<WebAssembly.Module> | undefined;
let stop: (() => void) | undefined;

function compile(): Promise<WebAssembly.Module> {
  compiled ??= (async () => {
    await loaded();
    const packed = Uint8Array.from(atob(ENGINE!), (letter) => letter.charCodeAt(0));
    ENGINE = undefined;
    const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return WebAssembly.compile(await new Response(plain).arrayBuffer());
  })().catch((failure: unknown) => {
    compiled = undefined;
    throw failure;
  });
  return compiled;
}

function loaded(): Promise<void> {
  return new Promise((done, fail) => {
    const script = document.createElement("script");
    script.src = "./engine.js";
    script.onload = () => done();
    script.onerror = () => fail(new Refused({
      message: "The engine, engine.js, cannot be loaded.",
      help: "Put it beside index.html, and reload the page.",
    }));
    document.head.append(script);
  });
}

// Loads and compiles the engine before it is asked.
export function prepare(): void {
  compile().catch(() => { compiled = undefined; });
}

export interface Answered<T> {
  json: T;
  content: Uint8Array<ArrayBuffer>;
  // Time it took [s], and the memory of the engine [bytes].
  seconds: number;
  memory: number;
}

export async function ask<T>(request: object, files: File[], doing: Doing): Promise<Answered<T>> {
  doing("loading the engine", null);
  const ended = new Promise<never>((_, fail) => { stop = () => fail(new Cancelled()); });
  let worker: Worker | undefined;
  try {
    const module = await Promise.race([compile(), ended]);
    const own = worker = new EngineWorker();
    const start = performance.now();
    const answer = new Promise<Told>((done) => {
      own.onerror = (event) => done({ kind: "failed", message: event.message });
      own.onmessage = ({ data }: MessageEvent<Told>) => {
        if (data.kind === "doing") doing(data.text, data.share);
        else done(data);
      };
      own.postMessage({ module, request: JSON.stringify(request), files });
    });
    const told = await Promise.race([answer, ended]);
    if (told.kind !== "answer") {
      throw new Refused({
        message: `The engine stopped: ${told.kind === "failed" ? told.message : ""}`,
        help: "A file may be damaged beyond decoding, or need more memory than a page has: copy it again, or try the command line.",
      });
    }
    const json = JSON.parse(told.json) as T & { problem?: Problem };
    if (json.problem) throw new Refused(json.problem);
    return {
      json,
      content: told.content as Uint8Array<ArrayBuffer>,
      seconds: (performance.now() - start) / 1e3,
      memory: told.memory,
    };
  } finally {
    stop = undefined;
    worker?.terminate();
  }
}

export function cancel(): void {
  stop?.();
}
