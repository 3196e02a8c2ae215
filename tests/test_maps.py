"""Maps over several parameters: their files, their cells, and that nothing is lost whatever ends a run."""

from __future__ import annotations

import errno
import os
import random
import re
import signal
import subprocess
import sys
import time
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pyarrow")

import pyarrow.parquet as pq

from vireport import analyse
from vireport.analysis.pointwise import find_motions
from vireport.errors import NumericalError, ScenarioError, UsageError
from vireport.scenario import Parameter, load, load_map, loads, loads_map
from vireport.sweep.cells import cells_of
from vireport.sweep.loci import loci_of
from vireport.sweep.mapping import evaluate_chunk
from vireport.sweep.plan import map_plan
from vireport.sweep.run import run_map
from vireport.sweep.workers import on_cluster

HELD = """\
schema_version: 1
device: {capsule_mass_kg: 0.1245, ball_mass_kg: 0.0041, restitution: 0.5}
excitation: {amplitude_n: 3.0, frequency_hz: 2.0}
"""
BLOCK = """\
map:
  chunk_cells: 60
  axes:
    - {path: inclination_deg, from: 0, to: 90, count: 20}
    - {path: device.length_m, from: 0.2, to: 0.9, count: 25}
"""
TEXT = HELD + BLOCK
CHUNKS = 9


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "map.yaml"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory) -> bytes:
    folder = tmp_path_factory.mktemp("undisturbed")
    (folder / "map.yaml").write_text(TEXT, encoding="utf-8")
    run_map(str(folder / "map.yaml"), folder / "out", workers=1, draw=False)
    return (folder / "out" / "map.parquet").read_bytes()


def result(folder: Path) -> bytes:
    return (folder / "map.parquet").read_bytes()


def plan_of(text: str):
    return map_plan(loads_map(text))


def whole(plan) -> list[np.ndarray]:
    return [np.concatenate(parts) for parts in zip(*(cells_of(plan, k) for k in range(plan.chunks)), strict=True)]


def mistakes(text: str) -> list[str]:
    with pytest.raises(ScenarioError) as caught:
        loads_map(text, "m")
    return [f"{one.line}:{one.path}" for one in caught.value.mistakes]


@pytest.mark.parametrize(
    ("old", "new", "found"),
    [
        ("from: 0,", "", ["7:map.axes.0"]),
        ("count: 20", "count: 2.5", ["7:map.axes.0.count"]),
        ("count: 20", "count: 20, values: [1, 2]", ["7:map.axes.0.from"]),
        ("to: 90", "to: 91", ["7:map.axes.0.to"]),
        ("inclination_deg", "device.length_m", ["7:map.axes.0.from", "8:map.axes.1.path"]),
        ("inclination_deg", "device.capsule_mass_kg", ["7:map.axes.0.path"]),
        ("device.length_m, from: 0.2, to: 0.9", "device.ball_mass_kg, from: 0.2, to: 0.9", None),
        ("restitution: 0.5", "restitution: 1.5", ["2:device.restitution"]),
        ("chunk_cells: 60", "sampling: sobol\n  samples: 100", None),
        ("chunk_cells: 60", "sampling: list", None),
        ("chunk_cells: 60", "simulate: {starts: 0}", ["5:map.simulate.starts"]),
        ("chunk_cells: 60", "samples: 60", ["5:map.samples"]),
        ("chunk_cells: 60", "chunks: 60", ["5:map.chunks"]),
        (BLOCK, "", ["1:map"]),
        ("map:", "sweep: {parameter: length_m, from: 1, to: 2}\nmap:", ["4:sweep"]),
    ],
)
def test_mistakes_are_found_with_line_and_path(old: str, new: str, found: list[str] | None) -> None:
    assert old in TEXT
    got = mistakes(TEXT.replace(old, new))
    assert got
    if found is not None:
        assert sorted(got) == sorted(found)


def test_all_mistakes_at_once() -> None:
    text = TEXT.replace("restitution: 0.5", "restitution: x").replace("to: 90", "to: 95").replace("0.9", "-1")
    assert mistakes(text) == ["2:device.restitution", "7:map.axes.0.to", "8:map.axes.1.to"]


