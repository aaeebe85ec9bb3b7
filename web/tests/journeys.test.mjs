// What people do with the page, and what goes wrong on the way.
import assert from "node:assert/strict";
import { Buffer } from "node:buffer";
import { spawnSync } from "node:child_process";
import { after, before, test } from "node:test";
import { bag } from "./mcap.mjs";
import { CONFORMANCE, PROGRAM, done, drop, example, fit, idle, launch, saved } from "./page.mjs";

let browser;
before(async () => { browser = await launch(); });
after(() => browser?.close());

const file = (name, text) => ({ name, mimeType: "application/octet-stream", buffer: Buffer.from(text) });

// Nothing was asked of anybody else, and nothing failed unseen.
function assertQuiet(page) {
  const own = (url) => url.startsWith(browser.origin) || /^(blob|data|about|file):/.test(url);
  assert.deepEqual(page.requests.filter((url) => !own(url)), []);
  assert.deepEqual(page.faults, []);
}

test("an example becomes a model that predicts another motion, and every file of it can be saved", async () => {
  const page = await browser.open();
  await example(page, "two-joints");
  assert.match(await page.innerText("#found"), /12000 rows, 120\.0 s at 100 Hz/);

  await fit(page);
  assert.match(await page.innerText("#verdict"), /Good: use the model as it is/);
  await done(page, () => page.click("#simulate"));
  const nrmse = await page.locator("#scores td:nth-of-type(2)").allInnerTexts();
  assert.ok(nrmse.length === 2 && nrmse.every((percent) => Number(percent) < 0.5), nrmse.join());

  const model = await saved(page, "text=Model (JSON)");
  assert.equal(model.name, "two-joints.json");
  assert.deepEqual(JSON.parse(model.content).joints, ["joint1", "joint2"]);
  const files = {
    "Report (HTML)": /^<!doctype html>/, "Equations (text)": /M11 =/, C99: /double/, Rust: /fn /,
    Python: /def /, LaTeX: /\\documentclass/, "FMU (sources)": /^PK/,
  };
  for (const [label, content] of Object.entries(files)) {
    const made = await saved(page, `#downloads >> text="${label}"`);
    assert.match(made.content.toString("latin1"), content, label);
  }

  const report = page.frameLocator("iframe");
  assert.match(await report.locator("h1").innerText(), /two-joints/);
  assert.ok(await report.locator(".plot canvas").count() > 0, "the charts of the report are drawn");
  assertQuiet(page);
  await page.context().close();
});

test("unknown columns become a model in six clicks, and a chain a robot", async () => {
  const page = await browser.open();
  let clicks = 1;
  await example(page, "raw-columns");
  assert.match(await page.innerText("#columns"), /Say what the columns mean/);

  const choose = async (label, value) => {
    clicks += 1;
    await page.getByLabel(label).selectOption(value);
  };
  assert.equal(await page.getByLabel("Meaning of tick_ms").inputValue(), "t");
  await choose("Meaning of encoder_A", "q");
  await choose("Meaning of drive_A", "tau");
  await choose("Unit of drive_A", "A");
  await page.getByLabel("Torque constants").fill("2.5");
  assert.equal(await page.getByLabel("Unit of encoder_A").inputValue(), "deg");
  await done(page, () => page.click("text=Read these columns"));
  clicks += 2;
  await fit(page);

  assert.ok(clicks <= 6, `${clicks} clicks`);
  assert.match(await page.innerText("#verdict"), /^(Good|Usable)/);
  const profile = await saved(page, "text=Save the profile");
  assert.match(profile.content.toString(), /torque_constant = 2\.5/);
  assert.match((await saved(page, "#downloads >> text=URDF")).content.toString(), /<robot/);
  assert.match((await saved(page, "#downloads >> text=MJCF")).content.toString(), /<mujoco/);
  assertQuiet(page);
  await page.context().close();
});

test("an arm whose joints slide is found to, and every option of the engine can be set", async () => {
  const page = await browser.open();
  await example(page, "gantry");
  await page.click("details.options summary");
  const options = await page.locator("details.options [name]").evaluateAll((all) => all.map((own) => own.name).sort());
  assert.ok(["activation", "clusters", "cutoff", "gravity_order", "kinds", "library", "n_bootstrap"].every((own) => options.includes(own)), options.join());
  assert.equal(await page.getByLabel("Seed").getAttribute("step"), "1");

  await fit(page);
  assert.match(await page.innerText("#verdict"), /^Good/);
  const model = JSON.parse((await saved(page, "text=Model (JSON)")).content);
  assert.equal(model.chain.kinds.length, 3);
  assert.match((await saved(page, "#downloads >> text=URDF")).content.toString(), /type="prismatic"/);
  assertQuiet(page);
  await page.context().close();
});

