// What a fit came to: verdict first, then errors, what to take away, another log, the report.
import { byId, download, element, fill, list, number, table } from "./dom";
import type { Fitted, Scores } from "./answers";
import type { Answered } from "./engine";

const FORMATS = [
  ["c", "C99"], ["rust", "Rust"], ["python", "Python"], ["latex", "LaTeX"],
  ["urdf", "URDF"], ["mjcf", "MJCF"], ["fmu", "FMU (sources)"],
] as const;

const WORDS: Record<string, string> = {
  good: "Good: use the model as it is.",
  usable: "Usable, with the reasons in mind.",
  unusable: "Unusable: a better log is needed.",
};

export interface Wishes {
  export(to: string, name: string): void;
  compare(files: File[]): void;
  // Another motion of the arm, where it is one of ours.
  simulate: (() => void) | undefined;
}

export function showResult(answered: Answered<Fitted>, name: string, wishes: Wishes): void {
  const { json: fitted, seconds, memory } = answered;
  const { summary } = fitted;
  const section = byId("result");
  const report = element("iframe", { title: "Report of the fit", sandbox: "allow-scripts", srcdoc: fitted.report });
  const held = summary.joints.map((_, joint) => {
    const [time, region] = [summary.held_out_percent[joint], summary.held_out_by_region_percent[joint]];
    return time == null ? undefined : Math.max(time, region ?? time);
  });
  const formats = FORMATS.filter(([to]) => fitted.is_chain || (to !== "urdf" && to !== "mjcf"));
  const other = element("input", { type: "file", multiple: true, id: "other", accept: ".csv,.parquet,.mcap,.npz,.mat,.db3", onchange: () => {
    wishes.compare([...other.files ?? []]);
    other.value = "";
  } });
  fill(section,
    element("h2", { id: "result-heading" }, "Verdict"),
    element("div", { class: summary.verdict === "good" ? "callout good" : "callout warning", id: "verdict" },
      element("strong", {}, WORDS[summary.verdict] ?? summary.verdict), list(summary.because)),
    table("Errors of each joint", ["joint", "terms", "residual [N·m]", "residual [% of std]", "held out [% of std]"],
      summary.joints.map((joint, k) => [joint, String(summary.active[k]), number(summary.residual_rms[k]), number(summary.residual_percent[k]), number(held[k])])),
    element("p", { class: "faded", id: "cost" }, `Found in ${seconds.toFixed(1)} s, in ${Math.ceil(memory / 1e6)} MB of memory.`),
    details("Warnings", fitted.warnings),
    details("Notes", fitted.notes),
    element("h3", {}, "Take away"),
    element("p", { class: "actions", id: "downloads" },
      element("button", { type: "button", class: "main", onclick: () => download(`${name}.json`, fitted.model, "application/json") }, "Model (JSON)"),
      element("button", { type: "button", onclick: () => download(`${name}.html`, fitted.report, "text/html") }, "Report (HTML)"),
      element("button", { type: "button", onclick: () => download(`${name}.txt`, fitted.equations, "text/plain") }, "Equations (text)"),
      ...formats.map(([to, label]) => element("button", { type: "button", onclick: () => wishes.export(to, name) }, label))),
    element("h3", {}, "Another log of the arm"),
    element("p", {}, "A motion that the model has not seen says more than the residual of its own: ",
      element("label", { for: "other", class: "inline" }, "choose a log"), " to predict",
      wishes.simulate && element("span", {}, ", or ", element("button", { type: "button", class: "small", id: "simulate", onclick: wishes.simulate }, "simulate one")), "."),
    other,
    element("div", { id: "scores", tabindex: -1 }),
    element("details", {}, element("summary", {}, "Equations of motion"),
      element("pre", { tabindex: 0, "aria-label": "Equations of motion" }, fitted.equations)),
    element("h3", {}, "Report"),
    report);
  section.hidden = false;
  byId("verdict").scrollIntoView({ block: "nearest" });
  section.focus({ preventScroll: true });
}

function details(title: string, texts: string[]): HTMLElement | null {
  return texts.length > 0
    ? element("details", { open: title === "Warnings" }, element("summary", {}, `${title} (${texts.length})`), list(texts))
    : null;
}

export function showScores({ scores, warnings, notes }: Scores, name: string): void {
  fill(byId("scores"),
    table(`Prediction of ${name}, ${scores.rows} rows`, ["joint", "RMSE [N·m]", "NRMSE [%]", "R²"],
      scores.joints.map((joint) => [joint.name, number(joint.rmse), number(joint.nrmse_percent), joint.r2 == null ? "–" : joint.r2.toFixed(6)])),
    list([...warnings, ...notes]));
  byId("scores").focus();
}
