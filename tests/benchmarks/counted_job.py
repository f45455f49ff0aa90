"""A job of test_instructions.py in a process of its own: ``python -m tests.benchmarks.counted_job residual 400``."""

from __future__ import annotations

import sys
from collections.abc import Callable

from glossa import VOWELS, Scene, Speaker, _core


def jobs() -> dict[str, Callable[[], object]]:
    """By name, on the built-in speaker with every effect, mirrored."""
    scene = Scene(Speaker.reference(), mirror=True)
    pieces = _core.Pieces(scene._solver, scene._fractions(VOWELS["i"]))
    positions = scene._body.nodes
    pieces.force(positions)
    pieces.assemble()
    return {
        "residual": lambda: pieces.force(positions),
        "assembly": pieces.assemble,
        "factorisation": pieces.factorise,
        "equilibrium": lambda: scene.equilibrate(VOWELS["ə"]),
    }


def main() -> None:
    job = jobs()[sys.argv[1]]
    for _ in range(int(sys.argv[2])):
        job()


if __name__ == "__main__":
    main()
