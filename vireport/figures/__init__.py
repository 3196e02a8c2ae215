"""Every figure of a study, drawn from its numbers."""

from vireport.figures.paper_figures import figure_2 as figure_2
from vireport.figures.paper_figures import figure_4 as figure_4
from vireport.figures.paper_figures import figure_7 as figure_7
from vireport.figures.paper_figures import pictures as pictures
