"""What the templates of a report know: a study with its pictures and its origin, and what follows from them.

Numbers are made here and texts in the templates; docs/templates.md lists the names by their docstrings.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from itertools import chain
from math import hypot
from pathlib import Path
from shlex import join
from typing import TYPE_CHECKING, ClassVar

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
        What `vireport.analyse` returns.
    pictures : mapping of str to Picture
        Figures by their names, each with `name`, `number`, `title`, `caption` and `alt`.
    provenance : Provenance
        Version, scenario with its SHA-256, Python, libraries, command and timestamp.
    changes : Table or None
        What has changed since a baseline, for `macros.table`; without rows where nothing has, None without a baseline.
    search : tuple of str and Table
        Where the scenario is a best design: ranges and evidence of the search, for `macros.parts`; else empty.
    templates : Path or None
        The user's folder, whose words come before those of the package.
    template : str
        The template that the report begins with.
    opens : Opening or None
        What the report opens with, if that is not what a run opens with.
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
        """What must be known first: `code`, `severity`, `title`, `cause` and `remedy` of each alert."""
        return self.study.alerts

    @property
    def source_url(self) -> str:
        """Address of the scenario on the site that runs the job, or ""."""
        return source_url(self.study)

    @property
    def title(self) -> str:
        """Title of the scenario, which is free text; "" without one."""
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
        """The solution by the analytic theory: device, sweep, critical points, stable ranges, design point, shaker."""
        return self.study.solution

    @property
    def design(self) -> DesignPoint | None:
        """The design point; None where the scenario gives none."""
        return self.study.solution.design

    @cached_property
    def verdict(self) -> WordedOpening:
        """What the report opens with, in words: `sentence`, `status`, `facts` and `tiles`."""
        return (self.opens or self.study.opening).worded(self.templates)

    @property
    def proof(self) -> Picture | None:
        """The picture of the first page: of the 1:1 motion or, where another motion is stable instead, of all."""
        of_others = ("figure-atlas",) if self.study.verdict.motion.data.instead else ()
        names = *of_others, "figure-answer", "figure-3", "figure-device"
        return next((self.pictures[name] for name in names if name in self.pictures), None)

    def say(self, words: str, macro: str, *values: object) -> str:
        """What a macro of a file of words says of some values, with marks for `rich`."""
        return Words(words, self.templates)(macro, *values)

    def added_sections(self, within: str = "") -> list[str]:
        """Templates of the sections of additions, in the order in which additions are listed.

        Parameters
        ----------
        within : str
            Name of the section that they belong to; "" for those that are sections of their own.
        """
        added = (finding for finding, _ in with_results(self.study.findings))
        return [finding.section for finding in added if finding.section and finding.within == within]

    def added_parts(self, name: str) -> Mapping[str, object]:
        """Sentences and tables of the section of an addition (`name`) by their names; empty where it found nothing.

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
    def results(self) -> dict[str, object]:
        """`results.json` as data; of the families those that the page shows."""
        return results(self.study, self.provenance, printed=True)

    @property
    def explored(self) -> str:
        """The command that opens the scenario in `vireport explore`; "" where it was read from standard input."""
        name, over = self.provenance.scenario_name, self.study.loaded.overrides
        options = chain.from_iterable(("--set", text) for text in over)
        return "" if name.startswith("<") else join(["vireport", "explore", name, *options])

    @property
    def listing(self) -> str:
        """Text of the scenario file."""
        return self.study.loaded.document.text

    def at_design(self) -> Iterator[tuple[Parameter, float]]:
        """Pairs of parameter and value at the design point, in the units of scenarios."""
        for x in DRIVING:
            yield x, float(getattr(self.solution.device, x))

    @property
    def mirrored(self) -> bool:
        """Whether the stable motions at the design point are two mirror images."""
        return self.study.verdict.motion.data.mirrored

    @property
    def nearest(self) -> Margin | None:
        """The nearest end of stable motion: `parameter`, `event`, `label`, `distance` and `relative` [1]."""
        return self.design.nearest if self.design is not None else None

    @property
    def held_harmonics(self) -> list[tuple[int, float]]:
        """Pairs: order of a harmonic of the force, and how far 1 % of the force more moves the nearest end at most."""
        nearest = self.nearest
        if nearest is None:
            return []
        slopes = (
            (harmonic.order, nearest.by_harmonics.get(harmonic.order)) for harmonic in self.solution.device.harmonics
        )
        return [(order, hypot(*slope) / 100) for order, slope in slopes if slope is not None]

    @property
    def tables(self) -> RunTables:
        """Tables of sections: one for `macros.table`, or several or none for `macros.parts`."""
        return RunTables(self.study, self.templates)

    @property
    def exactness(self) -> Exactness:
        """How exact the numbers of the model of rigid impacts are, which says how many digits are printed."""
        return self.study.evidence.exactness

    def derived(self) -> tuple[dict[str, float], ...]:
        """x_c [m], y_c [m/s], t_c [s], groups and the shaker's demands, at the design point and ends of the sweep."""
        device, parameter, sweep = self.solution.device, self.solution.parameter, self.solution.sweep
        design = device.value_of(parameter)
        ends = () if sweep is None else (sweep.start, sweep.end)
        values = ((float(design),) if design is not None else ()) + ends
        return tuple(_derived(device, parameter, value) for value in values)

    @property
    def holds(self) -> Held | None:
        """What the sweep holds constant: `GBAR`, `RATIO` or `D` by its `name`."""
        return self.solution.diagram.curve.level.held if self.solution.diagram is not None else None

    def going_on(self) -> Iterator[tuple[float, Point]]:
        """Pairs: an end of the sweep beyond which stable motion goes on, and the critical point that ends it there."""
        for part, beyond in zip(self.solution.stable_ranges, self.solution.beyond, strict=True):
            for (value, _), point in zip(part.ends, beyond, strict=True):
                if point is not None:
                    yield value, point

    @cached_property
    def paper(self) -> tuple[str | Table, ...]:
        """The paper's numbers beside ours, for `macros.parts`; empty where the scenario is none of the paper's."""
        compared = compare_with_paper(self.solution)
        return () if compared is None else paper_section(compared, self.templates)

    def failed(self) -> tuple[Criterion, ...]:
        """The requirements that are not met."""
        return tuple(unmet_criteria(self.study.criteria))

    @property
    def not_found(self) -> list[str]:
        """What `motions.portraits` names and is not among the motions found."""
        atlas, block = self.study.atlas, self.study.scenario.motions
        return [] if atlas is None or block is None else [x for x in block.portraits if atlas.named(x) is None]

    def rungs(self) -> tuple[Rung, ...]:
        """What the stable motions of each word generate at most, the most per second first [V, V/s, 1/s]."""
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
