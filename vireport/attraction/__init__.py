"""What is proved to come to a stable motion: a region around it, the ball from rest, shocks up to a bound."""

from vireport.attraction.proved import ClaimedSection, Proved, ProvedRegion, Rechecked, prove_again, proved_of
from vireport.attraction.trap import Trap

__all__ = ["ClaimedSection", "Proved", "ProvedRegion", "Rechecked", "Trap", "prove_again", "proved_of"]
