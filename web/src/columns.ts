// What the columns of a log mean: a form that makes a profile.
import { element, fill, list, select } from "./dom";
import { plot, range } from "./plot";
import type { Column, Opened, Profile, SignalColumns } from "./answers";

const SIGNALS = ["q", "dq", "ddq", "tau"] as const;
type Signal = (typeof SIGNALS)[number];
type Meaning = "" | "t" | Signal;

const MEANINGS = [
  ["", "not used"], ["t", "time"], ["q", "position"], ["dq", "velocity"],
  ["ddq", "acceleration"], ["tau", "torque or current"],
] as const;

const UNITS: Record<Exclude<Meaning, "">, string[]> = {
  t: ["s", "ms", "us", "ns"],
  q: ["rad", "deg", "rev", "m"],
  dq: ["rad/s", "deg/s", "rev/s", "rpm", "m/s"],
  ddq: ["rad/s2", "deg/s2", "rev/s2", "m/s2"],
  tau: ["N.m", "mN.m", "N", "A"],
};

// Columns with one name but for a number or a letter at the end: one signal, a column per joint.
interface Family { columns: Column[]; meaning: Meaning; unit: string }

export class ColumnsForm {
  private families: Family[];
  private rate = "";
  private constants = "1";
  private gears = "1";
  private readonly form: HTMLFormElement;

  constructor(opened: Opened, given: Profile | null, private readonly use: (profile: Profile) => void) {
    this.families = families(opened.columns);
    const profile = given ?? opened.suggestion?.profile;
    if (profile) this.take(profile);
    if (this.rate === "" && !this.families.some((family) => family.meaning === "t")) {
      const clock = this.families.find(({ columns, meaning }) => meaning === "" && columns.length === 1 && isClock(columns[0]!));
      if (clock) [clock.meaning, clock.unit] = ["t", likely("t", clock.columns)];
    }
    this.form = element("form", { onsubmit: (event: Event) => {
      event.preventDefault();
      this.use(this.profile());
    } });
    this.show();
  }

  static heading(opened: Opened): HTMLElement {
    const problem = opened.refused;
    const [text, help] = problem === undefined || problem.is_unnamed
      ? ["Say what the columns mean.", "One row of this table is a signal with a column for each joint, base to tip."]
      : [problem.message, problem.help];
    return element("div", {},
      element("h2", { id: "columns-heading" }, "Columns"),
      element("p", {}, element("strong", {}, text), element("br"), help));
  }

  element(opened: Opened): HTMLElement {
    const reasons = opened.suggestion?.reasons ?? [];
    return element("div", {}, this.form, reasons.length > 0 && element("details", {},
      element("summary", {}, "How the columns were understood"), list(reasons)));
  }

  // Fills the form with what a profile says.
  private take(profile: Profile): void {
    const names = (signal: SignalColumns) => (typeof signal.columns === "string"
      ? this.families.flatMap((family) => family.columns.map((column) => column.name))
        .filter((name) => name === signal.columns || new RegExp(`^\\d+$`).test(name.slice(signal.columns!.length)) && name.startsWith(signal.columns as string))
      : signal.columns ?? []);
    const give = (wanted: string[], meaning: Meaning, unit: string | null | undefined) => {
      for (const family of this.families) {
        if (!family.columns.some((column) => wanted.includes(column.name))) continue;
        family.meaning = meaning;
        family.unit = unit ?? UNITS[meaning as Signal][0]!;
      }
    };
    if (profile.t) give([profile.t.column], "t", profile.t.unit);
    for (const signal of SIGNALS) {
      const own = profile[signal];
      if (own) give(names(own), signal, own.unit);
    }
    const text = (value: number | number[] | undefined) => (value === undefined ? "1" : [value].flat().join(" "));
    this.rate = profile.rate ? String(profile.rate) : "";
    this.constants = text(profile.tau?.torque_constant);
    this.gears = text(profile.tau?.gear);
  }

  private profile(): Profile {
    const profile: Profile = {};
    const of = (meaning: Meaning) => this.families.filter((family) => family.meaning === meaning);
    const clock = of("t")[0];
    if (clock) profile.t = { column: clock.columns[0]!.name, unit: clock.unit };
    else if (this.rate.trim() !== "") profile.rate = Number(this.rate);
    for (const signal of SIGNALS) {
      const own = of(signal);
      if (own.length === 0) continue;
      profile[signal] = { columns: own.flatMap((family) => family.columns.map((column) => column.name)), unit: own[0]!.unit };
    }
    if (profile.tau?.unit === "A") {
      const values = (text: string) => {
        const found = text.split(/[\s,;]+/).filter((word) => word !== "").map(Number);
        return found.length === 1 ? found[0]! : found;
      };
      profile.tau.torque_constant = values(this.constants);
      profile.tau.gear = values(this.gears);
    }
    return profile;
  }

