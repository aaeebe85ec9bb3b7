// Options of a fit as the engine lists them, in groups; those left as they are are chosen by the log.
import { element } from "./dom";
import type { Keyword } from "./answers";

const GROUPS: Record<string, string[]> = {
  "What is fitted": ["library", "friction", "kinds", "counterbalance", "refine", "seed"],
  "Signals": ["cutoff", "noise_correction"],
  "Patterns of motion": ["activation", "clusters"],
  "Terms of a library": ["method", "select", "threshold", "interaction", "trig_order", "gravity_order", "n_bootstrap"],
};

const LABELS: Record<string, string> = {
  library: "Model", friction: "Friction", kinds: "Kinds of joints: r turns, p slides, as r,r,p",
  counterbalance: "Counterbalanced joints: their names, with commas", refine: "Refine", seed: "Seed",
  cutoff: "Cut-off of the filter [Hz]", noise_correction: "Bias of noise",
  activation: "Activation index", clusters: "Clusters of rows",
  method: "Regression", select: "Selection", threshold: "Least coefficient",
  interaction: "Joint angles in a term", trig_order: "Sines and cosines in a term",
  gravity_order: "The same in gravity's", n_bootstrap: "Resampled logs",
};

const WORDS: Record<string, string> = {
  chain: "learned chain of rigid bodies", energy: "energies M(q), V(q)", product: "products of terms",
  linear: "dry and viscous", stribeck: "Stribeck", auto: "by held-out rows", rollout: "by simulated motion",
  sindy: "one-shot SINDy", stepwise: "stepwise, by pattern of motion", bic: "BIC", lasso: "LASSO",
  stlsq: "thresholds", "noise_correction true": "taken out", "noise_correction false": "left in", scaled: "each joint by its range", paper: "constants of the paper",
};

// The filter goes with the log.
const CUTOFF: Keyword = { name: "cutoff", number: null };

function input(option: Keyword): HTMLElement {
  const { name } = option;
  const choice = (words: [string, string][]) => element("select", { name },
    ...[["", "usual"], ...words].map(([value, text]) => element("option", { value }, text)));
  if (option.word) return choice(option.word.map((word) => [word, WORDS[word] ?? word]));
  if ("switch" in option) return choice(["true", "false"].map((word) => [word, WORDS[`${name} ${word}`] ?? word]));
  if ("text" in option || "texts" in option) return element("input", { name, placeholder: "usual" });
  const { start, end } = option.whole ?? { start: 0, end: Number.MAX_VALUE };
  const most = option.whole ? Math.min(end, Number.MAX_SAFE_INTEGER) : end;
  return element("input", { name, type: "number", min: start, max: most, step: option.whole ? 1 : "any", placeholder: "usual" });
}

export function optionsForm(keywords: Keyword[]): HTMLElement {
  const all = new Map([...keywords, CUTOFF].map((option) => [option.name, option]));
  const grouped = Object.values(GROUPS).flat();
  const groups = { ...GROUPS, "Others": [...all.keys()].filter((name) => !grouped.includes(name)) };
  return element("details", { class: "options" }, element("summary", {}, "Options"),
    ...Object.entries(groups).map(([title, names]) => [title, names.flatMap((name) => all.get(name) ?? [])] as const)
      .filter(([, own]) => own.length > 0)
      .map(([title, own]) => element("fieldset", {}, element("legend", {}, title),
        ...own.map((option) => element("label", { class: "field" }, element("span", {}, LABELS[option.name] ?? option.name), input(option))))));
}

export function chosen(form: HTMLFormElement, keywords: Keyword[]): { options: Record<string, unknown>; cutoff: number | null } {
  const given = (name: string) => (form.elements.namedItem(name) as HTMLInputElement | HTMLSelectElement).value.trim();
  const options: Record<string, unknown> = {};
  for (const option of keywords) {
    const value = given(option.name);
    if (value === "") continue;
    if (option.whole || "number" in option) options[option.name] = Number(value);
    else if ("texts" in option) options[option.name] = value.split(/\s*,\s*/);
    else options[option.name] = "switch" in option ? value === "true" : value;
  }
  const cutoff = given("cutoff");
  return { options, cutoff: cutoff === "" ? null : Number(cutoff) };
}
