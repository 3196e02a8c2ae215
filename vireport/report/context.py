"""What the templates of a report know: a study with its pictures and its origin, and what follows from them.

Numbers are made here and texts in the templates; docs/templates.md lists the names with their units.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import chain
from math import hypot
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, Any, ClassVar

from msgspec import Struct

from vireport.design.margins import Margin
from vireport.design.point import DesignPoint
from vireport.design.solution import Solution
from vireport.motions.generation import ladder
from vireport.motions.points import Point
from vireport.motions.sweep import Held
from vireport.physics.device import Device
from vireport.physics.numbers import DIGITS
from vireport.report.ci_formats import source_url
from vireport.report.printed import paper_section
from vireport.report.tables import RunTables
from vireport.scenario.loading import Loaded
from vireport.scenario.parameters import DRIVING, Parameter
from vireport.study.checks.paper import compare_with_paper
from vireport.study.judging.alerts import Alert
from vireport.study.judging.evidence import Criterion, unmet_criteria
from vireport.study.judging.findings import with_results
from vireport.study.judging.opening import Opening, WordedOpening
from vireport.study.provenance import Provenance
from vireport.study.study import Study, results
from vireport.text.formatting import Exactness, exact, subtitle, tied
from vireport.text.tables import Table
from vireport.text.templates import Words

if TYPE_CHECKING:
    from vireport.figures.style import Picture
    from vireport.motions.generation import Rung


class Report(Struct, frozen=True, eq=False, dict=True):
    """The object `report` of the templates of `vireport run`.

    Attributes
    ----------
    study : Study
    pictures : mapping of str to Picture
        By their names.
    provenance : Provenance
    changes : Table or None
        What has changed since a baseline, without rows where nothing has; None without a baseline.
    search : tuple of str and Table
        Where the scenario is the best design: what it was looked for in, and with what evidence; else nothing.
    templates : Path or None
        A folder whose words come before ours.
    opens : Opening or None
        What it opens with instead of what a run opens with.
    """

    study: Study
    pictures: Mapping[str, Picture]
    provenance: Provenance
    changes: Table | None = None
    search: tuple[str | Table, ...] = ()
    templates: Path | None = None
    template: str = "report.typ.j2"
    opens: Opening | None = None
    decimals: ClassVar[int] = DIGITS

    @property
    def alerts(self) -> tuple[Alert, ...]:
        """What must be known before acting on the numbers."""
        return self.study.alerts

    @property
    def source_url(self) -> str:
        """Address of the scenario on the site that runs the job, or ""."""
        return source_url(self.study)

    @property
    def title(self) -> str:
        """Title of the scenario; free text, "" where it has none."""
        return self.study.scenario.title or ""

    @cached_property
    def heading(self) -> str:
        """The device at a glance: how it lies, and how long it is."""
        device, sweep = self.solution.device, self.solution.sweep
        lies = {0.0: "horizontal", 90.0: "upright"}.get(device.inclination_deg, "inclined")
        if sweep is not None and sweep.parameter is Parameter.INCLINATION:
            lies = "inclined"
        return tied(self.say("opening", f"title_{lies}", *map(self._stated, (Parameter.LENGTH, Parameter.INCLINATION))))

    @cached_property
    def subtitle(self) -> str:
        """Title and file of the scenario, and what drives the device."""
        driven = self.say("opening", "driven", *map(self._stated, (Parameter.AMPLITUDE, Parameter.FREQUENCY)))
        return subtitle(self.title, self.provenance.scenario_name, driven)

    def _stated(self, parameter: Parameter) -> str:
        """A parameter as text: at the design point, or without one from end to end of the sweep."""
        value, sweep = self.solution.device.value_of(parameter), self.solution.sweep
        if value is None and sweep is not None:
            return " to ".join(parameter.with_unit(exact(end)) for end in (sweep.start, sweep.end))
        return parameter.with_unit(exact(value))

    @property
    def loaded(self) -> Loaded:
        """The scenario as it was read."""
        return self.study.loaded

    @property
    def solution(self) -> Solution:
        """What the analytic theory says."""
        return self.study.solution

    @property
    def design(self) -> DesignPoint | None:
        """The design point; None where the scenario gives none."""
        return self.study.solution.design

    @cached_property
    def verdict(self) -> WordedOpening:
        """What the report opens with, in words."""
        return (self.opens or self.study.opening).worded(self.templates)

    @property
    def proof(self) -> Picture | None:
        """The picture of the first page: of all motions where another than the 1:1 motion is stable, else of that."""
        of_others = ("figure-atlas",) if self.study.verdict.motion.data.instead else ()
        names = *of_others, "figure-answer", "figure-3", "figure-device"
        return next((self.pictures[name] for name in names if name in self.pictures), None)

    def say(self, words: str, macro: str, *values: object) -> str:
        """What a macro of a file of words says of what it is given, with marks for `rich`."""
        return Words(words, self.templates)(macro, *values)

    def added_sections(self, within: str = "") -> list[str]:
        """Templates of the sections of additions to the study, in the order of their rows.

        Parameters
        ----------
        within : str
            Name of the section that they belong to; "" for those that are sections of their own.
        """
        added = (finding for finding, _ in with_results(self.study.findings))
        return [finding.section for finding in added if finding.section and finding.within == within]

    def added_parts(self, name: str) -> Mapping[str, Any]:
        """Sentences and tables of the section of an addition, by their names; empty where it found nothing.

        Parameters
        ----------
        name : str
            Of the addition.
        """
        added = (row for row in with_results(self.study.findings) if row[0].name == name)
        return next((finding.parts(result, self.templates) for finding, result in added), {})

    @property
    def coexisting(self) -> list[str]:
        """Words of the other motions that are stable at the design point, beside a stable 1:1 motion."""
        return list(dict.fromkeys(word.letters for word in self.study.verdict.motion.data.other_words))

    @property
    def results(self) -> dict[str, Any]:
        """The results as data, as results.json has them; of the families those that are shown."""
        return results(self.study, self.provenance, printed=True)

    @property
    def explored(self) -> str:
        """The command that opens the scenario to be changed by hand; "" where it was read from no file."""
        name, over = self.provenance.scenario_name, self.study.loaded.overrides
        options = chain.from_iterable(("--set", text) for text in over)
        return "" if name.startswith("<") else join(["vireport", "explore", name, *options])

    @property
    def listing(self) -> str:
        """The text of the scenario file that the report prints."""
        return self.study.loaded.document.text

    def at_design(self) -> Iterator[tuple[Parameter, float]]:
        """The parameters at the design point, in their units."""
        for x in DRIVING:
            yield x, float(getattr(self.solution.device, x))

    @property
    def mirrored(self) -> bool:
        """Whether the stable motions at the design point are two mirror images."""
        return self.study.verdict.motion.data.mirrored

    @property
    def nearest(self) -> Margin | None:
        """The nearest end of the design point's stable motions."""
        return self.design.nearest if self.design is not None else None

    @property
    def held_harmonics(self) -> list[tuple[int, float]]:
        """Orders of the force's harmonics, and how far one per cent of the force more moves the nearest end at most."""
        nearest = self.nearest
        if nearest is None:
            return []
        slopes = (
            (harmonic.order, nearest.by_harmonics.get(harmonic.order)) for harmonic in self.solution.device.harmonics
        )
        return [(order, hypot(*slope) / 100) for order, slope in slopes if slope is not None]

    @property
    def tables(self) -> RunTables:
        """The tables of its sections."""
        return RunTables(self.study, self.templates)

    @property
    def exactness(self) -> Exactness:
        """How exact all numbers are that the model of rigid impacts gives: how many digits of them are printed."""
        return self.study.evidence.exactness

    def derived(self) -> tuple[dict[str, float], ...]:
        """What follows at the design point, and at both ends of the sweep, as far as there are these."""
        device, parameter, sweep = self.solution.device, self.solution.parameter, self.solution.sweep
        design = device.value_of(parameter)
        ends = () if sweep is None else (sweep.start, sweep.end)
        values = ((float(design),) if design is not None else ()) + ends
        return tuple(_derived(device, parameter, value) for value in values)

    @property
    def holds(self) -> Held | None:
        """What the sweep holds of *d*, *ḡ* and their ratio."""
        return self.solution.diagram.curve.level.held if self.solution.diagram is not None else None

    def going_on(self) -> Iterator[tuple[float, Point]]:
        """Ends of the sweep beyond which stable motion goes on, and the critical point that ends it there."""
        for part, beyond in zip(self.solution.stable_ranges, self.solution.beyond, strict=True):
            for (value, _), point in zip(part.ends, beyond, strict=True):
                if point is not None:
                    yield value, point

    @cached_property
    def paper(self) -> tuple[str | Table, ...]:
        """The paper's numbers beside ours, where the scenario is one of its own; () elsewhere."""
        compared = compare_with_paper(self.solution)
        return () if compared is None else paper_section(compared, self.templates)

    def failed(self) -> tuple[Criterion, ...]:
        """The requirements that are not met."""
        return tuple(unmet_criteria(self.study.criteria))

    @property
    def not_found(self) -> list[str]:
        """The motions that `motions.portraits` names and that are not among those found."""
        atlas, block = self.study.atlas, self.study.scenario.motions
        return [] if atlas is None or block is None else [x for x in block.portraits if atlas.named(x) is None]

    def rungs(self) -> tuple[Rung, ...]:
        """What the stable motions of each impact sequence generate at most, the most per second first."""
        if self.study.atlas is None:
            return ()
        return ladder(self.study.atlas.printed_families, self.solution.membrane)


def _derived(device: Device, parameter: Parameter, value: float) -> dict[str, float]:
    """Units in SI, dimensionless groups and what the shaker must do, where one parameter has a value."""
    x = device.at(parameter, value)
    groups = device.groups(parameter, value)
    frequency, force = x[Parameter.FREQUENCY], x[Parameter.AMPLITUDE]
    shaker = device.shaker(parameter, value)
    return {
        "x_c": force / (4 * device.capsule_mass_kg * frequency**2),
        "y_c": float(device.velocity_unit(parameter, value)),
        "t_c": 1 / (2 * frequency),
        "d": float(groups.d),
        "gbar": float(groups.gbar),
        "friction": 0.0 if groups.friction is None else float(groups.friction),
        "acceleration_m_s2": shaker.acceleration_m_s2,
        "acceleration_g": shaker.acceleration_g,
        "stroke_m": shaker.stroke_m,
        "force_n": shaker.force_n,
    }
