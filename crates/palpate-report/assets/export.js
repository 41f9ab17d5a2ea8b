/** Figures as files: what a card draws as one SVG document or PNG picture, and the motion as an animated GIF. */
const figureFiles = (() => {
  const SVG = "http://www.w3.org/2000/svg", PIXELS = 2, MARGIN = 16;
  const STYLES = ["fill", "fill-opacity", "stroke", "stroke-opacity", "stroke-width", "stroke-dasharray", "stroke-linecap", "stroke-linejoin",
    "opacity", "paint-order", "font-size", "font-weight", "font-family"];

  /** A copy that needs no style sheet, without what is hidden. */
  function standalone(original) {
    const copy = original.cloneNode(true);
    const pairs = [[original, copy]];
    while (pairs.length) {
      const [from, to] = pairs.pop(), style = getComputedStyle(from);
      if (style.visibility === "hidden" || style.display === "none" || /cursor/.test(from.getAttribute("class"))) { to.remove(); continue; }
      for (const name of STYLES) to.setAttribute(name, style.getPropertyValue(name));
      to.removeAttribute("class");
      [...from.children].forEach((child, k) => pairs.push([child, to.children[k]]));
    }
    return copy;
  }

  const element = (parent, tag, attributes, text) => {
    const made = document.createElementNS(SVG, tag);
    for (const name in attributes) made.setAttribute(name, attributes[name]);
    if (text !== undefined) made.textContent = text;
    parent.appendChild(made);
    return made;
  };

  /** A sheet of that size on the colour of the cards. */
  function sheet(width, height) {
    const svg = document.createElementNS(SVG, "svg");
    for (const [name, value] of Object.entries({ xmlns: SVG, width, height, viewBox: `0 0 ${width} ${height}` })) svg.setAttribute(name, value);
    const paper = getComputedStyle(document.querySelector(".card")).backgroundColor;
    element(svg, "rect", { width, height, fill: paper });
    return svg;
  }

  function placed(svg, original, x, y) {
    const box = original.getBoundingClientRect(), copy = standalone(original);
    for (const [name, value] of Object.entries({ x, y, width: box.width, height: box.height })) copy.setAttribute(name, value);
    svg.appendChild(copy);
  }

  /** A line of text as it stands on the page. */
  function words(svg, original, text, x, y) {
    const style = getComputedStyle(original);
    element(svg, "text", { x, y, fill: style.color, "font-size": style.fontSize, "font-weight": style.fontWeight, "font-family": style.fontFamily }, text);
  }

  const title = (heading) => heading.firstChild.textContent.trim();

  /** All that a card draws, with its heading and legend. */
  function ofCard(card) {
    const drawings = [...card.querySelectorAll(".plot svg, .legend svg")], heading = card.querySelector("h2");
    const frame = card.getBoundingClientRect(), first = heading.getBoundingClientRect();
    const shown = [...card.querySelectorAll(".plot, .legend")].map((part) => part.getBoundingClientRect());
    // The read-out between heading and drawing belongs to the page.
    const gap = Math.min(...shown.map((box) => box.top)) - first.bottom - 8;
    const down = (box) => box.top - first.top - gap + MARGIN, along = (box) => box.left - first.left + MARGIN;
    const bottom = Math.max(...shown.map((box) => box.bottom));
    const svg = sheet(Math.ceil(frame.width - 2 * (first.left - frame.left) + 2 * MARGIN), Math.ceil(bottom - first.top - gap + 2 * MARGIN));
    const unit = heading.querySelector("small");
    words(svg, heading, title(heading) + (unit ? `, ${unit.textContent}` : ""), MARGIN, MARGIN + 15);
    for (const drawing of drawings) placed(svg, drawing, along(drawing.getBoundingClientRect()), down(drawing.getBoundingClientRect()));
    for (const entry of card.querySelectorAll(".legend li")) {
      const range = document.createRange();
      range.selectNodeContents(entry.lastChild);
      const box = range.getBoundingClientRect();
      words(svg, entry, entry.textContent, along(box), down(box) + 0.78 * box.height);
    }
    return svg;
  }

  const text = (svg) => new XMLSerializer().serializeToString(svg);

  /** A canvas with the picture of a sheet. */
  async function painted(svg, scale) {
    const image = new Image();
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text(svg))}`;
    await image.decode();
    const canvas = document.createElement("canvas");
    canvas.width = Math.round(Number(svg.getAttribute("width")) * scale);
    canvas.height = Math.round(Number(svg.getAttribute("height")) * scale);
    canvas.getContext("2d", { willReadFrequently: true }).drawImage(image, 0, 0, canvas.width, canvas.height);
    return canvas;
  }

  function download(blob, name) {
    const link = document.createElement("a");
    link.download = `${document.querySelector("h1").textContent.trim().replace(/\.\w+$/, "").replace(/[^\p{L}\p{N}.-]+/gu, "_") || "palpate"}-${name}`;
    link.href = URL.createObjectURL(blob);
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  }

  const save = {
    async SVG(card, name) { download(new Blob([text(ofCard(card))], { type: "image/svg+xml" }), `${name}.svg`); },
    async PNG(card, name) {
      const canvas = await painted(ofCard(card), PIXELS);
      canvas.toBlob((blob) => download(blob, `${name}.png`), "image/png");
    },
  };

  /** Gives the heading of each card that draws something its buttons. */
  function offer(main) {
    for (const card of main.querySelectorAll(".card")) {
      const plot = card.querySelector(".plot"), heading = card.querySelector("h2");
      if (!plot || !plot.querySelector("svg")) continue;
      const buttons = document.createElement("span");
      buttons.className = "save";
      for (const kind in save) {
        const button = document.createElement("button");
        button.type = "button";
        button.textContent = kind;
        button.setAttribute("aria-label", `Save ${title(heading)} as ${kind}`);
        button.addEventListener("click", () => save[kind](card, plot.id));
        buttons.append(button);
      }
      heading.after(buttons);
    }
  }

  /**
   * The motion as a file. `show(share)` draws the stage at a share of the motion; `tell(share)` says how far this has come.
   */
  async function film(stage, show, tell) {
    const FRAMES = 120, FRAME = 8, LAST = 160, COUNTED = 10;
    const box = stage.getBoundingClientRect(), width = Math.round(box.width), height = Math.round(box.height);
    const picture = async (share) => {
      show(share);
      const svg = sheet(width, height);
      placed(svg, stage, 0, 0);
      const canvas = await painted(svg, 1);
      return canvas.getContext("2d").getImageData(0, 0, width, height).data;
    };
    const encoder = gifEncoder(width, height), samples = [];
    for (let k = 0; k < COUNTED; k++) samples.push(await picture(1 - k / COUNTED));
    encoder.begin(samples);
    for (let k = 0; k < FRAMES; k++) {
      encoder.add(await picture(k / (FRAMES - 1)), k === FRAMES - 1 ? LAST : FRAME);
      if (!tell((k + 1) / FRAMES)) return;
    }
    download(new Blob([encoder.end()], { type: "image/gif" }), "motion.gif");
  }

  return { offer, film };
})();
