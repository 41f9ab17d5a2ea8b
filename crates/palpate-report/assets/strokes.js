/** Moves the object over the pad; everything else on the page of strokes is drawn already. */
(() => {
  const byId = (id) => document.getElementById(id);
  const { samples, zero, scale, raised, tilt } = JSON.parse(byId("data").textContent);
  const main = document.querySelector("main");
  figureFiles.offer(main);
  const count = samples ? samples.time.length : 0;
  const slider = byId("time"), button = byId("play"), speed = byId("speed");
  if (!count || !byId("stage-svg")) {
    for (const control of [slider, button, byId("film")]) control.disabled = true;
    return;
  }
  const { time, height, along, s, psi } = samples, band = samples.psi_band;
  const finite = Number.isFinite, start = time[0], end = time[count - 1];
  const fixed = (value, decimals) => value.toFixed(decimals).replace("-", "\u2212");

  function indexAt(t) {
    let low = 0, high = count - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (time[middle] <= t) low = middle; else high = middle - 1;
    }
    return low;
  }
  /** A column at a time; held where a neighbour is missing. */
  function at(column, i, t) {
    const a = column[i], b = column[i + 1];
    return finite(a) && finite(b) && time[i + 1] > time[i] ? a + (b - a) * (t - time[i]) / (time[i + 1] - time[i]) : a;
  }

  const cursors = [...document.querySelectorAll("svg[data-from]")].filter((svg) => svg.closest(".timed")).map((svg) => {
    const [from, to, left, right] = ["from", "to", "left", "right"].map((name) => Number(svg.dataset[name]));
    return { svg, line: svg.querySelector(".play-cursor"), from, to, left, right };
  });

  let now = start;
  function show(t) {
    now = Math.min(end, Math.max(start, t));
    const i = indexAt(now), x = at(along, i, now), y = at(height, i, now) - raised;
    const known = finite(psi[i]), touches = known && finite(s[i]);
    const contact = touches ? (at(s, i, now) - zero) / (1 + scale) - x : NaN;
    byId("pad").setAttribute("transform", `translate(${-x} 0)`);
    byId("pivot").setAttribute("transform", `translate(0 ${y})`);
    byId("object").setAttribute("transform", `translate(0 ${y}) rotate(${(known ? at(psi, i, now) : lastPsi(i)) - tilt})`);
    byId("object").setAttribute("opacity", known ? 1 : 0.35);
    byId("contact").setAttribute("visibility", touches ? "visible" : "hidden");
    byId("lever").setAttribute("visibility", touches ? "visible" : "hidden");
    if (touches) {
      byId("contact").setAttribute("cx", contact);
      byId("lever").setAttribute("d", `M0 ${y}V0H${contact}`);
    }
    slider.value = now;
    const parts = [["t", `${fixed(now, 2)} s`], ["height", `${fixed(y, 2)} mm`], ["s", touches ? `${fixed(s[i], 2)} mm` : "no contact"],
      ["ψ", known ? `${fixed(psi[i], 1)}° ± ${fixed(band[i], 2)}°` : "not told"]];
    byId("stage-readout").innerHTML = parts.map(([label, value]) => `<span>${label} <b>${value}</b></span>`).join("");
    for (const { line, from, to, left, right } of cursors) {
      line.setAttribute("visibility", "visible");
      line.setAttribute("transform", `translate(${(left + (now - from) / (to - from || 1) * (right - left)).toFixed(1)} 0)`);
    }
  }
  /** Where nothing is told the object is shown, faintly, as it was last, or as it will be first. */
  function lastPsi(i) {
    for (let k = i; k >= 0; k--) if (finite(psi[k])) return psi[k];
    return psi.find(finite) ?? 0;
  }

  let playing = false;
  function stop() {
    playing = false;
    button.classList.remove("playing");
    button.setAttribute("aria-label", "Play");
  }
  function play() {
    playing = true;
    button.classList.add("playing");
    button.setAttribute("aria-label", "Pause");
    if (now >= end) show(start);
    let before = performance.now();
    const step = (clock) => {
      if (!playing) return;
      show(now + (clock - before) / 1000 * Number(speed.value));
      before = clock;
      if (now >= end) stop(); else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }
  button.addEventListener("click", () => (playing ? stop() : play()));
  Object.assign(slider, { min: start, max: end, step: "any" });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || /^(SELECT|SUMMARY|BUTTON)$/.test(event.target.tagName)) return;
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === " ") { playing ? stop() : play(); event.preventDefault(); }
    if (way) { stop(); show(time[Math.min(count - 1, Math.max(0, indexAt(now) + way * (event.shiftKey ? 10 : 1)))]); event.preventDefault(); }
  });
  // A chart over time goes to the moment that it is pointed at.
  for (const { svg, from, to, left, right } of cursors) {
    const go = (event) => {
      const box = svg.getBoundingClientRect(), place = (event.clientX - box.left) * svg.viewBox.baseVal.width / box.width;
      stop();
      show(from + (place - left) / (right - left) * (to - from));
    };
    svg.addEventListener("pointerdown", go);
    svg.addEventListener("pointermove", (event) => { if (event.buttons) go(event); });
  }
  const film = byId("film");
  film.addEventListener("click", async () => {
    const shown = now;
    stop();
    film.disabled = true;
    await figureFiles.film(byId("stage-svg"), (share) => show(start + share * (end - start)), (share) => {
      film.textContent = share < 1 ? `${Math.round(100 * share)} %` : "GIF";
      return true;
    });
    film.disabled = false;
    show(shown);
  });
  show((start + end) / 2);
})();
