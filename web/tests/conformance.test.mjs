// The page finds the model that the command line finds.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { CONFORMANCE, PROGRAM, drop, fit, launch, saved } from "./page.mjs";

// Of the largest torque. A page has no fused products and sums two numbers at a time: roundings differ.
const TOLERANCE = 1e-9;

let browser;
const folder = mkdtempSync(join(tmpdir(), "torquewise-"));
before(async () => { browser = await launch(); });
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

// The torque of a model in the states of a case.
function torques(model, { q, dq, ddq }) {
  const heads = ["q", "dq", "ddq"].flatMap((signal) => q[0].map((_, k) => `${signal}${k + 1}`));
  const rows = q.map((own, row) => [row / 10, ...own, ...dq[row], ...ddq[row]].join(","));
  const [states, predicted] = [join(folder, "states.csv"), join(folder, "predicted.csv")];
  writeFileSync(states, `${["t", ...heads].join(",")}\n${rows.join("\n")}\n`);
  execFileSync(PROGRAM, ["predict", model, states, "-o", predicted, "--filter", "none"], { stdio: "pipe" });
  const [head, ...lines] = readFileSync(predicted, "utf8").trim().split("\n");
  const places = head.split(",").flatMap((column, place) => (column.startsWith("tau_hat") ? [place] : []));
  assert.equal(places.length, q[0].length, head);
  return lines.flatMap((line) => places.map((place) => Number(line.split(",")[place])));
}

for (const name of ["energy", "product", "one_shot", "chain"]) {
  test(`${name}: the model of the page is that of the command line`, { skip: !PROGRAM && "no command line is built" }, async () => {
    const states = JSON.parse(readFileSync(`${CONFORMANCE}${name}.json`));
    const { log, fit: options } = states;
    const flags = Object.entries(options).flatMap(([key, value]) => [`--${key.replace(/^n_/, "").replaceAll("_", "-")}`, String(value)]);
    const [native, own] = [join(folder, `${name}.json`), join(folder, "page.json")];
    execFileSync(PROGRAM, ["fit", `${CONFORMANCE}${log}`, "-o", native, ...flags], { stdio: "pipe" });

    const page = await browser.open();
    await drop(page, `${CONFORMANCE}${log}`);
    await page.locator("details.options summary").click();
    for (const [key, value] of Object.entries(options)) {
      const field = page.locator(`[name=${key}]`);
      if (await field.evaluate((own) => own.tagName) === "SELECT") await field.selectOption(value);
      else await field.fill(String(value));
    }
    await fit(page);
    writeFileSync(own, (await saved(page, "text=Model (JSON)")).content);

    const [found, expected] = [own, native].map((model) => torques(model, states));
    const largest = Math.max(...expected.map(Math.abs));
    const most = Math.max(...expected.map((torque, k) => Math.abs(torque - found[k]))) / largest;
    console.log(`${name}: ${most === 0 ? "the same bits" : `differs by ${most.toExponential(1)}`}`);
    assert.ok(most <= TOLERANCE, `differs by ${most}`);
    await page.context().close();
  });
}