test("a file that is wrong is refused with its place and a way out, and the next one is read", async () => {
  const page = await browser.open();
  const refused = async (name, text, ...said) => {
    await drop(page, file(name, text));
    const shown = await page.locator("#problem:not([hidden]), #columns:not([hidden])").first().innerText();
    for (const words of said) assert.match(shown, words, name);
  };
  await refused("a.txt", "t,q1\n", /a\.txt/, /extension|csv/i);
  await refused("bag.db3", "SQLite format 3\0", /reads no \.db3/, /ros2 bag convert/);
  await refused("empty.csv", "", /empty\.csv/);
  await refused("words.csv", "t,q1,tau1\n0,1,2\n0.1,x,2\n", /words\.csv/, /line 3|row 2/, /q1/);
  await refused("short.csv", "t,q1,tau1\n0,1,2\n0.1,2\n", /short\.csv/, /line 3|row 2/);
  await refused("half.parquet", `PAR1${"x".repeat(200)}`, /half\.parquet/, /Parquet|damaged/);
  await refused("half.mcap", "\x89MCAP0\r\n", /half\.mcap/);
  await refused("half.npz", "PK\x03\x04xxxx", /half\.npz/, /NumPy/);
  await refused("half.mat", "x".repeat(300), /half\.mat/, /MAT/);

  const rows = Array.from({ length: 500 }, (_, k) => `${k / 100},${Math.sin(k / 30)}`).join("\n");
  await drop(page, file("no-torque.csv", `t,q1\n${rows}`));
  assert.match(await page.innerText("#found"), /Not recorded: dq, ddq, tau/);
  await fit(page);
  assert.match(await page.innerText("#problem"), /no-torque\.csv has no torque/);
  await drop(page, `${CONFORMANCE}smooth.csv`);
  await page.locator("details.options summary").click();
  await page.locator("[name=library]").selectOption("chain");
  await page.locator("[name=threshold]").fill("0.1");
  await fit(page);
  assert.match(await page.innerText("#problem"), /threshold is not used by a learned chain/);
  assertQuiet(page);
  await page.context().close();
});

test("a bag whose chunks are packed by zstd is read, as are several files at once", async () => {
  const rows = (from) => Array.from({ length: 3000 }, (_, k) => {
    const t = from + k / 100;
    const [q, dq] = [[Math.sin(t), Math.cos(1.3 * t)], [Math.cos(t), -1.3 * Math.sin(1.3 * t)]];
    return { t, q, dq, tau: [9 * Math.cos(q[0]), 2 * Math.cos(q[1])] };
  });
  const bags = [0, 1].map((k) => ({ ...file(`run_${k}.mcap`, ""), buffer: bag(["hip", "knee"], rows(1000 * (k + 1))) }));
  const page = await browser.open();
  await drop(page, bags);
  const found = await page.innerText("#found");
  assert.match(found, /run_0\.mcap, run_1\.mcap: \d+ rows, 5\d\.\d s/);
  assert.match(found, /hip/);
  assertQuiet(page);
  await page.context().close();
});

test("a log of many megabytes is read in little memory", async () => {
  const lines = Array.from({ length: 2000 }, (_, k) => {
    const turn = (2 * Math.PI * k) / 2000;
    const [q1, q2] = [Math.sin(6 * turn), Math.cos(10 * turn)].map((q) => q.toFixed(12));
    return `${q1},${q2},${(9 * Math.cos(Number(q1))).toFixed(12)},${(2 * Math.cos(Number(q2))).toFixed(12)}\n`;
  }).join("");
  const page = await browser.open();
  const log = await page.evaluateHandle((own) => new File(["q1,q2,tau1,tau2\n", ...Array(400).fill(own)], "long.csv"), lines);
  assert.ok(await log.evaluate((own) => own.size) > 40e6);
  await done(page, () => log.evaluate((own) => {
    const moved = new DataTransfer();
    moved.items.add(own);
    document.dispatchEvent(new DragEvent("drop", { dataTransfer: moved }));
  }));
  await page.getByLabel("Rows per second").fill("100");
  await done(page, () => page.click("text=Read these columns"));
  assert.match(await page.innerText("#found"), /266635 rows, 7999\.0 s at 33\.33 Hz/);
  const memory = Number(await page.locator("#found").getAttribute("data-memory"));
  assert.ok(memory > 0 && memory < 100e6, `${memory} bytes`);
  await page.context().close();
});

