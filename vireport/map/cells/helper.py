"""A process that computes chunks of a map for another one, which begins it by ``python -m vireport.map.cells.helper``.

Its input is the store, pickled, and then the number of a chunk on each line; it writes the number of each chunk that it
has stored. It ends with its input, hence also where the process that began it was killed.
"""

from __future__ import annotations

import pickle
import sys

from vireport.map.cells.store import Store, write_chunk


def main() -> None:
    """Compute and store chunks until the input ends."""
    store: Store = pickle.load(sys.stdin.buffer)
    for line in sys.stdin.buffer:
        write_chunk(store, int(line))
        sys.stdout.buffer.write(line)
        sys.stdout.buffer.flush()


if __name__ == "__main__":
    main()
