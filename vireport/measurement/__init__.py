"""From measured impacts to a device: its unknown inputs with their uncertainty, or why they are not known."""

from vireport.measurement.flights import ClockedDevice, Unknown
from vireport.measurement.identification import Fitted, NoFit, Open, Unfit, Unidentifiable, fit
from vireport.measurement.inquiry import Identification, answered, inquiry_of
from vireport.measurement.misfit import BetterFit, judged, tested
from vireport.measurement.picking import Heard, Picked, filtered, picked
from vireport.measurement.recordings import Channel, HeardPlace, Recording, Unbroken, read_recording
from vireport.measurement.records import parse_record, read_record
from vireport.measurement.shaker import ShakerMotion, shaker_motion
from vireport.measurement.signals import OF_SHAKER, Signals, read_signals, with_shaker

__all__ = [
    "OF_SHAKER",
    "BetterFit",
    "Channel",
    "ClockedDevice",
    "Fitted",
    "Heard",
    "HeardPlace",
    "Identification",
    "NoFit",
    "Open",
    "Picked",
    "Recording",
    "ShakerMotion",
    "Signals",
    "Unbroken",
    "Unfit",
    "Unidentifiable",
    "Unknown",
    "answered",
    "filtered",
    "fit",
    "inquiry_of",
    "judged",
    "parse_record",
    "picked",
    "read_record",
    "read_recording",
    "read_signals",
    "shaker_motion",
    "tested",
    "with_shaker",
]
