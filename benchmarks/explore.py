"""How long the bench takes from a slider to the redrawn page, in Chromium, beside the strongest peer.

    python benchmarks/explore.py [MOVES]

A slider is moved in the page of `vireport explore`, and the time is taken until the curves are drawn anew, in a hand
that moves on 0.1 s after each answer, and until the margins are and the verdict is there, in one that waits for them;
all in medians over the moves. The peer, where it is installed (pip install
dash), is a page of Dash with the same function behind the same slider, drawn by Plotly. At last a slider is moved 1,000
times in a row, for the memory.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from record import record

ROOT = Path(__file__).resolve().parent.parent
sys.path += [str(ROOT / "tests"), str(ROOT / "tests" / "bench")]

from browser import Browser  # noqa: E402
from serving import Served, serving  # noqa: E402

EXAMPLES = ROOT / "examples"
MOVES_FOR_MEMORY = 1000
PATIENCE = 120.0

EVERYTHING = (
    *("--set", "motions.impacts=3", "--set", "simulation.samples=21", "--set", "disturbances.jitter_m_s=0.01"),
    *("--set", "tolerances.length_percent=1", "--set", "requirements.margin_any_percent=3"),
    *("--set", "excitation.harmonics=[{order: 2, percent: 1, phase_deg: 40}]"),
)
CASES: tuple[tuple[str, str, tuple[str, ...]], ...] = (
    ("inclined", "inclined", ()),
    ("horizontal", "horizontal", ()),
    ("inclined-forcing", "inclined-forcing", ()),
    ("inclined with all blocks", "inclined", EVERYTHING),
)

MOVE = """(value) => new Promise((done) => {
  const since = performance.now(), times = {};
  const slider = document.querySelector('input[type=range][aria-label^="Restitution r"]');
  const seen = (name, node) => new Promise((told) => {
    const watch = new MutationObserver(() => {
      watch.disconnect();
      requestAnimationFrame(() => { times[name] = performance.now() - since; told(); });
    });
    watch.observe(node, { childList: true, subtree: true });
  });
  const verdict = document.querySelector(".verdict"), progress = document.querySelector(".now");
  const margins = document.querySelector("table.margins");
  Promise.all([seen("curves", document.querySelector(".panels")), seen("margins", margins)]).then(() => {
    const look = () => verdict.classList.contains("waiting") ? setTimeout(look, 5)
      : done({ ...times, verdict: performance.now() - since });
    look();
  });
  slider.value = value;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
})"""
"""Moves a slider; the times from there until the curves, the margins and the verdict are drawn [ms]."""

MANY = """async (value) => {
  const slider = document.querySelector('input[type=range][aria-label^="Restitution r"]');
  slider.value = value;
  slider.dispatchEvent(new Event("input", { bubbles: true }));
  await new Promise((done) => setTimeout(done, 30));
}"""
"""Moves a slider as a hand does that does not wait."""

DRAG = """async (values) => {
  const slider = document.querySelector('input[type=range][aria-label^="Restitution r"]'), times = [];
  for (const value of values) {
    const since = performance.now();
    await new Promise((done) => {
      const watch = new MutationObserver(() => { watch.disconnect(); requestAnimationFrame(done); });
      watch.observe(document.querySelector(".panels"), { childList: true });
      slider.value = value;
      slider.dispatchEvent(new Event("input", { bubbles: true }));
    });
    times.push(performance.now() - since);
    await new Promise((done) => setTimeout(done, 100));
  }
  return times;
}"""
"""Moves a slider on and on; the time of each step until the curves are drawn [ms]."""

DASH = """
import sys, json
sys.path.insert(0, {root!r})
from dash import Dash, Input, Output, dcc, html
from plotly.subplots import make_subplots
from vireport.bench.session import first, opened
known = opened({file!r})
app = Dash(__name__, serve_locally=True)
app.layout = html.Div([dcc.Slider(0, 0.99, 0.002, value=0.5, id="r", updatemode="drag"), dcc.Graph(id="curves")])
@app.callback(Output("curves", "figure"), Input("r", "value"))
def draw(r):
    told, figure = first(known, {{"device.restitution": r}}), make_subplots(3, 1, shared_xaxes=True)
    for branch in told["branches"]:
        for first_row, last, stable in branch["pieces"]:
            rows = slice(first_row, last + 1)
            columns = ("velocity_bottom", "velocity_top"), ("phi_bottom_rad", "phi_top_rad"), ("q",)
            for number, names in enumerate(columns, 1):
                for name in names:
                    line = dict(dash="solid" if stable else "dash")
                    x, y = branch["sweep_value"][rows], branch[name][rows]
                    figure.add_scatter(x=x, y=y, line=line, row=number, col=1)
    return figure
