"""Which reader a file has, by its content; and how files that none reads are converted."""

from __future__ import annotations

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


class Reader(Struct, frozen=True):
    """A reader of files of one kind.

    Attributes
    ----------
    begins : callable
        Whether bytes are of such a file.
    read : callable
    module, package : str
        The library that it needs, as it is imported and installed; "" without one.
    """

    begins: Callable[[bytes], bool]
    read: ReadTable
    module: str = ""
    package: str = ""


def _is_matlab(data: bytes) -> bool:
    return data.startswith(b"MATLAB") or data[ORDER_AT:FIRST_AT] in (b"IM", b"MI") or _is_matlab_4(data)


def _is_matlab_4(data: bytes) -> bool:
    """Whether a file begins with the type of an array of version 4: little-endian, double to bytes, full."""
    return (
        len(data) > 20
        and data[:4] in (bytes([kind, 0, 0, 0]) for kind in (0, 10, 20, 30, 40, 50))
        and data[12:16]
        in (
            bytes(4),
            b"\1\0\0\0",
        )
    )


WAV = Reader(lambda data: data[:4] in ORDERS and data[8:12] == b"WAVE", read_sound)
READERS = (
    WAV,
    Reader(lambda data: HDF5 in (data[:8], data[512:520]), read_hdf5, "h5py", "h5py"),
    Reader(_is_matlab, read_matlab),
    Reader(lambda data: data.startswith((b"TDSm", b"TDSh")), read_tdms, "nptdms", "nptdms"),
    Reader(
        lambda data: data[:200].lstrip(b" \r\n").startswith(b"-1") and b"    58" in data[:200],
        read_uff,
        "pyuff",
        "pyuff",
    ),
    Reader(lambda data: data.startswith(b"PAR1"), read_parquet, "pyarrow", "pyarrow"),
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
    if reader.module and find_spec(reader.module) is None:
        raise UsageError(f"{name} needs {reader.package} to be read: {install_command(reader.package)}")
    return reader
