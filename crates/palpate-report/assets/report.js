
/**
 * Draws one arrangement into an untouched <main>, beginning at the time and speed of what was shown before.
 * Returns what ends it and says where it was.
 */
function report(data, before) {
  // ---------------------------------------------------------------- data

  const ending = new AbortController(), signal = ending.signal;
  const byId = (id) => document.getElementById(id);
  const finite = Number.isFinite;
  const RAD = Math.PI / 180;
  const PIECES = 3;
  const count = data.time.length;
  const outline = data.outline;
  const nodes = outline.theta.length;
  const truth = data.truth;
  const pieceClass = (piece) => `piece${piece % PIECES}`;
  const cos = (deg) => Math.cos(deg * RAD), sin = (deg) => Math.sin(deg * RAD);

  // Times that are missing or run backwards take the time before them, so that every search below is sound.
  const time = [];
  for (const t of data.time) time.push(Math.max(finite(t) ? t : -Infinity, time.length ? time[time.length - 1] : -Infinity));
  const firstFinite = time.find(finite) ?? 0;
  time.forEach((t, i) => { if (!finite(t)) time[i] = firstFinite; });
  const start = count ? time[0] : 0, end = count ? time[count - 1] : 0;

  const theta1 = (i) => data.phi1[i] - data.psi[i] - 90;
  const theta2 = (i) => theta1(i) + data.phi2[i] - 180;
  const base = (i) => (data.base ? data.base.map((column) => column[i] ?? 0) : [0, 0, 0, 0]);
  // null - null is 0 in JavaScript: a missing value must not pass for a number.
  const minus = (a, b) => (finite(a) && finite(b) ? a - b : NaN);

  /** Index of the last sample at or before a time. */
  function indexAt(t) {
    let low = 0, high = count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (time[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }

  /** The sample nearest to a time. */
  function nearestAt(t) {
    const i = indexAt(t);
    return i + 1 < count && time[i + 1] - t < t - time[i] ? i + 1 : i;
  }

  /** A column between two samples; held where a jump or a gap lies between them. */
  function between(column, i, t) {
    const j = i + 1;
    const a = column[i], b = column[j];
    if (j >= count || !finite(a) || !finite(b) || data.piece[i] !== data.piece[j] || !(time[j] > time[i])) return a;
    return a + (b - a) * (t - time[i]) / (time[j] - time[i]);
  }

  const spacing = nodes > 0 ? 360 / nodes : 360;
  const nodeAt = (theta) => {
    const place = Math.round((theta - (outline.theta[0] || 0)) / spacing);
    return ((place % nodes) + nodes) % nodes;
  };
  // What is known, what a contact itself passed over, and what follows from that by symmetry.
  const known = outline.touches.map((touches) => touches > 0);
  const felt = known.map((yes, node) => yes && outline.itself[node]);
  const copied = known.map((yes, node) => yes && !felt[node]);
  const LINES = ["unfelt", "copied", "felt"];
  const lineOf = (node) => (felt[node] ? 2 : copied[node] ? 1 : 0);

  // When, and in which piece, each part of the boundary was first felt.
  const firstFelt = new Array(nodes).fill(Infinity);
  const firstPiece = new Array(nodes).fill(0);
  {
    const mark = (node, i) => {
      if (felt[node] && time[i] < firstFelt[node]) { firstFelt[node] = time[i]; firstPiece[node] = data.piece[i]; }
    };
    for (const [angle, seen] of [[theta1, data.s1], [theta2, data.s2]]) {
      for (let i = 0; nodes && i < count; i++) {
        const here = angle(i);
        if (!finite(here) || !finite(data.psi[i]) || !finite(seen[i])) continue;
        mark(nodeAt(here), i);
        const before = i && data.piece[i - 1] === data.piece[i] && finite(seen[i - 1]) ? angle(i - 1) : NaN;
        const steps = Math.abs(here - before) / spacing;
        if (steps < 120 / spacing) for (let k = 1; k < steps; k++) mark(nodeAt(before + (here - before) * k / steps), i);
      }
    }
    // What the log felt only just, at the edge of a node, appears with its neighbour.
    for (let node = 0; node < nodes; node++) {
      for (let reach = 1; felt[node] && !finite(firstFelt[node]) && reach <= 6; reach++) {
        for (const near of [(node + reach) % nodes, (node + nodes - reach) % nodes]) {
          if (finite(firstFelt[near])) { firstFelt[node] = firstFelt[near]; firstPiece[node] = firstPiece[near]; }
        }
      }
      if (felt[node] && !finite(firstFelt[node])) { firstFelt[node] = end; firstPiece[node] = data.piece[count - 1] ?? 0; }
    }
  }

  // ---------------------------------------------------------------- what friction leaves to the centre of mass

  /** The part of a polygon where x nx + y ny <= limit. */
  function clipped(polygon, nx, ny, limit) {
    const beyond = polygon.map(([x, y]) => x * nx + y * ny - limit);
    if (beyond.every((value) => value <= 0)) return polygon;
    return polygon.flatMap((here, k) => {
      const next = (k + 1) % polygon.length, kept = beyond[k] <= 0 ? [here] : [];
      if ((beyond[k] <= 0) === (beyond[next] <= 0)) return kept;
      const share = beyond[k] / (beyond[k] - beyond[next]), there = polygon[next];
      return [...kept, [here[0] + share * (there[0] - here[0]), here[1] + share * (there[1] - here[1])]];
    });
  }
  /** For each sample the polygon that it and those before leave to the centre of mass, in the frame of the object. */
  const left = (() => {
    if (!data.strips) return null;
    let polygon = outline.x.map((x, node) => [x, outline.y[node]]).filter(([x, y]) => finite(x) && finite(y));
    return data.strips[0].map((low, i) => {
      const high = data.strips[1][i], band = finite(data.comBand[i]) ? data.comBand[i] : 0;
      if (finite(low) && finite(high) && finite(data.psi[i])) {
        // Noise must not shut out the estimate, which all samples together made.
        const nx = cos(data.psi[i]), ny = -sin(data.psi[i]);
        polygon = clipped(polygon, nx, ny, Math.max(high, 0) + band);
        polygon = clipped(polygon, -nx, -ny, -Math.min(low, 0) + band);
      }
      return polygon;
    });
  })();

  // ---------------------------------------------------------------- small tools

  const SVG = "http://www.w3.org/2000/svg";
  function draw(parent, tag, attributes = {}, text) {
    const element = document.createElementNS(SVG, tag);
    for (const name in attributes) element.setAttribute(name, attributes[name]);
    if (text !== undefined) element.textContent = text;
    parent.appendChild(element);
    return element;
  }

  const px = (value) => Math.round(value * 10) / 10;
  const crisp = (value) => Math.round(value) + 0.5;

  /** Path through points, broken where one is missing. */
  function path(points) {
    let d = "", pen = false;
    for (const [x, y] of points) {
      if (!finite(x) || !finite(y)) { pen = false; continue; }
      d += `${pen ? "L" : "M"}${px(x)} ${px(y)}`;
      pen = true;
    }
    return d;
  }

  function extent(columns, keep = () => true) {
    let low = Infinity, high = -Infinity;
    for (const column of columns) column.forEach((value, i) => {
      if (finite(value) && keep(i)) { low = Math.min(low, value); high = Math.max(high, value); }
    });
    return low <= high ? [low, high] : [0, 1];
  }

  function quantile(values, q) {
    const sorted = values.filter(finite).sort((a, b) => a - b);
    return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))] : NaN;
  }

  /** A round step that cuts `span` into at most about `pieces`. */
  function roundStep(span, pieces) {
    if (!(span > 0) || !finite(span)) return 1;
    const raw = span / Math.max(1, pieces), power = 10 ** Math.floor(Math.log10(raw));
    return [1, 2, 2.5, 5, 10].map((m) => m * power).find((step) => step >= raw * 0.999) || raw;
  }

  function ticks(low, high, pieces, step = roundStep(high - low, pieces)) {
    const values = [];
    for (let k = Math.ceil(low / step - 1e-9); k * step <= high + step * 1e-9 && values.length < 50; k++) values.push(k * step);
    return values;
  }

  const tidy = (text) => text.replace(/^-(0(\.0*)?)$/, "$1").replace("-", "\u2212");
  /** 1.2e-5 as people write it: 1.2 × 10⁻⁵. */
  function powerOfTen(value, decimals) {
    const [mantissa, exponent] = value.toExponential(decimals).split("e");
    const raised = [...exponent].map((c) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(c)] ?? "").join("");
    return `${tidy(mantissa)}\u00a0×\u00a010${raised}`;
  }
  function fixed(value, decimals) {
    if (!finite(value)) return "–";
    return Math.abs(value) >= 1e7 ? powerOfTen(value, 2) : tidy(value.toFixed(decimals));
  }
  /** Three significant digits. */
  function short(value) {
    if (!finite(value)) return "–";
    const size = Math.abs(value);
    if (size >= 1e7 || (size > 0 && size < 1e-4)) return powerOfTen(value, 1);
    return fixed(value, size === 0 ? 0 : Math.max(0, Math.min(6, 2 - Math.floor(Math.log10(size)))));
  }
  const tickLabel = (value, step) => fixed(value, Math.max(0, Math.min(6, -Math.floor(Math.log10(step) + 1e-9)
    + (/^[^1-9]*25/.test(step.toExponential()) || /^2\.5/.test(step.toExponential()) ? 1 : 0))));

  /** A length in mm for a read-out, in µm where that reads better. */
  const lengthText = (mm) => (finite(mm) && Math.abs(mm) < 0.1 ? `${short(mm * 1e3)} µm` : `${short(mm)} mm`);

  /** Read-out: pairs of label and value; only numbers and fixed words come in here. */
  function readout(id, parts) {
    byId(id).innerHTML = parts.map(([label, value]) => `<span>${label} <b>${value}</b></span>`).join("");
  }

  /** Draws all figures again, at the width of a sheet of paper or (null) of their boxes. */
  const drawAgain = [];
  const SHEET = 660;
  window.addEventListener("beforeprint", () => drawAgain.forEach((refresh) => refresh(SHEET)), { signal });
  window.addEventListener("afterprint", () => drawAgain.forEach((refresh) => refresh()), { signal });

  /** Keeps a drawing at the width of its box; the height is set before, so that nothing moves. */
  function figure(host, height, render) {
    let width = 0;
    const refresh = (wanted) => {
      const now = wanted || Math.floor(host.clientWidth);
      if (now < 120 || now === width) return;
      width = now;
      const high = height(width);
      host.style.height = `${high}px`;
      host.replaceChildren();
      const svg = draw(host, "svg", { viewBox: `0 0 ${width} ${high}`, role: "img", "aria-label": host.dataset.name });
      render(svg, width, high);
    };
    refresh();
    drawAgain.push(refresh);
    const observer = new ResizeObserver(() => refresh());
    observer.observe(host);
    signal.addEventListener("abort", () => observer.disconnect());
  }

  /** Lets the arrow keys go along the boundary; `show(node)` shows a place of it, null none. */
  function alongBoundary(host, show) {
    let here = null;
    const degree = Math.max(1, Math.round(nodes / 360));
    const attributes = { tabindex: "0", role: "slider", "aria-label": `${host.dataset.name}; θ in degrees`, "aria-valuemin": "0", "aria-valuemax": "360", "aria-valuenow": "0" };
    for (const name in attributes) host.setAttribute(name, attributes[name]);
    host.addEventListener("keydown", (event) => {
      const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key] ?? { Home: 0, End: 0, Escape: 0 }[event.key];
      if (way === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      event.stopPropagation();
      if (event.key === "Escape") here = null;
      else if (way === 0) here = event.key === "Home" ? 0 : nodes - 1;
      else here = here === null ? 0 : (here + way * degree * (event.shiftKey ? 10 : 1) + nodes) % nodes;
      show(here);
    });
    host.addEventListener("blur", () => { if (here !== null) show(here = null); });
    nodeViews.push((node) => {
      here = node;
      if (node === null) { host.removeAttribute("aria-valuetext"); return; }
      host.setAttribute("aria-valuenow", String(Math.round(outline.theta[node])));
      host.setAttribute("aria-valuetext", boundaryWords(node).map(([label, value]) => `${label} ${value}`).join(", "));
    });
  }

  function empty(host, text) {
    host.style.height = "10rem";
    const note = document.createElement("div");
    note.className = "empty";
    note.textContent = text;
    host.replaceChildren(note);
  }

  // ---------------------------------------------------------------- what is shown at the moment

  /** Views that follow the time; each gets (time, index). */
  const timeViews = [];
  /** Views that follow a hovered time (null: back to the time of the stage). */
  const hoverViews = [];
  /** Views that follow a hovered place on the boundary (null: none). */
  const nodeViews = [];
  let now = end, hovered = null;

  function setTime(t) {
    now = Math.min(end, Math.max(start, t));
    const i = count ? indexAt(now) : 0;
    for (const view of timeViews) view(now, i);
    if (hovered === null) for (const view of hoverViews) view(now, count ? nearestAt(now) : 0, false);
  }
  function hover(t) {
    hovered = t;
    const shown = t ?? now;
    for (const view of hoverViews) view(shown, count ? nearestAt(shown) : 0, t !== null);
  }
  function hoverNode(node) { for (const view of nodeViews) view(node); }

  // ---------------------------------------------------------------- charts

  /**
   * A chart over time or θ with an optional lane below for band and error.
   * spec: { host, x, xUnit, xDomain, xTicks, height, unit, y, yFactor, paint(layer, X, Y), ends, lane, right, jumps, onMove, onLeave, onPress }
   */
  function chart(spec) {
    const host = byId(spec.host);
    host.classList.add("scrub");
    const laneHeight = spec.lane ? 62 : 0, gap = (spec.lane ? 24 : 0) + (spec.strips || 0), bottom = 22, top = spec.caption ? 22 : 12;
    const cursors = { play: null, hover: null, X: null };
    figure(host, () => spec.height + laneHeight + gap + bottom + top, (svg, width, high) => {
      const left = 46, right = Math.max(left + 40, width - (spec.right || 14));
      const yTop = top, yBottom = top + spec.height;
      const [x0, x1] = spec.xDomain, span = x1 > x0 ? x1 - x0 : 1;
      const X = (value) => (finite(value) ? left + (value - x0) / span * (right - left) : NaN);
      let [low, high2] = spec.y;
      if (!(high2 > low)) { low -= 0.5 * Math.max(1e-6, Math.abs(low)); high2 += 0.5 * Math.max(1e-6, Math.abs(high2)); }
      const Y = (value) => (finite(value) ? yBottom - (value - low) / (high2 - low) * spec.height : NaN);

      const clip = `clip-${spec.host}`;
      const defs = draw(svg, "defs");
      draw(draw(defs, "clipPath", { id: clip }), "rect", { x: left - 2, y: yTop - 6, width: right - left + 4, height: spec.height + 12 });

      // Grid: horizontal lines with the unit at the uppermost, time along the bottom.
      const step = spec.yStep ? spec.yStep(low, high2) : roundStep(high2 - low, Math.max(2, spec.height / 42));
      const levels = ticks(low, high2, 0, step);
      levels.forEach((value) => {
        const y = crisp(Y(value));
        draw(svg, "path", { class: value === 0 ? "zero" : "grid", d: `M${left} ${y}H${right}` });
        draw(svg, "text", { x: left - 8, y: y + 4, "text-anchor": "end" }, tickLabel(value * (spec.yFactor || 1), step * (spec.yFactor || 1)));
      });
      const laneTop = yBottom + gap, laneBottom = laneTop + laneHeight;
      const floor = spec.lane ? laneBottom : yBottom;
      const xStep = spec.xTicks || roundStep(span, Math.max(2, (right - left) / 84));
      const times = ticks(x0, x0 + span, 0, xStep);
      times.forEach((value, k) => {
        const x = crisp(X(value));
        draw(svg, "path", { class: "rule", d: `M${x} ${floor}v4` });
        const last = k === times.length - 1;
        draw(svg, "text", { x, y: floor + 17, "text-anchor": "middle" }, tickLabel(value, xStep) + (last ? spec.xUnit : ""));
      });
      draw(svg, "path", { class: "rule", d: `M${left} ${crisp(floor)}H${right}` });

      if (spec.jumps) for (const jump of data.jumps) {
        if (jump >= x0 && jump <= x1) draw(svg, "path", { class: "jump", d: `M${crisp(X(jump))} ${yTop - 6}V${floor}` });
      }

      if (spec.caption) draw(svg, "text", { x: left, y: 10, class: "strong" }, spec.caption);
      const layer = draw(svg, "g", { "clip-path": `url(#${clip})` });
      spec.paint(layer, X, Y, { left, right, top: yTop, bottom: yBottom, svg });
      if (spec.lane) paintLane(svg, spec, X, left, right, laneTop, laneBottom);

      const cursor = (name) => draw(svg, "path", { class: name, d: `M0.5 ${yTop - 6}V${floor}`, visibility: "hidden" });
      cursors.play = cursor("play-cursor");
      cursors.hover = cursor("hover-cursor");
      cursors.X = X;
      cursors.value = (clientX) => {
        const box = host.getBoundingClientRect();
        const place = (clientX - box.left) * (width / (box.width || width));
        return Math.min(x1, Math.max(x0, x0 + (place - left) / (right - left) * span));
      };
      if (spec.rendered) spec.rendered({ svg, X, Y });
      setTime(now);
    });

    const place = (line, value) => {
      if (!line) return;
      const x = value === null ? NaN : cursors.X(value);
      line.setAttribute("visibility", finite(x) ? "visible" : "hidden");
      if (finite(x)) line.setAttribute("transform", `translate(${Math.round(x)} 0)`);
    };
    const move = (event) => { if (cursors.value) spec.onMove(cursors.value(event.clientX)); };
    let pressed = false;
    host.addEventListener("pointermove", (event) => { move(event); if (pressed && spec.onPress) spec.onPress(cursors.value(event.clientX)); });
    host.addEventListener("pointerdown", (event) => {
      if (!cursors.value) return;
      pressed = true;
      if (host.setPointerCapture) try { host.setPointerCapture(event.pointerId); } catch { /* not a live pointer */ }
      if (spec.onPress) spec.onPress(cursors.value(event.clientX));
    });
    const release = () => { pressed = false; };
    host.addEventListener("pointerup", release);
    host.addEventListener("pointercancel", () => { release(); spec.onLeave(); });
    host.addEventListener("pointerleave", (event) => { if (!pressed && !(spec.keepsTap && event.pointerType === "touch")) spec.onLeave(); });
    return { play: (value) => place(cursors.play, value), hover: (value) => place(cursors.hover, value) };
  }

  /** The strip below a chart: symmetrical 95 % band, and error lines where the truth is known. */
  function paintLane(svg, spec, X, left, right, top, bottom) {
    const lane = spec.lane, middle = (top + bottom) / 2, half = (bottom - top) / 2;
    const bands = lane.band.map((value, i) => (!lane.keep || lane.keep(i) ? value : NaN));
    const errors = lane.errors.flatMap((error) => error.values.filter((value, i) => finite(value) && (!lane.keep || lane.keep(i))).map(Math.abs));
    // An orientation that is not known at all would leave the others no room.
    const known = lane.unit === "°" ? bands.filter((band) => band < 180) : bands;
    const most = Math.max(1.25 * (quantile(known, 0.98) || 0), 1.1 * (quantile(errors, 0.995) || 0)) || 1;
    const micro = lane.unit === "mm" && most < 0.2;
    const factor = micro ? 1e3 : 1, unit = micro ? "µm" : lane.unit;
    const step = roundStep(most * factor, 1.4) / factor;
    const level = step <= most ? step : step / 2;
    const Y = (value) => (finite(value) ? middle - value / most * half : NaN);
    const clip = `clip-lane-${spec.host}`;
    draw(draw(svg, "clipPath", { id: clip }), "rect", { x: left - 1, y: top, width: right - left + 2, height: bottom - top });
    for (const value of [level, 0, -level]) {
      const y = crisp(Y(value));
      draw(svg, "path", { class: value === 0 ? "zero" : "grid", d: `M${left} ${y}H${right}` });
      const text = tickLabel(Math.abs(value) * factor, step * factor);
      draw(svg, "text", { x: left - 8, y: y + 4, "text-anchor": "end" }, value === 0 ? "0" : value > 0 ? `+${text}` : `\u2212${text}`);
    }
    const layer = draw(svg, "g", { "clip-path": `url(#${clip})` });
    const clamp = (value) => Math.max(-2 * most, Math.min(2 * most, value));
    let run = [];
    const flush = () => {
      if (run.length) {
        const upper = run.map(([x, w]) => [x, Y(clamp(w))]), lower = run.map(([x, w]) => [x, Y(clamp(-w))]).reverse();
        draw(layer, "path", { class: "band lane", d: `${path(upper.concat(lower))}Z` });
      }
      run = [];
    };
    lane.band.forEach((value, i) => {
      if (i && lane.breaks && lane.breaks(i)) flush();
      if (finite(value) && finite(spec.x[i])) run.push([X(spec.x[i]), value]); else flush();
    });
    flush();
    for (const error of lane.errors) draw(layer, "path", { class: `error ${error.class || ""} ${error.values.length > 1000 ? "dense" : ""}`, d: path(error.values.map((value, i) => [X(spec.x[i]), Y(clamp(finite(value) ? value : NaN))])) });
    const words = draw(svg, "text", { x: left, y: top - 6 }, `95 % band${lane.errors.length ? " and actual error" : ""}${lane.errors.some((error) => error.name) ? " in" : ""}`);
    for (const error of lane.errors) if (error.name) draw(words, "tspan", { class: `name ${error.class || ""}` }, ` ${error.name}`);
    draw(words, "tspan", {}, `, ${unit}`);
  }

  const newPiece = (i) => data.piece[i] !== data.piece[i - 1];
  /** What the contacts do under friction, a strip for each palm: full where the object sticks, a line where it slides. */
  function paintModes(svg, X, left, top) {
    data.modes.forEach((modes, palm) => {
      const y = top + 11 * palm;
      draw(svg, "text", { x: left - 8, y: y + 7, "text-anchor": "end", class: "small" }, `palm ${palm + 1}`);
      for (let from = 0; from < count;) {
        let to = from + 1;
        while (to < count && (modes[to] === 0) === (modes[from] === 0) && (modes[to] === null) === (modes[from] === null)) to++;
        const [x0, x1] = [X(time[from]), X(time[Math.min(to, count - 1)])], sticks = modes[from] === 0;
        if (modes[from] !== null) draw(svg, "rect", {
          class: `mode palm${palm + 1}`, x: x0, width: Math.max(0.5, x1 - x0), y: sticks ? y : y + 3, height: sticks ? 7 : 1,
        });
        from = to;
      }
    });
  }
  const doing = (mode) => (mode === 0 ? "sticks" : finite(mode) ? "slides" : "?");
  /** A line over time, one path per piece. */
  function paintPieces(layer, column, X, Y, kind = "") {
    let from = 0;
    for (let i = 1; i <= count; i++) {
      if (i < count && !newPiece(i)) continue;
      const points = [];
      for (let k = from; k < i; k++) points.push([X(time[k]), Y(column[k])]);
      if (points.length === 1) points.push(points[0]);
      draw(layer, "path", { class: `line ${kind} ${pieceClass(data.piece[from])}`, d: path(points) });
      from = i;
    }
  }
  /** The truth over time, broken where the estimate jumps. */
  function paintTruth(layer, column, X, Y) {
    draw(layer, "path", { class: "truth", d: path(column.flatMap((value, i) => (i && newPiece(i) ? [[NaN, NaN]] : []).concat([[X(time[i]), Y(value)]]))) });
  }
  const overTime = { x: time, xUnit: " s", xDomain: [start, end], jumps: true, onMove: hover, onLeave: () => hover(null), onPress: (t) => { stop(); setTime(t); } };
  const padded = ([low, high], share = 0.06) => { const pad = (high - low) * share || 0.5; return [low - pad, high + pad]; };
  function follow(view, read) {
    timeViews.push((t) => view.play(t));
    hoverViews.push((t, i, active) => { view.hover(active ? t : null); if (read) read(i); });
  }
  const clock = (t) => `${fixed(t, end - start < 20 ? 2 : end - start < 2000 ? 1 : 0)} s`;

  const degreeStep = (low, high) => {
    const raw = (high - low) / 5;
    return [15, 30, 45, 90, 180, 360].find((step) => raw > 7.5 && step >= raw) || roundStep(high - low, 4);
  };

  // ---------------------------------------------------------------- ψ, centre of mass, residuals

  /** What the log says, a line for each palm, with a dot at the time shown. */
  function readings(host, names, columns, unit, yStep) {
    let dots = null, scales = null;
    const view = chart({
      ...overTime, host, height: 150, right: 34, y: padded(extent(columns)), yStep,
      paint(layer, X, Y, box) {
        const ends = columns.map((column) => Y(column.findLast(finite)));
        const close = Math.abs(ends[0] - ends[1]) < 15;
        columns.forEach((column, k) => {
          draw(layer, "path", { class: `reading palm${k + 1}`, d: path(column.map((value, i) => [X(time[i]), Y(value)])).replace(/M[^ML]+/g, "$&h0") });
          const y = ends[k] + (close ? (ends[k] > ends[1 - k] || (ends[0] === ends[1] && k) ? 8 : -8) : 0);
          if (finite(y)) draw(box.svg, "text", { x: box.right + 8, y: y + 4, class: `strong palm${k + 1}` }, names[k]);
        });
      },
      rendered({ svg, X, Y }) {
        scales = { X, Y };
        dots = columns.map((_, k) => draw(svg, "circle", { class: `dot contact${k + 1}`, r: 4.5, visibility: "hidden" }));
      },
    });
    timeViews.push((t, i) => columns.forEach((column, k) => {
      if (!dots) return;
      const x = scales.X(t), y = scales.Y(between(column, i, t));
      dots[k].setAttribute("visibility", finite(x) && finite(y) ? "visible" : "hidden");
      if (finite(y)) { dots[k].setAttribute("cx", px(x)); dots[k].setAttribute("cy", px(y)); }
    }));
    follow(view, (i) => readout(`${host}-readout`, [
      ["t", clock(time[i])], ...columns.map((column, k) => [names[k], finite(column[i]) ? `${fixed(column[i], 2)}${unit}` : "no contact"]),
    ]));
  }

  function timeCharts() {
    readings("angles", ["φ₁", "φ₂"], [data.phi1, data.phi2], "°", degreeStep);
    readings("contacts", ["s₁", "s₂"], [data.s1, data.s2], " mm");
    const trueShown = truth && truth.psi.some(finite);
    const truePsi = trueShown ? data.psi.map((value, i) => minus(value, truth.psiError[i])) : null;
    const end1 = (layer, box, text, x, y) => draw(box.svg, "text", { x, y: y + 4, class: "strong halo" }, text);

    const psi = chart({
      ...overTime, host: "psi", height: 190, yStep: degreeStep, strips: data.modes ? 26 : 0,
      y: padded(withTruth([data.psi], truePsi || [])),
      paint(layer, X, Y, box) {
        if (data.modes) paintModes(box.svg, X, box.left, box.bottom + 7);
        paintPieces(layer, data.psi, X, Y);
        if (truePsi) paintTruth(layer, truePsi, X, Y);
      },
      lane: { unit: "°", band: data.psiBand, breaks: newPiece, errors: trueShown ? [{ values: truth.psiError }] : [] },
    });
    follow(psi, (i) => readout("psi-readout", [
      ["t", clock(time[i])],
      ["ψ", data.psiBand[i] >= 180 ? "not known" : `${fixed(data.psi[i], 2)}° ± ${short(data.psiBand[i])}°`],
      ...(trueShown ? [["error", `${short(truth.psiError[i])}°`]] : []),
      ...(data.modes ? data.modes.map((modes, palm) => [`palm ${palm + 1}`, doing(modes[i])]) : []),
    ]));
    byId("modes-note").hidden = byId("cones-note").hidden = !data.modes;

    const com = chart({
      ...overTime, host: "com", height: 190, right: 28,
      y: padded(withTruth([data.x, data.y], trueShown ? truth.x.concat(truth.y) : [])),
      paint(layer, X, Y, box) {
        for (const [column, name, trueColumn, kind] of [[data.x, "x", truth && truth.x, ""], [data.y, "y", truth && truth.y, "dashed"]]) {
          paintPieces(layer, column, X, Y, kind);
          if (trueShown) paintTruth(layer, trueColumn, X, Y);
          const y = Y(column[count - 1]);
          if (finite(y)) end1(layer, box, name, box.right + 8, y);
        }
      },
      lane: {
        unit: "mm", band: data.comBand, breaks: newPiece,
        errors: trueShown ? [{ values: truth.xError, name: "x" }, { values: truth.yError, name: "y", class: "second" }] : [],
      },
    });
    follow(com, (i) => readout("com-readout", [
      ["x", `${fixed(data.x[i], 2)}`],
      ["y", `${fixed(data.y[i], 2)} mm ± ${lengthText(data.comBand[i])}`],
      ...(trueShown ? [["error", `${lengthText(Math.hypot(truth.xError[i] ?? NaN, truth.yError[i] ?? NaN))}`]] : []),
    ]));

    const worst = Math.max(...extent(data.residuals.map((sensor) => sensor.values)).map(Math.abs));
    data.residuals.forEach((sensor, k) => {
      const sd = finite(data.sensorSd) && data.sensorSd > 0 ? data.sensorSd : sensor.rms;
      const reach = Math.max(finite(sd) && sd > 0 ? 4 * sd : 0, Math.min(worst * 1.05, finite(sd) && sd > 0 ? 10 * sd : Infinity)) || 1;
      const word = ["one", "two"][k], micro = reach < 0.2;
      const view = chart({
        ...overTime, host: `residual${k + 1}`, height: 112, caption: `palm ${k + 1}, ${micro ? "µm" : "mm"}`, right: 118,
        y: [-reach, reach], yFactor: micro ? 1e3 : 1, yStep: (low, high) => roundStep(high - low, 5),
        paint(layer, X, Y, box) {
          const dots = sensor.values.map((value, i) => {
            const x = X(time[i]), y = Y(finite(value) ? Math.max(-reach, Math.min(reach, value)) : NaN);
            return finite(x) && finite(y) ? `M${px(x)} ${px(y)}h0` : "";
          }).join("");
          draw(layer, "path", { class: `cloud ${word}`, d: dots });
          for (const level of [-2 * sd, 2 * sd]) if (finite(Y(level))) draw(layer, "path", { class: "sigma", d: `M${box.left} ${crisp(Y(level))}H${box.right}` });
          // Histogram on the same vertical axis, with the bell curve that the noise promises.
          const bins = sensor.histogram.length, tall = sensor.reach * 2 / bins;
          const peak = Math.max(...sensor.histogram, sensor.count * tall / (sd * 2.5066) || 0, 1);
          const wide = 62, x0 = box.right + 10;
          const bars = draw(box.svg, "g", { class: `bars ${word}` });
          sensor.histogram.forEach((n, bin) => {
            const from = Y(-sensor.reach + bin * tall), to = Y(-sensor.reach + (bin + 1) * tall);
            if (n && finite(from)) draw(bars, "rect", { x: x0, y: px(to), width: px(n / peak * wide), height: px(Math.max(0.5, from - to - 0.4)) });
          });
          const bell = [];
          for (let u = -4; u <= 4.001; u += 0.125) bell.push([x0 + wide * sensor.count * tall / (sd * 2.5066) * Math.exp(-u * u / 2) / peak, Y(u * sd)]);
          draw(box.svg, "path", { class: "bell", d: path(bell) });
          draw(box.svg, "path", { class: "rule", d: `M${crisp(x0 - 1)} ${box.top}V${box.bottom}` });
          if (finite(Y(2 * sd))) draw(box.svg, "text", { x: x0 + wide + 6, y: Y(2 * sd) + 4 }, "+2\u03c3");
          if (finite(Y(-2 * sd))) draw(box.svg, "text", { x: x0 + wide + 6, y: Y(-2 * sd) + 4 }, "\u22122\u03c3");
        },
      });
      follow(view, null);
    });
    const share = (sensor) => (sensor.count ? `${fixed(100 * sensor.beyond2 / sensor.count, 1)} % beyond 2σ` : "no contact seen");
    hoverViews.push((t, i, active) => readout("residual-readout", active
      ? [["t", clock(time[i])], ["palm 1", lengthText(data.residuals[0].values[i])], ["palm 2", lengthText(data.residuals[1].values[i])]]
      : data.residuals.map((sensor, k) => [`palm ${k + 1} RMS`, `${lengthText(sensor.rms)}</b>, ${share(sensor)}<b>`])));
  }

  // ---------------------------------------------------------------- shape

  /** Runs of consecutive nodes of one kind on the circle, as [kind, first, last]; neighbours share their end. */
  function runs(kind) {
    const found = [];
    let from = 0;
    for (let node = 1; node <= nodes; node++) {
      if (node < nodes && kind(node) === kind(from)) continue;
      found.push([kind(from), from, node]);
      from = node;
    }
    return found;
  }
  function runPath(first, last, place) {
    const points = [];
    for (let node = first; node <= last; node++) points.push(place(node % nodes));
    return path(points);
  }

  /** A column of the truth, where it is not so far off that what was found would shrink to nothing. */
  const near = (column, [low, high]) => column.filter((value) => finite(value) && value > low - (high - low) && value < high + (high - low));
  const withTruth = (found, actual) => { const range = extent(found); return extent([range, near(actual, range)]); };

  const whole = ([x, y]) => finite(x) && finite(y);
  const ring = (place) => `${path([...Array(nodes).keys()].map(place).filter(whole))}Z`;

  /** How much wider the band is drawn, so that it can be seen: 1, 2, 5, 10 ... */
  const radius = finite(data.meanRadius) && data.meanRadius > 0 ? data.meanRadius : 1;
  const exaggeration = (() => {
    const wide = quantile(outline.band.filter((_, node) => known[node]), 0.9);
    if (!(wide > 0)) return 1;
    let factor = 1;
    for (const next of [2, 5, 10, 20, 50, 100, 200, 500, 1000]) if (wide * next <= 0.07 * radius) factor = next;
    return factor;
  })();
  const widest = 0.2 * radius;
  const drawnBand = (node) => Math.min(widest, (outline.band[node] ?? NaN) * exaggeration);
  const cut = outline.band.some((band) => band * exaggeration > widest);

  function comMark(parent, x, y, size = 7) {
    const mark = draw(parent, "g", { transform: `translate(${px(x)} ${px(y)})` });
    draw(mark, "circle", { class: "com-disc", r: size });
    draw(mark, "path", { class: "com-quarter", d: `M0 0V${-size}A${size} ${size} 0 0 1 ${size} 0ZM0 0V${size}A${size} ${size} 0 0 1 ${-size} 0Z` });
    return mark;
  }
  const CENTROID = "M-5.5 0H5.5M0 -5.5V5.5";

  function scaleBar(svg, scale, right, bottom) {
    const mm = [1, 2, 5].flatMap((m) => [-3, -2, -1, 0, 1, 2, 3, 4].map((e) => m * 10 ** e)).sort((a, b) => b - a).find((length) => length * scale <= 96);
    if (!mm) return;
    const x = Math.round(right - mm * scale) + 0.5, y = Math.round(bottom) + 0.5;
    draw(svg, "path", { class: "scale", d: `M${x} ${y - 4}V${y}H${Math.round(right) + 0.5}V${y - 4}` });
    draw(svg, "text", { x: (x + right) / 2, y: y - 7, "text-anchor": "middle", class: "strong" }, `${mm} mm`);
  }

  function shapePanel() {
    const host = byId("shape");
    const usable = nodes >= 3 && outline.x.some(finite) && outline.y.some(finite);
    if (!usable) { empty(host, "No boundary was reconstructed."); return; }
    let mark = null, place = null;
    figure(host, (width) => Math.round(Math.min(500, Math.max(280, width))), (svg, width, high) => {
      const band = outline.band.map((_, node) => drawnBand(node) || 0);
      const reach = (column) => [-1, 1].map((side) => column.map((value, n) => (finite(value) ? value + side * band[n] : NaN)));
      const actual = truth ? truth.aligned : [];
      const [x0, x1] = withTruth(reach(outline.x), actual.map(([x]) => x));
      const [y0, y1] = withTruth(reach(outline.y), actual.map(([, y]) => y));
      const scale = Math.min((width - 124) / Math.max(1e-9, x1 - x0), (high - 84) / Math.max(1e-9, y1 - y0));
      const cx = width / 2 - scale * (x0 + x1) / 2, cy = (high - 18) / 2 + scale * (y0 + y1) / 2;
      const at = (x, y) => (finite(x) && finite(y) ? [cx + x * scale, cy - y * scale] : [NaN, NaN]);
      place = (node) => at(outline.x[node], outline.y[node]);
      const shifted = (node, by) => {
        const [x, y] = place(node), theta = outline.theta[node];
        return [x + by * scale * cos(theta), y - by * scale * sin(theta)];
      };
      draw(svg, "path", { class: "body", d: ring(place) });
      for (const [kind, first, last] of runs((node) => (finite(drawnBand(node)) && finite(outline.x[node]) && finite(outline.y[node]) ? (known[node] ? 2 : 1) : 0))) {
        if (!kind) continue;
        const run = Array.from({ length: last - first + 1 }, (_, k) => (first + k) % nodes).filter((n) => finite(drawnBand(n)) && whole(place(n)));
        const edge = run.map((n) => shifted(n, drawnBand(n))).concat(run.map((n) => shifted(n, -drawnBand(n))).reverse());
        draw(svg, "path", { class: kind === 2 ? "band" : "band guess", d: `${path(edge.filter(whole))}Z` });
      }
      for (const [kind, first, last] of runs(lineOf)) {
        draw(svg, "path", { class: LINES[kind], d: runPath(first, last, place) });
      }
      if (truth && truth.aligned.length) draw(svg, "path", { class: "truth", d: `${path(truth.aligned.map(([x, y]) => at(x, y)))}Z` });
      // Where the outward normal points along the axes.
      for (const degrees of [0, 90, 180, 270]) {
        const node = nodeAt(degrees), out = drawnBand(node) || 0;
        const [ax, ay] = shifted(node, out + 4 / scale), [bx, by] = shifted(node, out + 11 / scale), [tx, ty] = shifted(node, out + 18 / scale);
        if (!finite(ax) || !finite(tx)) continue;
        draw(svg, "path", { class: "faint", d: path([[ax, ay], [bx, by]]) });
        const anchor = degrees === 0 ? "start" : degrees === 180 ? "end" : "middle";
        draw(svg, "text", { x: px(tx), y: px(ty + (degrees === 90 ? 2 : degrees === 270 ? 7 : 4)), "text-anchor": anchor, class: "halo" }, degrees === 0 ? "θ = 0°" : `${degrees}°`);
      }
      const [gx, gy] = at(data.centroid[0], data.centroid[1]);
      const [ox, oy] = at(0, 0);
      comMark(svg, ox, oy);
      if (finite(gx)) draw(draw(svg, "g", { transform: `translate(${px(gx)} ${px(gy)})` }), "path", { class: "centroid", d: CENTROID });
      scaleBar(svg, scale, width - 4, high - 6);
      mark = draw(svg, "circle", { class: "dot", r: 5, fill: "var(--ink)", visibility: "hidden" });
    });

    const item = (glyph, text) => {
      const entry = document.createElement("li");
      const svg = draw(entry, "svg", { viewBox: "0 0 26 14", "aria-hidden": "true" });
      glyph(svg);
      entry.append(text);
      byId("shape-legend").appendChild(entry);
    };
    item((svg) => draw(svg, "path", { class: "felt", d: "M1 7H25" }), "felt");
    if (copied.includes(true)) item((svg) => draw(svg, "path", { class: "copied", d: "M1 7H25" }), "follows from symmetry");
    if (known.includes(false)) item((svg) => draw(svg, "path", { class: "unfelt", d: "M1 7H25" }), "never felt");
    item((svg) => draw(svg, "rect", { class: "band", x: 0, y: 2, width: 26, height: 10 }), `95 % band${exaggeration > 1 ? ` × ${exaggeration}` : ""}${cut ? ", cut off where wide" : ""}`);
    if (truth && truth.aligned.length) item((svg) => draw(svg, "path", { class: "truth", d: "M1 7H25" }), "truth");
    item((svg) => comMark(svg, 13, 7, 6), "centre of mass");
    item((svg) => draw(draw(svg, "g", { transform: "translate(13 7)" }), "path", { class: "centroid", d: CENTROID }), "centroid of the area");

    const find = (event) => {
      if (!place) return;
      const box = host.getBoundingClientRect(), x = event.clientX - box.left, y = event.clientY - box.top;
      let best = null, least = 44 ** 2;
      for (let node = 0; node < nodes; node++) {
        const [a, b] = place(node), far = (a - x) ** 2 + (b - y) ** 2;
        if (far < least) { least = far; best = node; }
      }
      hoverNode(best);
    };
    host.addEventListener("pointermove", find);
    host.addEventListener("pointerdown", find);
    // What was tapped stays.
    host.addEventListener("pointerleave", (event) => { if (event.pointerType !== "touch") hoverNode(null); });
    alongBoundary(host, hoverNode);
    nodeViews.push((node) => {
      const at = node === null || !place ? [NaN, NaN] : place(node);
      if (mark) {
        mark.setAttribute("visibility", finite(at[0]) ? "visible" : "hidden");
        if (finite(at[0])) { mark.setAttribute("cx", px(at[0])); mark.setAttribute("cy", px(at[1])); }
      }
      if (node === null) readout("shape-readout", [["point at the outline or tap it for details", ""]]);
      else readout("shape-readout", boundaryWords(node));
    });
  }

  function boundaryWords(node) {
    const touches = outline.touches[node];
    return [
      ["θ", `${fixed(outline.theta[node], 1)}°`],
      ["r", `${fixed(outline.r[node], 3)} mm ± ${lengthText(outline.band[node])}`],
      ["curvature radius", `${fixed(outline.v[node], 1)} mm`],
      [copied[node] ? "copies felt" : "felt", touches === 0 ? "never" : touches === 1 ? "once" : `${touches} times`],
    ];
  }

  function supportChart() {
    if (nodes < 3) { empty(byId("support"), "No boundary was reconstructed."); return; }
    const theta = outline.theta;
    let dots = null, scales = null;
    const trueShown = truth && truth.rError.some(finite);
    const trueR = trueShown ? outline.r.map((r, node) => minus(r, truth.rError[node])) : [];
    const [low, high] = padded(withTruth([outline.r], trueR), 0.1);
    const view = chart({
      host: "support", x: theta, xUnit: "°", xDomain: [0, 360], xTicks: window.innerWidth < 560 ? 90 : 45, height: 190, y: [low, high],
      keepsTap: true, onPress: (value) => hoverNode(nodeAt(value)), onMove: (value) => hoverNode(nodeAt(value)), onLeave: () => hoverNode(null),
      paint(layer, X, Y) {
        const place = (node) => [X(theta[node]), Y(outline.r[node])];
        for (const [kind, first, last] of runs(lineOf)) {
          draw(layer, "path", { class: LINES[kind], d: runPath(first, Math.min(last, nodes - 1), place) });
        }
        if (trueShown) draw(layer, "path", { class: "truth", d: path(theta.map((angle, node) => [X(angle), Y(trueR[node])])) });
      },
      lane: { unit: "mm", band: outline.band, keep: (node) => known[node], errors: trueShown ? [{ values: truth.rError }] : [] },
      rendered({ svg, X, Y }) {
        scales = { X, Y };
        dots = [1, 2].map((palm) => {
          const dot = draw(svg, "g", { visibility: "hidden" });
          draw(dot, "circle", { class: `dot contact${palm}`, r: 5.5 });
          draw(dot, "text", { y: -10, "text-anchor": "middle", class: "strong halo" }, String(palm));
          return dot;
        });
      },
    });
    alongBoundary(byId("support"), hoverNode);
    timeViews.push((t, i) => {
      if (!dots || !count) return;
      const psi = between(data.psi, i, t), phi1 = between(data.phi1, i, t), phi2 = between(data.phi2, i, t);
      [phi1 - psi - 90, phi1 - psi + phi2 - 270].forEach((angle, k) => {
        const seen = finite([data.s1, data.s2][k][i]) && finite(psi) && finite(angle);
        const node = seen ? nodeAt(angle) : 0;
        const x = seen ? scales.X(theta[node]) : NaN, y = seen ? scales.Y(outline.r[node]) : NaN;
        dots[k].setAttribute("visibility", finite(x) && finite(y) ? "visible" : "hidden");
        if (finite(x) && finite(y)) dots[k].setAttribute("transform", `translate(${px(x)} ${px(y)})`);
      });
    });
    nodeViews.push((node) => {
      view.hover(node === null ? null : theta[node]);
      readout("support-readout", node === null ? [["point at the curve or tap it; 1, 2: contacts at the time shown", ""]] : boundaryWords(node));
    });
  }

  // ---------------------------------------------------------------- the stage

  /** A friction cone that opens upwards, and both of its edges: the first bears the force where the object slides along +x. */
  function cone(svg, palm, friction, long) {
    const group = draw(svg, "g", { visibility: "hidden" }), width = Math.min(20 * long, friction * long);
    draw(group, "path", { class: `cone contact${palm + 1}`, d: `M0 0L${px(-width)} ${px(-long)}H${px(width)}Z` });
    const edges = [-1, 1].map((side) => draw(group, "path", { class: `edge palm${palm + 1}`, d: `M0 0L${px(side * width)} ${px(-long)}` }));
    return { group, edges };
  }

  function stage() {
    const host = byId("stage");
    if (!count || nodes < 3 || !data.psi.some(finite)) { empty(host, "No motion was reconstructed."); byId("stage-legend").remove(); return; }
    const longest = [data.s1, data.s2].map((s) => 1.1 * Math.max(0, ...[quantile(s, 1)].filter(finite)) || 3 * radius);
    const reach = Math.max(...extent([outline.x.map((x, n) => Math.hypot(x, outline.y[n]))]).map(Math.abs)) || radius;
    // Everything that will ever be in view.
    const xs = [], ys = [];
    const stride = Math.max(1, Math.floor(count / 1500));
    for (let i = 0; i < count; i += stride) {
      const [b1x, b1y, b2x, b2y] = base(i), phi12 = data.phi1[i] + data.phi2[i];
      if (finite(data.phi1[i]) && finite(phi12)) {
        xs.push(b1x, b2x, b1x + longest[0] * cos(data.phi1[i]), b2x + longest[1] * cos(phi12));
        ys.push(b1y, b2y, b1y + longest[0] * sin(data.phi1[i]), b2y + longest[1] * sin(phi12));
      }
      if (finite(data.x[i]) && finite(data.y[i])) { xs.push(data.x[i] - reach, data.x[i] + reach); ys.push(data.y[i] - reach, data.y[i] + reach); }
    }
    const [x0, x1] = extent([xs]), [y0, y1] = extent([ys]);
    let parts = null;

    figure(host, (width) => Math.round(Math.min(448, Math.max(280, width * 0.66))), (svg, width, high) => {
      const scale = Math.min((width - 28) / Math.max(1e-9, x1 - x0), (high - 40) / Math.max(1e-9, y1 - y0));
      const cx = width / 2 - scale * (x0 + x1) / 2, cy = 14 + (high - 40) / 2 + scale * (y0 + y1) / 2;
      const at = (x, y) => (finite(x) && finite(y) ? [cx + x * scale, cy - y * scale] : [NaN, NaN]);
      const own = (node) => { const x = outline.x[node], y = outline.y[node]; return finite(x) && finite(y) ? [x * scale, -y * scale] : [NaN, NaN]; };

      const trail = draw(svg, "g");
      let from = 0;
      for (let i = 1; i <= count; i++) {
        if (i < count && !newPiece(i)) continue;
        const points = [];
        for (let k = from; k < i; k++) points.push(at(data.x[k], data.y[k]));
        draw(trail, "path", { class: "trail", d: path(points) });
        from = i;
      }
      const palms = [1, 2].map((palm) => {
        const group = draw(svg, "g");
        const long = longest[palm - 1] * scale, thick = 9;
        draw(group, "rect", { class: "palm", x: 0, y: palm === 1 ? 0 : -thick, width: px(long), height: thick, rx: 2 });
        draw(group, "path", { class: "face", d: `M0 0H${px(long)}` });
        return group;
      });
      const object = draw(svg, "g", { id: "object" });
      const haze = draw(object, "path", { class: "haze", d: ring(own), "stroke-opacity": 0 });
      draw(object, "path", { class: "body", d: ring(own) });
      draw(object, "path", { class: "faint", d: ring(own) });
      const filled = [...Array(PIECES).keys()].map((piece) => draw(object, "path", { class: `felt piece${piece}` }));
      const possible = left ? draw(object, "path", { class: "possible" }) : null;
      const cones = data.friction ? data.friction.map((friction, k) => cone(svg, k, friction, 0.75 * radius * scale)) : [];
      let ghost = null;
      if (truth && truth.own.length && truth.psi.some(finite)) {
        ghost = draw(svg, "path", { class: "truth", d: `${path(truth.own.map(([x, y]) => (finite(x) && finite(y) ? [x * scale, -y * scale] : [NaN, NaN])))}Z` });
      }
      const pull = draw(svg, "g");
      const arrow = Math.max(24, 0.55 * radius * scale);
      draw(pull, "path", { class: "gravity", d: `M0 0V${px(arrow)}m-4.5 -6.5l4.5 6.5l4.5 -6.5` });
      comMark(pull, 0, 0, 6);
      const hinges = [draw(svg, "circle", { class: "hinge", r: 3.5 }), draw(svg, "circle", { class: "hinge", r: 3.5 })];
      const contacts = [1, 2].map((palm) => {
        const dot = draw(svg, "g", { visibility: "hidden" });
        draw(dot, "circle", { class: `dot contact${palm}`, r: 6 });
        const text = draw(dot, "text", { y: 4, "text-anchor": "middle", class: "strong halo" }, String(palm));
        return { dot, text };
      });
      scaleBar(svg, scale, width - 4, high - 6);
      const inferred = [trail, ...object.children, ghost, pull, ...cones.map(({ group }) => group)].filter((part) => part && part !== haze);
      parts = { at, own, palms, object, haze, inferred, filled, possible, cones, ghost, pull, hinges, contacts };
      parts.scale = scale;
      setTime(now);
    });

    const show = (element, yes) => element.setAttribute("visibility", yes ? "visible" : "hidden");
    const move = (element, x, y, rest = "") => {
      show(element, finite(x) && finite(y));
      if (finite(x) && finite(y)) element.setAttribute("transform", `translate(${x.toFixed(2)} ${y.toFixed(2)})${rest}`);
    };
    timeViews.push((t, i) => {
      if (!parts) return;
      // While it plays, what was inferred condenses out of a haze.
      const clear = sight(t);
      for (const part of parts.inferred) part.setAttribute("opacity", clear.toFixed(3));
      parts.haze.setAttribute("stroke-opacity", (clear * (1 - clear)).toFixed(3));
      parts.haze.setAttribute("stroke-width", px(2 + (1 - clear) * radius * parts.scale));
      const psi = between(data.psi, i, t), phi1 = between(data.phi1, i, t), phi12 = phi1 + between(data.phi2, i, t);
      const bases = data.base ? data.base.map((column) => between(column, i, t)) : [0, 0, 0, 0];
      const [x, y] = parts.at(between(data.x, i, t), between(data.y, i, t));
      const turned = finite(psi) ? ` rotate(${(-psi).toFixed(3)})` : "";
      move(parts.object, x, finite(psi) ? y : NaN, turned);
      move(parts.pull, x, y);
      [[phi1, data.s1], [phi12, data.s2]].forEach(([phi, s], k) => {
        const bx = bases[2 * k], by = bases[2 * k + 1], length = between(s, i, t);
        const [hx, hy] = parts.at(bx, by);
        move(parts.palms[k], hx, finite(phi) ? hy : NaN, finite(phi) ? ` rotate(${(-phi).toFixed(3)})` : "");
        move(parts.hinges[k], hx, hy);
        const seen = finite(length) && finite(phi);
        const [px1, py1] = seen ? parts.at(bx + length * cos(phi), by + length * sin(phi)) : [NaN, NaN];
        move(parts.contacts[k].dot, px1, py1);
        if (parts.cones[k]) {
          const { group, edges } = parts.cones[k], mode = data.modes[k][i];
          move(group, px1, py1, seen ? ` rotate(${(-phi - 180 * k).toFixed(3)})` : "");
          edges.forEach((edge, n) => show(edge, seen && mode === (n ? -1 : 1)));
        }
        if (seen) {
          // The number stands on the far side of the palm.
          const side = k === 0 ? 1 : -1;
          parts.contacts[k].text.setAttribute("x", px(side * 20 * sin(phi)));
          parts.contacts[k].text.setAttribute("y", px(side * 20 * cos(phi) + 4));
        }
      });
      if (parts.ghost) {
        // The truth is known at samples only; between two of them its distance from the estimate is held.
        const off = (estimate, actual) => minus(actual[i], estimate[i]);
        const [gx, gy] = parts.at(between(data.x, i, t) + off(data.x, truth.x), between(data.y, i, t) + off(data.y, truth.y));
        const turn = psi + off(data.psi, truth.psi);
        move(parts.ghost, gx, finite(turn) ? gy : NaN, finite(turn) ? ` rotate(${(-turn).toFixed(3)})` : "");
      }
      if (parts.possible) parts.possible.setAttribute("d", `${path(left[i].map(([px2, py2]) => [px2 * parts.scale, -py2 * parts.scale]))}Z`);
      const d = new Array(PIECES).fill("");
      for (const [kind, first, last] of runs((node) => (firstFelt[node] <= t ? firstPiece[node] % PIECES : -1))) {
        if (kind >= 0) d[kind] += runPath(first, last, parts.own);
      }
      parts.filled.forEach((line, piece) => line.setAttribute("d", d[piece]));
    });

    const pieces = [...new Set(data.piece)];
    timeViews.push((t, i) => {
      const share = nodes ? firstFelt.filter((first) => first <= t).length / nodes : 0;
      readout("stage-readout", [
        ["t", clock(t)], ["ψ", `${fixed(data.psi[i], 1)}°`], ["felt so far", `${fixed(100 * share, 0)} %`],
        ...(pieces.length > 1 ? [["piece", `${pieces.indexOf(data.piece[i]) + 1} of ${pieces.length}`]] : []),
      ]);
    });

    const entry = (glyph, text) => {
      const item = document.createElement("li");
      glyph(draw(item, "svg", { viewBox: "0 0 26 14", "aria-hidden": "true" }));
      item.append(text);
      byId("stage-legend").appendChild(item);
    };
    entry((svg) => {
      const shown = Math.min(pieces.length, PIECES);
      for (let k = 0; k < shown; k++) draw(svg, "path", { class: `felt piece${k}`, "stroke-linecap": "butt", d: `M${1 + 24 * k / shown} 7H${1 + 24 * (k + 1) / shown}` });
    }, pieces.length > 1 ? "felt so far, by piece" : "felt so far");
    entry((svg) => draw(svg, "path", { class: "faint", d: "M1 7H25" }), "not felt yet");
    entry((svg) => { draw(svg, "circle", { class: "contact1", cx: 7, cy: 7, r: 5 }); draw(svg, "circle", { class: "contact2", cx: 20, cy: 7, r: 5 }); }, "contacts on palms 1, 2");
    entry((svg) => comMark(svg, 13, 7, 6), "centre of mass and its track");
    if (data.friction) {
      entry((svg) => { draw(svg, "path", { class: "cone contact1", d: "M7 13L2 1H12Z" }); draw(svg, "path", { class: "cone contact2", d: "M20 13L15 1H25Z" }); }, "friction cones; an edge where it slides");
      entry((svg) => draw(svg, "path", { class: "possible", d: "M3 2L22 5L17 12L6 11Z" }), "what is left to the centre of mass");
    }
    if (truth && truth.own.length) entry((svg) => draw(svg, "path", { class: "truth", d: "M1 7H25" }), "truth");
    if (data.jumps.length) entry((svg) => draw(svg, "path", { class: "jump", d: "M13 0V14" }), "jump");
  }

  // ---------------------------------------------------------------- time control

  const play = byId("play"), slider = byId("time"), speed = byId("speed");
  const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
  /** Until anything else was asked for, the page shows the middle of the motion, and play begins with the start. */
  let playing = false, last = 0, filming = false, poster = !before, rested = 0;
  /** The shares of the motion between which the outline appears, and how long the end stands, seconds. */
  const BLIND = 0.07, SEEN = 0.3, REST = 1.5;
  /** How much of what was inferred is shown, 0 to 1: all of it, but for the begin of the motion while it plays. */
  function sight(t) {
    if (!filming && (!playing || still)) return 1;
    const share = Math.min(1, Math.max(0, ((t - start) / (end - start) - BLIND) / (SEEN - BLIND)));
    return share * share * (3 - 2 * share);
  }
  function stop() {
    const was = playing;
    playing = poster = false;
    play.classList.remove("playing");
    play.setAttribute("aria-label", "Play");
    if (was) setTime(now);
  }
  function step(stamp) {
    if (!playing) return;
    const passed = Math.min(0.1, Math.max(0, (stamp - last) / 1000));
    last = stamp;
    const next = now + passed * Number(speed.value);
    if (now < end || still) { setTime(next); rested = 0; } else if ((rested += passed) > REST) setTime(start);
    if (next >= end && still) stop(); else requestAnimationFrame(step);
  }
  function toggle() {
    if (play.disabled) return;
    if (playing) { stop(); return; }
    const fromStart = poster || now >= end;
    playing = true;
    poster = false;
    play.classList.add("playing");
    play.setAttribute("aria-label", "Pause");
    setTime(fromStart ? start : now);
    last = performance.now();
    requestAnimationFrame(step);
  }

  /** Saves the motion as an animation. */
  async function film() {
    const button = byId("film"), stage = document.querySelector("#stage svg");
    if (!stage || filming) return;
    stop();
    const there = now, name = button.textContent;
    filming = true;
    play.disabled = slider.disabled = true;
    try {
      await figureFiles.film(stage, (share) => setTime(start + share * (end - start)), (share) => {
        button.textContent = `${fixed(100 * share, 0)} %`;
        return !signal.aborted;
      });
    } finally {
      filming = play.disabled = slider.disabled = false;
      button.textContent = name;
      setTime(there);
    }
  }

  function controls() {
    const span = end - start;
    byId("film").addEventListener("click", film);
    if (!(span > 0)) { byId("film").disabled = play.disabled = slider.disabled = speed.disabled = true; return; }
    slider.min = String(start);
    slider.max = String(end);
    slider.step = "any";
    slider.addEventListener("input", () => { stop(); setTime(Number(slider.value)); });
    timeViews.push((t) => { slider.value = String(t); slider.setAttribute("aria-valuetext", clock(t)); });
    play.addEventListener("click", toggle);

    // Real time if that is watchable, else the speed that takes about 15 seconds.
    const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
    const best = span >= 4 && span <= 30 ? 1 : speeds.reduce((a, b) => (Math.abs(Math.log(span / b / 15)) < Math.abs(Math.log(span / a / 15)) ? b : a));
    const middle = speeds.indexOf(best);
    for (const value of speeds.slice(Math.max(0, middle - 3), middle + 4)) {
      const option = document.createElement("option");
      option.value = String(value);
      option.textContent = `${value}×`;
      option.selected = value === (before ? before.speed : best);
      speed.appendChild(option);
    }

    const marks = byId("marks");
    const share = (t) => `${100 * (t - start) / span}%`;
    let from = 0;
    for (let i = 1; i <= count; i++) {
      if (i < count && !newPiece(i)) continue;
      const bar = document.createElement("i");
      bar.className = pieceClass(data.piece[from]);
      bar.style.left = share(time[from]);
      bar.style.right = `${100 - 100 * ((i < count ? time[i] : end) - start) / span}%`;
      marks.appendChild(bar);
      from = i;
    }
    for (const jump of data.jumps) {
      if (!(jump >= start && jump <= end)) continue;
      const line = document.createElement("u");
      line.style.left = share(jump);
      marks.appendChild(line);
    }

    document.addEventListener("keydown", (event) => {
      const target = event.target instanceof Element ? event.target : document.body;
      if (event.ctrlKey || event.metaKey || event.altKey || target.closest("select, summary, a, [type=radio]")) return;
      const direction = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
      if (event.key === " " && !target.closest("button")) toggle();
      else if (direction) { stop(); setTime(time[Math.min(count - 1, Math.max(0, nearestAt(now) + direction * (event.shiftKey ? 10 : 1)))]); }
      else return;
      event.preventDefault();
    }, { signal });

    for (const button of document.querySelectorAll(".jumps button")) {
      button.addEventListener("click", () => {
        stop();
        setTime(Number(button.dataset.time || start));
        byId("card-motion").scrollIntoView({ block: "nearest" });
      });
    }
  }

  // ---------------------------------------------------------------- on paper

  /** The motion in a strip of pictures, since paper does not move. */
  function strip() {
    const PICTURES = 6, there = now;
    stop();
    const original = document.querySelector("#stage svg");
    if (!original || !(end > start)) return;
    for (let k = 0; k < PICTURES; k++) {
      setTime(start + k / (PICTURES - 1) * (end - start));
      const frame = document.createElement("figure"), caption = document.createElement("figcaption"), copy = original.cloneNode(true);
      copy.querySelector("#object").removeAttribute("id");
      copy.setAttribute("aria-label", `At ${clock(now)}`);
      caption.textContent = clock(now);
      frame.append(copy, caption);
      byId("strip").append(frame);
    }
    setTime(there);
  }
  window.addEventListener("beforeprint", strip, { signal });
  window.addEventListener("afterprint", () => byId("strip").replaceChildren(), { signal });

  // ---------------------------------------------------------------- go

  controls();
  shapePanel();
  stage();
  if (count) timeCharts();
  else for (const id of ["angles", "contacts", "psi", "com", "residual1"]) empty(byId(id), "No samples.");
  supportChart();
  hoverNode(null);
  figureFiles.offer(document.querySelector("main"));
  setTime(before ? before.time : (start + end) / 2);
  return () => {
    playing = false;
    ending.abort();
    return { time: now, speed: Number(speed.value) };
  };
}

// ------------------------------------------------------------------ which arrangement is shown

(() => {
  const { log, arrangements } = JSON.parse(document.getElementById("data").textContent);
  const untouched = document.querySelector("main").cloneNode(true);
  let leave = null;

  function show(number) {
    const left = leave ? leave() : null;
    if (leave) {
      // A new <main>, as high as the old one while it fills, so that the page stays where it was scrolled to.
      const old = document.querySelector("main"), fresh = untouched.cloneNode(true);
      const folded = [...old.querySelectorAll(".card > details")];
      fresh.style.minHeight = `${old.offsetHeight}px`;
      fresh.querySelectorAll(".card > details").forEach((details, k) => { details.open = folded[k].open; });
      old.replaceWith(fresh);
    }
    for (const part of document.querySelectorAll("[data-arrangement]")) part.hidden = Number(part.dataset.arrangement) !== number;
    leave = report({ ...log, ...arrangements[number] }, left);
    document.querySelector("main").style.minHeight = "";
  }

  for (const choice of document.querySelectorAll("[name=arrangement]")) choice.addEventListener("change", () => show(Number(choice.value)));
  show(0);
})();
