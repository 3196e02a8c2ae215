"""Periodic motions of any word: what they are, what happens to them, and those with two impacts in closed form.

A way through, in the order in which a sweep of 1:1 motions (one impact on each membrane) is solved:

1. `orbits`: for every q (share of the period from the bottom to the top) and forcing phase there is one 1:1 motion, in
   closed form, and the d and gbar that it belongs to: a surface over the plane of q and phase.
2. `sweep`: when one parameter of a device varies, d, gbar, their ratio or both stay constant. This `Level` is a curve
   on the surface, and in the plane of q and phase (`level_plane`).
3. `level_curve`: the curve cut into strands, and sampled so finely that nothing hides between two samples. Two sheets
   over q where the force is a sine; with harmonics, or where a restitution varies (`bounces`), a `contour`.
4. `pieces`: the strands cut where the sweep or the motions end, with the events on them (`events`, `conditions`):
   period doubling, fold, pitchfork, grazing, changes between node and focus.
5. `points`: each event solved for in decimals (`polish`), to the last digit of a double.
6. `branches`: a piece with its points as rows of numbers (`one_to_one`) and as a family (`families`).
7. `diagram`: the branches numbered, their critical points labelled, Table 1. `diagram.solve` does 2 to 7: it calls each
   stage once, with what the stage before it returned.

Motions of any word have no closed form: `periodicity` has their conditions and derivatives, `paths` follows them by
pseudo-arclength from event to event, `switching` steps from a point onto the families that meet at it. The package
`atlas` joins both kinds of families.

Used by all: `stability` (return map, its trace, types), `turning` (turning points of the ball: whether it stays between
the membranes), `roots` (searches in brackets), `error_bounds` (how far each number may be from the exact one).
`pointwise` and `plane` find all 1:1 motions at thousands of design points at once, without a sweep. `generation` has
voltages.
"""