def test_restitution_of_one_is_outside_the_theory() -> None:
    with pytest.raises(NumericalError, match="restitution"):
        plan_of(TEXT.replace("restitution: 0.5", "restitution: 1"))


def test_grid_has_every_combination_and_exact_ends() -> None:
    angle, length = whole(plan_of(TEXT))
    assert len(angle) == 500
    assert len(set(zip(angle, length, strict=True))) == 500
    assert (angle[0], angle[-1], length[0], length[-1]) == (0.0, 90.0, 0.2, 0.9)
    assert (length[:25] == length[25:50]).all()  # the last axis varies fastest


@pytest.mark.parametrize("sampling", ["grid", "sobol", "latin_hypercube"])
def test_cells_do_not_depend_on_the_chunks(sampling: str) -> None:
    text = TEXT
    if sampling != "grid":
        text = re.sub(", count: ..", "", TEXT).replace("map:", f"map:\n  sampling: {sampling}\n  samples: 256")
    one = plan_of(text)
    for size in (1000, 60, 7):
        for a, b in zip(whole(one), whole(replace(one, chunk_cells=size)), strict=True):
            assert np.array_equal(a, b)


def test_samples_fill_their_box_evenly() -> None:
    for sampling in ("sobol", "latin_hypercube"):
        text = re.sub(", count: ..", "", TEXT).replace("map:", f"map:\n  sampling: {sampling}\n  samples: 256")
        angle, length = whole(plan_of(text))
        for values, low, high in ((angle, 0, 90), (length, 0.2, 0.9)):
            counts = np.histogram(values, bins=256 if sampling == "latin_hypercube" else 64, range=(low, high))[0]
            assert counts.min() == counts.max()


def test_results_do_not_depend_on_the_chunks() -> None:
    plan = plan_of(TEXT)
    large = evaluate_chunk(replace(plan, chunk_cells=1000), 0)
    start = 0
    for k in range(plan.chunks):
        part = evaluate_chunk(plan, k)
        assert part.to_pylist() == large.slice(start, len(part)).to_pylist()
        start += len(part)


def test_every_cell_is_what_a_scenario_says() -> None:
    table = evaluate_chunk(replace(plan_of(TEXT), chunk_cells=500), 0).to_pylist()
    compared = 0
    for row in random.Random(1).sample(table, 40):
        text = HELD.replace("restitution", f"length_m: {row['length_m']!r}, restitution")
        study = analyse(loads(f"{text}inclination_deg: {row['inclination_deg']!r}\n"), ("json",))
        motions, volts = study.solution.design.motions, study.solution.design.voltages
        assert row["motions"] == motions.admissible.sum()
        assert row["stable"] == motions.stable.sum()
        if not row["motions"]:
            assert row["stability"] is row["q"] is row["u_ave_v"] is None
            continue
        compared += 1
        same = np.flatnonzero(motions.admissible & (np.abs(motions.q - row["q"]) < 1e-9))
        i = int(same[np.argmin(np.abs(motions.phi_bottom[same] - row["phi_bottom_rad"]))])
        assert row["stability"] == motions.words[i]
        assert bool(row["stable"]) == bool(motions.stable[i])
        for name in ("velocity_bottom", "velocity_top", "trace", "wall_gap"):
            assert row[name] == pytest.approx(getattr(motions, name)[i], rel=1e-9, abs=1e-9)
        assert row["u_ave_v"] == pytest.approx(volts.average_v[i], rel=1e-9)
        margin = 1 + 0.5**4 - abs(motions.trace[i])
        assert row["multiplier_margin"] == pytest.approx(margin, rel=1e-9, abs=1e-9)
    assert compared > 20