  private show(): void {
    const rows = this.families.map((family, place) => this.row(family, place));
    const amperes = this.families.some((family) => family.meaning === "tau" && family.unit === "A");
    const field = (label: string, value: string, type: string, change: (value: string) => void, hint: string) =>
      element("label", { class: "field" }, element("span", {}, label),
        element("input", { type, value, inputmode: "decimal", step: "any", oninput: (event: Event) => change((event.target as HTMLInputElement).value) }),
        element("small", {}, hint));
    fill(this.form,
      element("div", { class: "families" }, ...rows),
      element("div", { class: "fields" },
        !this.families.some((family) => family.meaning === "t") && field("Rows per second", this.rate, "number", (value) => { this.rate = value; }, "where no column is a clock"),
        amperes && field("Torque constants [N·m/A]", this.constants, "text", (value) => { this.constants = value; }, "one for all joints, or one each"),
        amperes && field("Gears", this.gears, "text", (value) => { this.gears = value; }, "turns of the motor for one of the joint")),
      element("p", { class: "actions" }, element("button", { class: "main" }, "Read these columns")));
  }

  private row(family: Family, place: number): HTMLElement {
    const names = family.columns.map((column) => column.name).join(", ");
    const again = () => {
      const focused = (document.activeElement as HTMLElement | null)?.getAttribute("aria-label");
      this.show();
      this.form.querySelector<HTMLElement>(`[aria-label="${CSS.escape(focused ?? "")}"]`)?.focus();
    };
    const meaning = select(`Meaning of ${names}`, MEANINGS, family.meaning, (value) => {
      family.meaning = value as Meaning;
      if (family.meaning !== "") family.unit = likely(family.meaning, family.columns);
      again();
    });
    const unit = family.meaning !== "" && select(`Unit of ${names}`, UNITS[family.meaning].map((own) => [own, own.replace("N.m", "N·m").replace("s2", "s²").replace(/^us$/, "µs")] as const), family.unit, (value) => {
      family.unit = value;
      again();
    });
    const split = family.columns.length > 1 && element("button", { type: "button", class: "small", "aria-label": `Take ${names} apart`, onclick: () => {
      this.families.splice(place, 1, ...family.columns.map((column) => ({ ...family, columns: [column] })));
      this.show();
    } }, "one by one");
    return element("div", { class: family.meaning === "" ? "family" : "family used" },
      element("div", { class: "names" }, element("code", {}, names), split), plot(family.columns),
      element("div", { class: "choices" }, meaning, unit));
  }
}

function families(columns: Column[]): Family[] {
  const found = new Map<string, Column[]>();
  for (const column of columns) {
    const stem = column.name.replace(/(\d+|(?<=[_.\- ])[A-Za-z](?![A-Za-z]))(?=\D*$)/, "#");
    found.set(stem, [...(found.get(stem) ?? []), column]);
  }
  return [...found.values()].map((own) => ({ columns: own, meaning: "", unit: "" }));
}

// Whether values grow by about the same from row to row.
function isClock({ values }: Column): boolean {
  const mean = ((values.at(-1) ?? 0) - (values[0] ?? 0)) / Math.max(1, values.length - 1);
  return mean > 0 && values.every((value, row) => {
    const step = row === 0 ? mean : (value ?? NaN) - (values[row - 1] ?? NaN);
    return step > 0 && step < 3 * mean;
  });
}

// The unit that the size of values speaks for.
function likely(meaning: Exclude<Meaning, "">, columns: Column[]): string {
  const [low, high] = range(columns);
  if (meaning === "q") return Math.max(-low, high) > 4 * Math.PI ? "deg" : "rad";
  if (meaning !== "t") return UNITS[meaning][0]!;
  const values = columns[0]!.values;
  const step = ((values.at(-1) ?? 0) - (values[0] ?? 0)) / Math.max(1, values.length - 1);
  return step < 0.2 ? "s" : step < 200 ? "ms" : step < 2e5 ? "us" : "ns";
}
