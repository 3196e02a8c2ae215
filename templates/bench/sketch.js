// The device in motion: the capsule, its membranes and the ball, by places that the program has worked out.
import { clamp, make, place } from "./elements.js";

const SECONDS_PER_PERIOD = 2.5;
const ROOM = 170; // of the capsule and its way, from end to end
const BALL = 6; // radius
const REACH = 0.3; // of a capsule whose way is not known, over its length

/** The value of sampled numbers between two samples. */
const between = (values, k, share) => values[k] + share * (values[k + 1] - values[k]);

/** A sketch that moves: `show` gives it a path and an inclination, `end` stops it. */
export const deviceInMotion = () => {
  const bottom = make("line", { class: "wall bottom" });
  const top = make("line", { class: "wall top" });
  const tube = make("rect", { class: "tube" });
  const ball = make("circle", { class: "ball", r: BALL, cy: 0 });
  const turned = make("g", {}, tube, bottom, top, ball);
  const named = { role: "img", "aria-label": "The device in motion" };
  const svg = make("svg", { viewBox: "-100 -100 200 200", class: "device", ...named }, turned);
  let path = null;
  let reach = REACH;
  let time = 0;
  let before = null;
  let playing = !matchMedia("(prefers-reduced-motion: reduce)").matches;

  const put = (centre, distance) => {
    const length = ROOM / (1 + 2 * reach);
    const [low, high] = [centre * length - length / 2, centre * length + length / 2];
    place(tube, { x: low, y: -10, width: length, height: 20 });
    // The bottom membrane is at +d/2 of Z = X - x: the lower end of the inclined capsule.
    place(bottom, { x1: low, x2: low, y1: -13, y2: 13 });
    place(top, { x1: high, x2: high, y1: -13, y2: 13 });
    place(ball, { cx: low + BALL + distance * (length - 2 * BALL) });
  };

  const draw = () => {
    svg.classList.toggle("still", path === null);
    if (path === null) {
      put(0, 0);
      return;
    }
    const now = time % path.time.at(-1);
    const k = clamp(path.time.findIndex((own) => own > now) - 1, 0, path.time.length - 2);
    const share = clamp((now - path.time[k]) / (path.time[k + 1] - path.time[k] || 1), 0, 1);
    put(between(path.capsule, k, share), between(path.distance, k, share));
  };

  const step = (now) => {
    if (!playing) {
      before = null;
      return;
    }
    if (before !== null) time += (now - before) / 1000 / SECONDS_PER_PERIOD;
    before = now;
    draw();
    requestAnimationFrame(step);
  };

  const button = make("button", { type: "button" });
  const play = (wanted) => {
    playing = wanted;
    button.textContent = playing ? "Pause" : "Play";
    if (playing) requestAnimationFrame(step);
  };
  button.addEventListener("click", () => play(!playing));
  play(playing);

  return {
    parts: [svg, button],
    show: (motion, inclination) => {
      path = motion;
      reach = path === null ? REACH : Math.max(...path.capsule.map(Math.abs));
      place(turned, { transform: `rotate(${-inclination})` });
      draw();
    },
    end: () => play(false),
  };
};
