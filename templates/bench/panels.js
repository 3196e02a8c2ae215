// The figures along the sweep: their panels, drawn from answers alone.
import { FEWEST, clamp, make, named, show, shown, ticksOf, unitOf } from "./elements.js";

const TURN = 2 * Math.PI;
const QUARTERS = ["0", "π/2", "π", "3π/2", "2π"];
const EDGE = { left: 58, right: 14, top: 20, bottom: 34 }; // room for ticks and names around a panel [px]
const HEIGHTS = { 1: 330, 2: 230, 3: 168 }; // of a panel, by how many there are [px]
const NEAR = 200; // of the first one above the sliders of a narrow screen [px]
const LABEL = 22; // width of the label of a critical point [px]

const size = (values) => values.map(Math.abs);
const curve = (name, values, side) => ({ name, values, side });

const ofVelocities = (x) => [
  curve("bottom", size(x.velocity_bottom), "bottom"),
  curve("top", size(x.velocity_top), "top"),
];
const ofPhases = (x) => [curve("bottom", x.phi_bottom_rad, "bottom"), curve("top", x.phi_top_rad, "top")];
const rest = (shares) => shares.map((q) => 1 - q);
const ofFlights = (x) => [curve("from the bottom", x.q, "bottom"), curve("from the top", rest(x.q), "top")];
const ofEigenvalues = (x) =>
  x.multiplier_1 ? [curve("λ₁", x.multiplier_1, "only"), curve("λ₂", x.multiplier_2, "only")] : [];
const ofVoltages = (x) => {
  if (!x.u_ave_v) return [];
  return [
    curve("bottom", x.u_bottom_v, "bottom"),
    curve("top", x.u_top_v, "top"),
    curve("average", x.u_ave_v, "average"),
  ];
};

/**
 * The panels of each figure: `of` gives the curves of a branch, or of the motions of the design point; `measured` reads
 * a measured impact; beyond `floor` and `ceiling` nothing needs to be seen, and at `bounds` there is a line.
 */
export const FIGURES = {
  "Figure 2: impacts": [
    {
      label: "impact velocity |Ż| [–]",
      of: ofVelocities,
      floor: 0,
      measured: (impact) => Math.abs(impact.velocity),
    },
    { label: "phase φ [rad]", of: ofPhases, angle: true, measured: (impact) => impact.phase_rad },
    { label: "flight time over the period [–]", of: ofFlights },
  ],
  "Figure 4: stability": [
    { label: "discriminant Δ [–]", of: (x) => [curve("Δ", x.discriminant, "only")], ceiling: 2.6, bounds: [0] },
    { label: "eigenvalues λ, or Re λ [–]", of: ofEigenvalues, ceiling: 1.6, floor: -1.6, bounds: [-1, 1] },
  ],
  "Figure 7: voltages": [{ label: "voltage U [V]", of: ofVoltages }],
};

/** The panels of a figure that there is something for, in an answer. */
export const panelsOf = (figure, answer) =>
  FIGURES[figure].filter((panel) => answer.branches.length === 0 || panel.of(answer.branches[0]).length);

/** The stable ranges of an answer in words. */
const rangesOf = ({ stable, swept }) =>
  stable.map(([from, to]) => `${shown(from, FEWEST)} to ${shown(to, FEWEST)} ${swept.unit}`).join(" and ");

/** The strokes of one curve on one piece of a branch, broken where a phase comes round. */
const stroke = (x, y, [first, last], scale, angle) => {
  let path = "";
  let pen = "M";
  for (let k = first; k <= last; k += 1) {
    if (angle && k > first && Math.abs(y[k] - y[k - 1]) > Math.PI) pen = "M";
    path += `${pen}${scale.x(x[k]).toFixed(1)} ${scale.y(y[k]).toFixed(1)}`;
    pen = "L";
  }
  return path;
};

/** From where to where a panel goes: what is drawn in it, as far as it needs to be seen, and some room. */
const extentOf = (panel, answers) => {
  if (panel.angle) return [0, TURN];
  let [low, high] = [Infinity, -Infinity];
  const seen = (value) => {
    low = Math.min(low, value);
    high = Math.max(high, value);
  };
  for (const { branches } of answers)
    for (const branch of branches)
      for (const { values } of panel.of(branch))
        for (const [first, last] of branch.pieces) for (let k = first; k <= last; k += 1) seen(values[k]);
  if (low > high) return [0, 1];
  for (const bound of panel.bounds ?? []) seen(bound);
  low = Math.max(low, panel.floor ?? -Infinity);
  high = Math.min(high, panel.ceiling ?? Infinity);
  const room = 0.06 * (high - low || Math.abs(high) || 1);
  return [panel.floor === 0 ? Math.max(0, low - room) : low - room, high + room];
};

