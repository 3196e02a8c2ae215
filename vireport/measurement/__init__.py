"""From measured impacts to a device: its unknown inputs with their uncertainty, or why they are not known."""

from vireport.measurement.flights import ClockedDevice, Unknown
from vireport.measurement.identification import Fitted, NoFit, Open, Unfit, Unidentifiable, fit
from vireport.measurement.inquiry import Identification, answered, inquiry_of
from vireport.measurement.misfit import BetterFit, judged, tested
from vireport.measurement.motion import ForceMaximum, Measured, MeasuredMotion, Quantity, measured
from vireport.measurement.picking import Heard, Picked, filtered, picked
from vireport.measurement.recordings import Channel, HeardPlace, Recording, Unbroken, read_recording
from vireport.measurement.records import Record, Sweepable, parse_record, read_record, record_contents
from vireport.measurement.shaker import ShakerDoubt, ShakerFinding, ShakerMotion, shaker_findings, shaker_motion
from vireport.measurement.signals import OF_SHAKER, Signals, read_signals, shaken, shaker_of, with_shaker

__all__ = [
    "OF_SHAKER",
    "BetterFit",
    "Channel",
    "ClockedDevice",
    "Fitted",
    "ForceMaximum",
    "Heard",
    "HeardPlace",
    "Identification",
    "Measured",
    "MeasuredMotion",
    "NoFit",
    "Open",
    "Picked",
    "Quantity",
    "Record",
    "Recording",
    "ShakerDoubt",
    "ShakerFinding",
    "ShakerMotion",
    "Signals",
    "Sweepable",
    "Unbroken",
    "Unfit",
    "Unidentifiable",
    "Unknown",
    "answered",
    "filtered",
    "fit",
    "inquiry_of",
    "judged",
    "measured",
    "parse_record",
    "picked",
    "read_record",
    "read_recording",
    "read_signals",
    "record_contents",
    "shaken",
    "shaker_findings",
    "shaker_motion",
    "shaker_of",
    "tested",
    "with_shaker",
]
