/* The learned chain, moved by the log: forward kinematics, an orthographic view, a player. */
function skeleton(figure, colour) {
  const { joints, resolved, frames, slides, gravity, t, q } = JSON.parse(figure.querySelector("script").textContent);
  const [canvas, play, slider, clock] = ["canvas", "button", "input", "output"].map((tag) => figure.querySelector(tag));
  const pen = canvas.getContext("2d");
  const times = (m, v) => [0, 3, 6].map((r) => m[r] * v[0] + m[r + 1] * v[1] + m[r + 2] * v[2]);
  const plus = (a, b, scale = 1) => a.map((x, k) => x + scale * b[k]);
  const dot = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (v) => v.map((x) => x / Math.hypot(...v));
  const product = (a, b) => [0, 3, 6].flatMap((r) => [0, 1, 2].map((c) => a[r] * b[c] + a[r + 1] * b[c + 3] + a[r + 2] * b[c + 6]));
  const turnZ = (angle) => [Math.cos(angle), -Math.sin(angle), 0, Math.sin(angle), Math.cos(angle), 0, 0, 0, 1];

  /* Origin and direction of each axis in the base: R ← R·Rᵢ·Rz(qᵢ), p ← p + R·pᵢ; a slide p ← p + qᵢ R·z. */
  function axesAt(angles) {
    let [rotation, origin] = [[1, 0, 0, 0, 1, 0, 0, 0, 1], [0, 0, 0]];
    return frames.map((frame, i) => {
      origin = plus(origin, times(rotation, frame.origin));
      rotation = product(product(rotation, frame.rotation), turnZ(slides[i] ? 0 : angles[i]));
      const axis = times(rotation, [0, 0, 1]);
      if (slides[i]) origin = plus(origin, axis, angles[i]);
      return { origin, axis };
    });
  }

  /* Up is against gravity; the view turns about up, and tilts. */
  const up = unit(gravity.map((x) => -x));
  const east = unit(cross(up, Math.abs(up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0]));
  const north = cross(up, east);

  /* What the motion fills: its middle height, and how far it reaches from there. */
  const origins = q.flatMap((angles) => axesAt(angles).map((own) => own.origin));
  const heights = origins.map((p) => dot(p, up));
  const middle = 0.5 * (Math.min(...heights) + Math.max(...heights));
  const reach = 1.15 * Math.max(...origins.map((p) => Math.hypot(...plus(p, up, -middle)))) || 1;
  let [turn, tilt, at] = [0.6, 0.35, 0];

  const state = () => {
    const row = Math.min(Math.floor(at), t.length - 1);
    const next = Math.min(row + 1, t.length - 1);
    const part = at - row;
    return { time: t[row] + part * (t[next] - t[row]), angles: q[row].map((x, i) => x + part * (q[next][i] - x)) };
  };

  function paint() {
    const ratio = devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    const scale = 0.48 * Math.min(width, height) / reach;
    const view = (p) => {
      const [x, y, z] = [east, north, up].map((own) => dot(own, plus(p, up, -middle)));
      const [across, away] = [x * Math.cos(turn) - y * Math.sin(turn), x * Math.sin(turn) + y * Math.cos(turn)];
      return [width / 2 + scale * across, height / 2 - scale * (z * Math.cos(tilt) - away * Math.sin(tilt))];
    };
    const line = (from, to, stroke, thickness, dash = []) => {
      pen.beginPath();
      pen.moveTo(...view(from));
      pen.lineTo(...view(to));
      pen.setLineDash(dash);
      Object.assign(pen, { strokeStyle: stroke, lineWidth: thickness, lineCap: "round" });
      pen.stroke();
    };
    const ground = (x, y) => plus(east.map((own) => own * x * reach), north, y * reach);
    for (const k of [-1, -0.5, 0, 0.5, 1]) {
      line(ground(-1, k), ground(1, k), colour("grid"), 1);
      line(ground(k, -1), ground(k, 1), colour("grid"), 1);
    }
    const { time, angles } = state();
    const axes = axesAt(angles);
    const dash = (i) => resolved[i] ? [] : [9, 9];
    axes.slice(1).forEach(({ origin }, i) => line(axes[i].origin, origin, colour("measured"), 6, dash(i + 1)));
    pen.font = "12px system-ui, sans-serif";
    const taken = [];
    axes.forEach(({ origin, axis }, i) => {
      line(plus(origin, axis, -0.13 * reach), plus(origin, axis, 0.13 * reach), colour(`series-${i % 6}`), 3, dash(i));
      const [x, y] = view(plus(origin, axis, 0.16 * reach));
      /* Names of axes that meet stand below each other. */
      let low = y;
      while (taken.some(([a, b]) => Math.abs(a - x) < 60 && Math.abs(b - low) < 13)) low += 13;
      taken.push([x, low]);
      pen.fillStyle = colour(`series-${i % 6}`);
      pen.textAlign = x > width - 80 ? "right" : "left";
      pen.fillText(joints[i].slice(0, 24), x, low);
    });
    clock.textContent = `${time.toFixed(1)} s`;
    figure.axes = axes;
  }

  /* As fast as the log, but never longer than 20 s. */
  let last = null;
  const rate = (t.length - 1) / Math.min(20, Math.max(1, t.at(-1) - t[0]));
  const isPlaying = () => play.getAttribute("aria-pressed") === "true";
  function step(now) {
    if (!isPlaying()) { last = null; return; }
    at = last === null ? at : (at + rate * (now - last) / 1000) % (t.length - 1);
    last = now;
    slider.value = 1000 * at / (t.length - 1);
    paint();
    requestAnimationFrame(step);
  }
  play.addEventListener("click", () => {
    play.setAttribute("aria-pressed", !isPlaying());
    play.textContent = isPlaying() ? "❚❚ pause" : "▶ play";
    requestAnimationFrame(step);
  });
  slider.addEventListener("input", () => {
    at = slider.value / 1000 * (t.length - 1);
    paint();
  });
  canvas.addEventListener("pointerdown", (event) => canvas.setPointerCapture(event.pointerId));
  canvas.addEventListener("pointermove", (event) => {
    if (!event.buttons) return;
    turn += 0.01 * event.movementX;
    tilt = Math.max(-1.5, Math.min(1.5, tilt + 0.01 * event.movementY));
    paint();
  });
  new ResizeObserver(paint).observe(canvas);
  return paint;
}