def test_stability_changes_where_the_paper_says() -> None:
    text = HELD + "map:\n  axes:\n    - {path: inclination_deg, values: [0, 45]}\n    - {path: device.length_m, "
    d = np.array([0.18705, 0.18706, 0.4179, 0.4180])  # either side of B1: horizontal, and at 45 degrees
    values = ", ".join(repr(float(x)) for x in d * 3 / (4 * 0.1245 * 4))
    rows = evaluate_chunk(plan_of(f"{text}values: [{values}]}}\n"), 0).to_pylist()
    assert [rows[k]["stability"] for k in (0, 1)] == ["unstable node", "stable node"]
    assert [rows[k]["stability"] for k in (6, 7)] == ["unstable node", "stable node"]
    assert rows[6]["period_doubling_margin"] < 0 < rows[7]["period_doubling_margin"]


def test_one_command_maps_six_parameters() -> None:
    axes = {
        "inclination_deg": [0, 45],
        "device.length_m": [0.5, 0.7],
        "excitation.amplitude_n": [3, 4],
        "excitation.frequency_hz": [1.9, 2.0],
        "device.restitution": [0, 0.5],
        "device.ball_mass_kg": [0.004, 0.005],
    }
    lines = "".join(f"    - {{path: {path}, values: {values}}}\n" for path, values in axes.items())
    table = evaluate_chunk(plan_of(f"{HELD}map:\n  axes:\n{lines}"), 0)
    assert len(table) == 64
    frame = table.to_pandas()
    assert (frame.u_ave_v.to_numpy()[1::2] > frame.u_ave_v.to_numpy()[::2])[frame.motions[::2] > 0].all()


def test_simulation_of_a_cell_agrees_with_its_stability() -> None:
    pytest.importorskip("numba")
    text = HELD + "map:\n  simulate: {starts: 8, impacts: 400}\n  axes:\n    - {path: inclination_deg, values: [45]}\n"
    rows = evaluate_chunk(plan_of(text + "    - {path: device.length_m, values: [0.6, 0.6934]}\n"), 0).to_pylist()
    assert [row["stable"] for row in rows] == [0, 1]
    assert rows[0]["basin_share"] == 0
    assert rows[0]["word"] != "BT"
    assert rows[1]["basin_share"] > 0.5
    assert rows[1]["word"] == "BT"


def test_result_is_read_by_pandas_without_a_nan(undisturbed: bytes, tmp_path: Path) -> None:
    import pandas

    path = tmp_path / "map.parquet"
    path.write_bytes(undisturbed)
    frame = pandas.read_parquet(path)
    assert len(frame) == 500
    assert set(frame.stability.dropna()) <= {"stable node", "stable focus", "unstable node"}
    schema = pq.read_schema(path)
    assert schema.field("length_m").metadata == {b"unit": b"m"}
    assert schema.metadata[b"map"].decode() == TEXT
    for column in pq.read_table(path).columns:
        if column.type == "double":
            assert np.isfinite(column.drop_null().to_numpy()).all()


@pytest.mark.parametrize("workers", [1, 2])
def test_same_bytes_on_any_number_of_cores(file: Path, undisturbed: bytes, workers: int) -> None:
    run_map(str(file), file.parent / "out", workers=workers, draw=False)
    assert result(file.parent / "out") == undisturbed


class Stop(Exception):
    """Ends a run from within."""


def stopping(after: int, error: BaseException):
    """Progress that raises once so many cells are done."""

    def progress(done: int, total: int) -> None:
        if done >= after:
            raise error

    return progress


@pytest.mark.parametrize("error", [KeyboardInterrupt(), Stop()], ids=["ctrl-c", "error"])
def test_a_stopped_run_is_resumed(file: Path, undisturbed: bytes, error: BaseException) -> None:
    out = file.parent / "out"
    with pytest.raises(type(error)):
        run_map(str(file), out, workers=2, progress=stopping(120, error), draw=False)
    kept = sorted((out / ".chunks").glob("*.arrow"))
    assert 2 <= len(kept) < CHUNKS
    before = {path: path.stat().st_mtime_ns for path in kept}
    seen: list[int] = []
    run_map(str(file), out, workers=1, progress=lambda done, total: seen.append(done), draw=False)
    assert seen[0] == sum(60 if path.stem != "000000008" else 20 for path in before)
    assert result(out) == undisturbed


