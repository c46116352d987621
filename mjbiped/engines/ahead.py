"""How many walks of one kind a program is about to make, by which `mjbiped.engines.compiling` decides."""

from __future__ import annotations

from contextvars import ContextVar

AHEAD: ContextVar[int] = ContextVar("walks ahead", default=1)
"""Number of walks of the study that is under way in this process; 1: none is."""
