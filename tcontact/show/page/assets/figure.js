"use strict";
// A figure of curves: wheel or + and - zoom, dragging marks a span, double click or 0 shows all, arrows move.
const HUES = ["#1f77c9", "#c0392b", "#23824a", "#b06a00", "#8e44ad", "#8b5a2b", "#c71585", "#607080", "#008b9a"];
const FRAME = { width: 560, height: 250, left: 62, right: 12, top: 10, bottom: 34 };

function element(name, attributes = {}, ...children) {
  const svg = ["svg", "g", "path", "line", "text", "rect", "clipPath", "title"].includes(name) && attributes.svg !== 0;
  const made = svg ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) if (key !== "svg") made.setAttribute(key, value);
  made.append(...children);
  return made;
}

function prefixed(size) {
  const prefixes = { "-4": "p", "-3": "n", "-2": "µ", "-1": "m", 0: "", 1: "k", 2: "M", 3: "G", 4: "T" };
  const power = size > 0 && isFinite(size) ? Math.max(-4, Math.min(4, Math.floor(Math.log10(size) / 3 + 1e-9))) : 0;
  return [1000 ** power, prefixes[power]];
}

function words(value, unit) {
  if (!isFinite(value)) return isNaN(value) ? "none" : value > 0 ? "∞" : "-∞";
  const [factor, prefix] = unit && !unit.startsWith("kg") ? prefixed(Math.abs(value)) : [1, ""];
  const figure = Number((value / factor).toPrecision(4)), size = Math.abs(figure);
  return `${size && size < 1e-3 ? figure.toExponential() : figure} ${prefix}${unit}`.trim();
}

function marks(low, high) {
  const rough = (high - low) / 5 || 1;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map(s => s * power).reduce((a, b) => Math.abs(b - rough) < Math.abs(a - rough) ? b : a);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-6); k <= high / step + 1e-6; k++) found.push(k * step);
  return found;
}

class Figure {
  constructor(place, group, clock) {
    this.group = group;
    this.lines = group.lines.map(line => ({ ...line, x: numbers(line.x, "f8"), y: numbers(line.y, "f8") }));
    const label = `${group.title}: ${this.lines.map(line => line.name).join(", ")}. Plus and minus zoom, arrows move, 0 shows all.`;
    this.svg = element("svg", { viewBox: `0 0 ${FRAME.width} ${FRAME.height}`, tabindex: 0, role: "img", "aria-label": label });
    this.legend = element("div", { class: "legend" });
    place.append(element("h3", {}, group.title), this.svg, this.legend);
    this.now = null;
    this.whole();
    this.listen();
    if (clock) clock.watch(time => { this.now = time; this.mark(); });
  }

  whole() {
    let [x0, x1] = [Infinity, -Infinity];
    for (const line of this.lines) for (const x of line.x) if (isFinite(x)) { x0 = Math.min(x0, x); x1 = Math.max(x1, x); }
    this.all = this.span = x0 < x1 ? [x0, x1] : [0, 1];
    this.draw();
  }

  zoom(middle, factor) {
    const low = middle - (middle - this.span[0]) * factor, high = middle + (this.span[1] - middle) * factor;
    this.show(low, high);
  }

  show(low, high) {
    const [first, last] = this.all, least = 1e-6 * (last - first);
    low = Math.max(first, low);
    high = Math.min(last, high);
    if (high - low < least) return;
    this.span = [low, high];
    this.draw();
  }