def test_lost_and_broken_files_are_made_again(file: Path, undisturbed: bytes) -> None:
    out = file.parent / "out"
    with pytest.raises(Stop):
        run_map(str(file), out, workers=1, progress=stopping(400, Stop()), draw=False)
    chunks = sorted((out / ".chunks").glob("*.arrow"))
    chunks[1].unlink()
    chunks[3].write_bytes(chunks[3].read_bytes()[:-100])
    chunks[4].write_bytes(b"")
    (out / ".chunks" / ".new.left").write_bytes(b"half a chunk")
    (out / ".map.parquet.left").write_bytes(b"half a map")
    (out / ".chunks" / "000000099.arrow").write_bytes(chunks[0].read_bytes())
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed
    assert not list(out.rglob(".*left"))
    assert not list((out / ".chunks").glob("*.arrow"))


def test_a_finished_map_is_left_alone(file: Path, undisturbed: bytes) -> None:
    out = file.parent / "out"
    run_map(str(file), out, workers=1, draw=False)
    made = (out / "map.parquet").stat().st_mtime_ns
    run_map(str(file), out, workers=1, progress=stopping(0, Stop()), draw=False)
    assert (out / "map.parquet").stat().st_mtime_ns == made


@pytest.mark.parametrize("finished", [False, True])
def test_another_map_is_not_mixed_in(file: Path, undisturbed: bytes, finished: bool) -> None:
    out = file.parent / "out"
    if finished:
        run_map(str(file), out, workers=1, draw=False)
        (out / ".chunks" / "manifest.json").unlink()
    else:
        with pytest.raises(Stop):
            run_map(str(file), out, workers=1, progress=stopping(120, Stop()), draw=False)
    file.write_text(TEXT.replace("restitution: 0.5", "restitution: 0.6"), encoding="utf-8")
    with pytest.raises(UsageError, match="the map file changed"):
        run_map(str(file), out, workers=1, draw=False)
    file.write_text(TEXT, encoding="utf-8")
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed


def test_another_version_is_not_mixed_in(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    out = file.parent / "out"
    with pytest.raises(Stop):
        run_map(str(file), out, workers=1, progress=stopping(120, Stop()), draw=False)
    monkeypatch.setattr("vireport.sweep.store.__version__", "99")
    with pytest.raises(UsageError, match="the version of vireport changed"):
        run_map(str(file), out, workers=1, draw=False)


def test_two_runs_do_not_share_a_folder(file: Path) -> None:
    pytest.importorskip("fcntl")

    def progress(done: int, total: int) -> None:
        with pytest.raises(UsageError, match="another run"):
            run_map(str(file), file.parent / "out", workers=1, draw=False)
        raise Stop

    with pytest.raises(Stop):
        run_map(str(file), file.parent / "out", workers=1, progress=progress, draw=False)


@pytest.mark.parametrize("failing", [3, 9])
def test_a_full_disk_is_told_and_the_run_resumed(
    file: Path, undisturbed: bytes, monkeypatch: pytest.MonkeyPatch, failing: int
) -> None:
    """The manifest is the first file that is forced to the disk, the result the last."""
    out, real, calls = file.parent / "out", os.fsync, []

    def fsync(handle: int) -> None:
        calls.append(handle)
        if len(calls) > failing:
            raise OSError(errno.ENOSPC, "No space left on device")
        real(handle)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fsync)
        with pytest.raises(UsageError, match=r"No space left.*run the same command again"):
            run_map(str(file), out, workers=1, draw=False)
    assert len(list((out / ".chunks").glob("*.arrow"))) == failing - 1
    assert not list(out.rglob(".new.*"))
    run_map(str(file), out, workers=1, draw=False)
    assert result(out) == undisturbed


RUN = """
import sys
from pathlib import Path
from vireport.sweep.run import run_map
if __name__ == "__main__":
    run_map(sys.argv[1], Path(sys.argv[2]), workers=2, draw=False)
"""