app.run(host="127.0.0.1", port={port}, debug=False)
"""

DASH_MOVE = """(value) => new Promise((done) => {
  const since = performance.now(), graph = document.querySelector(".js-plotly-plot");
  graph.once("plotly_afterplot", () => requestAnimationFrame(() => done(performance.now() - since)));
  dash_clientside.set_props("r", { value });
})"""


@contextmanager
def page(address: str) -> Iterator[Browser]:
    """A page in Chromium."""
    with tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as folder:  # Chromium ends after us
        browser = Browser(Path(folder))
        browser.look(1440)
        browser.visit(address)
        yield browser
        browser.process.terminate()
        browser.process.wait()


def until(browser: Browser, condition: str) -> None:
    """Wait until something holds in a page."""
    begun = time.monotonic()
    while not browser.run(condition):
        if time.monotonic() - begun > PATIENCE:
            raise TimeoutError(condition)
        time.sleep(0.05)


def values(count: int) -> list[float]:
    """Places of the slider, away from one another."""
    return [round(0.42 + 0.16 * ((k * 0.618034) % 1), 3) for k in range(count)]


def medians(times: list[dict[str, float]]) -> dict[str, float]:
    """The median and the 95th percentile of each time [ms]."""
    told = {}
    for name in times[0]:
        ordered = sorted(own[name] for own in times)
        told[f"{name}_ms"] = statistics.median(ordered)
        told[f"{name}_p95_ms"] = ordered[min(len(ordered) - 1, int(0.95 * len(ordered)))]
    return told


def own(served: Served, moves: int) -> dict[str, float]:
    """The times of the bench."""
    with page(served.address) as browser:
        until(browser, '!document.querySelector(".waiting") && document.querySelector(".sentence").textContent')
        steps = browser.run(f"({DRAG})({[round(0.42 + 0.004 * k, 3) for k in range(moves)]})")
        waited = [browser.run(f"({MOVE})({value})") for value in values(moves)]
        return medians([{"curves": step} for step in steps]) | medians(
            [{name: own[name] for name in ("margins", "verdict")} for own in waited]
        )


def of_dash(file: Path, moves: int) -> float | None:
    """The median time of the peer [ms]; None where it is not installed."""
    if find_spec("dash") is None:
        return None
    port = 8397
    code = DASH.format(root=str(ROOT), file=str(file), port=port)
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as server:
        try:
            time.sleep(8)
            with page(f"http://127.0.0.1:{port}/") as browser:
                until(browser, 'Boolean(document.querySelector(".js-plotly-plot .trace"))')
                return statistics.median(browser.run(f"({DASH_MOVE})({value})") for value in values(moves))
        finally:
            server.kill()


def resident_mb(process: int) -> float:
    """Memory of a process [MB]."""
    lines = Path(f"/proc/{process}/status").read_text(encoding="ascii").splitlines()
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmRSS"))


def memory(served: Served) -> dict[str, float]:
    """What the server and the page keep after many moves, and before them [MB]."""
    with page(served.address) as browser:
        until(browser, '!document.querySelector(".waiting") && document.querySelector(".sentence").textContent')

        def kept() -> tuple[float, float]:
            browser.call("HeapProfiler.collectGarbage")
            return resident_mb(served.process.pid), browser.run("performance.memory.usedJSHeapSize") / 2**20

        before = kept()
        for k in range(MOVES_FOR_MEMORY):
            browser.run(f"({MANY})({0.42 + 0.002 * (k % 80)})")
        until(browser, '!document.querySelector(".waiting")')
        after = kept()
    names = "server_before_mb", "page_before_mb", "server_after_mb", "page_after_mb"
    return dict(zip(names, (*before, *after), strict=True))


def main() -> None:
    """Measure, print and keep."""
    moves, rows = int(sys.argv[1]) if len(sys.argv) > 1 else 40, list[dict[str, Any]]()
    for name, scenario, options in CASES:
        file = EXAMPLES / f"{scenario}.yaml"
        with tempfile.TemporaryDirectory() as folder, serving(file, Path(folder), *options) as served:
            told = own(served, moves if not options else max(5, moves // 8))
        peer = of_dash(file, moves) if not options else None
        rows.append({"scenario": name, **told, "peer_ms": peer, "ratio": peer and peer / told["curves_ms"]})
        print(json.dumps(rows[-1]), flush=True)
    with tempfile.TemporaryDirectory() as folder, serving(EXAMPLES / "inclined.yaml", Path(folder)) as served:
        kept = memory(served)
    print(json.dumps(kept))
    record("explore", moves=moves, pages=rows, memory={"moves": MOVES_FOR_MEMORY, **kept})


if __name__ == "__main__":
    main()
