"""From measured impacts to a device: its unknown inputs with their uncertainty, or why they are not known."""

from vireport.measurement.flights import ClockedDevice, Unknown
from vireport.measurement.identification import Fitted, NoFit, Open, Unfit, Unidentifiable, fit
from vireport.measurement.inquiry import Identification, answered, inquiry_of
from vireport.measurement.misfit import BetterFit, judged, tested
from vireport.measurement.records import parse_record, read_record

__all__ = [
    "BetterFit",
    "ClockedDevice",
    "Fitted",
    "Identification",
    "NoFit",
    "Open",
    "Unfit",
    "Unidentifiable",
    "Unknown",
    "answered",
    "fit",
    "inquiry_of",
    "judged",
    "parse_record",
    "read_record",
    "tested",
]
