"""What can be put on the bench, and what is saved of it."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from conftest import EXAMPLES

from vireport.base.errors import ScenarioError, UsageError
from vireport.bench.jobs import Aside, Asked, Job
from vireport.bench.session import first, job_of, loaded_of, opened, refusal, require_new, save
from vireport.scenario.loading import load
from vireport.study.plan import Task
from vireport.study.study import analyse


def test_a_map_is_refused_with_the_command_for_it() -> None:
    with pytest.raises(UsageError, match=r"has a map block.*vireport map"):
        opened(EXAMPLES / "maps" / "map.yaml")


def test_blocks_that_have_no_part_are_named_with_their_command() -> None:
    known = opened(EXAMPLES / "best-design.yaml", ("accuracy={repeats: 1}",))
    assert [note.partition(":")[0] for note in known.notes] == [
        "The block accuracy has no part here",
        "The block design has no part here",
    ]
    assert "vireport optimise" in known.notes[1]
    assert first(known, {})["shown"] is not None


def test_what_was_loaded_is_opened_with_what_was_set_over_it() -> None:
    loaded = load(EXAMPLES / "inclined.yaml", {"device.length_m": 0.66})
    assert first(opened(loaded), {})["values"]["device.length_m"] == 0.66


def test_a_mistake_is_told_with_the_path_of_its_control() -> None:
    known = opened(EXAMPLES / "inclined.yaml")
    with pytest.raises(ScenarioError) as refused:
        first(known, {"device.restitution": 1.5, "excitation.amplitude_n": -1.0})
    told = refusal(refused.value)["refused"]
    assert {mistake["path"] for mistake in told} == {"device.restitution", "excitation.amplitude_n"}
    assert all(value in mistake["message"] for mistake, value in zip(told, ("1.5", "-1"), strict=True))


def test_what_is_saved_is_the_scenario_of_the_page(tmp_path: Path) -> None:
    known = opened(EXAMPLES / "inclined.yaml", ("title=first",))
    path = save(known, {"device.length_m": 0.7, "requirements.margin_any_percent": 3.0}, "second", tmp_path / "new")
    assert path == tmp_path / "new" / "second.yaml"
    saved = load(path).scenario
    assert (saved.title, saved.device.length_m, saved.requirements.margin_any_percent) == ("first", 0.7, 3.0)
    one, other = (
        analyse(x, ()).solution.design.motions
        for x in (path, load(EXAMPLES / "inclined.yaml", {"device.length_m": 0.7}))
    )
    assert one.q.tolist() == other.q.tolist()
    with pytest.raises(UsageError, match="exists already"):
        save(known, {}, "second", tmp_path / "new")


@pytest.mark.parametrize("name", ["", "../x", "a/b", "a\\b", ".hidden", "x" * 61, "a\nb", "nul\0", "-o"])
def test_a_file_is_saved_in_its_folder_alone(name: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no name for a file"):
        save(opened(EXAMPLES / "inclined.yaml"), {}, name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_block_of_which_every_key_is_taken_away_goes() -> None:
    bare = opened(EXAMPLES / "inclined.yaml")
    for path in ("requirements.margin_any_percent", "tolerances.length_percent"):
        assert first(bare, {path: 2.0})["values"][path] == 2.0
        assert first(bare, {path: None})["values"][path] is None
    given = opened(EXAMPLES / "ci" / "failing.yaml")
    required = [path for path in given.stated_keys if path.startswith("requirements.")]
    one = loaded_of(given, {"requirements.margin_grazing_percent": None}).scenario
    assert one.requirements is not None
    assert loaded_of(given, dict.fromkeys(required)).scenario.requirements is None
    with pytest.raises(ScenarioError, match="nothing is required in it"):
        first(bare, {"requirements": {}})


def test_a_report_is_written_where_there_is_nothing(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    for free in ("new", "empty"):
        require_new(tmp_path / free)
    (tmp_path / "taken").mkdir()
    (tmp_path / "taken" / "report.html").write_text("of another design")
    (tmp_path / "file").write_text("")
    for name in ("taken", "file"):
        with pytest.raises(UsageError, match=f"{name} exists already"):
            require_new(tmp_path / name)


def test_records_are_where_the_scenario_has_them(tmp_path: Path) -> None:
    (tmp_path / "own").mkdir()
    for name in ("shaker.wav", "shaker.wav.yaml"):
        (tmp_path / name).write_bytes((EXAMPLES / "records" / name).read_bytes())
    file = tmp_path / "own" / "driven.yaml"
    file.write_text((EXAMPLES / "driven.yaml").read_text().replace("records/shaker.wav", "../shaker.wav"))
    with pytest.raises(UsageError, match=r"leads out of the folder of the scenario.*--allow-outside"):
        analyse(loaded_of(opened(file), {}), (Task.JSON,))
    known = opened(file, allow_outside=True)
    assert analyse(loaded_of(known, {}), (Task.JSON,)).driven is not None
    job = msgspec.json.decode(msgspec.json.encode(job_of(known, Aside.STUDY, Asked({}))), type=Job)
    assert job.place == load(file, allow_outside=True).place


def test_saved_elsewhere_a_scenario_names_the_same_records(tmp_path: Path) -> None:
    told = (EXAMPLES / "driven.yaml").read_text() + "measured:\n  - {impacts: measured-impacts.csv}\n"
    for name in ("records", "measured-impacts.csv"):
        (tmp_path / "given").mkdir(exist_ok=True)
        (tmp_path / "given" / name).symlink_to(EXAMPLES / name)
    (tmp_path / "given" / "driven.yaml").write_text(told)
    known = opened(tmp_path / "given" / "driven.yaml", allow_outside=True)
    for folder, there in ((tmp_path / "given", ""), (tmp_path / "new" / "deep", "../../given/")):
        saved = load(save(known, {}, "second", folder), allow_outside=True)
        assert saved.scenario.measured is not None
        assert saved.scenario.measured[0].impacts == f"{there}measured-impacts.csv"
        record = str(saved.scenario.excitation.record)
        assert (folder / record).samefile(EXAMPLES / "records" / "shaker.wav")
    whole = opened(known.place.path_of("driven.yaml"), (f"excitation.record={EXAMPLES}/records/shaker.wav",), True)
    saved = load(save(whole, {}, "third", tmp_path / "new"), allow_outside=True)
    assert saved.scenario.excitation.record == f"{EXAMPLES}/records/shaker.wav"


def test_no_record_is_named_that_the_page_may_not_read(tmp_path: Path) -> None:
    known = opened(EXAMPLES / "driven.yaml")
    for path in ("../elsewhere.wav", str(tmp_path / "elsewhere.wav")):
        with pytest.raises(UsageError, match="leads out of the folder of the scenario"):
            save(known, {"excitation.record": path}, "second", tmp_path / "new")
    assert not (tmp_path / "new").exists()
