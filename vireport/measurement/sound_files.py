"""WAV files: samples of each channel in shares of full scale, where the file holds as many as its header says."""

from __future__ import annotations

import io
import struct
import warnings

import numpy as np

from vireport.base.errors import UsageError
from vireport.measurement.tables import RecordedTable, Title, Wanted
from vireport.scenario.blocks import LayoutBlock, RecordedUnit
from vireport.text.foreign import visible

ORDERS = {b"RIFF": "<", b"RIFX": ">", b"RF64": "<"}
"""With which a file begins, and the order of its bytes."""

HEADER, CHUNK, FORMAT = 12, 8, 16
"""Bytes of the head of a file, of a chunk's, and the fewest that tell the format."""

LARGE = b"ds64", 16
"""The chunk of a large file with the size of its samples, and where that stands in it."""

UNKNOWN = 0xFFFFFFFF
"""Size in a chunk whose size stands elsewhere, or was never written."""


def read_sound(name: str, data: bytes, keys: LayoutBlock, wanted: Wanted) -> RecordedTable:
    """Read the channels of a WAV file, in shares of full scale.

    Raises
    ------
    UsageError
        If it is none, or its header and its samples do not fit together.
    """
    from scipy.io import wavfile  # type: ignore[import-untyped]

    _require_whole(name, data)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wavfile.WavFileWarning)
            rate, samples = wavfile.read(io.BytesIO(data))
    except Exception as error:  # of bytes that are no WAV file, it may raise anything
        raise UsageError(f"{name} cannot be read as WAV: {visible(str(error), 200)}") from error
    kind = samples.dtype
    # What is floating is in shares of full scale already; of integers the largest is full scale.
    full = 1.0 if kind.kind == "f" else 128.0 if kind == np.uint8 else -float(np.iinfo(kind).min)
    channels = samples.reshape(len(samples), -1).T
    zero = 128.0 if kind == np.uint8 else 0.0
    titles = tuple(Title(f"channel {k}", RecordedUnit.FS) for k in range(1, len(channels) + 1))
    columns = {k: (channels[k].astype(float) - zero) / full for k in wanted(titles)}
    return RecordedTable(f"WAV: {len(channels)} channel{'s' * (len(channels) != 1)}", titles, columns, 1 / float(rate))


def _require_whole(name: str, data: bytes) -> None:
    """Refuse a file whose header does not fit what follows, as where its recorder was not closed.

    Raises
    ------
    UsageError
    """
    order = ORDERS.get(data[:4])
    if order is None or data[8:HEADER] != b"WAVE":
        raise UsageError(f"{name} cannot be read as WAV: it does not begin as one (allowed: uncompressed WAV)")
    place, large, block = HEADER, 0, 0
    while place + CHUNK <= len(data):
        kind = data[place : place + 4]
        (size,) = struct.unpack_from(f"{order}I", data, place + 4)
        place += CHUNK
        rest = len(data) - place
        if kind == LARGE[0] and rest >= LARGE[1]:
            (large,) = struct.unpack_from(f"{order}Q", data, place + 8)
        elif kind == b"fmt " and min(size, rest) >= FORMAT:
            _, channels, rate, _, block, _ = struct.unpack_from(f"{order}HHIIHH", data, place)
            if not channels or not rate or not block or block % channels:
                what = f"{channels} channels, {rate} samples in a second and {block} bytes for each"
                raise UsageError(
                    f"{name}: its header says {what} (allowed: above 0, and the same bytes for each channel)"
                )
        elif kind == b"data":
            claimed = large if size == UNKNOWN and large else size
            if not block:
                raise UsageError(f"{name} cannot be read as WAV: its header does not say the format (allowed: it does)")
            if not claimed or claimed > rest or claimed % block:
                what = f"says {claimed} bytes of samples, {block} for each, and {rest} follow"
                how = "a file whose recording was ended: an editor of sound that opens it can save it whole"
                raise UsageError(f"{name}: its header {what} (allowed: {how})")
            return
        place += size + size % 2
    raise UsageError(f"{name} cannot be read as WAV: it has no samples (allowed: a file whose recording was ended)")
