// The page in Chromium: served by `torquewise serve`, or opened from the disk.
import { spawn } from "node:child_process";
import { readFile } from "node:fs/promises";
import { join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

export const DIST = fileURLToPath(new URL("../dist/", import.meta.url));
export const CONFORMANCE = fileURLToPath(new URL("../../tests/conformance/", import.meta.url));

/** The program, which has the page in it. */
export const PROGRAM = process.env.TORQUEWISE_PROGRAM;

const FLAGS = [
  "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--disable-background-networking",
  "--disable-component-update", "--no-first-run",
];

// Long enough for a fit on a busy machine [ms].
const PATIENCE = 120_000;

export async function launch() {
  const named = process.env.TORQUEWISE_CHROMIUM || "chromium";
  const program = named.includes("/") ? named : `/usr/bin/${named}`;
  const browser = await chromium.launch({ executablePath: program, args: FLAGS });
  const server = spawn(PROGRAM, ["serve", "--no-browser"], { stdio: ["ignore", "ignore", "pipe"] });
  const origin = await new Promise((found, failed) => {
    let told = "";
    server.on("error", failed);
    server.on("exit", () => failed(new Error(told)));
    server.stderr.on("data", (text) => {
      told += text;
      const address = /http:\/\/127\.0\.0\.1:\d+/.exec(told);
      if (address) found(address[0]);
    });
  });
  return {
    origin,
    onDisk: pathToFileURL(join(DIST, "index.html")).href,
    async open(url = `${origin}/`, options = {}) {
      const context = await browser.newContext({ acceptDownloads: true, ...options });
      const page = await context.newPage();
      page.setDefaultTimeout(PATIENCE);
      page.requests = [];
      page.faults = [];
      page.on("request", (request) => page.requests.push(request.url()));
      page.on("pageerror", (error) => page.faults.push(String(error)));
      page.on("console", (line) => line.type() === "error" && page.faults.push(line.text()));
      await page.goto(url);
      return page;
    },
    async close() {
      await browser.close();
      server.kill("SIGINT");
    },
  };
}

export async function example(page, name) {
  await page.click(`[data-example=${name}]`);
  await page.waitForSelector("#found:not([hidden]), #columns:not([hidden])");
  await idle(page);
}

// Does something that makes the page work, and waits until it is done.
export async function done(page, act) {
  const ends = page.evaluate(() => new Promise((end) => {
    const watch = new MutationObserver(() => {
      if (document.body.hasAttribute("aria-busy")) return;
      watch.disconnect();
      end();
    });
    watch.observe(document.body, { attributeFilter: ["aria-busy"] });
  }));
  await act();
  await ends;
}

export function drop(page, files, into = "#files") {
  return done(page, () => page.setInputFiles(into, files));
}

export async function idle(page) {
  await page.waitForFunction(() => !document.body.hasAttribute("aria-busy"));
}

export function fit(page) {
  return done(page, () => page.click("#run"));
}

export async function saved(page, button) {
  const [made] = await Promise.all([page.waitForEvent("download"), page.click(button)]);
  await idle(page);
  return { name: made.suggestedFilename(), content: await readFile(await made.path()) };
}
