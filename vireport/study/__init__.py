"""What is done for a scenario: its plan, its results, and the files for machines."""

from vireport.study.results import results as results
from vireport.study.study import Study as Study
from vireport.study.study import analyse as analyse
