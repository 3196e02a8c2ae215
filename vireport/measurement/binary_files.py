"""Tables of columns that libraries read, each after it is certain that the file has what it claims."""

from __future__ import annotations

import io
import logging
import tempfile
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace

from vireport.base.errors import UsageError
from vireport.measurement.tables import RecordedTable, Title, Wanted
from vireport.measurement.vectors import NOTHING, budget_of, library_read, table_of_vectors, too_large
from vireport.scenario.blocks import LayoutBlock

OF_TIMES = 17
"""What UFF calls the quantity of an abscissa that is a time."""


def read_tdms(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the channels of a TDMS file of one group, by their names, with the time base of their properties.

    Raises
    ------
    UsageError
    """
    from nptdms import TdmsFile  # type: ignore[import-untyped]
    from nptdms.log import log_manager  # type: ignore[import-untyped]

    # It would tell a user what it makes of a file that is cut off, which is refused.
    log_manager.set_level(logging.CRITICAL)

    def read() -> RecordedTable:
        with TdmsFile.open(io.BytesIO(data)) as file:
            if file.file_status.incomplete_final_segment:
                raise UsageError(f"{name}: the file is cut off (allowed: one that is complete)")
            channels = [channel for group in file.groups() for channel in group.channels()]
            if sum(len(channel) for channel in channels) > len(data):
                raise UsageError(f"{name}: it claims more samples than it has bytes (allowed: a file that is complete)")
            single = len({channel.group_name for channel in channels}) == 1
            names = [c.name if single else f"{c.group_name}/{c.name}" for c in channels]
            units = [str(channel.properties.get("unit_string", "")) for channel in channels]
            titles = [Title.of(*pair) for pair in zip(names, units, strict=True)]
            table = table_of_vectors(
                name, "TDMS file", titles, lambda places: {k: np.asarray(channels[k][:]) for k in places}, wanted
            )
            bases = {
                (float(c.properties.get("wf_increment", 0.0)), float(c.properties.get("wf_start_offset", 0.0)))
                for c in (channels[k] for k in table.columns)
            }
        return _with_base(name, table, bases)

    return library_read(name, "TDMS", read)


def _with_base(name: str, table: RecordedTable, bases: set[tuple[float, float]]) -> RecordedTable:
    """A table with the time base of its columns.

    Raises
    ------
    UsageError
        If they differ.
    """
    if len(bases) > 1:
        raise UsageError(f"{name}: the channels have different time bases (allowed: one for all)")
    step, start = next(iter(bases), (0.0, 0.0))
    return RecordedTable(table.reading, table.titles, table.columns, table.step_s or step, start)


def read_uff(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the functions of time of a UFF file, sets 58 and 58b, by their first line of identification.

    Raises
    ------
    UsageError
    """
    import pyuff  # type: ignore[import-untyped]

    def read() -> RecordedTable:
        # The library takes a path alone.
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "signals.uff"
            path.write_bytes(data)
            file = pyuff.UFF(str(path))
            kinds = list(file.get_set_types())
            sets = [file.read_sets(k) for k, kind in enumerate(kinds) if int(kind) == 58]
        sets = [row for row in sets if int(row["abscissa_spec_data_type"]) == OF_TIMES]
        names = [str(row["id1"]).strip() for row in sets]
        units = [str(row.get("ordinate_axis_units_lab", "")).replace("NONE", "").strip() for row in sets]
        titles = [Title.of(*pair) for pair in zip(names, units, strict=True)]
        table = table_of_vectors(
            name, "UFF file", titles, lambda places: {k: _even(name, sets[k]) for k in places}, wanted
        )
        return _with_base(name, table, {(_step(row), float(row["x"][0])) for row in (sets[k] for k in table.columns)})

    return library_read(name, "UFF", read)


def _even(name: str, row: Mapping[str, Any]) -> Any:
    """The values of a function of time at even times."""
    values = np.asarray(row["data"])
    if len(values) != int(row["num_pts"]):
        raise UsageError(f"{name}: {row['id1']}: the file is cut off (allowed: one that is complete)")
    if len(values) < 2 or not int(row["abscissa_spacing"]):
        raise UsageError(f"{name}: {row['id1']}: is at uneven times (allowed: even spacing)")
    return values if not np.iscomplexobj(values) else NOTHING


def _step(row: Mapping[str, Any]) -> float:
    """Time from a value to the next [s]."""
    return float(row["abscissa_inc"])


def read_parquet(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the columns of a Parquet file by their names.

    Raises
    ------
    UsageError
    """
    from pyarrow import BufferReader, parquet, types  # type: ignore[import-untyped]

    def read() -> RecordedTable:
        file = parquet.ParquetFile(BufferReader(data))
        count, schema = file.metadata.num_rows, file.schema_arrow
        units = [(field.metadata or {}).get(b"unit", b"").decode("utf-8", "replace") for field in schema]
        numeric = [types.is_floating(field.type) or types.is_integer(field.type) for field in schema]
        titles = [Title.of(*pair) for pair in zip(schema.names, units, strict=True)]
        titles = [replace(title, numeric=is_one) for title, is_one in zip(titles, numeric, strict=True)]

        def stored(places: Sequence[int]) -> Mapping[int, Any]:
            if 8 * count * len(places) > budget_of(data):
                raise too_large(name)
            columns = {k: file.read(columns=[schema.names[k]], use_threads=False).column(0) for k in places}
            return {k: column.to_numpy(zero_copy_only=False) for k, column in columns.items()}

        return table_of_vectors(name, "Parquet file", titles, stored, wanted)

    return library_read(name, "Parquet", read)


def read_npz(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the arrays of an npz file by their names; objects, which would be pickles, are no arrays of numbers.

    Raises
    ------
    UsageError
    """

    def read() -> RecordedTable:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            rows = [row for row in archive.infolist() if row.filename.endswith(".npy")]
            if sum(row.file_size for row in rows) > budget_of(data):
                raise too_large(name)

            def array(row: zipfile.ZipInfo) -> Any:
                with archive.open(row) as file:
                    unfolded = file.read(row.file_size + 1)
                return _array(f"{name}: {row.filename}", unfolded)

            titles = [Title.of(row.filename.removesuffix(".npy")) for row in rows]
            return table_of_vectors(
                name, "npz file", titles, lambda places: {k: array(rows[k]) for k in places}, wanted
            )

    return library_read(name, "npz", read)


def _array(name: str, stored: bytes) -> Any:
    """The array of an npy file whose header fits what follows.

    Raises
    ------
    UsageError
    """
    file = io.BytesIO(stored)
    version = np.lib.format.read_magic(file)
    read_header = np.lib.format.read_array_header_1_0 if version[0] == 1 else np.lib.format.read_array_header_2_0
    shape, _, kind = read_header(file)
    if kind.hasobject:
        return NOTHING
    if kind.itemsize * int(np.prod(shape, dtype=object)) != len(stored) - file.tell():
        raise UsageError(f"{name}: its header does not fit its size (allowed: a file that is complete)")
    return np.load(io.BytesIO(stored), allow_pickle=False)
