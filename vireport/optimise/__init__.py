"""The best design: which values of some inputs make an objective largest, all requirements met."""

from vireport.optimise import outputs
from vireport.optimise.grid import DesignGrid, JudgedDesign, grid_of
from vireport.optimise.problem import Problem, problem_of
from vireport.optimise.search import optimise

__all__ = [
    "DesignGrid",
    "JudgedDesign",
    "Problem",
    "grid_of",
    "optimise",
    "outputs",
    "problem_of",
]
