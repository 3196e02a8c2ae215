"""The best design: which values of some inputs make an objective largest, all requirements met."""

from vireport.optimise import outputs
from vireport.optimise.grid import DesignGrid, JudgedDesign, grid_of
from vireport.optimise.problem import Problem, problem_of
from vireport.optimise.search import SearchEvidence, SearchResult, optimise

__all__ = [
    "DesignGrid",
    "JudgedDesign",
    "Problem",
    "SearchEvidence",
    "SearchResult",
    "grid_of",
    "optimise",
    "outputs",
    "problem_of",
]
