// The page in Chromium: served by a plain server, or opened from the disk.
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join } from "node:path";
import { fileURLToPath, pathToFileURL } from "node:url";
import { chromium } from "playwright-core";

export const DIST = fileURLToPath(new URL("../dist/", import.meta.url));
export const CONFORMANCE = fileURLToPath(new URL("../../tests/conformance/", import.meta.url));

const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css" };
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
  const server = createServer(async ({ url }, reply) => {
    const path = new URL(url, "http://localhost").pathname;
    const file = join(DIST, path === "/" ? "index.html" : path);
    const content = await readFile(file).catch(() => null);
    reply.writeHead(content ? 200 : 404, { "content-type": TYPES[extname(file)] ?? "text/plain" });
    reply.end(content ?? "not found");
  });
  await new Promise((done) => server.listen(0, "127.0.0.1", done));
  const origin = `http://127.0.0.1:${server.address().port}`;
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
      server.close();
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
