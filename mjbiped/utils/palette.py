"""Colours of figures and videos that colour-blind readers can tell apart, by M. Okabe and K. Ito (2002)."""

BLUE, ORANGE, VERMILLION, GREEN, BLACK = "#0072B2", "#E69F00", "#D55E00", "#009E73", "#000000"
PURPLE, SKY = "#CC79A7", "#56B4E9"

IN_WORDS = {BLUE: "blue", ORANGE: "orange", VERMILLION: "vermillion", GREEN: "green", BLACK: "black"}
IN_WORDS |= {PURPLE: "purple", SKY: "sky blue"}
"""Names of the colours, for legends and captions."""


def rgb(colour: str) -> tuple[float, float, float]:
    """Red, green and blue from 0 to 1 of a colour written as "#D55E00"."""
    red, green, blue = (int(colour[place : place + 2], 16) / 255.0 for place in (1, 3, 5))
    return red, green, blue
