// Elements of the page, made in one expression.

type Child = Node | string | null | undefined | false;

export function element<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Record<string, unknown> = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) made.setAttribute(name, "");
    else if (value !== false && value != null) made.setAttribute(name, String(value));
  }
  return fill(made, ...children);
}

// Puts children in place of those that are there.
export function fill<E extends Element>(into: E, ...children: Child[]): E {
  into.replaceChildren(...children.filter((child): child is Node | string => !!child));
  return into;
}

export function byId<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

export function select(label: string, options: readonly (readonly [string, string])[], value: string, change: (value: string) => void): HTMLSelectElement {
  const made = element("select", { "aria-label": label, onchange: () => change(made.value) },
    ...options.map(([own, text]) => element("option", { value: own, selected: own === value }, text)));
  return made;
}

export function table(caption: string, heads: string[], rows: (Node | string)[][]): HTMLElement {
  const is = (place: number) => (place === 0 ? {} : { class: "number" });
  return element("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": caption },
    element("table", {},
      element("caption", {}, caption),
      element("thead", {}, element("tr", {}, ...heads.map((head, k) => element("th", { scope: "col", ...is(k) }, head)))),
      element("tbody", {}, ...rows.map((cells) => element("tr", {},
        ...cells.map((cell, k) => element(k === 0 ? "th" : "td", k === 0 ? { scope: "row" } : is(k), cell)))))));
}

export function list(texts: string[]): HTMLElement | null {
  return texts.length > 0 ? element("ul", {}, ...texts.map((text) => element("li", {}, text))) : null;
}

export function number(value: number | null | undefined): string {
  if (value == null || !Number.isFinite(value)) return "–";
  const digits = Number(value.toPrecision(4));
  return Math.abs(digits) >= 1e5 || (digits !== 0 && Math.abs(digits) < 1e-4) ? digits.toExponential() : String(digits);
}

export function download(name: string, content: BlobPart, type: string): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  element("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
