// The page finds the model that the command line finds.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { after, before, test } from "node:test";
import { CONFORMANCE, drop, fit, launch, saved } from "./page.mjs";

const PROGRAM = process.env.TORQUEWISE_PROGRAM;

// A page has no fused products and sums over two numbers at a time: roundings differ.
const TOLERANCE = 1e-9;

let browser;
const folder = mkdtempSync(join(tmpdir(), "torquewise-"));
before(async () => { browser = await launch(); });
after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true });
});

// The largest difference of numbers in the same place, over the largest of their list.
function difference(one, other, where = "") {
  if (typeof one === "number" && typeof other === "number") {
    return one === other ? 0 : Math.abs(one - other) / Math.max(1, Math.abs(one), Math.abs(other));
  }
  if (one === null || typeof one !== "object") {
    assert.deepEqual(one, other, where);
    return 0;
  }
  assert.deepEqual(Object.keys(one), Object.keys(other), where);
  return Math.max(0, ...Object.keys(one).map((key) => difference(one[key], other[key], `${where}.${key}`)));
}

for (const name of ["energy", "product", "one_shot", "chain"]) {
  test(`${name}: the model of the page is that of the command line`, { skip: !PROGRAM && "no command line is built" }, async () => {
    const { log, fit: options } = JSON.parse(readFileSync(`${CONFORMANCE}${name}.json`));
    const flags = Object.entries(options).flatMap(([key, value]) => [`--${key.replace(/^n_/, "").replaceAll("_", "-")}`, String(value)]);
    const file = join(folder, `${name}.json`);
    execFileSync(PROGRAM, ["fit", `${CONFORMANCE}${log}`, "-o", file, ...flags]);
    const expected = JSON.parse(readFileSync(file));

    const page = await browser.open();
    await drop(page, `${CONFORMANCE}${log}`);
    await page.locator("details.options summary").click();
    for (const [key, value] of Object.entries(options)) {
      const field = page.locator(`[name=${key}]`);
      if (await field.evaluate((own) => own.tagName) === "SELECT") await field.selectOption(value);
      else await field.fill(String(value));
    }
    await fit(page);
    const found = JSON.parse((await saved(page, "text=Model (JSON)")).content);

    const most = difference(found, expected);
    console.log(`${name}: ${most === 0 ? "the same bits" : `differs by ${most.toExponential(1)}`}`);
    assert.ok(most <= TOLERANCE, `differs by ${most}`);
    await page.context().close();
  });
}
