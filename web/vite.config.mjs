// Builds the page into dist/: files that any server hands out, and that work from a disk.
import { readFileSync } from "node:fs";
import { gzipSync } from "node:zlib";
import { defineConfig } from "vite";

const ENGINE = process.env.TORQUEWISE_ENGINE
  ?? "../target/web/wasm32-unknown-unknown/web/torquewise_web.wasm";
const COLOURS = "../crates/torquewise-report/src/assets";

// A browser reads no module and no other file from a disk, but plain scripts: the engine is one.
function engine() {
  return {
    name: "engine",
    generateBundle() {
      const packed = gzipSync(readFileSync(ENGINE), { level: 9 }).toString("base64");
      this.emitFile({ type: "asset", fileName: "engine.js", source: `globalThis.ENGINE="${packed}"` });
    },
  };
}

// The style stands in the page, so that it is there at first paint; its colours are those of the report.
function page() {
  const colours = (theme) => readFileSync(`${COLOURS}/${theme}.css`, "utf8");
  return {
    name: "page",
    transformIndexHtml: {
      order: "post",
      handler: (html) => html
        .replace(/<script type="module"[^>]*src="([^"]*)"[^>]*>/, '<script defer src="$1">')
        .replace("/* style */", `:root {\n${colours("light")}}
@media (prefers-color-scheme: dark) { :root {\n${colours("dark")}} }
${readFileSync("src/app.css", "utf8")}`),
    },
  };
}

export default defineConfig({
  base: "./",
  plugins: [engine(), page()],
  worker: { format: "iife" },
  build: {
    target: "es2022",
    modulePreload: false,
    rollupOptions: {
      output: { format: "iife", entryFileNames: "app.js" },
    },
  },
});