def wait_until(condition, seconds: float = 60) -> None:
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end
        time.sleep(0.002)


def test_kill_9_of_a_run_loses_no_chunk_and_leaves_no_process(file: Path, tmp_path: Path) -> None:
    file.write_text(TEXT.replace("count: 20", "count: 400"), encoding="utf-8")
    script, out = tmp_path / "run.py", tmp_path / "out"
    script.write_text(RUN, encoding="utf-8")
    run = subprocess.Popen([sys.executable, str(script), str(file), str(out)], start_new_session=True)
    wait_until(lambda: len(list((out / ".chunks").glob("*.arrow"))) >= 3)
    run.kill()
    run.wait()
    kept = len(list((out / ".chunks").glob("*.arrow")))
    assert 3 <= kept < 167
    wait_until(lambda: not _group_members(run.pid))
    run_map(str(file), out, workers=1, draw=False)
    run_map(str(file), tmp_path / "calm", workers=1, draw=False)
    assert result(out) == result(tmp_path / "calm")


def _group_members(group: int) -> list[int]:
    """Processes that are left of a process group."""
    try:
        os.killpg(group, 0)
    except ProcessLookupError:
        return []
    return [group]


def test_a_killed_worker_is_replaced(file: Path, undisturbed: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    pools: list[object] = []

    class Pool(ProcessPoolExecutor):
        def __init__(self, *arguments: object) -> None:
            super().__init__(*arguments)
            pools.append(self)

    killed: list[int] = []

    def progress(done: int, total: int) -> None:
        if done >= 120 and not killed:
            killed.append(next(iter(pools[0]._processes)))
            os.kill(killed[0], signal.SIGKILL)

    monkeypatch.setattr("vireport.sweep.workers.ProcessPoolExecutor", Pool)
    run_map(str(file), file.parent / "out", workers=2, progress=progress, draw=False)
    assert killed
    assert result(file.parent / "out") == undisturbed


def test_a_cluster_gives_the_same_bytes_though_a_worker_is_killed(file: Path, undisturbed: bytes) -> None:
    distributed = pytest.importorskip("distributed")
    dask = pytest.importorskip("dask")
    settings = {"distributed.admin.tick.limit": "60s", "logging.distributed": "critical"}
    with (
        dask.config.set(settings),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=50
        ) as cluster,
    ):
        killed: list[int] = []

        def progress(done: int, total: int) -> None:
            if done >= 120 and not killed:
                killed.append(cluster.workers[0].pid)
                os.kill(killed[0], signal.SIGKILL)

        out = file.parent / "out"
        run_map(str(file), out, scheduler=cluster.scheduler_address, progress=progress, draw=False)
    assert killed
    assert result(out) == undisturbed


def test_a_scheduler_that_is_not_there_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("distributed")
    import dask

    with (
        dask.config.set({"distributed.comm.timeouts.connect": "300ms"}),
        pytest.raises(NumericalError, match="cannot be reached"),
    ):
        next(on_cluster(plan_of(TEXT), iter([0]), Path, "tcp://127.0.0.1:9"))


def test_the_example_is_a_map(example) -> None:
    loaded = load_map(example("maps/map"))
    assert map_plan(loaded).shape == (60, 80)
    with pytest.raises(ScenarioError, match="map"):
        load(example("maps/map"))


def motions_at(plan, x: float, y: float):
    """All motions at two values of the axes."""
    device = replace(plan.device, **dict(zip(plan.names, (x, y), strict=True)))
    d, gbar = device.groups(Parameter.LENGTH, device.length_m)
    return find_motions(np.array([float(d)]), np.array([float(gbar)]), 0.5, 1)


@pytest.fixture(scope="module")
def curves():
    plan = plan_of(TEXT)
    return plan, loci_of(plan)


def points_on(loci, kind: str) -> list[tuple[float, float]]:
    return [(x, y) for one in loci if one.kind == kind for x, y in zip(one.x, one.y, strict=True)]


