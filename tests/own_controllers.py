"""Controllers as users write them into files of their own, for tests that load them by name."""

from pathlib import Path

SPREAD = """\
from dataclasses import dataclass

from controllers import Controller


@dataclass(frozen=True)
class HipSpread(Controller):
    stiffness: float = 0.5
    spread: float = 0.4

    def torque(self, memory, t, q, dq):
        return 0.0, -self.stiffness * (q[1] - q[0] - self.spread)
"""
"""A controller that needs neither robot nor gait; it walks down 2 degrees."""


def law(body: str, *, above: str = "", fields: str = "") -> str:
    """The source of a class `Law` whose `torque` has this body; `fields` stand in the class before it."""
    inside = "".join(f"    {line}\n" for line in fields.splitlines())
    lines = "".join(f"        {line}\n" for line in body.splitlines())
    return (
        f"import math\nfrom controllers import Controller\n{above}\n"
        f"class Law(Controller):\n{inside}    def torque(self, memory, t, q, dq):\n{lines}"
    )


def write(folder: Path, name: str, text: str) -> Path:
    """Write a file; returns its path."""
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path
