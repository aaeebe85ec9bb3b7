"use strict";
(() => {
  const root = document.documentElement;
  const plots = [];

  /* A colour of the palette as it is now. */
  const colour = (name) => getComputedStyle(root).getPropertyValue(`--${name}`).trim();
  const tint = (name, alpha) => colour(name) + alpha;
  const skeletons = [];
  const repaint = () => {
    plots.forEach((plot) => plot.redraw(false));
    skeletons.forEach((paint) => paint());
  };

  /* --- numbers --- */

  const SUPERSCRIPT = "⁰¹²³⁴⁵⁶⁷⁸⁹";
  const raised = (n) => (n < 0 ? "⁻" : "") + [...String(Math.abs(n))].map((d) => SUPERSCRIPT[d]).join("");
  const minus = (text) => text.replace("-", "−");

  function power(value, mantissa) {
    const exponent = Math.floor(Math.log10(Math.abs(value)) + 1e-9);
    const factor = value / 10 ** exponent;
    const digits = minus(String(+factor.toFixed(mantissa)));
    return digits === "1" ? `10${raised(exponent)}` : `${digits}·10${raised(exponent)}`;
  }

  /* A tick, with the decimals its distance to the next one asks for. */
  function tick(value, step) {
    if (value === 0) return "0";
    const size = Math.abs(value);
    if (size >= 1e6 || step < 1e-5) return power(value, 3);
    let decimals = 0;
    while (decimals < 9 && Math.abs(step * 10 ** decimals - Math.round(step * 10 ** decimals)) > 1e-6) decimals++;
    const text = value.toFixed(decimals);
    return minus(+text === 0 ? text.replace("-", "") : text);
  }

  /* A number that is read out: five significant digits. */
  function readable(value) {
    if (value == null) return "–";
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) return power(value, 3);
    return minus(String(+value.toPrecision(5)));
  }

  const place = (axis, value) => axis.places[Math.round(value)] ?? readable(value);

  /* --- numbers at a logarithmic axis --- */

  /* Fewer decades than this are divided evenly: no three round ratios lie between their ends. */
  const FEW_DECADES = 0.7;
  /* Fewer decades than this get numbers between them. */
  const SOME_DECADES = 1.9;
  const SLACK = 1e-9;
  const range = (first, last) => Array.from({ length: Math.max(0, last - first + 1) }, (_, k) => first + k);
  /* Without the last digits, which are wrong after a multiplication. */
  const exact = (value) => +value.toPrecision(12);

  /* Round numbers from low to high, at most about so many. */
  function logTicks(axis, low, high, most) {
    const [from, to] = [Math.log10(low), Math.log10(high)];
    const span = to - from;
    if (span < FEW_DECADES) return evenTicks(axis, low, high, most);
    const factors = span < SOME_DECADES ? [1, 2, 5] : [1];
    const every = Math.floor(Math.floor(span) / Math.max(1, most)) + 1;
    return range(Math.floor(from), Math.ceil(to))
      .filter((exponent) => exponent % every === 0)
      .flatMap((exponent) => factors.map((factor) => exact(factor * 10 ** exponent)))
      .filter((value) => Math.log10(value) >= from - SLACK && Math.log10(value) <= to + SLACK)
      .filter((value) => !axis.whole || value >= 1);
  }

  function evenTicks(axis, low, high, most) {
    const rough = Math.max((high - low) / Math.max(1, most), axis.whole ? 1 : 0);
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = exact(unit * ([1, 2, 5].find((factor) => factor * unit >= rough * (1 - SLACK)) ?? 10));
    return range(Math.ceil(low / step - SLACK), Math.floor(high / step + SLACK)).map((k) => exact(k * step));
  }

  /* Plain if there are few zeros; evenly divided numbers have the same decimals. */
  function logTexts(ticks) {
    const isEven = ticks.length > 1 && ticks.at(-1) / ticks[0] < 10 ** FEW_DECADES;
    const decimals = isEven ? Math.max(0, -Math.floor(Math.log10(ticks[1] - ticks[0]) + SLACK)) : null;
    return ticks.map((value) => {
      const exponent = Math.floor(Math.log10(value) + SLACK);
      if (exponent < -3 || exponent > 5) return `${exact(value / 10 ** exponent)}e${exponent}`;
      return decimals === null ? String(value) : value.toFixed(decimals);
    });
  }

  /* --- names at an axis --- */

  const FONT = getComputedStyle(document.body).fontFamily;
  const SMALL = 12;
  const MOST_LETTERS = 40;
  const short = (name) => (name.length > MOST_LETTERS ? `${name.slice(0, MOST_LETTERS - 1)}…` : name);
  const ruler = document.createElement("canvas").getContext("2d");

  function textWidth(text) {
    ruler.font = `${SMALL}px ${FONT}`;
    return ruler.measureText(text).width;
  }

  /* How names stand below an axis: level where they fit side by side, else slanted, else upright,
     and where even so there is no room only every k-th. A slanted name ends at its place: there has
     to be room for it to the left of it. */
  function standing(places, slot, leftOf) {
    const lengths = places.map((name) => textWidth(short(name)));
    const longest = Math.max(0, ...lengths);
    if (longest + 8 <= slot) return { angle: 0, every: 1, height: SMALL };
    const slant = Math.SQRT1_2;
    const fits = lengths.every((length, i) => leftOf(i) < 0 || (length + SMALL) * slant <= leftOf(i));
    if (fits && slot * slant >= SMALL + 2) return { angle: 45, every: 1, height: (longest + SMALL) * slant };
    return { angle: 90, every: Math.ceil(SMALL / slot), height: longest };
  }

  /* The same for a plot as it is zoomed. */
  function standingOf(plot, places) {
    const { min, max } = plot.scales.x;
    const slot = plot.bbox.width / uPlot.pxRatio / (max - min);
    return standing(places, slot, (i) => (i < min ? -1 : plot.bbox.left / uPlot.pxRatio + (i - min) * slot));
  }

  function namesBelow(plot, places, shown) {
    const { angle, every } = standingOf(plot, places);
    const right = plot.width - plot.bbox.left / uPlot.pxRatio;
    return shown.map((i) => {
      const name = short(places[i]);
      const at = plot.valToPos(i, "x");
      /* A level name at the edge of a zoomed plot would be cut off. */
      const isCut = angle === 0 && at + textWidth(name) / 2 > right;
      return i % every || isCut ? "" : name;
    });
  }

  /* A chart with turned names is higher, so that its curves keep their room. */
  function withNames({ width, height }, { x: { places } }) {
    if (!places.length) return { width, height };
    const left = 50;
    const slot = (width - left - 12) / places.length;
    const names = standing(places, slot, (i) => left + (i + 0.5) * slot);
    return { width, height: Math.round(height + names.height - SMALL) };
  }

  /* --- points --- */

  /* One column of abscissae for all series: what a series has no point at is undefined, its gaps
     are null. */
  function align(spec) {
    const pick = (key) => (series) => series[key];
    if (spec.columns.length <= 1) {
      return { x: spec.columns[0] ?? [], y: spec.series.map(pick("y")), low: spec.series.map(pick("low")), high: spec.series.map(pick("high")) };
    }
    const rows = spec.columns.flatMap((xs, column) => xs.map((x, row) => ({ x, column, row })));
    rows.sort((a, b) => a.x - b.x);
    const spread = (key) => spec.series.map((series) => series[key].length === 0 ? [] :
      rows.map((r) => (r.column === series.column ? series[key][r.row] : undefined)));
    return { x: rows.map((r) => r.x), y: spread("y").map(widenGaps), low: spread("low"), high: spread("high") };
  }

  /* A gap reaches to the points of its series on both sides. */
  function widenGaps(ys) {
    const gaps = [...ys.keys()].filter((row) => ys[row] === null);
    for (const gap of gaps) {
      for (let row = gap - 1; row >= 0 && ys[row] === undefined; row--) ys[row] = null;
      for (let row = gap + 1; row < ys.length && ys[row] === undefined; row++) ys[row] = null;
    }
    return ys;
  }

  /* --- scales --- */

  const extent = (lists, start = [Infinity, -Infinity]) => {
    let [low, high] = start;
    for (const list of lists) for (const value of list) {
      if (value == null) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
    return [low, high];
  };

  function xRange(spec, data) {
    return (_, low, high) => {
      if (low == null || !(low <= high)) return [0, 1];
      const [first, last] = [data.x[0], data.x[data.x.length - 1]];
      /* uPlot widens a single abscissa before it asks. */
      if (first === last) [low, high] = [first, last];
      if (low !== first || high !== last) return [low, high];
      if (spec.x.range) return spec.x.range;
      if (spec.x.places.length) return [-0.5, spec.x.places.length - 0.5];
      const isLine = spec.series.every((s) => s.mark === "line" || ["broad", "dashed"].includes(s.mark) && s.low.length === 0);
      if (spec.x.log) {
        const ratio = low === high ? 3 : (high / low) ** (isLine ? 0 : 0.04);
        return [low / ratio, high * ratio];
      }
      if (low === high) return [low - 1, high + 1];
      const bars = spec.series.some((s) => s.mark === "bars");
      const pad = bars ? 0.5 * (high - low) / Math.max(1, data.x.length - 1) : isLine ? 0 : 0.03 * (high - low);
      return [low - pad, high + pad];
    };
  }

  function yRange(spec, data) {
    const guides = spec.guides.filter((g) => g.axis === "y").map((g) => g.at);
    return (plot, low, high) => {
      if (spec.y.range) return spec.y.range;
      if (low == null) [low, high] = [Infinity, -Infinity];
      const shown = (lists) => lists.filter((_, i) => plot.series[i + 1].show);
      [low, high] = extent([...shown(data.low), ...shown(data.high), guides], [low, high]);
      if (!(low <= high)) return spec.y.log ? [0.1, 1] : [0, 1];
      if (spec.y.log) return logRange(low, high);
      const fromZero = spec.series.some((s) => s.mark === "bars");
      if (fromZero) [low, high] = [Math.min(0, low), Math.max(0, high)];
      const pad = 0.07 * (high - low) || 0.1 * Math.abs(high) || 1;
      return [fromZero && low === 0 ? 0 : low - pad, fromZero && high === 0 ? 0 : high + pad];
    };
  }

  function logRange(low, high) {
    const [from, to] = [Math.log10(low), Math.log10(high)];
    const pad = to - from > 1e-6 ? 0.05 * (to - from) : 0.5;
    return [10 ** (from - pad), 10 ** (to + pad)];
  }

  /* --- what uPlot does not draw --- */

  function drawBands(plot, spec) {
    const { left, top, width, height } = plot.bbox;
    for (const band of spec.bands) {
      plot.ctx.fillStyle = tint(band.colour, "30");
      for (const [from, to] of band.spans) {
        const start = Math.max(left, plot.valToPos(from, "x", true));
        const end = Math.min(left + width, plot.valToPos(to, "x", true));
        if (end > start) plot.ctx.fillRect(start, top, end - start, height);
      }
    }
  }

  function clipped(plot, draw) {
    const { ctx, bbox } = plot;
    ctx.save();
    ctx.beginPath();
    ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
    ctx.clip();
    draw(ctx, bbox, uPlot.pxRatio);
    ctx.restore();
  }

  /* Between the ends of each two points that follow one another, with no gap between. */
  function fillSpread(plot, xs, low, high, fill) {
    const at = (x, y) => [plot.valToPos(x, "x", true), plot.valToPos(y, "y", true)];
    const rows = [...xs.keys()].filter((row) => low[row] !== undefined);
    plot.ctx.fillStyle = fill;
    plot.ctx.beginPath();
    rows.slice(1).forEach((row, k) => {
      const before = rows[k];
      if ([low[before], high[before], low[row], high[row]].includes(null)) return;
      plot.ctx.moveTo(...at(xs[before], low[before]));
      for (const [x, y] of [[xs[row], low[row]], [xs[row], high[row]], [xs[before], high[before]]]) plot.ctx.lineTo(...at(x, y));
    });
    plot.ctx.fill();
  }

  function drawSpread(plot, spec, data) {
    clipped(plot, (ctx, _, ratio) => {
      spec.series.forEach((series, i) => {
        if (!data.low[i].length || !plot.series[i + 1].show) return;
        if (series.mark === "line") return fillSpread(plot, data.x, data.low[i], data.high[i], tint(series.colour, "60"));
        ctx.strokeStyle = colour(series.colour);
        ctx.lineWidth = 1.5 * ratio;
        const cap = 4 * ratio;
        ctx.beginPath();
        data.x.forEach((x, k) => {
          if (data.low[i][k] == null || data.high[i][k] == null) return;
          const at = plot.valToPos(x, "x", true);
          const [low, high] = [data.low[i][k], data.high[i][k]].map((y) => plot.valToPos(y, "y", true));
          ctx.moveTo(at, low); ctx.lineTo(at, high);
          for (const end of [low, high]) { ctx.moveTo(at - cap, end); ctx.lineTo(at + cap, end); }
        });
        ctx.stroke();
      });
    });
  }

  function drawGuides(plot, spec) {
    clipped(plot, (ctx, { left, top, width, height }, ratio) => {
      ctx.strokeStyle = colour("faded");
      ctx.lineWidth = ratio;
      ctx.setLineDash([5 * ratio, 4 * ratio]);
      for (const { axis, at } of spec.guides) {
        const position = plot.valToPos(at, axis, true);
        ctx.beginPath();
        if (axis === "x") { ctx.moveTo(position, top); ctx.lineTo(position, top + height); }
        else { ctx.moveTo(left, position); ctx.lineTo(left + width, position); }
        ctx.stroke();
      }
    });
  }

  /* --- one chart --- */

  const HEIGHT = 270;
  const LOW_HEIGHT = 230;
  const DOT = { cloud: 3.4, rings: 13, dotted: 6.5 };

  /* Points that no line reaches: gaps or nothing on both sides. */
  function lonely(ys) {
    const known = [...ys.keys()].filter((row) => ys[row] !== undefined);
    const isGap = (place) => ys[known[place]] == null;
    const rows = known.filter((_, place) => !isGap(place) && isGap(place - 1) && isGap(place + 1));
    return rows.length ? rows : null;
  }

  function seriesOptions(series, ys) {
    const { mark } = series;
    const stroke = () => colour(series.colour);
    const dot = DOT[mark];
    const options = { label: series.label, stroke, width: mark === "broad" ? 4.5 : 1.6 };
    const alone = lonely(ys);
    options.points = { show: () => false, filter: () => (mark === "bars" ? null : alone), size: 5, width: 0, stroke: "transparent", fill: stroke };
    if (mark === "dashed") options.dash = [6, 4];
    if (mark === "cloud" || mark === "rings") options.paths = () => null;
    if (mark === "bars") Object.assign(options, { width: 0, fill: () => tint(series.colour, "b0"), paths: uPlot.paths.bars({ size: [0.86, 90] }) });
    if (mark === "cloud") options.points = { show: true, size: dot, width: 0, stroke: "transparent", fill: () => tint(series.colour, "99") };
    if (mark === "rings") options.points = { show: true, size: dot, width: 2.5, stroke, fill: () => tint("paper", "80") };
    if (mark === "dotted") options.points = { show: true, size: dot, width: 0, stroke: "transparent", fill: stroke };
    return options;
  }

  /* As wide as its longest number. */
  function axisSize(plot, values, index, cycle) {
    const axis = plot.axes[index];
    if (cycle > 1) return axis._size;
    const longest = (values ?? []).reduce((a, b) => (b && b.length > a.length ? b : a), "");
    plot.ctx.font = axis.font[0];
    return Math.ceil(axis.ticks.size + axis.gap + plot.ctx.measureText(longest).width / uPlot.pxRatio + 4);
  }

  /* Distances of numbers that stand at an axis of whole numbers. */
  const WHOLE_STEPS = range(0, 15).flatMap((exponent) => [1, 2, 5].map((factor) => factor * 10 ** exponent));

  function axisOptions(axis, isX) {
    const space = isX ? 60 : 34;
    const options = {
      scale: isX ? "x" : "y",
      font: `${SMALL}px ${FONT}`,
      stroke: () => colour("faded"),
      grid: { stroke: () => colour("grid"), width: 1, show: !(isX && axis.places.length) },
      ticks: { stroke: () => colour("grid"), width: 1, size: 4 },
      gap: 5,
      space,
      filter: (_, splits) => splits,
      values: (_, splits, __, ___, step) => splits.map((v) => (v == null ? "" : tick(v, step))),
    };
    if (axis.whole) options.incrs = WHOLE_STEPS;
    if (isX) Object.assign(options, { label: axis.label || null, labelFont: `${SMALL}px ${FONT}`, labelSize: 18, labelGap: 2, size: 26 });
    else options.size = axisSize;
    if (axis.places.length) Object.assign(options, placesOptions(axis.places, isX));
    else if (axis.log) Object.assign(options, logOptions(axis, isX, space));
    return options;
  }

  /* The ticks are given: any step will do, but without one uPlot draws none, and of steps below
     5 it wants to know the decimals. */
  const anyStep = (_, __, low, high) => [Math.max(5, high - low)];

  function logOptions(axis, isX, space) {
    const room = (plot) => (isX ? plot.bbox.width : plot.bbox.height) / uPlot.pxRatio;
    return {
      incrs: anyStep,
      splits: (plot, _, low, high) => logTicks(axis, low, high, Math.floor(room(plot) / space)),
      values: (_, splits) => logTexts(splits),
    };
  }

  function placesOptions(places, isX) {
    const splits = (_, __, low, high) => range(0, places.length - 1).filter((i) => i >= low && i <= high);
    if (!isX) return { incrs: anyStep, splits, values: (_, shown) => shown.map((i) => short(places[i])) };
    return {
      incrs: anyStep,
      splits,
      values: (plot, shown) => namesBelow(plot, places, shown),
      rotate: (plot) => standingOf(plot, places).angle,
      /* Ticks and gap, and a little below. */
      size: (plot) => Math.ceil(standingOf(plot, places).height + 14),
    };
  }

  /* The row a series is read out at: the nearest point of a cloud, else the nearest abscissa. */
  function nearestRow(spec, data) {
    return (plot, index, row) => {
      if (index === 0 || row == null) return row;
      const ys = data.y[index - 1];
      const { mark } = spec.series[index - 1];
      if (mark !== "cloud" && mark !== "rings") {
        for (let d = 0; d < ys.length; d++) {
          if (ys[row - d] != null) return row - d;
          if (ys[row + d] != null) return row + d;
        }
        return null;
      }
      const { left, top } = plot.cursor;
      let [best, least] = [null, 24 ** 2];
      for (let k = 0; k < ys.length; k++) {
        if (ys[k] == null) continue;
        const dx = plot.valToPos(data.x[k], "x") - left;
        if (Math.abs(dx) > 24) continue;
        const distance = dx ** 2 + (plot.valToPos(ys[k], "y") - top) ** 2;
        if (distance < least) [best, least] = [k, distance];
      }
      return best;
    };
  }

  const element = (tag, className, text) => {
    const made = document.createElement(tag);
    made.className = className;
    if (text != null) made.textContent = text;
    return made;
  };

  /* What the cursor points at. */
  function fillReadout(box, plot, spec, data) {
    const lines = [];
    spec.series.forEach((series, i) => {
      const row = plot.cursor.idxs[i + 1];
      if (row == null || !plot.series[i + 1].show) return;
      const isCloud = series.mark === "cloud" || series.mark === "rings";
      const y = readable(data.y[i][row]);
      const spread = data.low[i].length ? ` (${readable(data.low[i][row])} … ${readable(data.high[i][row])})` : "";
      const line = element("div", "");
      const swatch = element("span", `swatch ${series.mark}`);
      swatch.style.setProperty("--c", `var(--${series.colour})`);
      line.append(swatch, element("span", "", series.label), element("b", "", (isCloud ? `${place(spec.x, data.x[row])}, ${y}` : y) + spread));
      lines.push(line);
    });
    if (lines.length && plot.cursor.idx != null && !spec.series.every((s) => s.mark === "cloud" || s.mark === "rings")) {
      const line = element("div", "");
      line.append(element("span", "", spec.x.label), element("b", "", place(spec.x, data.x[plot.cursor.idx])));
      lines.unshift(line);
    }
    box.hidden = lines.length === 0;
    box.replaceChildren(...lines);
  }

  function placeReadout(box, plot) {
    const { left, top } = plot.cursor;
    const [width, height] = [box.offsetWidth, box.offsetHeight];
    const room = plot.over.clientWidth;
    const beside = left + 14 + width <= room ? left + 14 : Math.max(0, left - 14 - width);
    box.style.left = `${Math.min(beside, Math.max(0, room - width))}px`;
    box.style.top = `${Math.max(0, Math.min(top - height - 8, plot.over.clientHeight - height))}px`;
  }

  function options(figure, spec, data, size) {
    const box = element("div", "readout");
    box.hidden = true;
    const isCloud = spec.series.some((s) => s.mark === "cloud" || s.mark === "rings");
    let isOver = false;
    const cursor = {
      drag: { x: true, y: isCloud, uni: 24, dist: 5 },
      dataIdx: nearestRow(spec, data),
      x: !isCloud,
      y: false,
      points: { size: 7, width: 1.5 },
    };
    if (spec.linked) cursor.sync = { key: spec.linked, scales: ["x", null] };
    const scale = (axis, range) => ({ time: false, distr: axis.log ? 3 : 1, range });
    return {
      ...size,
      padding: [10, 12, 0, 0],
      legend: { show: false },
      focus: { alpha: 1 },
      cursor,
      scales: { x: scale(spec.x, xRange(spec, data)), y: scale(spec.y, yRange(spec, data)) },
      axes: [axisOptions(spec.x, true), axisOptions(spec.y, false)],
      series: [{}, ...spec.series.map((series, i) => seriesOptions(series, data.y[i]))],
      hooks: {
        init: [(plot) => {
          plot.over.append(box);
          plot.over.addEventListener("mouseenter", () => { isOver = true; });
          plot.over.addEventListener("mouseleave", () => { isOver = false; box.hidden = true; });
        }],
        drawClear: [(plot) => drawBands(plot, spec)],
        draw: [(plot) => { drawGuides(plot, spec); drawSpread(plot, spec, data); }],
        setCursor: [(plot) => {
          if (!isOver || plot.cursor.left < 0) { box.hidden = true; return; }
          fillReadout(box, plot, spec, data);
          if (!box.hidden) placeReadout(box, plot);
        }],
        setScale: [(plot, key) => followZoom(figure, plot, spec, key)],
      },
    };
  }

  /* --- zoom --- */

  let isFollowing = false;
  const limits = (plot) => ["x", "y"].map((key) => [plot.scales[key].min, plot.scales[key].max]);
  const differ = ([a, b], [c, d]) => Math.abs(a - c) + Math.abs(b - d) > 1e-9 * (Math.abs(d - c) + Number.MIN_VALUE);

  function followZoom(figure, plot, spec, key) {
    if (!figure.whole) return;
    const reset = figure.querySelector(".reset");
    const [x] = limits(plot);
    const isCloud = plot.cursor.drag.y;
    reset.hidden = !(differ(x, figure.whole[0]) || (isCloud && differ(limits(plot)[1], figure.whole[1])));
    if (!spec.linked || key !== "x" || isFollowing) return;
    isFollowing = true;
    for (const other of plots) {
      if (other !== plot && other.linked === spec.linked) other.setScale("x", { min: x[0], max: x[1] });
    }
    isFollowing = false;
  }

  /* --- the page --- */

  const sizeOf = (host, spec) => {
    const width = Math.max(120, Math.floor(host.clientWidth));
    return withNames({ width, height: width < 480 ? LOW_HEIGHT : HEIGHT }, spec);
  };

  function draw(figure) {
    const spec = JSON.parse(figure.querySelector("script").textContent);
    const host = figure.querySelector(".plot");
    const data = align(spec);
    const plot = new uPlot(options(figure, spec, data, sizeOf(host, spec)), [data.x, ...data.y], host);
    plot.linked = spec.linked;
    figure.plot = plot;
    figure.spec = spec;
    plots.push(plot);
    requestAnimationFrame(() => { figure.whole = limits(plot); });
    for (const key of figure.querySelectorAll("button.key")) {
      key.addEventListener("click", () => {
        const index = +key.dataset.series;
        const show = !plot.series[index].show;
        key.setAttribute("aria-pressed", show);
        plot.setSeries(index, { show });
      });
    }
    figure.querySelector(".reset").addEventListener("click", () => plot.setData(plot.data));
    new ResizeObserver(() => {
      const size = sizeOf(host, spec);
      const isOther = size.width !== plot.width || size.height !== plot.height;
      if (isOther && host.clientWidth > 0 && !root.dataset.printing) plot.setSize(size);
    }).observe(host);
  }

  const figures = [...document.querySelectorAll("figure.chart")];
  figures.forEach(draw);

  for (const figure of document.querySelectorAll("figure.skeleton")) skeletons.push(skeleton(figure, colour));

  /* The contents stand open beside the page where there is room, and are one line where there is none. */
  const contents = document.querySelector("nav details");
  const wide = matchMedia("(min-width: 72rem)");
  const unfold = () => { contents.open = wide.matches; };
  wide.addEventListener("change", unfold);
  unfold();
  contents.addEventListener("click", (event) => { if (event.target.tagName === "A") unfold(); });

  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", repaint);
  document.getElementById("theme").addEventListener("click", () => {
    const isDark = root.dataset.theme ? root.dataset.theme === "dark" : dark.matches;
    root.dataset.theme = isDark ? "light" : "dark";
    repaint();
  });

  /* Paper is light, as wide as a page, and hides nothing. */
  let closed = [];
  addEventListener("beforeprint", () => {
    root.dataset.printing = "";
    closed = [...document.querySelectorAll("details:not([open])")];
    closed.forEach((details) => { details.open = true; });
    for (const figure of figures) {
      const isBeside = figure.parentElement.classList.contains("beside");
      const size = { width: isBeside ? 340 : 700, height: isBeside ? 210 : 240 };
      figure.plot.setSize(withNames(size, figure.spec));
    }
    repaint();
  });
  addEventListener("afterprint", () => {
    delete root.dataset.printing;
    closed.forEach((details) => { details.open = false; });
    figures.forEach((figure) => figure.plot.setSize(sizeOf(figure.querySelector(".plot"), figure.spec)));
    repaint();
  });
  root.dataset.ready = figures.length;
})();