/** Where values are in a panel [px]; what is far beyond it is just beyond it. */
const scaleOf = (panel, answers, width, height) => {
  const { from, to } = answers[0].swept;
  const [low, high] = extentOf(panel, answers);
  const [span, inner, bottom] = [high - low, width - EDGE.left - EDGE.right, height - EDGE.bottom];
  return {
    ...{ low, high, inner, bottom, width, height },
    x: (value) => EDGE.left + ((value - from) / (to - from)) * inner,
    y: (value) => bottom - ((clamp(value, low - span, high + span) - low) / span) * (bottom - EDGE.top),
    value: (x) => from + clamp((x - EDGE.left) / inner, 0, 1) * (to - from),
  };
};

/** The curves of all answers, those of the first over the others, and stable ones over unstable ones. */
const curvesOf = (panel, answers, scale) =>
  [...answers].reverse().flatMap((answer) =>
    [false, true].flatMap((stable) =>
      answer.branches.flatMap((branch) => {
        const pieces = branch.pieces.filter((piece) => piece[2] === stable);
        return panel.of(branch).map(({ values, side }) =>
          make("path", {
            class: `curve ${answer === answers[0] ? side : "kept"} ${stable ? "stable" : "unstable"}`,
            d: pieces.map((piece) => stroke(branch.sweep_value, values, piece, scale, panel.angle)).join(""),
          }),
        );
      }),
    ),
  );

const ticksOfPanel = (panel, swept, scale) => {
  const quarters = QUARTERS.map((text, k) => [(k * TURN) / 4, text]);
  const up = panel.angle ? quarters : ticksOf(scale.low, scale.high, 4).map((value) => [value, show(value)]);
  const across = ticksOf(swept.from, swept.to, scale.width < 500 ? 4 : 7);
  return [
    ...up.flatMap(([value, text]) => [
      make("line", { class: "tick", x1: EDGE.left - 4, x2: EDGE.left, y1: scale.y(value), y2: scale.y(value) }),
      make("text", { class: "number", x: EDGE.left - 7, y: scale.y(value) + 4 }, text),
    ]),
    ...across.flatMap((value) => [
      make("line", { class: "tick", x1: scale.x(value), x2: scale.x(value), y1: scale.bottom, y2: scale.bottom + 4 }),
      make("text", { class: "number across", x: scale.x(value), y: scale.bottom + 16 }, show(value)),
    ]),
  ];
};

/** The critical points: labels that would lie on one another are left out; the title of each line has them. */
const eventsOf = ({ points, swept }, scale, labelled) => {
  let free = labelled ? -Infinity : Infinity;
  const within = points.filter(({ sweep_value: value }) => value >= swept.from && value <= swept.to);
  return within
    .sort((one, other) => one.sweep_value - other.sweep_value)
    .flatMap(({ label, words, sweep_value: value }) => {
      const x = scale.x(value);
      const line = make("line", { class: "event", x1: x, x2: x, y1: EDGE.top, y2: scale.bottom });
      line.append(make("title", {}, `${label} ${words} at ${shown(value, FEWEST)} ${swept.unit}`));
      if (x <= free) return [line];
      free = x + LABEL;
      return [line, make("text", { class: "event-label", x: x + 3, y: EDGE.top + 11 }, label)];
    });
};

/** The design point: a line, and its motions on the curves, hollow where they are not stable. */
const designOf = (panel, { motions, swept }, scale) => {
  if (swept.value === null) return [];
  const x = scale.x(swept.value);
  const line = make("line", { class: "design", x1: x, x2: x, y1: EDGE.top, y2: scale.bottom });
  if (motions === null) return [line];
  const marks = panel.of(motions).flatMap(({ values, side }) =>
    values.map((value, row) => {
      if (!motions.admissible[row] || value < scale.low || value > scale.high) return null;
      const hollow = motions.stability[row].startsWith("stable") ? "" : "hollow";
      return make("circle", { class: `at-design ${side} ${hollow}`, cx: x, cy: scale.y(value), r: 4 });
    }),
  );
  return [line, ...marks];
};