test("a fit is cancelled at once, and begins anew", async () => {
  const page = await browser.open();
  await drop(page, `${CONFORMANCE}rough.csv`);
  await page.click("#run");
  await page.waitForFunction(() => /geometry|summing|friction|cut-offs/.test(document.getElementById("doing").textContent));
  await page.click("#cancel");
  await idle(page);
  assert.match(await page.innerText("#problem"), /Cancelled/);
  assert.ok(await page.locator("#result").isHidden());

  await fit(page);
  assert.match(await page.innerText("#verdict"), /held-out/);
  await page.context().close();
});

test("once loaded it works offline, and from a disk", async () => {
  const away = await browser.open();
  await away.waitForLoadState("networkidle");
  await away.context().setOffline(true);
  const disk = await browser.open(browser.onDisk);
  for (const page of [away, disk]) {
    await drop(page, `${CONFORMANCE}smooth.csv`);
    await fit(page);
    assert.match(await page.innerText("#verdict"), /held-out/);
    assertQuiet(page);
    await page.context().close();
  }
});

test("the server has the page alone, and a port that is taken is said to be", async () => {
  const missing = await fetch(`${browser.origin}/../Cargo.toml`);
  assert.equal(missing.status, 404);
  const { port } = new URL(browser.origin);
  const second = spawnSync(PROGRAM, ["serve", "--no-browser", "--port", port], { encoding: "utf8" });
  assert.equal(second.status, 1);
  assert.match(second.stderr, new RegExp(`127\\.0\\.0\\.1:${port}[^]*--port`));
});

test("it is used by keyboard alone, and each control has a name", async () => {
  const page = await browser.open();
  const tabTo = async (name) => {
    for (let k = 0; k < 40; k += 1) {
      await page.keyboard.press("Tab");
      if ((await page.evaluate(() => document.activeElement?.textContent?.trim())) === name) return;
    }
    assert.fail(`${name} is not reached by Tab`);
  };
  await tabTo("two joints with noise");
  await page.keyboard.press("Enter");
  await page.waitForSelector("#found:not([hidden])");
  await idle(page);
  await tabTo("Find the equations of motion");
  await done(page, () => page.keyboard.press("Enter"));
  assert.equal(await page.evaluate(() => document.activeElement?.id), "result");

  const nameless = await page.evaluate(() => [...document.querySelectorAll("button, input, select, iframe, summary, section:not([hidden])")]
    .filter((own) => {
      const label = own.getAttribute("aria-label") ?? own.getAttribute("title") ?? own.labels?.[0]?.textContent
        ?? document.getElementById(own.getAttribute("aria-labelledby"))?.textContent ?? own.textContent;
      return !label?.trim();
    }).map((own) => own.outerHTML.slice(0, 80)));
  assert.deepEqual(nameless, []);
  await page.context().close();
});

test("it fits 400 px and 4K, light and dark", async () => {
  for (const [width, height, colorScheme] of [[400, 800, "dark"], [3840, 2160, "light"]]) {
    const page = await browser.open(undefined, { viewport: { width, height }, colorScheme });
    await example(page, "raw-columns");
    const folder = process.env.TORQUEWISE_SHOTS;
    if (folder) await page.screenshot({ path: `${folder}/columns-${width}.png`, fullPage: true });
    await example(page, "two-joints");
    await fit(page);
    if (folder) await page.screenshot({ path: `${folder}/result-${width}.png`, fullPage: true });
    const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(overflow <= 0, `${width} px: ${overflow} px too wide`);
    const [ink, paper] = await page.evaluate(() => {
      const { color, backgroundColor } = getComputedStyle(document.body);
      return [color, backgroundColor].map((own) => own.match(/\d+/g).slice(0, 3).reduce((sum, x) => sum + Number(x), 0));
    });
    assert.equal(ink > paper, colorScheme === "dark");
    await page.context().close();
  }
});
