// Options of a fit, in groups; those left as they are are chosen by the log.
import { element } from "./dom";

type Option =
  | { name: string; label: string; words: readonly (readonly [string, string])[] }
  | { name: string; label: string; least: number; most: number; step: "any" | 1 }
  | { name: string; label: string; hint: string };

const GROUPS: { title: string; options: Option[] }[] = [
  { title: "What is fitted", options: [
    { name: "library", label: "Model", words: [["", "chosen by the log"], ["chain", "learned chain of rigid bodies"], ["energy", "energies M(q), V(q)"], ["product", "products of terms"]] },
    { name: "friction", label: "Friction", words: [["", "chosen by held-out rows"], ["none", "none"], ["linear", "dry and viscous"], ["stribeck", "Stribeck"]] },
    { name: "kinds", label: "Kinds of joints", hint: "r turns, p slides, as r,r,p" },
    { name: "counterbalance", label: "Counterbalanced joints", hint: "their names, with commas" },
  ] },
  { title: "Signals", options: [
    { name: "cutoff", label: "Cut-off of the filter [Hz]", least: 0, most: 1e5, step: "any" },
    { name: "noise_correction", label: "Bias of noise", words: [["", "taken out"], ["false", "left in"]] },
  ] },
  { title: "Terms of a library", options: [
    { name: "method", label: "Regression", words: [["", "stepwise, by pattern of motion"], ["sindy", "one-shot SINDy"]] },
    { name: "select", label: "Selection", words: [["", "usual"], ["bic", "BIC"], ["lasso", "LASSO"], ["stlsq", "thresholds"]] },
    { name: "threshold", label: "Least coefficient", least: 0, most: 1e9, step: "any" },
    { name: "interaction", label: "Joint angles in a term", least: 1, most: 16, step: 1 },
    { name: "trig_order", label: "Sines and cosines in a term", least: 1, most: 8, step: 1 },
    { name: "n_bootstrap", label: "Resampled logs", least: 0, most: 1000, step: 1 },
  ] },
  { title: "Search", options: [
    { name: "refine", label: "Refine", words: [["", "by torque alone"], ["rollout", "by simulated motion"]] },
    { name: "seed", label: "Seed", least: 0, most: 4_294_967_295, step: 1 },
  ] },
];

export function optionsForm(): HTMLElement {
  const field = (option: Option) => element("label", { class: "field" },
    element("span", {}, option.label),
    "words" in option
      ? element("select", { name: option.name }, ...option.words.map(([value, text]) => element("option", { value }, text)))
      : "hint" in option
        ? element("input", { name: option.name, placeholder: option.hint })
        : element("input", { name: option.name, type: "number", min: option.least, max: option.most, step: option.step, placeholder: "usual" }));
  return element("details", { class: "options" }, element("summary", {}, "Options"),
    ...GROUPS.map(({ title, options }) => element("fieldset", {}, element("legend", {}, title), ...options.map(field))));
}

export function chosen(form: HTMLFormElement): { options: Record<string, unknown>; cutoff: number | null } {
  const options: Record<string, unknown> = {};
  for (const option of GROUPS.flatMap((group) => group.options)) {
    const value = (form.elements.namedItem(option.name) as HTMLInputElement | HTMLSelectElement).value.trim();
    if (value === "") continue;
    if ("least" in option) options[option.name] = Number(value);
    else if (option.name === "counterbalance") options[option.name] = value.split(/\s*,\s*/);
    else options[option.name] = value === "false" ? false : value;
  }
  const cutoff = (options["cutoff"] as number | undefined) ?? null;
  delete options["cutoff"];
  return { options, cutoff };
}
