// Live figures: one crosshair through the panels of figures 2, 4 and 7, the numbers of the motion under it, and the
// device that plays this motion. Everything it shows is in the page; without it the page says the same.
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

  // The motion under the crosshair: a branch and a row of it.
  let branch = 0, row = 0, playing = !still.matches, time = 0, before = null;
  const value = (name) => data.branches[branch].columns[name][row];

  // The device

  const bottom = make("line", { class: "bottom" }), top = make("line", { class: "top" });
  const capsule = make("rect", { class: "capsule" }), ball = make("circle", { class: "ball", r: 5 });
  const turned = make("g", {}, capsule, bottom, top, ball);
  const device = make("svg", { viewBox: "-100 -100 200 200", class: "device", role: "img" }, turned);

  // Z between the membranes a time t after a bottom impact, Eq. (2.12); lengths in x_c, times in t_c.
  const relative = (t) => {
    const up = 2 * data.n * value("q"), d = value("d");
    const [name, start, wall] = t < up ? ["bottom", 0, d / 2] : ["top", up, -d / 2];
    const e = t - start, phase = value(`phi_${name}_rad`), after = -(data.r[name] ?? data.r) * value(`velocity_${name}`);
    const z = wall + (after + (value("gbar") * e) / 2 - Math.sin(phase) / Math.PI) * e
      - (Math.cos(Math.PI * e + phase) - Math.cos(phase)) / Math.PI ** 2;
    return Math.max(-d / 2, Math.min(d / 2, z));
  };

  const drawDevice = () => {
    const d = value("d"), scale = 170 / (d + 2 / Math.PI ** 2), half = (d / 2) * scale;
    const t = time % (2 * data.n), up = 2 * data.n * value("q");
    const centre = (-Math.cos(Math.PI * t + value("phi_bottom_rad")) / Math.PI ** 2) * scale;
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

  const step = (now) => {
    if (!playing || panel.hidden) { before = null; return; }
    if (before !== null) time += ((now - before) / 1000) * (2 / SECONDS_PER_PERIOD);
    before = now;
    drawDevice();
    requestAnimationFrame(step);
  };
  const play = () => {
    button.textContent = playing ? "Pause" : "Play";
    if (playing && before === null) requestAnimationFrame(step);
  };

  // The panel at the foot of the window

  const button = make("button", { type: "button" }), close = make("button", { type: "button" }, "Close");
  const kind = make("strong"), numbers = make("dl");
  const cells = data.readings.map(([name, label, unit]) => {
    const cell = make("dd", { "data-name": name });
    numbers.append(make("div", {}, make("dt", {}, unit ? `${label} [${unit}]` : label), cell));
    return [name, cell];
  });
  const panel = make("aside", { class: "live", "aria-label": "Motion at the crosshair", hidden: "" },
    device, make("div", {}, make("p", {}, kind, " ", button, " ", close), numbers));
  document.body.append(panel);
  button.addEventListener("click", () => { playing = !playing; play(); });
  close.addEventListener("click", () => {
    panel.hidden = true;
    for (const figure of figures) figure.cross.setAttribute("visibility", "hidden");
  });
  still.addEventListener("change", () => { playing = !still.matches; play(); });

  // The figures

  const figures = Object.entries(data.figures).map(([name, [low, high]]) => {
    const svg = document.querySelector(`svg[data-figure="${name}"]`);
    if (!svg) return null;
    const line = make("line", { y1: low, y2: high });
    const dots = data.branches[0].places[name].slice(1).map(() => make("circle", { r: 3 }));
    const cross = make("g", { class: "cross", visibility: "hidden" }, line, ...dots);
    svg.append(cross);
    const slider = make("input", { type: "range", min: 0, step: 1, "aria-label": `Motion along the branch, ${name}` });
    const choice = make("select", { "aria-label": `Branch, ${name}` },
      ...data.branches.map((x, k) => make("option", { value: k }, x.name)));
    const control = make("div", { class: "live-control" }, choice, slider);
    svg.parentNode.after(control);
    const figure = { name, svg, line, dots, cross, slider, choice, control };
    slider.addEventListener("input", () => show(branch, Number(slider.value), figure));
    choice.addEventListener("change", () => changeBranch(Number(choice.value), figure));
    for (const kind of ["pointermove", "pointerdown"]) {
      svg.addEventListener(kind, (event) => {
        const [b, i] = nearest(figure, event);
        show(b, i, figure);
      });
    }
    svg.addEventListener("click", (event) => {
      const [b, i, distance] = nearest(figure, event, (b, i) => i in data.branches[b].labels);
      if (distance < NEAR) location.hash = `#point-${data.branches[b].labels[i]}`;
    });
    return figure;
  }).filter(Boolean);

  // The motion whose curves come nearest to the pointer, of those that are wanted, and how near [units of the drawing].
  const nearest = ({ name, svg }, event, wanted = () => true) => {
    const { x, y } = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    let best = [branch, row, Infinity];
    data.branches.forEach(({ places }, b) => {
      const [across, ...curves] = places[name];
      for (const curve of curves) {
        curve.forEach((at, i) => {
          const distance = at === null ? Infinity : Math.hypot(across[i] - x, at - y);
          if (distance < best[2] && wanted(b, i)) best = [b, i, distance];
        });
      }
    });
    return best;
  };

  const changeBranch = (to, figure) => {
    const at = data.branches[branch].places[figure.name][0][row];
    const across = data.branches[to].places[figure.name][0].map((x) => Math.abs(x - at));
    show(to, across.indexOf(Math.min(...across)), figure);
  };

  const show = (b, i, from) => {
    [branch, row] = [b, i];
    const { columns, places, words, labels } = data.branches[branch];
    for (const { name, line, dots, cross, slider, choice } of figures) {
      const [across, ...curves] = places[name];
      place(line, { x1: across[row], x2: across[row] });
      curves.forEach((curve, k) => {
        const at = curve[row];
        place(dots[k], at === null ? { visibility: "hidden" } : { cx: across[row], cy: at, visibility: "inherit" });
      });
      cross.setAttribute("visibility", "visible");
      choice.value = branch;
      place(slider, { max: across.length - 1, "aria-valuetext": `${data.swept} ${print(value("sweep_value"))} ${data.unit}, ${words[row]}` });
      slider.value = row;
    }
    kind.textContent = labels[row] ? `${words[row]}, ${labels[row]}` : words[row];
    for (const [name, cell] of cells) cell.textContent = print(columns[name][row]);
    place(device, { "aria-label": `The device in this motion: ${words[row]}` });
    if (panel.hidden) {
      panel.hidden = false;
      play();
    }
    if (from && panel.previousElementSibling !== from.control) from.control.after(panel);
    drawDevice();
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

  for (const { slider, choice } of figures) {
    place(slider, { max: data.branches[0].columns.d.length - 1, value: 0 });
    choice.value = branch;
  }
})();