/** The measured 1:1 motions that a panel shows. */
const measuredOf = (panel, records, scale) =>
  (panel.measured ? records : [])
    .filter(({ word, sweep_value: value }) => word === "BT" && value !== null)
    .flatMap(({ impacts, sweep_value: value }) =>
      impacts.map((impact) => {
        const [x, y] = [scale.x(value), scale.y(panel.measured(impact))];
        return make("circle", { class: `measured ${impact.membrane}`, cx: x, cy: y, r: 3 });
      }),
    );

/**
 * The panels of a figure.
 *
 * `answers` are that of the page and, as thin curves, one that it is compared with; `records` what was measured;
 * `moved` is told the value of the swept input that is pointed at; where it is `narrow`, the first panel stands apart.
 */
export const drawPanels = (figure, answers, records, width, moved, narrow) => {
  const [answer] = answers;
  const { swept } = answer;
  const shown = panelsOf(figure, answer);
  return shown.map((panel, number) => {
    const apart = narrow && number === 0;
    const scale = scaleOf(panel, answers, width, apart ? NEAR : HEIGHTS[shown.length]);
    const frame = { x: EDGE.left, y: EDGE.top, width: scale.inner, height: scale.bottom - EDGE.top };
    const window = { viewBox: `${frame.x} ${frame.y} ${frame.width} ${frame.height}`, overflow: "hidden" };
    const lines = (panel.bounds ?? []).map((bound) => {
      const y = scale.y(bound);
      return make("line", { class: "bound", x1: frame.x, x2: frame.x + frame.width, y1: y, y2: y });
    });
    const bars = answer.stable.map(([from, to]) => {
      const bar = { x: scale.x(from), y: scale.bottom - 3, width: Math.max(1, scale.x(to) - scale.x(from)), height: 3 };
      return make("rect", { class: "stable-bar", ...bar });
    });
    const axis = `${swept.quantity} ${named(swept.symbol)}${unitOf(swept.unit)}`;
    const stable = rangesOf(answer) || "no value";
    const ends = `from ${show(swept.from)} to ${show(swept.to)} ${swept.unit}`;
    const svg = make(
      "svg",
      {
        ...{ viewBox: `0 0 ${width} ${scale.height}`, width, height: scale.height, class: "panel", role: "img" },
        "aria-label": `${panel.label} along ${swept.quantity}, ${ends}; stable for ${stable}`,
      },
      make("rect", { class: "frame", ...frame }),
      make("svg", { ...frame, ...window }, lines, curvesOf(panel, answers, scale), measuredOf(panel, records, scale)),
      make("text", { class: "label", x: EDGE.left + 4, y: EDGE.top - 6 }, panel.label),
      ticksOfPanel(panel, swept, scale),
      apart || number === shown.length - 1
        ? make("text", { class: "label across", x: EDGE.left + scale.inner / 2, y: scale.height - 4 }, axis)
        : null,
      eventsOf(answer, scale, number === 0),
      designOf(panel, answer, scale),
      bars,
    );
    const point = (event) => {
      const box = svg.getBoundingClientRect();
      moved(scale.value(((event.clientX - box.left) / box.width) * width));
    };
    svg.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      svg.setPointerCapture(event.pointerId);
      point(event);
    });
    svg.addEventListener("pointermove", (event) => {
      if (event.buttons & 1) point(event);
    });
    return svg;
  });
};

/** What the lines of a figure mean. */
export const legendOf = (figure, answers) => {
  const [answer] = answers;
  const [panel] = panelsOf(figure, answer);
  const key = (side, name) => make("span", { class: `key ${side}` }, name);
  const curves = panel && answer.branches[0] ? panel.of(answer.branches[0]) : [];
  const names = curves.filter(({ side }, k) => curves.findIndex((own) => own.side === side) === k);
  return [
    ...names.map(({ side, name }) => key(side, name)),
    key("stable-key", "stable"),
    key("unstable-key", "unstable"),
    key("range-key", "where 1:1 motion is stable"),
    ...(answers.length > 1 ? [key("kept", "A")] : []),
  ];
};
