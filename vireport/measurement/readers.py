"""The reader for a file, by its content, and how files without a reader are converted."""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib.util import find_spec

from msgspec import Struct

from vireport.base.errors import UsageError, install_command
from vireport.measurement.binary_files import read_npz, read_parquet, read_tdms, read_uff
from vireport.measurement.matlab import FIRST_AT, HDF5, ORDER_AT, read_hdf5, read_matlab
from vireport.measurement.sound_files import ORDERS, read_sound
from vireport.measurement.tables import RecordedTable, Wanted
from vireport.measurement.text_files import read_text
from vireport.scenario.blocks import LayoutBlock

ReadTable = Callable[[str, bytes, LayoutBlock, Wanted], RecordedTable]
"""From the name of a file, its bytes, what is said of it and the choice of its columns to a table of these."""


UFF = re.compile(rb"\s*-1[ ]*\r?\n\s*(?:58b?|15[0-9]?|164|2\d{3})\s")
"""With which a UFF file begins: the mark of a set, and the number of one that files with functions of time have."""

MOST_OF_HEAD, FIRST_OF_4 = 400, 20
"""Bytes in which a UFF file shows itself, and those before the name of an array of MATLAB 4."""


class Reader(Struct, frozen=True):
    """A reader of files of one kind.

    Attributes
    ----------
    begins : callable
        Whether bytes are of such a file.
    read : callable
    package : str
        Name of the module that the reader needs; "" for none.
    """

    begins: Callable[[bytes], bool]
    read: ReadTable
    package: str = ""


def _is_matlab(data: bytes) -> bool:
    return data.startswith(b"MATLAB") or data[ORDER_AT:FIRST_AT] in (b"IM", b"MI") or _is_matlab_4(data)


def _is_matlab_4(data: bytes) -> bool:
    """Whether a file begins with a full array of version 4, of numbers in the order of bytes of today's machines."""
    kinds = (bytes([kind, 0, 0, 0]) for kind in range(0, 60, 10))
    return len(data) > FIRST_OF_4 and data[:4] in kinds and data[12:16] in (bytes(4), b"\1\0\0\0")


WAV = Reader(lambda data: data[:4] in ORDERS and data[8:12] == b"WAVE", read_sound)
READERS = (
    WAV,
    Reader(lambda data: HDF5 in (data[:8], data[512:520]), read_hdf5, "h5py"),
    Reader(_is_matlab, read_matlab),
    Reader(lambda data: data.startswith((b"TDSm", b"TDSh")), read_tdms, "nptdms"),
    Reader(lambda data: UFF.match(data[:MOST_OF_HEAD]) is not None, read_uff, "pyuff"),
    Reader(lambda data: data.startswith(b"PAR1"), read_parquet, "pyarrow"),
    Reader(lambda data: data.startswith(b"PK\3\4") and b".npy" in data[:300], read_npz),
)
"""The readers of files that are no text, each with how its files begin."""

TEXT = Reader(lambda data: True, read_text)

CONVERTED = (
    (b"fLaC", "FLAC", "ffmpeg -i FILE FILE.wav"),
    (b"OggS", "Ogg", "ffmpeg -i FILE FILE.wav"),
    (b"ID3", "MP3", "ffmpeg -i FILE FILE.wav"),
    (b"PK\3\4", "a workbook or an archive", "libreoffice --headless --convert-to csv FILE, or unzip FILE"),
    (b"\xd0\xcf\x11\xe0", "an old workbook", "libreoffice --headless --convert-to csv FILE"),
    (b"\x1f\x8b", "compressed by gzip", "gunzip -k FILE"),
    (b"7z\xbc\xaf", "an archive", "7z x FILE"),
    (b"MDF     ", "ASAM MDF", "python -c \"import asammdf; asammdf.MDF('FILE').export('csv', 'FILE')\""),
    (b"#9", "binary LeCroy", 'python -c "import lecroyparser", or save it as ASCII on the oscilloscope'),
    (b":WFMP", "Tektronix ISF", "convert it with TekScope, or save it as a spreadsheet on the oscilloscope"),
    (b"AG10", "binary Keysight", "save it as CSV on the oscilloscope"),
    (b"SQLite format 3", "a database", "sqlite3 -csv -header FILE 'select * from TABLE' > FILE.csv"),
)
"""Beginnings of files that are not read, what these are, and the command that converts them."""


def reader_of(name: str, data: bytes) -> Reader:
    """The reader of a file, whose library is there.

    Raises
    ------
    UsageError
        With the command that converts the file, or installs the library.
    """
    reader = next((reader for reader in READERS if reader.begins(data)), TEXT)
    for begin, kind, how in CONVERTED:
        if reader is TEXT and data.startswith(begin):
            raise UsageError(f"{name} is {kind}, which is not read (convert it: {how.replace('FILE', name)})")
    if reader.package and find_spec(reader.package) is None:
        raise UsageError(f"{name} needs {reader.package} to be read: {install_command(reader.package)}")
    return reader
