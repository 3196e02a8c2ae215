"""The best design: which values of some inputs make an objective largest, all requirements met."""

from vireport.optimise import outputs
from vireport.optimise.problem import problem_of
from vireport.optimise.search import Point, optimise

__all__ = ["Point", "optimise", "outputs", "problem_of"]
