"""Critical points proved in ball arithmetic."""

from vireport.proofs.certificates import Certificate, Enclosure, certify

__all__ = [
    "Certificate",
    "Enclosure",
    "certify",
]
