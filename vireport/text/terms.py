"""What the terms mean that reports use, in the words of a textbook."""

from __future__ import annotations

TERMS = {
    "1:1 motion": "The ball strikes each membrane once in a forcing period, and every period is like the last.",
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
    "stable node": "Disturbances of the motion die out without oscillation: both multipliers are real and less "
    "than 1 in size.",
    "stable focus": "Disturbances of the motion die out in a spiral: the multipliers are complex and less than 1 "
    "in size.",
    "margin": "How far an input may go from the design point until the first critical point at which the stable motion "
    "ends, or another takes over, as a share of its value, every other input as it is.",
    "word": "The impacts of one period of a motion in their order: B on the bottom membrane, T on the top, as in BBT.",
    "chaos": "A motion that never repeats itself although nothing in it is random: neighbouring motions part "
    "exponentially.",
}
"""Each term with what it means."""