def test_multipliers_are_minus_one_where_periods_double(curves) -> None:
    plan, loci = curves
    points = points_on(loci, "period_doubling")
    assert len(points) > 100
    for x, y in points[::7]:
        assert np.abs(motions_at(plan, x, y).trace + (1 + 0.5**4)).min() < 1e-6


@pytest.mark.parametrize("kind", ["fold", "grazing"])
def test_motions_appear_across_the_other_curves(curves, kind: str) -> None:
    plan, loci = curves
    points = [(x, y) for x, y in points_on(loci, kind) if x > 0.5]
    assert len(points) > 20
    for x, y in points[::5]:
        sides = [motions_at(plan, x, y * (1 + k * 1e-7)) for k in (-1, 1)]
        if kind == "fold":
            assert abs(len(sides[0].cell) - len(sides[1].cell)) == 2
        else:
            assert abs(int(sides[0].admissible.sum()) - int(sides[1].admissible.sum())) == 1


def test_curves_pass_through_the_paper_s_points(curves) -> None:
    _, loci = curves
    metres = 3 / (4 * 0.1245 * 4)
    doubling = [one for one in loci if one.kind == "period_doubling"]
    long = max(doubling, key=lambda one: len(one.x))
    assert np.interp(45.0, long.x, long.y) == pytest.approx(0.4179595416 * metres, rel=1e-4)
    assert long.y[0] == pytest.approx(0.1870532313 * metres, rel=1e-9)
    fold = max((one for one in loci if one.kind == "fold"), key=lambda one: len(one.x))
    assert fold.y[0] == pytest.approx(0.2634315843 * metres, rel=1e-9)


def test_curves_are_joined_without_jumps(curves) -> None:
    _, loci = curves
    for one in loci:
        assert (np.diff(one.x) > 0).all()
        assert np.abs(np.diff(one.y)).max() < 0.03


def test_pictures_show_the_cells(file: Path) -> None:
    """The colour of the picture at a cell is that of its type."""
    from PIL import Image

    from vireport.sweep.figures import TYPES, map_figures

    out = file.parent / "out"
    summary = run_map(str(file), out, workers=1)
    assert all(str(out / f"map-{name}.png") in summary for name in ("stability", "margin", "voltage"))
    axes = map_figures(map_plan(load_map(file)), out / "map.parquet")["map-stability"].axes[0]
    picture = Image.open(out / "map-stability.png").convert("RGB")
    rows = pq.read_table(out / "map.parquet").to_pylist()
    right = 0
    for row in rows:
        x, y = axes.transData.transform((row["inclination_deg"], row["length_m"]))
        pixel = picture.getpixel((round(x), round(picture.height - y)))
        wanted = TYPES[row["stability"]][1] if row["stability"] else "#FFFFFF"
        right += "#{:02X}{:02X}{:02X}".format(*pixel) == wanted
    assert right > 0.85 * len(rows)  # the others lie under a curve


def test_pictures_are_the_same_in_every_run(file: Path) -> None:
    text = TEXT.replace("count: 20", "count: 4").replace("device.length_m, from: 0.2, to: 0.9", "RESTITUTION")
    file.write_text(
        text.replace("RESTITUTION", "device.restitution, from: 0.3, to: 0.6").replace(
            "restitution: 0.5}", "restitution: 0.5, length_m: 0.5}"
        ),
        encoding="utf-8",
    )
    names = ("map-stability.png", "map-margin.png", "map-voltage.png")
    found = []
    for k in range(2):
        run_map(str(file), file.parent / f"out{k}", workers=1)
        found.append([(file.parent / f"out{k}" / name).read_bytes() for name in names])
    assert found[0] == found[1]


def test_samples_are_not_drawn(file: Path) -> None:
    text = re.sub(", count: ..", "", TEXT).replace("map:", "map:\n  sampling: sobol\n  samples: 64")
    file.write_text(text, encoding="utf-8")
    summary = run_map(str(file), file.parent / "out", workers=1)
    assert "heat maps are drawn of a grid" in summary
    assert not list((file.parent / "out").glob("*.png"))
