// The page: a log is dropped, looked at, fitted, and taken away as a model.
import { Cancelled, Refused, ask, cancel, prepare } from "./engine";
import { ColumnsForm } from "./columns";
import { byId, download, element, fill, list, number, table } from "./dom";
import { chosen, optionsForm } from "./options";
import { showResult, showScores } from "./result";
import type { Fitted, Keyword, Opened, Profile, Scores } from "./answers";

// The log in hand, and how it is read; nothing of it outlives the page.
let files: File[] = [];
let profile: Profile | null = null;
let isBusy = false;

// Examples, and those that move the same arm otherwise.
const OTHER_MOTIONS: Record<string, string> = { "two-joints": "two-joints-other-motion" };

function doing(text: string, share: number | null): void {
  byId("doing").textContent = `${text} …`;
  const bar = byId<HTMLProgressElement>("bar");
  if (share === null) bar.removeAttribute("value");
  else bar.value = share;
}

// Does one thing at a time, and says why it did not come about.
async function work(what: () => Promise<void>): Promise<void> {
  if (isBusy) return;
  isBusy = true;
  document.body.setAttribute("aria-busy", "true");
  byId("problem").hidden = true;
  byId("work").hidden = false;
  try {
    await what();
  } catch (error) {
    if (error instanceof Cancelled) refuse("Cancelled: nothing was kept of it.", null);
    else if (error instanceof Refused) refuse(error.problem.message, error.problem.help);
    else refuse(String(error), "Reload the page, and try again.");
  } finally {
    isBusy = false;
    document.body.removeAttribute("aria-busy");
    byId("work").hidden = true;
  }
}

function refuse(message: string, help: string | null): void {
  const problem = byId("problem");
  fill(problem, element("strong", {}, message), element("p", {}, help));
  problem.hidden = false;
  problem.scrollIntoView({ block: "nearest" });
}

function logAt(own: File[], cutoff: number | null): object {
  return { files: own.map((file, at) => ({ name: file.name, at, size: file.size })), profile, cutoff };
}

function open(own: File[], by: Profile | null): Promise<void> {
  return work(async () => {
    for (const id of ["found", "columns", "fit", "result"]) byId(id).hidden = true;
    [files, profile] = [own, by];
    const { json, memory } = await ask<Opened>({ ask: "open", ...logAt(own, null) }, own, doing);
    byId("found").dataset["memory"] = String(memory);
    const columns = byId("columns");
    const form = new ColumnsForm(json, by, (asked) => void open(files, asked));
    if (json.log) {
      showFound(json);
      fill(columns, element("details", {}, element("summary", {}, "Columns are something else"), form.element(json)));
    } else {
      fill(columns, ColumnsForm.heading(json), form.element(json));
    }
    columns.hidden = false;
    byId(json.log ? "found" : "columns").focus();
  });
}

function showFound(opened: Opened): void {
  const { options, log } = opened;
  const { found, warnings, is_filtered, profile: text } = log!;
  const patterns = found.patterns.map(({ name, rows }) => `${name} ${Math.round(100 * rows / Math.max(1, found.rows))} %`);
  fill(byId("found"), 
    element("h2", { id: "found-heading" }, "What is in it"),
    element("p", {}, `${files.map((file) => file.name).join(", ")}: ${found.rows} rows, ${found.seconds.toFixed(1)} s at ${number(found.rate_hz)} Hz; ${patterns.join(", ")}.`,
      found.missing.length > 0 && ` Not recorded: ${found.missing.join(", ")}.`,
      is_filtered && " Accelerations are derived by a filter."),
    table("Joints", ["joint", "from", "to [rad or m]", "speed up to", "torque, std [N·m]"],
      found.joints.map((joint) => [joint.name, number(joint.q_range[0]), number(joint.q_range[1]), number(joint.dq_peak), number(joint.tau_std)])),
    warnings.length > 0 && element("div", { class: "callout warning" }, list(warnings)),
    text ? element("p", {}, element("button", { type: "button", onclick: () => download("profile.toml", text, "text/plain") }, "Save the profile"), " of these columns, for the command line and Python.") : null);
  byId("found").hidden = false;
  const form = element("form", { onsubmit: (event: Event) => {
    event.preventDefault();
    void fit(form, options);
  } }, element("p", { class: "actions" }, element("button", { class: "main", id: "run" }, "Find the equations of motion")), optionsForm(options));
  fill(byId("fit"), element("h2", { id: "fit-heading" }, "Fit"), form);
  byId("fit").hidden = false;
}

function fit(form: HTMLFormElement, keywords: Keyword[]): Promise<void> {
  return work(async () => {
    byId("result").hidden = true;
    const { options, cutoff } = chosen(form, keywords);
    const date = `${new Date().toISOString().slice(0, 16).replace("T", " ")} UTC`;
    const own = files;
    const answered = await ask<Fitted>({ ask: "fit", log: logAt(own, cutoff), options, date }, own, doing);
    const { json } = answered;
    const name = (files[0]?.name ?? "arm").replace(/\.[^.]*$/, "");
    const compare = async (other: File[]) => {
      const scores = await ask<Scores>({ ask: "evaluate", model: json.model, log: logAt(other, cutoff) }, other, doing);
      showScores(scores.json, other.map((file) => file.name).join(", "));
    };
    showResult(answered, name, {
      export: (to, own) => void work(async () => {
        const { json: made, content } = await ask<{ name: string; left_out: string[] }>({ ask: "export", model: json.model, to, name: own, force: false }, [], doing);
        download(made.name, content, "application/octet-stream");
        if (made.left_out.length > 0) refuse(`${made.name} is saved. It cannot hold: ${made.left_out.join("; ")}.`, null);
      }),
      compare: (other) => void work(() => compare(other)),
      simulate: OTHER_MOTIONS[name] === undefined ? undefined
        : () => void work(async () => compare([await simulated(OTHER_MOTIONS[name]!)])),
    });
  });
}

async function simulated(name: string): Promise<File> {
  const { json, content } = await ask<{ name: string }>({ ask: "example", name }, [], doing);
  return new File([content], json.name);
}

function example(name: string): Promise<void> {
  let made: File | undefined;
  return work(async () => { made = await simulated(name); }).then(() => made && open([made], null));
}

const input = byId<HTMLInputElement>("files");
input.addEventListener("change", () => {
  const own = [...input.files ?? []];
  input.value = "";
  if (own.length > 0) void open(own, null);
});
byId("cancel").addEventListener("click", cancel);
byId("examples").addEventListener("click", (event) => {
  const name = (event.target as HTMLElement).dataset["example"];
  if (name) void example(name);
});
for (const kind of ["dragover", "dragleave", "drop"]) {
  document.addEventListener(kind, (event) => {
    event.preventDefault();
    byId("drop").classList.toggle("over", kind === "dragover");
  });
}
document.addEventListener("drop", (event) => {
  const own = [...(event as DragEvent).dataTransfer?.files ?? []];
  if (own.length > 0) void open(own, null);
});
requestAnimationFrame(() => setTimeout(prepare));
