// What the parts of the bench are made of: elements of the page, numbers as text, ticks.

const SVG = "http://www.w3.org/2000/svg";
const DRAWN = new Set(["svg", "g", "line", "circle", "rect", "path", "text", "title"]);

/** Significant digits of a number that is set, or stands at a tick: of inputs. */
export const DIGITS = 5;

/** Digits of a number of which it is not known yet how exact it is, and of shares: as in vireport/text/formatting.py. */
export const FEWEST = 3;
const ROUGHLY = 2;

/** An element with attributes, of which functions listen to events and truth values switch, and with children. */
export const make = (name, attributes = {}, ...children) => {
  const node = DRAWN.has(name) ? document.createElementNS(SVG, name) : document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(key, value);
    else if (typeof value === "boolean") node.toggleAttribute(key, value);
    else node.setAttribute(key, value);
  }
  node.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return node;
};

const SIGNS = { good: "✓", caution: "!", bad: "✗", neutral: "i" };

/** A sign of what something means for the design: never by colour alone. */
export const signOf = (status) => make("span", { class: `icon ${status}`, "aria-hidden": "true" }, SIGNS[status]);

/** Give an element other attributes. */
export const place = (node, attributes) => {
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
};

/** A number for a field, with so many digits at most. */
export const plain = (value, digits = DIGITS) => String(Number(value.toPrecision(digits)));

/** A number of an axis or an input. */
export const show = (value, digits = DIGITS) => plain(value, digits).replaceAll("-", "−");

/** A number that a model gives, with the digits that its error leaves, as the program prints it. */
export const shown = (value, digits) => {
  // What is not 1 is not printed as 1: a restitution, or a multiplier at the end of stability.
  let used = digits;
  while (used < 14 && Math.abs(Number(value.toPrecision(used))) === 1 && Math.abs(value) !== 1) used += 1;
  const text = value.toPrecision(used);
  return (text.includes("e") || Number(text) === value ? plain(value, used) : text).replaceAll("-", "−");
};

/** A change in per cent, with its sign and the two digits that the program prints of one. */
export const signed = (percent) => `${percent < 0 ? "−" : "+"}${shown(Math.abs(percent), ROUGHLY)} %`;

/** A number with its unit, which the program calls "1" where there is none. */
export const withUnit = (text, unit) => {
  if (unit === "" || unit === "1") return text;
  return unit === "°" || unit === "deg" ? `${text}°` : `${text} ${unit}`;
};

/** The unit behind a name. */
export const unitOf = (unit) => (unit === "" || unit === "1" ? "" : ` [${unit === "deg" ? "°" : unit}]`);

/** A symbol as it is read: r_top is r top. */
export const named = (symbol) => symbol.replace("_", " ");

/** The same with its index set below the line. */
export const marked = (symbol) => {
  const [letter, index] = symbol.split("_");
  return index === undefined ? [letter] : [letter, make("sub", {}, index)];
};

export const clamp = (value, low, high) => Math.min(Math.max(value, low), high);

/** Steps of 1, 2 or 5 times a power of ten, about `count` of them in a range. */
export const stepOf = (range, count) => {
  const rough = range / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5, 10].find((k) => k * power >= rough * 0.999) ?? 10);
};

/** Round values in a range, about `count` of them. */
export const ticksOf = (low, high, count) => {
  const step = stepOf(high - low || 1, count);
  const ticks = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1)
    ticks.push(Number((k * step).toPrecision(12)));
  return ticks;
};