  draw() {
    const { width, height, left, right, top, bottom } = FRAME;
    const [x0, x1] = this.span;
    let [y0, y1] = [Infinity, -Infinity];
    for (const line of this.lines)
      for (let k = 0; k < line.x.length; k++)
        if (line.x[k] >= x0 && line.x[k] <= x1 && isFinite(line.y[k])) { y0 = Math.min(y0, line.y[k]); y1 = Math.max(y1, line.y[k]); }
    if (!(y0 <= y1)) [y0, y1] = [0, 1];
    if (y0 === y1) [y0, y1] = y0 === 0 ? [-1, 1] : [y0 - 0.1 * Math.abs(y0), y1 + 0.1 * Math.abs(y1)];
    const margin = 0.04 * (y1 - y0);
    [y0, y1] = [y0 - margin, y1 + margin];
    this.x = x => left + (x - x0) / (x1 - x0) * (width - left - right);
    this.y = y => height - bottom - (y - y0) / (y1 - y0) * (height - top - bottom);
    this.back = place => x0 + (place - left) / (width - left - right) * (x1 - x0);
    const unit = this.group.unit, free = !unit || unit.startsWith("kg");
    const [yFactor, yPrefix] = free ? [1, ""] : prefixed(Math.max(Math.abs(y0), Math.abs(y1)));
    const [xFactor, xPrefix] = prefixed(Math.max(Math.abs(x0), Math.abs(x1)));
    const parts = [];
    const short = value => {
      const size = Math.abs(value), text = Number(value.toPrecision(6));
      return size && (size < 1e-3 || size >= 1e6) ? text.toExponential().replace("e+", "e") : text.toString();
    };
    for (const tick of marks(x0 / xFactor, x1 / xFactor)) {
      const x = this.x(tick * xFactor);
      parts.push(element("line", { class: "grid", x1: x, x2: x, y1: top, y2: height - bottom }));
      parts.push(element("text", { x, y: height - bottom + 14, "text-anchor": "middle" }, short(tick)));
    }
    for (const tick of marks(y0 / yFactor, y1 / yFactor)) {
      const y = this.y(tick * yFactor);
      parts.push(element("line", { class: "grid", x1: left, x2: width - right, y1: y, y2: y }));
      parts.push(element("text", { x: left - 5, y: y + 4, "text-anchor": "end" }, short(tick)));
    }
    parts.push(element("text", { x: (left + width - right) / 2, y: height - 4, "text-anchor": "middle" }, `time [${xPrefix}s]`));
    const name = `${this.group.title.toLowerCase()}${unit ? ` [${yPrefix}${unit}]` : ""}`;
    parts.push(element("text", { transform: `translate(12 ${(top + height - bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, name));
    const clip = `clip${Figure.count = (Figure.count || 0) + 1}`;
    parts.push(element("clipPath", { id: clip }, element("rect", { x: left, y: top, width: width - left - right, height: height - top - bottom })));
    this.lines.forEach((line, number) => {
      let path = "", pen = false;
      for (let k = 0; k < line.x.length; k++) {
        const inside = line.x[Math.min(k + 1, line.x.length - 1)] >= x0 && line.x[Math.max(k - 1, 0)] <= x1;
        if (!inside || !isFinite(line.y[k])) { pen = false; continue; }
        path += `${pen ? "L" : "M"}${this.x(line.x[k]).toFixed(2)} ${this.y(line.y[k]).toFixed(2)}`;
        pen = true;
      }
      const style = { class: "curve", d: path, stroke: HUES[number % HUES.length], "clip-path": `url(#${clip})` };
      parts.push(element("path", line.dashed ? { ...style, "stroke-dasharray": "6 4" } : style));
    });
    this.cursor = element("line", { class: "now", y1: top, y2: height - bottom });
    this.chosen = element("rect", { class: "chosen", y: top, height: height - top - bottom, width: 0, x: 0 });
    this.svg.replaceChildren(...parts, this.cursor, this.chosen);
    this.mark();
  }

  mark(time = this.now) {
    const seen = time !== null && time >= this.span[0] && time <= this.span[1];
    this.cursor.setAttribute("visibility", seen ? "visible" : "hidden");
    if (seen) for (const end of ["x1", "x2"]) this.cursor.setAttribute(end, this.x(time));
    this.legend.replaceChildren(...this.lines.map((line, number) => {
      const sample = element("i", { svg: 0, class: line.dashed ? "dashed" : "", style: `border-color:${HUES[number % HUES.length]}` });
      const value = time === null || !line.x.length ? "" : ` ${words(at(line, time), this.group.unit)}`;
      return element("span", {}, sample, element("b", {}, line.name), value);
    }));
  }

  listen() {
    const place = event => this.back((event.clientX - this.svg.getBoundingClientRect().left) * FRAME.width / this.svg.clientWidth);
    let start = null;
    this.svg.addEventListener("wheel", event => { event.preventDefault(); this.zoom(place(event), event.deltaY > 0 ? 1.25 : 0.8); }, { passive: false });
    this.svg.addEventListener("pointerdown", event => { start = place(event); this.svg.setPointerCapture(event.pointerId); });
    this.svg.addEventListener("pointermove", event => {
      const here = place(event);
      if (start === null) { this.mark(here); return; }
      const [low, high] = [Math.min(start, here), Math.max(start, here)].map(this.x);
      this.chosen.setAttribute("x", low);
      this.chosen.setAttribute("width", high - low);
    });
    this.svg.addEventListener("pointerup", event => {
      const [low, high] = [start, place(event)].sort((a, b) => a - b);
      const wide = start !== null && this.x(high) - this.x(low) > 6;
      start = null;
      this.chosen.setAttribute("width", 0);
      if (wide) this.show(low, high);
    });
    this.svg.addEventListener("pointerleave", () => { if (start === null) this.mark(); });
    this.svg.addEventListener("dblclick", () => this.whole());
    this.svg.addEventListener("keydown", event => {
      const [low, high] = this.span, step = 0.1 * (high - low), middle = (low + high) / 2;
      const does = { "+": () => this.zoom(middle, 0.8), "=": () => this.zoom(middle, 0.8), "-": () => this.zoom(middle, 1.25), "0": () => this.whole(),
        ArrowLeft: () => { const by = Math.min(step, low - this.all[0]); this.show(low - by, high - by); },
        ArrowRight: () => { const by = Math.min(step, this.all[1] - high); this.show(low + by, high + by); } }[event.key];
      if (does) { event.preventDefault(); does(); }
    });
  }
}

function at(line, time) {
  let low = 0, high = line.x.length - 1;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (line.x[middle] < time) low = middle + 1; else high = middle;
  }
  return low > 0 && time - line.x[low - 1] < line.x[low] - time ? line.y[low - 1] : line.y[low];
}

function numbers(text, kind) {
  const bytes = Uint8Array.from(atob(text), letter => letter.charCodeAt(0));
  return new { f8: Float64Array, i4: Int32Array, u2: Uint16Array }[kind](bytes.buffer);
}
