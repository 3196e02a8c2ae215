// Live figures: one crosshair through the panels of figures 2, 4 and 7, or the motions of the design point beside the
// device's sketch; under each the numbers of the motion, and the device that plays it. It begins at the design point.
// Everything it shows is in the page; without it the page says the same.
(() => {
  "use strict";
  const source = document.getElementById("live-data");
  if (!source) return;
  const data = JSON.parse(source.textContent);
  const DIGITS = 5, SECONDS_PER_PERIOD = 2.5, FLASH = 0.06, NEAR = 12, TAU = 2 * Math.PI;
  const still = matchMedia("(prefers-reduced-motion: reduce)");

  const make = (name, attributes = {}, ...children) => {
    const drawn = ["svg", "g", "line", "circle", "rect"].includes(name);
    const node = drawn ? document.createElementNS("http://www.w3.org/2000/svg", name) : document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    node.append(...children);
    return node;
  };
  const print = (value) => (typeof value === "number" ? value.toPrecision(DIGITS) : value).replaceAll("-", "\u2212");
  const place = (node, attributes) => {
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  };

  // The motion that is shown: a branch and a row of it.
  let [branch, row] = data.start, playing = !still.matches, time = 0, before = null;
  const value = (name) => data.branches[branch].columns[name][row];
  const POINTING = "Point at a curve, or move the slider: this is the motion there.";
  const OUTSIDE = "Outside the membrane's geometry: no voltages, only a ranking.";

  // Integrals of the force over its phase, once for the velocity and twice for the position; of a sine sin and -cos.
  const once = (phase) => data.force.reduce((sum, [k, c, s]) => sum + (c * Math.sin(k * phase) - s * Math.cos(k * phase)) / k, 0);
  const twice = (phase) => data.force.reduce((sum, [k, c, s]) => sum - (c * Math.cos(k * phase) + s * Math.sin(k * phase)) / k ** 2, 0);

  // Z between the membranes a time t after a bottom impact, Eq. (2.12); lengths in x_c, times in t_c.
  const relative = (t) => {
    const up = 2 * data.n * value("q"), d = value("d");
    const [name, start, wall] = t < up ? ["bottom", 0, d / 2] : ["top", up, -d / 2];
    const e = t - start, phase = value(`phi_${name}_rad`);
    const z = wall + (value(`after_${name}`) + (value(`gravity_${name}`) * e) / 2 - once(phase) / Math.PI) * e
      + (twice(Math.PI * e + phase) - twice(phase)) / Math.PI ** 2;
    return Math.max(-d / 2, Math.min(d / 2, z));
  };

  // The device, drawn under each figure; those that are shown move together.
  const deviceOf = () => {
    const bottom = make("line", { class: "bottom" }), top = make("line", { class: "top" });
    const capsule = make("rect", { class: "capsule" }), ball = make("circle", { class: "ball", r: 5 });
    const turned = make("g", {}, capsule, bottom, top, ball);
    const device = make("svg", { viewBox: "-100 -100 200 200", class: "device", role: "img" }, turned);
    const draw = () => {
      const d = value("d"), scale = 170 / (d + 2 / Math.PI ** 2), half = (d / 2) * scale;
      const t = time % (2 * data.n), up = 2 * data.n * value("q");
      const centre = (twice(Math.PI * t + value("phi_bottom_rad")) / Math.PI ** 2) * scale;
      const angle = data.angle === null ? value("sweep_value") : data.angle;
      place(turned, { transform: `rotate(${-angle})` });
      place(capsule, { x: centre - half, y: -9, width: 2 * half, height: 18 });
      place(bottom, { x1: centre - half, x2: centre - half, y1: -12, y2: 12 });
      place(top, { x1: centre + half, x2: centre + half, y1: -12, y2: 12 });
      place(ball, { cx: centre - relative(t) * scale * (1 - 5 / Math.max(half, 6)), cy: 0 });
      const since = (start) => (((t - start) % (2 * data.n)) + 2 * data.n) % (2 * data.n);
      bottom.classList.toggle("struck", since(0) < 2 * FLASH);
      top.classList.toggle("struck", since(up) < 2 * FLASH);
    };
    return { device, draw };
  };

  const open = () => figures.filter(({ panel }) => !panel.hidden);
  const step = (now) => {
    if (!playing || !open().length) { before = null; return; }
    if (before !== null) time += ((now - before) / 1000) * (2 / SECONDS_PER_PERIOD);
    before = now;
    for (const { draw } of open()) draw();
    requestAnimationFrame(step);
  };
  const play = () => {
    for (const { button } of figures) button.textContent = playing ? "Pause" : "Play";
    if (playing && before === null) requestAnimationFrame(step);
  };
  still.addEventListener("change", () => { playing = !still.matches; play(); });

  // The panel under a figure, in the flow of the page: it covers nothing.
  const panelOf = (name) => {
    const { device, draw } = deviceOf();
    const button = make("button", { type: "button" }), close = make("button", { type: "button" }, "Close");
    const kind = make("strong"), numbers = make("dl"), doubt = make("p", { class: "doubt", hidden: "" }, OUTSIDE);
    const cells = data.readings.map(([key, label, unit]) => {
      const cell = make("dd", { "data-name": key });
      numbers.append(make("div", {}, make("dt", {}, unit ? `${label} [${unit}]` : label), cell));
      return [key, cell];
    });
    const hint = data.figures[name] === null ? [] : [make("p", { class: "hint" }, POINTING)];
    const panel = make("aside", { class: "live", "aria-label": `Motion shown, ${name}`, hidden: "" },
      device, make("div", {}, make("p", {}, kind, " ", button, " ", close), ...hint, numbers, doubt));
    button.addEventListener("click", () => { playing = !playing; play(); });
    return { panel, device, draw, button, close, kind, cells, doubt };
  };

  // A figure's drawing, of which there are two where a narrow screen shows another one, with its crosshair. The places
  // that the page knows are those of the wide one; across and down give where they are in this one.
  const drawingOf = (name, svg) => {
    const moved = svg.classList.contains("narrow") ? data.narrow[name] : null;
    const to = ([factor, shift], at) => factor * at + shift;
    const [y1, y2] = moved ? moved.extent : data.figures[name];
    const line = make("line", { y1, y2 });
    const dots = data.branches[0].places[name].slice(1).map(() => make("circle", { r: 3 }));
    const cross = make("g", { class: "cross", visibility: "hidden" }, line, ...dots);
    svg.append(cross);
    return { name, svg, line, dots, cross, across: (x) => (moved ? to(moved.across, x) : x),
      down: (k, y) => (moved ? to(moved.down[k], y) : y) };
  };

  // The figures
  const figures = Object.entries(data.figures).map(([name, extent]) => {
    const drawn = [...document.querySelectorAll(`svg[data-figure="${name}"]`)];
    if (!drawn.length) return null;
    const figure = { name, ...panelOf(name) };
    const choice = make("select", { "aria-label": `Motions, ${name}` },
      ...data.branches.map((x, k) => make("option", { value: k }, x.name)));
    const slider = make("input", { type: "range", min: 0, step: 1, "aria-label": `Motion along the branch, ${name}` });
    const control = make("div", { class: "live-control" }, choice, ...(extent === null ? [] : [slider]));
    drawn[0].parentNode.after(control);
    control.after(figure.panel);
    Object.assign(figure, { slider, choice, drawings: extent === null ? [] : drawn.map((svg) => drawingOf(name, svg)) });
    slider.addEventListener("input", () => show(branch, Number(slider.value), figure));
    choice.addEventListener("change", () => changeBranch(Number(choice.value), figure));
    figure.close.addEventListener("click", () => {
      figure.panel.hidden = true;
      for (const { cross } of figure.drawings) cross.setAttribute("visibility", "hidden");
    });
    for (const drawing of figure.drawings) {
      for (const kind of ["pointermove", "pointerdown"]) {
        drawing.svg.addEventListener(kind, (event) => {
          const [b, i] = nearest(drawing, event);
          show(b, i, figure);
        });
      }
      drawing.svg.addEventListener("click", (event) => {
        const [b, i, distance] = nearest(drawing, event, (b, i) => i in data.branches[b].labels);
        if (distance < NEAR) location.hash = `#point-${data.branches[b].labels[i]}`;
      });
    }
    return figure;
  }).filter(Boolean);

  // The motion whose curves come nearest to the pointer, of those that are wanted, and how near [units of the drawing].
  const nearest = ({ name, svg, across: toX, down: toY }, event, wanted = () => true) => {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    let best = [branch, row, Infinity];
    data.branches.forEach(({ places }, b) => {
      const [across, ...curves] = places[name];
      curves.forEach((curve, k) => curve.forEach((at, i) => {
        const distance = at === null ? Infinity : Math.hypot(toX(across[i]) - x, toY(k, at) - y);
        if (distance < best[2] && wanted(b, i)) best = [b, i, distance];
      }));
    });
    return best;
  };

  const changeBranch = (to, { name }) => {
    if (data.figures[name] === null) return show(to, 0);
    const at = data.branches[branch].places[name][0][row];
    const across = data.branches[to].places[name][0].map((x) => Math.abs(x - at));
    show(to, across.indexOf(Math.min(...across)));
  };

  const show = (b, i, { panel } = {}) => {
    [branch, row] = [b, i];
    if (panel) panel.hidden = false;
    const { columns, places, words, labels, outside } = data.branches[branch];
    for (const { name, drawings, slider, choice, device, draw, kind, cells, doubt } of figures) {
      choice.value = branch;
      for (const { line, dots, cross, across: toX, down: toY } of drawings) {
        const [across, ...curves] = places[name], x = toX(across[row]);
        place(line, { x1: x, x2: x });
        curves.forEach((curve, k) => {
          const at = curve[row];
          place(dots[k], at === null ? { visibility: "hidden" } : { cx: x, cy: toY(k, at), visibility: "inherit" });
        });
        cross.setAttribute("visibility", "visible");
      }
      if (drawings.length) {
        const [across] = places[name];
        place(slider, { max: across.length - 1, "aria-valuetext": `${data.swept} ${print(value("sweep_value"))} ${data.unit}, ${words[row]}` });
        slider.value = row;
      }
      kind.textContent = labels[row] ? `${words[row]}, ${labels[row]}` : words[row];
      for (const [key, cell] of cells) {
        const error = columns[`${key}_error`];  // of what was measured, a standard error
        cell.textContent = print(columns[key][row]) + (error ? ` ± ${error[row].toPrecision(2)}` : "");
      }
      doubt.hidden = !outside.includes(row);
      place(device, { "aria-label": `The device in this motion: ${words[row]}` });
      draw();
    }
    play();
  };

  // From the row of a critical point back to its place in the first figure.
  data.branches.forEach(({ labels }, b) => {
    for (const [i, label] of Object.entries(labels)) {
      const cell = document.getElementById(`point-${label}`);
      if (!cell || cell.querySelector("a") || !figures.length) continue;
      const link = make("a", { href: `#${figures[0].name}` }, ...cell.childNodes);
      link.addEventListener("click", () => show(b, Number(i), figures[0]));
      cell.append(link);
    }
  });

  // What is unstable can be taken out of a figure that is crowded with it.
  for (const frame of document.querySelectorAll(":has(> svg.figure .unstable)")) {
    const box = make("input", { type: "checkbox", checked: "" });
    frame.after(make("label", { class: "live-control" }, box, "Show unstable motions"));
    box.addEventListener("change", () => frame.classList.toggle("stable-only", !box.checked));
  }

  if (figures.length) show(branch, row, figures[0]);
})();
