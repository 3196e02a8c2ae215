"""Keys of a scenario for error against run time: the block `accuracy`."""

from vireport.scenario.keys import Block, WhenGiven, key


class AccuracyBlock(Block):
    """Error against run time of several methods, and the motion with compliant membranes beside the rigid one."""

    repeats: int = key(5, "Repeats", "1", "Runs of each method, of which the median time counts.", ge=1, le=100)
    compliant_membrane: bool = key(
        True,
        "Compliant membrane",
        "",
        "Whether to solve the motion with the membrane's own stiffness too.",
        addition="membranes",
    )
    ladder: tuple[float, ...] = key(
        (1.0, 1e2, 1e4, 1e6, 1e8),
        "Ladder",
        "1",
        "Factors on the membrane's stiffness, ascending from 1.",
        example=[1.0, 1e4],
        min_length=2,
        max_length=8,
        strict=False,
        addition="membranes",
    )


KEYS = {
    "accuracy": (
        WhenGiven[AccuracyBlock] | None,
        key(None, "Accuracy", "", "Error against run time, and the compliant membrane. Left out, neither is measured."),
    )
}
