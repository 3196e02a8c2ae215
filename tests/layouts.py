"""Files as instruments and programs write them: their layouts imitated, with numbers of our own.

    python tests/layouts.py FOLDER

writes all of them. Each has the same two signals, whose values are known, and the `record:` keys that it is read with.
"""

from __future__ import annotations

import io
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.io import savemat, wavfile

COUNT, STEP, START = 1400, 2e-3, -0.4
TIMES = START + STEP * np.arange(COUNT)
VOLTAGE = np.round(2.5 * np.sin(40 * TIMES) * np.exp(-((TIMES - 0.3) ** 2)), 9)
ACCELERATION = np.round(24.1 * np.cos(2 * np.pi * 2 * TIMES) + 0.013, 9)


class Layout(NamedTuple):
    """A file in a layout of some instrument.

    Attributes
    ----------
    format, file : str
        What is imitated, and the name of the file.
    data : bytes
    columns : dict
        Of each signal that the file has its column and, where the file does not state them, its unit and scale.
    tells : str
        What the line that says how it was read has in it.
    start : float
        Of the times that it is read with [s].
    in_g : bool
        Whether its accelerations are in g.
    """

    format: str
    file: str
    data: bytes
    columns: dict[str, Any]
    tells: str
    start: float = START
    in_g: bool = True

    @property
    def record(self) -> dict[str, Any]:
        """The `record:` block that it is read with."""
        keys = "column", "unit", "scale"
        return {
            "columns": {
                signal: {key: value for key, value in zip(keys, values, strict=False) if value is not None}
                for signal, values in self.columns.items()
            }
        }

    @property
    def exact(self) -> dict[str, Any]:
        """The signals in SI units, by the beginnings of their names."""
        return {"voltage": VOLTAGE, "acceleration": ACCELERATION * (9.80665 if self.in_g else 1.0)}


def rows(*columns: Any, mark: str = ",", decimal: str = ".", end: str = "\n", before: str = "", after: str = "") -> str:
    """Lines of numbers, each with all its digits."""
    lists = [column if isinstance(column, list) else [repr(float(x)) for x in column] for column in columns]
    lines = (before + mark.join(row) + after for row in zip(*lists, strict=True))
    return end.join(line.replace(".", decimal) if decimal != "." else line for line in lines) + end


