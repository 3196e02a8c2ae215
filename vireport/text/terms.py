"""What the terms mean that reports use, in the words of a textbook."""

from __future__ import annotations

TERMS = {
    "1:1 motion": "The ball strikes each membrane once in a forcing period, and every period is like the last. Its "
    "word is BT.",
    "BT": "The word of the 1:1 motion: one impact on the bottom membrane, one on the top. BBT is 2:1 motion, with two "
    "impacts on the bottom.",
    "word": "The impacts of one period of a motion in their order: B on the bottom membrane, T on the top, as in BBT.",
    "family": "All motions of one word that change into one another as an input is varied. A symmetric motion is its "
    "own mirror image, an asymmetric one is not.",
    "admissible": "A solution of the equations is admissible, and a motion, if the ball stays between the membranes "
    "from impact to impact.",
    "design point": "The device as the scenario gives it, with one value for every input.",
    "stable range": "The values of the swept input over which there is an admissible stable 1:1 motion.",
    "margin": "How far an input may go from the design point until the first critical point at which the stable motion "
    "ends, or another takes over, as a share of its value, with every other input unchanged.",
    "margin to use": "The least margin that rigid impacts, soft membranes and neglected effects leave: by how much an "
    "input may be off before the motion ends.",
    "critical point": "A value of the swept input at which motions appear, vanish, or change their type: node to focus "
    "(A), period doubling (B), fold or pitchfork (C), grazing (G).",
    "multiplier": "The factor by which a small disturbance grows or shrinks in one period of the motion. The motion is "
    "stable if all are less than 1 in size.",
    "period doubling": "A multiplier of the motion goes through -1: beyond it the motion repels, and one that repeats "
    "itself after twice the time begins or ends there. Often the first of a cascade that ends in chaos.",
    "fold": "A multiplier of the motion goes through 1, and a stable and an unstable motion meet and vanish. Beyond it "
    "the ball jumps to another motion.",
    "pitchfork": "A multiplier of a symmetric motion of a horizontal capsule goes through 1, and two asymmetric "
    "motions, mirror images of each other, branch off. Where they are stable, stability passes to them: the device "
    "goes on working, with unequal flights and other voltages. Margins and requirements count it as the end of the "
    "motion that was designed.",
    "grazing": "Between two impacts the ball just touches a membrane. Beyond it the motion would pass through the "
    "membrane: another one, with that impact, takes its place.",
    "node to focus": "The multipliers of the motion become complex: disturbances then die out in a spiral. Stability "
    "does not change.",
    "stable node": "Disturbances of the motion die out without oscillation: both multipliers are real and less than 1 "
    "in size.",
    "stable focus": "Disturbances of the motion die out in a spiral: the multipliers are complex and less than 1 in "
    "size.",
    "chaos": "A motion that never repeats itself although nothing in it is random: neighbouring motions part "
    "exponentially.",
    "reached from rest": "The device comes to the motion when it is switched on with the ball at rest on the bottom "
    "membrane.",
    "basin": "All states from which the device comes to a motion. Each stable motion has its own.",
    "hysteresis": "The motion at a value of an input depends on whether the input came to it from below or from above.",
    "rest cycle": "A motion in which the ball lies on the bottom membrane again and again, and repeats all from there.",
    "recovery": "The forcing periods until 1 % of a small disturbance is left.",
    "least shock": "The smallest jump of the relative velocity found, at any moment of the period, after which the "
    "device goes to another motion.",
    "jitter": "The spread of phases, velocities and voltages under small random kicks at the impacts.",
    "restitution": "The ratio r of the ball's speed relative to the capsule after an impact to that before it.",
    "d": "The dimensionless length s M omega^2/(F pi^2): the distance s between the membranes in the unit of length "
    "that the capsule's mass M, the force F and its angular frequency omega make.",
    "gbar": "The dimensionless gravity M g sin(beta)/F: gravity along the capsule over the force's acceleration.",
    "q": "The share of its period that a 1:1 motion takes from the bottom membrane to the top one. A symmetric motion "
    "has 1/2.",
    "phi": "The phase of the force at an impact, 0 where the force is largest.",
    "U_ave": "The mean over the two impacts of a period of the voltage that each generates.",
}
"""Each term with what it means."""
