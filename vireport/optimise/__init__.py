"""The best design: which values of some inputs make an objective largest, all requirements met."""

from vireport.optimise import outputs
from vireport.optimise.problem import Problem, problem_of
from vireport.optimise.search import Evidence, Point, optimise

__all__ = ["Evidence", "Point", "Problem", "optimise", "outputs", "problem_of"]