def texts() -> Iterator[Layout]:
    """Exports as text."""
    two = {"voltage_v": ("CH1", None), "acceleration_m_s2": ("CH2", "g")}
    timed = {"time_s": ("TIME", None), **two}
    both = rows(TIMES, VOLTAGE, ACCELERATION)
    head = [
        *("Model,MSO58", "Firmware Version,1.28.4", "", "Waveform Type,ANALOG", "Point Format,Y"),
        *("Horizontal Units,s", "Horizontal Scale,0.04", f"Sample Interval,{STEP}", f"Record Length,{COUNT}"),
        *("Gating,0.0% to 100.0%", "Probe Attenuation,1,1", "Vertical Units,V,V", "Vertical Offset,0,0"),
        *("Vertical Scale,1,1", "Vertical Position,-2.54,0", ",", ",", ",", "Label,,", "TIME,CH1,CH2"),
    ]
    yield Layout(
        "Tektronix MSO, DPO",
        "tek0001.csv",
        ("\r\n".join(head) + "\r\n").encode() + both.encode(),
        timed,
        "Tektronix",
    )
    beside = [
        *(f"Record Length,{COUNT:.6e}", f"Sample Interval,{STEP:.6e}", "Trigger Point,7.0e+02", ",,", ",,", ",,"),
        *("Source,CH1", "Vertical Units,V", "Vertical Scale,5.0e-02", "Vertical Offset,0.0e+00", "Horizontal Units,s"),
        *("Horizontal Scale,2.5e-04", "Pt Fmt,Y", "Yzero,0.0e+00", "Probe Atten,1.0e+00", "Model Number,TDS2024B"),
        *("Serial Number,C012345", "Firmware Version,FV:v22.11"),
    ]
    lines = [
        f"{beside[k] if k < len(beside) else ','},,{time!r},{value!r},"
        for k, (time, value) in enumerate(zip(TIMES.tolist(), VOLTAGE.tolist(), strict=True))
    ]
    lines = [line if line.count(",") == 5 else line.replace(",,,,", ",,,", 1) for line in lines]
    yield Layout(
        "Tektronix TDS",
        "F0000CH1.CSV",
        ("\r\n".join(lines) + "\r\n").encode(),
        {"time_s": (4, None), "voltage_v": (5, None)},
        "Tektronix",
    )
    keysight = {"time_s": ("x-axis", None), "voltage_v": ("1", None), "acceleration_m_s2": (3, "g")}
    yield Layout(
        "Keysight InfiniiVision",
        "scope_1.csv",
        ("x-axis,1,2\nsecond,Volt,Volt\n" + both).encode(),
        keysight,
        "Keysight",
    )
    infiniium = [
        *("Revision:,0", "Type:,raw", "Start:,0", f"Points:,{COUNT}", "Count:,1", "XDispRange:,2.8", "XDispOrg:,-0.4"),
        *(f"XInc:,{STEP!r}", f"XOrg:,{START!r}", "XUnits:,second", "YDispRange:,8.0", "YDispOrg:,0.0", "YInc:,1e-3"),
        *("YOrg:,0.0", "YUnits:,Volt", "Frame:,DSO9254A:MY0000", "Date:,1 JAN 2024", "Time:,10:00:00:00", "Data:,"),
    ]
    yield Layout(
        "Keysight Infiniium, values alone",
        "ch1.csv",
        ("\n".join(infiniium) + "\n" + rows(VOLTAGE)).encode(),
        {"voltage_v": (1, None)},
        "Keysight",
    )
    sequence = [str(k) for k in range(COUNT)]
    yield Layout(
        "Rigol DS1000Z",
        "NewFile1.csv",
        (
            f"X,CH1,CH2,Start,Increment,\r\nSequence,Volt,Volt,{START!r},{STEP!r}\r\n"
            + rows(sequence, VOLTAGE, ACCELERATION, after=",,", end="\r\n")
        ).encode(),
        two,
        "Rigol",
    )
    yield Layout(
        "Rigol DS1000E",
        "NewFile2.csv",
        ("X,CH1,CH2,\r\nSecond,Volt,Volt,\r\n" + rows(TIMES, VOLTAGE, ACCELERATION, after=",", end="\r\n")).encode(),
        {"time_s": ("X", None), **two},
        "Rigol",
    )
    yield Layout(
        "Rigol MSO5000, DHO",
        "RigolDS0.csv",
        (f"CH1V,CH2V,t0 ={START!r}, tInc = {STEP!r},\n" + rows(VOLTAGE, ACCELERATION, after=",,")).encode(),
        two,
        "Rigol",
    )
    siglent = [
        *(f"Record Length,Analog:{COUNT},", f"Sample Interval,Analog:{STEP:.6E},", "Vertical Units,CH1:V,CH2:V,"),
        *(
            "Vertical Scale,CH1:1.00,CH2:1.00,",
            "Vertical Offset,CH1:0.00,CH2:0.00,",
            "Horizontal Units,s,",
            "Horizontal Scale,0.2,",
        ),
        *(
            "Model Number,SDS1104X-E,",
            "Serial Number,SDS00000000,",
            "Software Version,7.6.1.20,",
            "Source,CH1,CH2",
            "Second,Volt,Volt",
        ),
    ]
    yield Layout(
        "Siglent",
        "SDS00001.csv",
        ("\n".join(siglent) + "\n" + both).encode(),
        {"time_s": ("Source", None), **two},
        "Siglent",
    )
    yield Layout(
        "Rohde & Schwarz RTB, RTM",
        "WFM01.CSV",
        ("in s,CH1 in V,CH2 in V\r\n" + rows(TIMES, VOLTAGE, ACCELERATION, end="\r\n")).encode(),
        {"time_s": (1, None), **two},
        "Rohde",
    )
    yield Layout(
        "PicoScope",
        "pico.csv",
        (
            "Time,Channel A,Channel B\r\n(ms),(V),(mV)\r\n\r\n"
            + rows([repr(float(x)) for x in TIMES * 1e3], VOLTAGE, ACCELERATION, end="\r\n")
        ).encode(),
        {"voltage_v": ("Channel A", None), "acceleration_m_s2": ("Channel B", "g")},
        "PicoScope",
    )
    yield Layout(
        "PicoScope, decimal commas",
        "pico-komma.csv",
        b"\xef\xbb\xbf"
        + (
            "Time;Channel A;Channel B\r\n(ms);(V);(mV)\r\n\r\n"
            + rows([repr(float(x)) for x in TIMES * 1e3], VOLTAGE, ACCELERATION, mark=";", decimal=",", end="\r\n")
        ).encode(),
        {"voltage_v": ("Channel A", None), "acceleration_m_s2": ("Channel B", "g")},
        "PicoScope",
    )
    yield Layout(
        "LeCroy",
        "C1Trace00000.csv",
        (
            f"LECROYWR64Xi,12345,Waveform\r\nSegments,1,SegmentSize,{COUNT}\r\n"
            + "Segment,TrigTime,TimeSinceSegment1\r\n#1,01-Jan-2024 10:00:00,0                 \r\nTime,Ampl\r\n"
            + rows(TIMES, VOLTAGE, end="\r\n")
        ).encode(),
        {"voltage_v": ("Ampl", "V")},
        "LeCroy",
    )
    phone = '"Time (s)"{0}"Acceleration x (m/s^2)"{0}"Acceleration y (m/s^2)"\n'
    of_phone = {"acceleration_m_s2": ("Acceleration y", None)}
    yield Layout("phyphox", "Raw Data.csv", (phone.format(",") + both).encode(), of_phone, "phyphox", in_g=False)
    yield Layout(
        "phyphox, tabs and decimal commas",
        "Raw Data 2.csv",
        (phone.format("\t") + rows(TIMES, VOLTAGE, ACCELERATION, mark="\t", decimal=",")).encode(),
        of_phone,
        "phyphox",
        in_g=False,
    )
    lvm = [
        *("LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab", "Decimal_Separator\t."),
        *("Multi_Headings\tNo", "X_Columns\t{0}", "Time_Pref\tRelative", "Operator\tnobody", "Date\t2024/01/01"),
        *("Time\t10:00:00", "***End_of_Header***\t", "\t", "Channels\t2\t", f"Samples\t{COUNT}\t{COUNT}"),
        *(
            "Date\t2024/01/01\t2024/01/01",
            "Time\t10:00:00\t10:00:00",
            "Y_Unit_Label\tVolts\tg",
            "X_Dimension\tTime\tTime",
        ),
        *(
            f"X0\t{START!r}\t{START!r}",
            f"Delta_X\t{STEP!r}\t{STEP!r}",
            "***End_of_Header***\t\t",
            "X_Value\tCH1\tCH2\tComment",
        ),
    ]
    of_lvm = {"voltage_v": ("CH1", None), "acceleration_m_s2": ("CH2", None)}
    yield Layout(
        "LabVIEW LVM",
        "test.lvm",
        ("\r\n".join(lvm).format("One") + "\r\n" + rows(TIMES, VOLTAGE, ACCELERATION, mark="\t", end="\r\n")).encode(),
        of_lvm,
        "LabVIEW",
    )
    yield Layout(
        "LabVIEW LVM without times",
        "test2.lvm",
        (
            "\r\n".join(lvm).format("No") + "\r\n" + rows(VOLTAGE, ACCELERATION, mark="\t", before="\t", end="\r\n")
        ).encode(),
        of_lvm,
        "LabVIEW",
    )
    digilent = "#Digilent WaveForms Oscilloscope Acquisition\n#Device Name: Discovery2\n#Sample rate: 500Hz\n"
    digilent += "#Samples: 1400\n\nTime (s),Channel 1 (V),Channel 2 (V)\n"
    yield Layout(
        "Digilent WaveForms",
        "acq0001.csv",
        (digilent + both).encode(),
        {"voltage_v": ("Channel 1", None), "acceleration_m_s2": ("Channel 2", "g")},
        "WaveForms",
    )
    yield Layout(
        "Saleae Logic",
        "analog.csv",
        ("Time [s],Channel 0,Channel 1\n" + both).encode(),
        {"voltage_v": ("Channel 0", "V"), "acceleration_m_s2": ("Channel 1", "g")},
        "Saleae",
    )
    logger = f"Device: 4711\nSampling rate (Hz): {1 / STEP:g}\nStart: {START!r}\n\nU [V]\ta [g]\n"
    yield Layout(
        "Data logger, values alone, blanks",
        "logger.txt",
        (logger + rows(VOLTAGE, ACCELERATION, mark="  ")).encode(),
        {"voltage_v": (1, "V"), "acceleration_m_s2": (2, "g")},
        "text",
    )
    sheet = "Zeit [s];Spannung [mV];Beschleunigung [m/s²]\n" + rows(TIMES, VOLTAGE, ACCELERATION, mark=";", decimal=",")
    yield Layout(
        "Spreadsheet, UTF-16",
        "tabelle.csv",
        sheet.encode("utf-16"),
        {"voltage_v": ("Spannung", "V"), "acceleration_m_s2": ("Beschleunigung", "g")},
        "text",
    )
    yield Layout(
        "Spreadsheet, CR, quoted",
        "mac.csv",
        (
            '"Time, s","U","a (g)"\n'
            + rows(*([f'"{float(x)!r}"' for x in column] for column in (TIMES, VOLTAGE, ACCELERATION)))
        )
        .replace("\n", "\r")
        .encode(),
        {"time_s": (1, "s"), "voltage_v": ("U", "V"), "acceleration_m_s2": ("a", None)},
        "text",
    )
    yield Layout("Names of signals", "named.csv", ("time_s,voltage_v,acceleration_g\n" + both).encode(), {}, "text")


