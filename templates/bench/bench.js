// The bench: sliders over a scenario, and what the program answers to them. Nothing is computed here but places on the
// page. A backend has `ask(kind, question, told)`, which promises an answer; `remember(state)` and `recalled()`, which
// keep the state; `saves`, whether it writes files, and `report(name)`, where a report that was written can be read.
import { DIGITS, FEWEST, clamp, make, marked, named, plain, show, shown, signOf, signed, stepOf } from "./elements.js";
import { ticksOf, unitOf, withUnit } from "./elements.js";
import { FIGURES, drawPanels, legendOf, panelsOf } from "./panels.js";
import { deviceInMotion } from "./sketch.js";

const DRAGGED = 200; // between two changes in a hand that drags, at most [ms]
const MOVING = 15; // how long margins wait in such a hand, after the curves [ms]
const REST = 250; // how long the hand rests before what is slow is asked for [ms]
const GONE = 2000; // between two tries to reach a server that has gone [ms]
const MOST_UNDONE = 200; // states that can be gone back to
const NARROWEST = 280; // panel [px]

const pause = (time) => new Promise((done) => setTimeout(done, time));
const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

export function mount(root, start, backend) {
  const file = start.name.replace(/^.*[\\/]/, "");
  const controls = new Map(start.controls.map((control) => [control.path, control]));
  let state = backend.recalled(),
    history = [state],
    at = 0;
  let answer = null,
    finding = null,
    kept = null,
    ended = false;
  let figure = Object.keys(FIGURES)[0];
  const device = deviceInMotion();

  // --- asking ------------------------------------------------------------------------------------------------------
  // A question goes out when the one before it is answered, with the state as it is then: a hand that moves fast never
  // makes a queue.
  let wanted = 0,
    answered = 0,
    asking = false,
    resting = null,
    turn = 0,
    margins = Promise.resolve(null),
    dragging = false,
    changed = -Infinity;

  const set = (changes, instead = false) => {
    const next = instead ? { ...changes } : { ...state, ...changes };
    if (same(next, state)) return;
    // A map is that of all other inputs as they are.
    const free = drawn === null ? [] : drawn.axes.map((key) => inputOf(key).path);
    const moved = Object.keys({ ...state, ...next }).filter((path) => !same(next[path], state[path]));
    if (moved.some((path) => !free.includes(path))) cards.plane.classList.add("waiting");
    state = next;
    wanted += 1;
    turn += 1;
    dragging = performance.now() - changed < DRAGGED;
    changed = performance.now();
    clearTimeout(resting);
    waitForFindings();
    pump();
  };

  const ask = async (kind, more = {}, told = () => {}) => {
    try {
      const found = await backend.ask(kind, { state, ...more }, told);
      alive(true);
      return found;
    } catch {
      alive(false);
      return null;
    }
  };

  /** Margins follow those asked for before, of which none is of use any more where something has moved. */
  const askMargins = () => {
    const mine = turn;
    margins = margins.then(() => (mine === turn ? ask("margins") : null));
  };

  const pump = async () => {
    if (asking || ended) return;
    asking = true;
    let beside = -1;
    while (answered !== wanted && !ended) {
      const number = wanted;
      // Another process works them out at the same time. In a hand that drags they would only slow down the curves.
      if (!dragging) {
        beside = turn;
        askMargins();
        await null; // their question goes out first: it is passed on before the curves keep the server busy
      }
      const found = await ask("first");
      if (found === null) {
        await pause(GONE);
        continue;
      }
      answered = number;
      if (found.refused) refuse(found.refused);
      else {
        answer = { ...found, state };
        refuse([]);
        drawFirst();
      }
    }
    asking = false;
    if (ended || answer === null || root.querySelector(".message:not([hidden])")) return;
    const mine = turn;
    if (beside !== mine) {
      await pause(MOVING);
      if (mine !== turn || ended) return;
      askMargins();
    }
    const found = await margins;
    if (mine !== turn || ended) return;
    if (found === null) {
      resting = setTimeout(pump, GONE);
      return;
    }
    if (!found.refused) drawMargins(found.margins ?? [], found.unresolved);
    resting = setTimeout(() => rest(mine), REST);
  };

  /** What is slow is asked for in turn, each as long as nothing has moved. */
  const rest = async (mine) => {
    if (!same(state, history[at])) {
      history = [...history.slice(0, at + 1), state].slice(-MOST_UNDONE);
      at = history.length - 1;
      showHistory();
    }
    backend.remember(state);
    await plane(mine);
    if (mine !== turn) return;
    const told = (what) => {
      if (mine === turn) progress.textContent = `${what} …`;
    };
    const found = await ask("study", {}, told);
    if (mine !== turn || found === null) return;
    if (found.refused) {
      progress.textContent = "";
      refuse(found.refused);
      return;
    }
    finding = { ...found, changes: null };
    drawFindings();
    const todo = await ask("changes", {}, told);
    if (mine !== turn || todo === null) return;
    finding.changes = todo.changes ?? null;
    progress.textContent = "";
    drawChanges();
  };

  const alive = (there) => {
    gone.hidden = there;
  };

  const refuse = (mistakes) => {
    message.replaceChildren(
      ...mistakes.map(({ path, message: text }) => {
        const control = controls.get(path);
        return make("p", {}, control ? `${control.title}: ${text}` : path ? `${path}: ${text}` : text);
      }),
    );
    message.hidden = mistakes.length === 0;
    for (const [path, { field }] of rows)
      field.setAttribute("aria-invalid", String(mistakes.some((own) => own.path === path)));
    if (mistakes.length) {
      verdict.className = "card verdict neutral";
      progress.textContent = "";
    }
  };

  // --- inputs ------------------------------------------------------------------------------------------------------
  const rows = new Map();

  const rowOf = (control) => {
    const span = control.end - control.start,
      step = stepOf(span, 500);
    const label = `${control.title}${control.symbol ? ` ${named(control.symbol)}` : ""}${unitOf(control.unit)}`;
    const field = make("input", {
      type: "number",
      step: "any",
      "aria-label": label,
      title: control.meaning,
      change: () => set({ [control.path]: field.value === "" ? null : Number(field.value) }),
    });
    const range = control.slider
      ? make("input", {
          type: "range",
          min: Math.floor(control.start / step) * step,
          max: Math.ceil(control.end / step - 1e-9) * step,
          step,
          "aria-label": `${label}, slider`,
          input: () =>
            set({ [control.path]: Number(clamp(Number(range.value), control.start, control.end).toPrecision(DIGITS)) }),
        })
      : null;
    const row = make(
      "div",
      { class: "row" },
      make("span", { class: "name", "aria-hidden": "true" }, label),
      field,
      range,
    );
    rows.set(control.path, { row, field, range, control });
    return row;
  };

  const groups = {};
  for (const control of start.controls) (groups[control.group] ??= []).push(rowOf(control));
  const R = ["device.restitution", "device.restitution_bottom", "device.restitution_top"];
  const apart = make("input", {
    type: "checkbox",
    change: () => {
      const [r, bottom, top] = R.map((path) => answer.values[path]);
      set(
        apart.checked
          ? { [R[0]]: null, [R[1]]: r, [R[2]]: r }
          : { [R[0]]: Number(((bottom + top) / 2).toPrecision(12)), [R[1]]: null, [R[2]]: null },
      );
    },
  });
  const capsule = make(
    "select",
    { change: () => set({ "device.capsule": capsule.value }) },
    start.choices["device.capsule"].map((word) => make("option", {}, word)),
  );

  const harmonicRows = make("div");
  const harmonicsOf = () => (answer?.values["excitation.harmonics"] ?? []).map((own) => ({ ...own }));
  const setHarmonics = (list) => set({ "excitation.harmonics": list });
  const drawHarmonics = () => {
    const list = harmonicsOf();
    if (harmonicRows.contains(document.activeElement) && harmonicRows.childElementCount === list.length) {
      list.forEach((own, k) =>
        [...harmonicRows.children[k].querySelectorAll("input")].forEach((input) => {
          if (input !== document.activeElement) input.value = plain(own[input.dataset.key]);
        }),
      );
      return;
    }
    harmonicRows.replaceChildren(
      ...list.map((own, k) => {
        const change = (key, value) => {
          const next = harmonicsOf();
          next[k][key] = value;
          setHarmonics(next);
        };
        const input = (key, label, attributes, event) =>
          make("input", {
            "data-key": key,
            "aria-label": `${label} of harmonic ${k + 1}`,
            value: plain(own[key]),
            ...attributes,
            [event]: (told) => change(key, Number(told.target.value)),
          });
        return make(
          "div",
          { class: "row harmonic" },
          make("label", {}, "order ", input("order", "order", { type: "number", min: 2, max: 8 }, "change")),
          make(
            "label",
            {},
            "size [%] ",
            input("percent", "size", { type: "number", step: "any", min: 0, max: 50 }, "change"),
          ),
          input("percent", "size, slider,", { type: "range", min: 0, max: 20, step: 0.1 }, "input"),
          make(
            "label",
            {},
            "phase [°] ",
            input("phase_deg", "phase", { type: "number", step: "any", min: -360, max: 360 }, "change"),
          ),
          input("phase_deg", "phase, slider,", { type: "range", min: -360, max: 360, step: 1 }, "input"),
          make(
            "button",
            { type: "button", click: () => setHarmonics(harmonicsOf().filter((_, j) => j !== k)) },
            "Remove",
          ),
        );
      }),
    );
  };
  const addHarmonic = make(
    "button",
    {
      type: "button",
      click: () => {
        const list = harmonicsOf(),
          order = [2, 3, 4, 5, 6, 7, 8].find((k) => list.every((own) => own.order !== k));
        if (order) setHarmonics([...list, { order, percent: 2, phase_deg: 0 }]);
      },
    },
    "Add a harmonic",
  );

  /** A group whose keys are there only where they are given, with a choice of those that could be. */
  const optional = (name, say) => {
    const own = start.controls.filter((control) => control.group === name),
      list = make("div", {}, groups[name] ?? []);
    const choice = make("select", {
      "aria-label": say,
      change: () => {
        const path = choice.value;
        choice.value = "";
        if (!path) return;
        rows.get(path).row.hidden = false;
        rows.get(path).field.focus();
      },
    });
    const draw = () => {
      for (const { path } of own) {
        const { row, field } = rows.get(path);
        row.hidden = answer.values[path] === null && document.activeElement !== field;
      }
      const absent = own.filter(({ path }) => rows.get(path).row.hidden);
      if (absent.length + 1 === choice.options.length) return;
      choice.replaceChildren(
        make("option", { value: "" }, say),
        ...absent.map(({ path, title }) => make("option", { value: path }, title)),
      );
    };
    return { part: make("div", {}, list, choice), draw };
  };
  const required = optional("Required", "Require …"),
    tolerated = optional("Tolerances", "Allow for …");
  const everyTolerance = make("input", {
    type: "number",
    step: "any",
    min: 0,
    "aria-label": "Every input ± [%]",
    change: () => {
      const value =
        everyTolerance.value === "" || Number(everyTolerance.value) === 0 ? null : Number(everyTolerance.value);
      const two = answer.values[R[0]] === null;
      const keys = [
        "length",
        "amplitude",
        "capsule_mass",
        "frequency",
        "inclination",
        ...(two ? ["restitution_bottom", "restitution_top"] : ["restitution"]),
      ];
      const given = start.controls.filter(({ group, path }) => group === "Tolerances" && answer.values[path] !== null);
      const cleared = Object.fromEntries(given.map(({ path }) => [path, null]));
      set({
        ...cleared,
        ...(value === null ? {} : Object.fromEntries(keys.map((key) => [`tolerances.${key}_percent`, value]))),
      });
    },
  });

  const also = [
    ["disturbances", "Shocks, and where the outcome from rest changes"],
    ["motions", "Other impact sequences (seconds)"],
    ["simulation", "Simulation along the sweep (seconds)"],
  ].filter(([block]) => start.may_be_added.includes(block)).map(([block, say]) => {
    const box = make("input", { type: "checkbox", change: () => set({ [block]: box.checked ? {} : null }) });
    return { block, box, label: make("label", { class: "check" }, box, ` ${say}`) };
  });

  const swept = make(
    "select",
    {
      "aria-label": "Input that is swept",
      change: () => {
        const own = start.sweepable.find(({ key }) => key === swept.value);
        set(
          own
            ? { sweep: { parameter: own.key, from: own.from, to: own.to } }
            : { sweep: null, simulation: null, motions: null },
        );
      },
    },
    make("option", { value: "" }, "nothing"),
    start.sweepable.map(({ key, quantity, symbol }) => make("option", { value: key }, `${quantity} ${named(symbol)}`)),
  );
  const sweepEnd = (key) => {
    const field = make("input", {
      type: "number",
      step: "any",
      "aria-label": key === "from" ? "Sweep from" : "Sweep to",
      change: () => {
        const { parameter, from, to } = answer.swept;
        set({ sweep: { parameter, from, to, [key]: Number(field.value) } });
      },
    });
    return field;
  };
  const sweepFrom = sweepEnd("from"),
    sweepTo = sweepEnd("to");

  const drawInputs = () => {
    for (const [path, { field, range, row }] of rows) {
      const value = answer.values[path];
      if (field !== document.activeElement || field.value === "" || Number(field.value) !== value)
        field.value = value === null ? "" : plain(value, 12);
      if (range && range !== document.activeElement && value !== null) range.value = value;
      if (range) range.disabled = value === null;
      if (R.includes(path)) row.hidden = value === null;
    }
    apart.checked = answer.values[R[0]] === null;
    capsule.value = answer.values["device.capsule"];
    swept.value = answer.swept?.parameter ?? "";
    for (const [field, key] of [
      [sweepFrom, "from"],
      [sweepTo, "to"],
    ]) {
      field.disabled = answer.swept === null;
      if (field !== document.activeElement) field.value = answer.swept ? plain(answer.swept[key], 12) : "";
    }
    for (const { block, box } of also) box.checked = answer.blocks.includes(block);
    drawHarmonics();
    required.draw();
    tolerated.draw();
    const off = start.controls
      .filter(({ group }) => group === "Tolerances")
      .map(({ path }) => answer.values[path])
      .filter((value) => value !== null);
    if (everyTolerance !== document.activeElement)
      everyTolerance.value = off.length && off.every((value) => value === off[0]) ? plain(off[0]) : "";
  };

  // --- figures -----------------------------------------------------------------------------------------------------
  const panels = make("div", { class: "panels" });
  const near = make("div", { class: "near" });
  const legend = make("p", { class: "legend" });
  const chosen = make(
    "select",
    {
      "aria-label": "Figure",
      change: () => {
        figure = chosen.value;
        drawFigure();
      },
    },
    Object.keys(FIGURES).map((name) => make("option", {}, name)),
  );
  /** On a narrow screen the first panel stays above the sliders, with what belongs to it. */
  const arrange = () => {
    const narrow = getComputedStyle(near).display !== "none";
    if (choose.parentNode === (narrow ? inputs : figures)) return narrow;
    if (narrow) inputs.prepend(choose, legend, near);
    else figures.prepend(choose, panels, legend);
    return narrow;
  };
  const drawFigure = () => {
    if (answer === null) return;
    const along = answer.swept;
    const narrow = arrange();
    const fill = (parts) => {
      near.replaceChildren(...(narrow ? parts.slice(0, 1) : []));
      panels.replaceChildren(...(narrow ? parts.slice(1) : parts));
      legend.replaceChildren();
    };
    const say = (text) => fill([make("p", { class: "hint" }, text)]);
    if (along === null) return say("Nothing is swept: choose an input above to see the motions along it.");
    if (!panelsOf(figure, answer).length) return say("Voltages are evaluated where the mass of the ball is given.");
    const beside = kept !== null && kept.answer.swept?.parameter === along.parameter ? [kept.answer] : [];
    const answers = [answer, ...beside];
    const moved = (value) => {
      if (controls.has(along.path)) set({ [along.path]: Number(value.toPrecision(DIGITS)) });
    };
    const width = Math.max(NARROWEST, panels.clientWidth || 0);
    fill(drawPanels(figure, answers, finding?.results.measured ?? [], width, moved, narrow));
    legend.replaceChildren(...legendOf(figure, answers));
    return undefined;
  };

  // --- findings ----------------------------------------------------------------------------------------------------
  const message = make("div", { class: "message", role: "alert", hidden: true });
  const gone = make(
    "div",
    { class: "message", role: "alert", hidden: true },
    make(
      "p",
      {},
      "There is no answer: the program behind this page has ended, or does not answer. What is set here is kept; it goes on by itself once it is there again. After a new start of vireport explore, put what follows # in the address of this page behind the new address.",
    ),
  );
  const verdict = make("section", { class: "card verdict neutral", "aria-label": "Verdict" });
  const sentence = make("p", { class: "sentence" }),
    said = make("ul", { class: "said" }),
    tiles = make("dl", { class: "tiles" }),
    progress = make("p", { class: "now", role: "status" });
  verdict.append(sentence, said, tiles, progress);
  const numbers = make("table"),
    marginTable = make("table", { class: "margins" }),
    criteria = make("table");
  const todo = make("div"),
    alerts = make("div"),
    leftOut = make("div");
  const cards = {};
  const card = (key, title, ...parts) =>
    (cards[key] = make("section", { class: "card", hidden: true }, make("h2", {}, title), ...parts));

  const shownMotion = () =>
    answer.shown === null
      ? null
      : Object.fromEntries(Object.entries(answer.motions).map(([key, own]) => [key, own[answer.shown]]));

  const waitForFindings = () => {
    finding = null;
    verdict.className = "card verdict neutral waiting";
    progress.textContent = "Being checked …";
    for (const key of ["criteria", "changes", "alerts", "left"]) cards[key].classList.add("waiting");
  };

  const numberRows = ({ answer: told, digits }, both) => {
    const text = (value) => shown(value, digits ?? FEWEST);
    const motion =
      told.shown === null
        ? null
        : Object.fromEntries(Object.entries(told.motions).map(([key, own]) => [key, own[told.shown]]));
    if (motion === null) return null;
    const stable = told.motions.stability.filter(
      (word, k) => told.motions.admissible[k] && word.startsWith("stable"),
    ).length;
    return [
      ["Motion", `${motion.stability}${stable > 1 ? `, one of ${stable} stable ones` : ""}`],
      ["Impact velocity, bottom and top [–]", `${text(motion.velocity_bottom)}, ${text(-motion.velocity_top)}`],
      ["Phase, bottom and top [rad]", `${text(motion.phi_bottom_rad)}, ${text(motion.phi_top_rad)}`],
      ["Share q of the period from bottom to top", text(motion.q)],
      // A tile has it, but for A.
      ...(motion.u_ave_v === undefined || !both
        ? []
        : [["Mean voltage by the paper’s formulae [V]", text(motion.u_ave_v)]]),
    ];
  };

  const drawNumbers = () => {
    const here = numberRows({ answer, digits: finding?.digits }, kept !== null),
      other = kept ? numberRows(kept, true) : null;
    if (here === null && other === null) {
      numbers.replaceChildren(
        make(
          "caption",
          {},
          answer.swept !== null && answer.swept.value === null
            ? "No design point: give the swept input a value."
            : "No 1:1 motion at the design point.",
        ),
      );
      return;
    }
    const names = [...new Set([...(here ?? []), ...(other ?? [])].map(([name]) => name))];
    const cell = (list, name) =>
      make(
        "td",
        { "data-name": name },
        list === null ? "no 1:1 motion" : (list.find(([own]) => own === name)?.[1] ?? "–"),
      );
    numbers.replaceChildren(
      ...(kept
        ? [
            make(
              "thead",
              {},
              make("tr", {}, make("td"), make("th", { scope: "col" }, "here"), make("th", { scope: "col" }, "A")),
            ),
          ]
        : []),
      make(
        "tbody",
        {},
        names.map((name) =>
          make("tr", {}, make("th", { scope: "row" }, name), cell(here, name), kept ? cell(other, name) : null),
        ),
      ),
    );
  };

  const drawFirst = () => {
    drawFigure();
    cards.margins.classList.add("waiting");
    // The curves are shown first: the rest is drawn once they are.
    const mine = answer;
    requestAnimationFrame(() => setTimeout(() => mine === answer && drawRest()));
  };

  const drawRest = () => {
    drawInputs();
    device.show(answer.path, answer.values.inclination_deg ?? answer.swept?.value ?? 0);
    drawNumbers();
    const motion = shownMotion();
    // What was found out of another design is taken away, and its place kept: nothing moves under the hand.
    verdict.style.minHeight = `${verdict.offsetHeight}px`;
    said.replaceChildren();
    tiles.replaceChildren();
    sentence.textContent =
      motion === null
        ? answer.motions === null
          ? "No design point"
          : "No 1:1 motion here"
        : motion.stability.startsWith("stable")
          ? `1:1 motion: ${motion.stability}`
          : `1:1 motion only ${motion.stability}`;
    cards.motion.hidden = false;
    placePoint();
  };

  const drawMargins = (list, unresolved, digits = FEWEST) => {
    cards.margins.classList.remove("waiting");
    const ends = list.filter((margin) => margin.ends_stability || margin.taken_over);
    cards.margins.hidden = ends.length === 0 && unresolved.length === 0;
    const known = new Map(start.inputs.map((own) => [own.key, own]));
    marginTable.replaceChildren(
      make(
        "thead",
        {},
        make(
          "tr",
          {},
          ["Input", "Ends at", "Room", "Event"].map((name) => make("th", { scope: "col" }, name)),
        ),
      ),
      make(
        "tbody",
        {},
        ends.slice(0, 8).map((margin) => {
          const { quantity, symbol, unit } = known.get(margin.parameter);
          return make(
            "tr",
            {},
            make("th", { scope: "row" }, `${quantity} `, ...marked(symbol)),
            make("td", { class: "figure" }, withUnit(shown(margin.sweep_value, digits), unit)),
            make(
              "td",
              { class: "figure" },
              margin.percent === null ? withUnit(show(margin.distance, 2), unit) : signed(margin.percent),
            ),
            make(
              "td",
              {},
              `${margin.kind.replaceAll("_", " ")}${margin.ends_stability ? "" : ", another motion takes over"}`,
            ),
          );
        }),
      ),
    );
    const open = unresolved.length ? ` Not resolved along ${unresolved.join(", ").replaceAll("_", " ")}.` : "";
    const model = "By rigid impacts; the margin to use counts soft membranes and neglected effects, too.";
    marginTable.append(make("caption", {}, `${model}${open}`));
  };

  const drawFindings = () => {
    const { verdict: told, results } = finding;
    verdict.className = `card verdict ${told.status}`;
    verdict.style.minHeight = "";
    sentence.textContent = told.sentence;
    progress.textContent = "";
    for (const own of Object.values(cards)) own.classList.remove("waiting");
    said.replaceChildren(
      ...told.facts.map(({ status, text }) => make("li", { class: status }, signOf(status), make("span", {}, text))),
    );
    tiles.replaceChildren(
      ...told.tiles.map(({ status, label, value, remark }) =>
        make("div", { class: status }, make("dt", {}, label), make("dd", { class: "value" }, value), make("dd", {}, remark)),
      ),
    );
    if (results.design_point)
      drawMargins(results.design_point.margins, results.design_point.margins_unresolved, finding.digits);
    drawNumbers();
    const lines = results.requirements?.criteria ?? [];
    cards.criteria.hidden = lines.length === 0;
    criteria.replaceChildren(
      make(
        "thead",
        {},
        make(
          "tr",
          {},
          ["Requirement", "Limit", "Value", ""].map((name) => make("th", { scope: "col" }, name)),
        ),
      ),
      make(
        "tbody",
        {},
        lines.map((line) =>
          make(
            "tr",
            { class: line.passed ? "good" : "bad" },
            make("th", { scope: "row" }, line.title),
            make("td", {}, line.limit),
            make("td", {}, line.value_text),
            make("td", {}, line.passed ? "met" : "not met"),
          ),
        ),
      ),
    );
    cards.alerts.hidden = results.alerts.length === 0;
    alerts.replaceChildren(
      ...results.alerts.map((alert) =>
        make(
          "details",
          {},
          make("summary", {}, `${alert.title} (${alert.code})`),
          make("p", {}, alert.cause),
          make("p", {}, alert.remedy),
        ),
      ),
    );
    leftOut.replaceChildren(
      ...[
        ...start.notes,
        ...finding.left_out.map(({ what, why }) => `${what[0].toUpperCase()}${what.slice(1)}: ${why}.`),
      ].map((text) => make("p", {}, text)),
    );
    cards.left.hidden = false;
    drawChanges();
    drawFigure();
  };

  const drawChanges = () => {
    const list = finding?.changes;
    cards.changes.hidden = !list;
    if (!list) return;
    todo.replaceChildren(
      ...(list.length
        ? [make("p", { class: "hint" }, "Any one of these, all else as it is; a run with each was made.")]
        : [make("p", {}, "No single input was found that mends it, up to twice or half its value.")]),
      ...list
        .slice(0, 8)
        .map((change) =>
          make(
            "button",
            { type: "button", class: "change", click: () => set({ [change.path]: change.value }) },
            `${change.percent !== null && change.percent < 0 ? "↓" : "↑"} ${change.quantity} ${named(change.symbol)} to ${withUnit(show(change.value), change.unit)}${change.percent === null ? "" : ` (${signed(change.percent)})`}`,
          ),
        ),
    );
  };

  // --- the plane of two inputs ---------------------------------------------------------------------------------------
  const raster = make("canvas", { class: "raster", role: "img" }),
    pointer = make("button", { type: "button", class: "point", "aria-label": "Design in the map: arrow keys move it" });
  const field = make("div", { class: "plane" }, raster, pointer),
    planeNote = make("p", { class: "hint" });
  const mapNames = [make("p", { class: "name across" }), make("p", { class: "name up" })],
    mapTicks = [make("div", { class: "ticks across" }), make("div", { class: "ticks up" })];
  const cell = (kind, text) => make("span", { class: `key swatch ${kind}` }, text);
  const map = make(
    "div",
    { class: "map" },
    mapNames[1],
    mapTicks[1],
    field,
    mapTicks[0],
    mapNames[0],
    make(
      "p",
      { class: "legend" },
      cell("stable-cell", "stable 1:1 motion"),
      cell("unstable-cell", "unstable only"),
      cell("no-cell", "no 1:1 motion"),
      cell("point-cell", "this design: drag it"),
    ),
  );
  const axisChoice = (label) =>
    make("select", {
      "aria-label": label,
      change: () => {
        drawn = null;
        plane(turn);
      },
    });
  const across = axisChoice("Map, across"),
    upwards = axisChoice("Map, up");
  let drawn = null;
  const inputOf = (key) => start.inputs.find((own) => own.key === key);
  const rangeOf = (key) => {
    const { from, to } = inputOf(key);
    const own = answer.values[inputOf(key).path];
    return own === null || own === undefined ? [from, to] : [Math.min(from, own), Math.max(to, own)];
  };
  const drawAxes = () => {
    const two = answer.values[R[0]] === null;
    const fits = start.inputs.filter(({ key }) => (two ? key !== "restitution" : !key.startsWith("restitution_")));
    for (const [select, other] of [
      [across, answer.swept?.parameter === "inclination_deg" ? "length_m" : "inclination_deg"],
      [upwards, answer.swept?.parameter ?? "length_m"],
    ]) {
      const had = select.value || other;
      select.replaceChildren(
        ...fits.map(({ key, quantity, symbol }) => make("option", { value: key }, `${quantity} ${named(symbol)}`)),
      );
      select.value = fits.some(({ key }) => key === had) ? had : fits[0].key;
    }
  };
  const plane = async (mine) => {
    if (answer === null) return;
    drawAxes();
    const axes = [across.value, upwards.value];
    const none = (why) => {
      cards.plane.classList.remove("waiting");
      map.hidden = true;
      planeNote.textContent = why;
    };
    if (axes[0] === axes[1]) return none("Choose two different inputs.");
    if (axes.some((key) => answer.values[inputOf(key).path] === null && !R.includes(inputOf(key).path)))
      return none("The map needs a design point.");
    const found = await ask("plane", { axes, ranges: axes.map(rangeOf) });
    if (mine !== turn || found === null) return;
    cards.plane.hidden = false;
    if (found.refused) return none(found.refused.map((own) => own.message).join(" "));
    none("");
    map.hidden = false;
    drawn = found;
    drawRaster();
    nameAxes();
    placePoint();
    return undefined;
  };
  const nameAxes = () => {
    const told = drawn.axes.map((key, k) => {
      const { quantity, symbol, unit } = inputOf(key),
        [low, high] = drawn.ranges[k],
        name = `${quantity} ${named(symbol)}${unitOf(unit)}`;
      mapNames[k].textContent = name;
      mapTicks[k].replaceChildren(
        ...ticksOf(low, high, 5).map((value) => {
          const tick = make("span", {}, show(value));
          tick.style[k === 0 ? "left" : "bottom"] = `${(100 * (value - low)) / (high - low)}%`;
          return tick;
        }),
      );
      return `${name} from ${show(low)} to ${show(high)}`;
    });
    raster.setAttribute("aria-label", `Where 1:1 motion is stable; across ${told[0]}, up ${told[1]}`);
  };
  const drawRaster = () => {
    if (drawn === null) return;
    const style = getComputedStyle(field),
      colours = ["--none", "--unstable", "--stable"].map((own) => style.getPropertyValue(own).trim());
    raster.height = drawn.cells.length;
    raster.width = drawn.cells[0].length;
    const context = raster.getContext("2d");
    drawn.cells.forEach((row, j) =>
      row.forEach((cell, i) => {
        context.fillStyle = colours[cell];
        context.fillRect(i, raster.height - 1 - j, 1, 1);
      }),
    );
  };
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", drawRaster);
  const placePoint = () => {
    if (drawn === null || answer === null) return;
    drawn.axes.forEach((key, k) => {
      const [low, high] = drawn.ranges[k],
        own = answer.values[inputOf(key).path],
        share = clamp((own - low) / (high - low), 0, 1);
      pointer.style[k === 0 ? "left" : "bottom"] = `${100 * share}%`;
    });
  };
  const moveTo = (shares) =>
    set(
      Object.fromEntries(
        drawn.axes.map((key, k) => {
          const [low, high] = drawn.ranges[k];
          return [inputOf(key).path, Number((low + clamp(shares[k], 0, 1) * (high - low)).toPrecision(DIGITS))];
        }),
      ),
    );
  const drag = (event) => {
    const box = raster.getBoundingClientRect();
    moveTo([(event.clientX - box.left) / box.width, (box.bottom - event.clientY) / box.height]);
  };
  field.addEventListener("pointerdown", (event) => {
    if (drawn && event.button === 0) {
      field.setPointerCapture(event.pointerId);
      field.dataset.dragged = "1";
      drag(event);
      event.preventDefault();
      pointer.focus();
    }
  });
  field.addEventListener("pointermove", (event) => {
    if (field.dataset.dragged) drag(event);
  });
  for (const over of ["pointerup", "pointercancel"]) field.addEventListener(over, () => delete field.dataset.dragged);
  pointer.addEventListener("keydown", (event) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1] }[event.key];
    if (!by || drawn === null) return;
    event.preventDefault();
    moveTo(
      drawn.axes.map((key, k) => {
        const [low, high] = drawn.ranges[k];
        return (answer.values[inputOf(key).path] - low) / (high - low) + 0.01 * by[k];
      }),
    );
  });

  // --- the whole page ----------------------------------------------------------------------------------------------
  const goTo = (place) => {
    if (place < 0 || place >= history.length) return;
    at = place;
    showHistory();
    set(history[at], true);
  };
  const undo = make("button", { type: "button", click: () => goTo(at - 1) }, "Undo");
  const redo = make("button", { type: "button", click: () => goTo(at + 1) }, "Redo");
  const reset = make("button", { type: "button", click: () => set({}, true) }, "As in the file");
  const showHistory = () => {
    undo.disabled = at === 0;
    redo.disabled = at === history.length - 1;
  };
  const keep = make("button", {
    type: "button",
    click: () => {
      kept = kept ? null : { state, answer, digits: finding?.digits };
      showKept();
      drawNumbers();
      drawFigure();
    },
  });
  const swap = make(
    "button",
    {
      type: "button",
      click: () => {
        const other = { state, answer, digits: finding?.digits };
        set(kept.state, true);
        kept = other;
        drawNumbers();
        drawFigure();
      },
    },
    "Change places with A",
  );
  const showKept = () => {
    keep.textContent = kept ? "Drop A" : "Keep this as A";
    swap.hidden = !kept;
  };
  const told = make("p", { class: "told", role: "status" });
  const name = make("input", {
    type: "text",
    "aria-label": "Name of the scenario to save",
    value: `${file.replace(/\.[^.]*$/, "").replace(/[^\w .-]/g, "") || "design"}-2`,
  });
  const saveAs = async (kind) => {
    told.textContent = kind === "report" ? "The report is being written …" : "";
    const found = await ask(kind, { name: name.value }, (what) => {
      told.textContent = `${what} …`;
    });
    if (found === null) return;
    if (found.refused) {
      told.textContent = found.refused.map((own) => own.message).join(" ");
      return;
    }
    told.replaceChildren(
      `Saved as ${found.saved}. `,
      ...(found.report
        ? [
            make(
              "a",
              { href: backend.report(found.report), target: "_blank", rel: "noopener" },
              `Report of ${found.report}`,
            ),
          ]
        : []),
    );
    name.value = name.value.replace(/(\d*)$/, (digits) => String(Number(digits || 1) + 1));
  };
  const link = make(
    "button",
    {
      type: "button",
      click: async () => {
        backend.remember(state);
        try {
          await navigator.clipboard.writeText(location.href);
          told.textContent = "The address of this design is copied.";
        } catch {
          told.textContent = "The address above carries this design.";
        }
      },
    },
    "Copy link",
  );
  const actions = make(
    "div",
    { class: "actions", role: "toolbar", "aria-label": "Actions" },
    undo,
    redo,
    reset,
    keep,
    swap,
    backend.saves
      ? [
          link,
          name,
          make("button", { type: "button", click: () => saveAs("save") }, "Save as scenario"),
          make("button", { type: "button", click: () => saveAs("report") }, "Save, and write its report"),
        ]
      : null,
  );
  const keys = (event) => {
    if (!(event.ctrlKey || event.metaKey) || event.target.matches?.("input[type=text], input[type=number]")) return;
    const key = event.key.toLowerCase();
    if (key === "z") {
      event.preventDefault();
      goTo(event.shiftKey ? at + 1 : at - 1);
    }
    if (key === "y") {
      event.preventDefault();
      goTo(at + 1);
    }
  };
  root.addEventListener("keydown", keys);

  const folded = (title, ...parts) => make("details", { class: "group" }, make("summary", {}, title), ...parts);
  const choose = make(
    "div",
    { class: "choose" },
    make("label", {}, "Show ", chosen),
    make("label", {}, " along ", swept),
    make("label", {}, " from ", sweepFrom),
    make("label", {}, " to ", sweepTo),
  );
  const inputs = make(
    "section",
    { class: "inputs", "aria-label": "Inputs" },
    near,
    make("h2", {}, "Device"),
    groups.Device,
    make("label", { class: "check" }, apart, " The membranes differ"),
    make("label", { class: "row" }, make("span", { class: "name" }, "Capsule"), capsule),
    make("h2", {}, "Force"),
    groups.Force,
    harmonicRows,
    addHarmonic,
    groups.Membrane ? folded("Membranes", groups.Membrane) : null,
    folded("Requirements", required.part),
    folded(
      "Tolerances",
      make("label", { class: "row" }, make("span", { class: "name" }, "Every input ± [%]"), everyTolerance),
      tolerated.part,
    ),
    folded(
      "Also work out",
      also.map(({ label }) => label),
    ),
  );
  const figures = make(
    "section",
    { class: "figures", "aria-label": "Figures" },
    choose,
    panels,
    legend,
    card(
      "plane",
      "Map of two inputs",
      make("div", { class: "choose" }, make("label", {}, "Across ", across), make("label", {}, " up ", upwards)),
      map,
      planeNote,
    ),
  );
  const head = make(
    "div",
    { class: "head" },
    verdict,
    make("section", { class: "card moving", "aria-label": "Device in motion" }, device.parts),
  );
  const findings = make(
    "section",
    { class: "findings", "aria-label": "Findings" },
    card("changes", "What to change", todo),
    card("criteria", "Requirements", criteria),
    card("motion", "At the design point", numbers),
    card("margins", "Where stable motion ends", marginTable),
    card("alerts", "Alerts", alerts),
    (cards.left = make(
      "section",
      { class: "card", hidden: true },
      make("details", {}, make("summary", {}, "Not worked out here"), leftOut),
    )),
  );
  root.classList.add("bench");
  root.replaceChildren(
    make(
      "header",
      {},
      make("h1", {}, start.title),
      make("p", { class: "hint" }, `${file}, vireport ${start.version}`),
    ),
    gone,
    message,
    make("div", { class: "columns" }, make("div", { class: "tools" }, actions, told), head, inputs, figures, findings),
  );
  showHistory();
  showKept();
  let width = 0;
  const watch = new ResizeObserver(([entry]) => {
    if (Math.abs(entry.contentRect.width - width) > 2) {
      width = entry.contentRect.width;
      drawFigure();
    }
  });
  watch.observe(panels);
  waitForFindings();
  wanted = 1;
  pump();
  return {
    set: (next) => set(next, true),
    state: () => state,
    end: () => {
      ended = true;
      device.end();
      watch.disconnect();
      clearTimeout(resting);
      root.removeEventListener("keydown", keys);
      dark.removeEventListener("change", drawRaster);
    },
  };
}
