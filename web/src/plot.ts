// Columns as small curves, one colour each, on a common scale.
import { element } from "./dom";
import type { Column } from "./answers";

const WIDTH = 240;
const HEIGHT = 48;

export function range(columns: Column[]): [number, number] {
  let [low, high] = [Infinity, -Infinity];
  for (const column of columns) {
    for (const value of column.values) {
      if (value === null) continue;
      low = Math.min(low, value);
      high = Math.max(high, value);
    }
  }
  return [low, high];
}

export function plot(columns: Column[]): HTMLElement {
  const [low, high] = range(columns);
  if (low > high) return element("span", { class: "faded" }, "no numbers");
  const box = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  box.setAttribute("viewBox", `0 0 ${WIDTH} ${HEIGHT}`);
  box.setAttribute("preserveAspectRatio", "none");
  box.setAttribute("role", "img");
  const shown = [low, high].map((value) => Number(value.toPrecision(3)));
  box.setAttribute("aria-label", `first rows, from ${shown[0]} to ${shown[1]}`);
  columns.forEach((column, k) => {
    const last = Math.max(1, column.values.length - 1);
    let pen = "M";
    const points = column.values.map((value, row) => {
      if (value === null) {
        pen = "M";
        return "";
      }
      const y = high > low ? (HEIGHT - 2) * (1 - (value - low) / (high - low)) + 1 : HEIGHT / 2;
      const point = `${pen}${(WIDTH * row / last).toFixed(1)} ${y.toFixed(1)}`;
      pen = "L";
      return point;
    });
    const line = document.createElementNS("http://www.w3.org/2000/svg", "path");
    line.setAttribute("d", points.join(""));
    line.setAttribute("style", `stroke: var(--series-${k % 6})`);
    box.append(line);
  });
  return element("figure", { class: "plot" }, box as unknown as HTMLElement,
    element("figcaption", {}, `${shown[0]} to ${shown[1]}`));
}
