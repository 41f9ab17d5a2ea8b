"use strict";

/**
 * An animated GIF of pictures (RGBA bytes of a canvas) of one size: one palette for all of them, and of each but the first only what has changed.
 */
function gifEncoder(width, height) {
  const COLORS = 255, AS_IT_WAS = 255, BITS = 8;
  const bytes = [], nearest = new Map();
  let palette = null, shown = null;
  const short = (value) => bytes.push(value & 255, value >> 8);
  const ascii = (text) => { for (const letter of text) bytes.push(letter.charCodeAt(0)); };
  const key = (rgba, at) => rgba[at] << 16 | rgba[at + 1] << 8 | rgba[at + 2];

  /** The colours that occur most often in some of the pictures. */
  function begin(samples) {
    const counts = new Map();
    for (const rgba of samples) for (let at = 0; at < rgba.length; at += 4) counts.set(key(rgba, at), (counts.get(key(rgba, at)) || 0) + 1);
    palette = [...counts].sort((a, b) => b[1] - a[1]).slice(0, COLORS).map(([color]) => color);
    ascii("GIF89a");
    short(width); short(height);
    bytes.push(0xf0 | BITS - 1, 0, 0);
    for (let k = 0; k < 256; k++) { const color = palette[k] ?? 0; bytes.push(color >> 16, color >> 8 & 255, color & 255); }
    bytes.push(0x21, 0xff, 11); ascii("NETSCAPE2.0"); bytes.push(3, 1, 0, 0, 0);
  }

  function indexOf(color) {
    let index = nearest.get(color);
    if (index !== undefined) return index;
    let least = Infinity;
    palette.forEach((other, k) => {
      const far = ((color >> 16) - (other >> 16)) ** 2 + ((color >> 8 & 255) - (other >> 8 & 255)) ** 2 + ((color & 255) - (other & 255)) ** 2;
      if (far < least) { least = far; index = k; }
    });
    nearest.set(color, index);
    return index;
  }

  /** Variable-length codes after Lempel, Ziv and Welch, in blocks of 255 bytes. */
  function compress(indices) {
    const CLEAR = 1 << BITS;
    let held = 0, free = 0, block = [], size = BITS + 1, next = CLEAR + 2, table = new Map();
    const flush = () => { if (block.length) bytes.push(block.length, ...block); block = []; };
    const put = (code) => {
      held |= code << free;
      for (free += size; free >= 8; free -= 8) { block.push(held & 255); held >>>= 8; if (block.length === 255) flush(); }
    };
    bytes.push(BITS);
    put(CLEAR);
    let prefix = indices[0];
    for (let k = 1; k < indices.length; k++) {
      const longer = prefix << 8 | indices[k], code = table.get(longer);
      if (code !== undefined) { prefix = code; continue; }
      put(prefix);
      if (next < 4096) {
        table.set(longer, next++);
        if (next - 1 === 1 << size && size < 12) size++;
      } else {
        put(CLEAR);
        table = new Map(); size = BITS + 1; next = CLEAR + 2;
      }
      prefix = indices[k];
    }
    put(prefix);
    put(CLEAR + 1);
    if (free) block.push(held & 255);
    flush();
    bytes.push(0);
  }

  function add(rgba, hundredths) {
    const next = new Uint8Array(width * height);
    for (let k = 0; k < next.length; k++) next[k] = indexOf(key(rgba, 4 * k));
    let left = width, right = 0, top = height, bottom = 0;
    for (let k = 0; k < next.length; k++) {
      if (shown && shown[k] === next[k]) continue;
      const x = k % width, y = (k - x) / width;
      left = Math.min(left, x); right = Math.max(right, x); top = Math.min(top, y); bottom = y;
    }
    if (left > right) left = right = top = bottom = 0;
    const changed = [];
    for (let y = top; y <= bottom; y++) for (let x = left; x <= right; x++) {
      const k = y * width + x;
      changed.push(shown && shown[k] === next[k] ? AS_IT_WAS : next[k]);
    }
    bytes.push(0x21, 0xf9, 4, 0x05); short(hundredths); bytes.push(AS_IT_WAS, 0);
    bytes.push(0x2c); short(left); short(top); short(right - left + 1); short(bottom - top + 1); bytes.push(0);
    compress(changed);
    shown = next;
  }

  return { begin, add, end: () => { bytes.push(0x3b); return new Uint8Array(bytes); } };
}
