// The page of runs beside each other, or of a study.
class Clock {
  constructor(times) { this.times = times; this.index = 0; this.watchers = []; }
  watch(does) { this.watchers.push(does); }
  set(index) { this.index = index; for (const does of this.watchers) does(this.times[index], index); }
}

function table(title, rows, head) {
  const lines = rows.map(row => element("tr", {}, ...row.map((text, k) => k === 0 ? element("th", { scope: "row" }, String(text)) : text instanceof Node ? element("td", {}, text) : element("td", {}, String(text)))));
  const top = head ? [element("thead", {}, element("tr", {}, ...head.map(text => element("th", { scope: "col" }, text))))] : [];
  return element("section", { class: "card" }, element("h3", {}, title), element("div", { class: "wide" }, element("table", {}, ...top, element("tbody", {}, ...lines))));
}

function player(clock) {
  const last = clock.times.length - 1;
  const slider = element("input", { type: "range", min: 0, max: last, value: 0, "aria-label": "Frame of the film" });
  const play = element("button", { type: "button", "aria-pressed": "false" }, "Play");
  const shown = element("output", { class: "clock" });
  let timer = null;
  const stop = () => { clearInterval(timer); timer = null; play.textContent = "Play"; play.setAttribute("aria-pressed", "false"); };
  const start = () => {
    if (clock.index === last) clock.set(0);
    play.textContent = "Pause";
    play.setAttribute("aria-pressed", "true");
    timer = setInterval(() => clock.index < last ? clock.set(clock.index + 1) : stop(), Math.max(40, 6000 / (last + 1)));
  };
  play.addEventListener("click", () => timer ? stop() : start());
  slider.addEventListener("input", () => { if (timer) stop(); clock.set(Number(slider.value)); });
  slider.addEventListener("keydown", event => { if (event.key === " ") { event.preventDefault(); play.click(); } });
  clock.watch((time, index) => {
    slider.value = index;
    shown.textContent = words(time, "s");
    slider.setAttribute("aria-valuetext", `${words(time, "s")}, frame ${index + 1} of ${last + 1}`);
  });
  return element("div", { class: "bar" }, play, slider, shown);
}

function legend(view, place) {
  const { field, index } = view, rows = [];
  if (field.bodies.length) {
    const names = field.bodies.map((name, number) => {
      const step = 3 * Math.round((number - field.low) / (field.high - field.low) * 255);
      const sample = element("i", { svg: 0, style: `background:rgb(${view.table.slice(step, step + 3).join(",")})` });
      return element("span", {}, sample, name);
    });
    rows.push(element("div", { class: "names" }, ...names));
  } else {
    const strip = element("canvas", { width: 256, height: 1, "aria-hidden": "true" });
    const ink = strip.getContext("2d");
    for (let k = 0; k < 256; k++) { ink.fillStyle = `rgb(${view.table.slice(3 * k, 3 * k + 3).join(",")})`; ink.fillRect(k, 0, 1, 1); }
    rows.push(element("div", { class: "scale" }, words(field.low, field.unit), strip, words(field.high, field.unit)));
    rows.push(element("p", { class: "quiet" }, `Largest value in this frame: ${words(field.peaks[index], field.unit)}`));
  }
  place.replaceChildren(...rows);
}

function surfaceCard(run, clock) {
  const card = element("section", { class: "card" }, element("h3", {}, "Surface"));
  const surface = run.surface;
  if (!surface) { card.append(element("p", {}, run.without)); return card; }
  const place = element("div", { class: "view", tabindex: 0, role: "img", "aria-label": "Surface of the bodies. Drag or use the arrow keys to turn it, plus and minus to zoom." });
  card.append(place);
  let view;
  try { view = new View(place, surface); } catch (error) {
    place.remove();
    card.append(element("p", {}, "This browser shows no WebGL, which the surface needs; the film shows the run."));
    return card;
  }
  const choice = element("select", { "aria-label": "Field that colours the surface" }, ...surface.fields.map((field, number) => element("option", { value: number }, field.name)));
  const home = element("button", { type: "button" }, "Reset view");
  const colours = element("div");
  const bar = element("div", { class: "bar" }, choice, home);
  if (surface.obstacles.length) {
    const box = element("input", { type: "checkbox", checked: "" });
    box.addEventListener("change", () => view.showObstacles(box.checked));
    bar.append(element("label", {}, box, " obstacles"));
  }
  choice.addEventListener("change", () => { view.choose(Number(choice.value)); legend(view, colours); });
  home.addEventListener("click", () => view.home());
  clock.watch((time, index) => { view.show(index); legend(view, colours); });
  card.append(colours, bar, element("p", { class: "quiet" }, "Drag to turn, wheel to zoom, right button to move; or the arrow keys, plus and minus."));
  return card;
}

function filmCard(run, clock) {
  const card = element("section", { class: "card" }, element("h3", {}, "Film"));
  if (!run.film.length) { card.append(element("p", {}, run.without)); return card; }
  const picture = element("img", { class: "film", alt: `Pictures of ${run.title}` });
  clock.watch((time, index) => { picture.src = `data:image/jpeg;base64,${run.film[index]}`; });
  card.append(picture, player(clock));
  return card;
}

function figureCard(group, clock) {
  const card = element("section", { class: "card figure" });
  new Figure(card, group, clock);
  return card;
}

function columnsCard(run, clock) {
  const choice = element("select", { "aria-label": "Column of the history" }, ...run.columns.map((group, number) => element("option", { value: number }, group.title)));
  const place = element("div");
  const show = () => { place.replaceChildren(); new Figure(place, run.columns[Number(choice.value)], clock); };
  choice.addEventListener("change", show);
  show();
  return element("section", { class: "card figure" }, element("h3", {}, "Any column of the history"), choice, place);
}

function runSection(run) {
  const clock = new Clock(run.times.length ? run.times : [0]);
  const verdict = element("p", { class: `verdict ${run.verdict.good ? "good" : "bad"}` }, `${run.verdict.good ? "✓" : "✗"} ${run.verdict.text}`);
  const section = element("section", { class: "run" }, element("h2", {}, run.title), verdict);
  if (run.verdict.message) section.append(element("p", {}, run.verdict.message));
  const cards = element("div", { class: "cards" }, surfaceCard(run, clock), filmCard(run, clock));
  section.append(cards);
  for (const group of run.figures) cards.append(figureCard(group, clock));
  if (run.columns.length) cards.append(columnsCard(run, clock));
  if (run.checks.length) {
    const rows = run.checks.map(one => [one.name, one.value, one.bound, element("span", { class: one.passed ? "good" : "bad" }, one.passed ? "✓ passed" : "✗ failed")]);
    cards.append(table("Checks", rows, ["check", "value", "bound", "verdict"]));
  }
  for (const [title, rows] of run.tables) if (rows.length) cards.append(table(title, rows));
  clock.set(clock.times.length - 1);
  return section;
}

function studySection(study) {
  const section = element("section", { class: "run" }, element("h2", {}, study.title));
  if (study.picture) section.append(element("section", { class: "card" }, element("img", { src: `data:image/png;base64,${study.picture}`, alt: "Error against wall time of every method" })));
  section.append(table("Rows", study.rows, study.head));
  return section;
}

const data = JSON.parse(document.getElementById("data").textContent);
document.getElementById("runs").append(...data.runs.map(runSection), ...data.studies.map(studySection));
document.documentElement.dataset.ready = "yes";