def uff(name: str, values: Any, unit: str, binary: bool) -> bytes:
    """A function of time in a set 58, its numbers as text or as bytes."""
    body = values.astype("<f8").tobytes()
    kind = f"    58b     1     2          11{len(body):12d}     0     0           0           0" if binary else "    58"
    lines = ["    -1", kind, name, "NONE", "01-Jan-24 10:00:00", "NONE", "NONE"]
    lines.append("    1         0    0         0 NONE               1   3 NONE               0   0")
    lines.append(f"         4{len(values):10d}         1{START:13.5e}{STEP:13.5e}{0:13.5e}")
    lines.append(f"        17    0    0    0 {'TIME':20s} {'s':20s}")
    lines += [f"        12    0    0    0 {'Response':20s} {unit:20s}"]
    lines += [f"         0    0    0    0 {'NONE':20s} {'NONE':20s}"] * 2
    head = ("\n".join(line.ljust(80) for line in lines) + "\n").encode()
    if not binary:
        cells = [f"{value:20.11e}" for value in values]
        body = "".join("".join(cells[k : k + 4]) + "\n" for k in range(0, len(cells), 4)).encode()
    return head + body + b"    -1".ljust(80) + b"\n"


def of_libraries() -> Iterator[Layout]:
    """Files that libraries write."""
    import h5py
    import pyarrow
    from nptdms import ChannelObject, RootObject, TdmsWriter
    from pyarrow import parquet

    named = {"voltage_v": ("U", None), "acceleration_m_s2": ("a", None)}
    properties = {"wf_increment": STEP, "wf_start_offset": START, "wf_samples": COUNT}
    stream = io.BytesIO()
    with TdmsWriter(stream) as writer:
        channels = [
            ChannelObject("rig", name, values, properties={**properties, "unit_string": unit})
            for name, values, unit in (("U", VOLTAGE, "Volts"), ("a", ACCELERATION, "g"))
        ]
        writer.write_segment([RootObject(properties={"name": "test"}), *channels])
    yield Layout("TDMS", "test.tdms", stream.getvalue(), named, "TDMS")
    for binary in (False, True):
        sets = (
            uff(name, values, unit, binary) for name, values, unit in (("U", VOLTAGE, "V"), ("a", ACCELERATION, "g"))
        )
        yield Layout(f"UFF 58{'b' * binary}", f"test58{'b' * binary}.uff", b"".join(sets), named, "UFF")
    stream = io.BytesIO()
    wavfile.write(stream, round(1 / STEP), np.stack([VOLTAGE / 4, ACCELERATION / 32], axis=1))
    of_sound = {"voltage_v": (1, "V", 4.0), "acceleration_m_s2": (2, "g", 32.0)}
    yield Layout("WAV", "test.wav", stream.getvalue(), of_sound, "WAV", 0.0)
    own = {"U": VOLTAGE, "a": ACCELERATION}
    units = {"voltage_v": ("U", "V"), "acceleration_m_s2": ("a", "g")}
    stream = io.BytesIO()
    savemat(stream, {**own, "t": TIMES})
    yield Layout("MATLAB 5", "test5.mat", stream.getvalue(), {"time_s": ("t", "s"), **units}, "MATLAB")
    for matlab in (True, False):
        stream = io.BytesIO()
        with h5py.File(stream, "w", userblock_size=512 if matlab else 0) as stored:
            where = stored if matlab else stored.create_group("rig")
            for name, values in (*own.items(), ("t", TIMES)):
                array = where.create_dataset(name, data=values[:, None] if matlab else values)
                if matlab:
                    array.attrs["MATLAB_class"] = np.bytes_("double")
                else:
                    array.attrs["units"] = {"U": "V", "a": "g", "t": "s"}[name]
        if matlab:
            data = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM" + stream.getvalue()[128:]
            yield Layout(
                "MATLAB 7.3", "test73.mat", data, {"time_s": ("t", "s"), **units}, "MATLAB file of version 7.3"
            )
        else:
            grouped = {signal: (f"rig/{name}", None) for signal, (name, _) in units.items()}
            yield Layout("HDF5", "test.h5", stream.getvalue(), grouped, "HDF5")
    stream = io.BytesIO()
    parquet.write_table(pyarrow.table({"t [s]": TIMES, "U [V]": VOLTAGE, "a [g]": ACCELERATION}), stream)
    yield Layout("Parquet", "test.parquet", stream.getvalue(), named, "Parquet")
    stream = io.BytesIO()
    np.savez(stream, sampling_rate_hz=1 / STEP, **own)
    yield Layout("npz", "test.npz", stream.getvalue(), units, "npz", 0.0)


def layouts() -> list[Layout]:
    """All layouts."""
    return [*texts(), *of_libraries()]


if __name__ == "__main__":
    target = Path(sys.argv[1])
    for layout in layouts():
        (target / layout.file).write_bytes(layout.data)
