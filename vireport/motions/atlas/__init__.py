"""Every family of motions of a sweep: looked for among all flight times, followed, and joined where they meet.

Candidates come from four searches, each for the words that it can do: `one_impact` (a scan over the phase), `exclusion`
(flight times at which no motion can be are left out, by proof; two and three impacts), `four_impacts` (a grid of
times), `guesses` (any word that the user names). The first three rest on `surface`, the closed form of motions above
their flight times. `families` follows what they find, from event to event, to an atlas. `portraits` draws a motion.
"""
