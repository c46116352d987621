"""Valid ranges of user inputs, and checks of names and lists.

The ranges are wide: they contain whatever the engines were measured to work with (docs/tables/domains.md), and exclude
what no arithmetic survives. Conditions on several numbers at once, such as a slope too steep to stand on, are checked
where they arise. All messages have one form: the name, the value that was given, and what it must be.
"""

from __future__ import annotations

import difflib
import inspect
import math
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cache, wraps
from numbers import Integral, Real
from types import NoneType
from typing import Annotated, Any, TypeVar, cast, get_args, get_origin

import numpy as np
from numpy.typing import NDArray

from mjbiped.errors import InputError, shown

Kind = TypeVar("Kind")
Function = TypeVar("Function", bound=Callable[..., Any])


@dataclass(frozen=True)
class Domain:
    """A closed range of real numbers.

    Attributes:
        low: Least value.
        high: Greatest value.
        unit: Unit as written behind a number; empty for pure numbers.
    """

    low: float
    high: float
    unit: str = ""

    def __str__(self) -> str:
        """Both ends and the unit, for messages."""
        return f"from {self.low:g} to {self.high:g} {self.unit}".rstrip()

    @property
    def words(self) -> str:
        """Description of a valid value."""
        return f"a number {self}"

    def check(self, name: str, value: object) -> float:
        """Check a number.

        Args:
            name: Name of the quantity, for the message.
            value: Anything; only real numbers of Python or NumPy pass, and no truth values.

        Returns:
            The number as a plain float; negative zero becomes zero, so that equal values are equal bit by bit.

        Raises:
            InputError: The value is not a finite number in the domain.
        """
        number = as_float(value)
        if not self.low <= number <= self.high:
            words = "" if math.isfinite(number) else "a finite number "
            raise InputError(f"{name} = {shown(value)}: must be {words}{self}")
        return number

    def array(self, name: str, value: object, shape: tuple[int | None, ...] | None) -> NDArray[np.float64]:
        """Check an array of numbers, given as nested sequences or as an array.

        Args:
            name: Name of the quantity, for the message.
            value: Numbers in sequences or arrays.
            shape: Expected shape, with None for any length; None for any shape.

        Returns:
            A new array.

        Raises:
            InputError: The shape is different, or an entry is not a finite number in the domain.
        """
        # entries of lists keep their types: NumPy would turn texts and truth values among numbers into numbers
        given = value if isinstance(value, np.ndarray) else np.array(value, dtype=object)
        if given.dtype.kind == "O" and all(_is_real(each) for each in given.flat):
            given = np.array([as_float(each) for each in given.flat], dtype=np.float64).reshape(given.shape)
        if given.dtype.kind not in "iuf":
            raise InputError(f"{name} = {shown(value)}: must be numbers {self}")
        wanted = given.shape if shape is None else shape
        if len(wanted) != given.ndim or any(n not in (None, m) for n, m in zip(wanted, given.shape, strict=True)):
            raise InputError(f"{name}: expected shape {str(shape).replace('None', 'n')}, got {given.shape}")
        numbers = np.array(given, dtype=np.float64)
        outside = ~((self.low <= numbers) & (numbers <= self.high))
        if outside.any():
            worst = float(numbers[outside][0])
            word = "" if math.isfinite(worst) else "finite "
            raise InputError(f"{name}: {shown(worst)} in it: must be {word}numbers {self}")
        return numbers


@dataclass(frozen=True)
class Count:
    """A closed range of whole numbers.

    Attributes:
        low: Least value.
        high: Greatest value.
    """

    low: int
    high: int

    def __str__(self) -> str:
        """Both ends, for messages."""
        return f"a whole number from {self.low} to {self.high}"

    @property
    def words(self) -> str:
        """Description of a valid value."""
        return str(self)

    def check(self, name: str, value: object) -> int:
        """Check a whole number of Python or NumPy; a float is refused.

        Raises:
            InputError: The value is not a whole number in the domain.
        """
        if isinstance(value, bool) or not isinstance(value, Integral) or not self.low <= int(value) <= self.high:
            raise InputError(f"{name} = {shown(value)}: must be {self}")
        return int(value)


def _is_real(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def as_float(value: object) -> float:
    """Convert a real number to a float: infinity if it is too great, NaN if it is not a real number."""
    if not _is_real(value):
        return math.nan
    try:
        return float(value) + 0.0  # type: ignore[arg-type]  # a real number
    except OverflowError:
        return math.inf


def parse_number(text: object) -> int | float | None:
    """Parse a number; None if it is not a text of one."""
    if not isinstance(text, str) or "_" in text:
        return None
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return None


def check_states(name: str, value: object, shape: tuple[int | None, ...]) -> NDArray[np.float64]:
    """Check states (q1, q2, dq1, dq2) in rad and rad/s along the last dimension of an array.

    Raises:
        InputError: The shape is different, or a number is outside its domain.
    """
    states = STATE.array(name, value, shape)
    ANGLE.array(f"{name}, its angles", states[..., :2], None)
    return states


def check_text(name: str, value: object) -> str:
    """Check a text that is written into records.

    Raises:
        InputError: The value is not text, or UTF-8 cannot write it, like some file names.
    """
    if not isinstance(value, str):
        raise InputError(f"{name} = {shown(value)}: must be text")
    try:
        value.encode()
    except UnicodeEncodeError as error:
        raise InputError(f"{name} = {shown(value)}: must be text that UTF-8 can write; rename it") from error
    return value


def check_kind(name: str, value: object, kind: type[Kind]) -> Kind:
    """Check that a value is an object of a class of this package.

    Raises:
        InputError: It is not.
    """
    if isinstance(value, kind):
        return value
    raise InputError(f"{name} must be a mjbiped.{kind.__name__}, got {type(value).__name__}")


def check_fields(instance: object) -> None:
    """Check the fields of a dataclass that are annotated with a domain, and replace them with plain numbers.

    A field `speed: Annotated[float, SPEED]` must be in its domain; `Annotated[float | None, SPEED]` allows None, and so
    does a default of None.

    Raises:
        InputError: One is outside its domain.
    """
    for name, number in _checked(type(instance), vars(instance)).items():
        object.__setattr__(instance, name, number)


def checked(function: Function) -> Function:
    """Decorate a function to check the arguments that are annotated with a domain, as `check_fields` does for fields.

    The function receives plain numbers. An argument outside its domain raises an `InputError`.
    """
    signature = inspect.signature(function)

    @wraps(function)
    def checking(*args: object, **named: object) -> object:
        given = signature.bind(*args, **named)
        given.arguments.update(_checked(function, given.arguments))
        return function(*given.args, **given.kwargs)

    return cast(Function, checking)


def _checked(owner: type | Callable[..., object], values: Mapping[str, object]) -> dict[str, object]:
    """Check the values of the fields or parameters that a class or a function annotates with domains."""
    return {
        name: domain.check(name, values[name])
        for name, (domain, optional) in annotated(owner).items()
        if name in values and not (optional and values[name] is None)
    }


@cache
def annotated(owner: type | Callable[..., object]) -> dict[str, tuple[Any, bool]]:
    """Domains of the fields of a class, or parameters of a function, by name, and whether None is allowed."""
    found = {}
    for part in reversed(getattr(owner, "__mro__", (owner,))):
        space = vars(sys.modules[part.__module__])
        for name, hint in inspect.get_annotations(part).items():
            with suppress(Exception):  # a type that only a type checker sees, or whatever a user's class has there
                meant = eval(hint, space) if isinstance(hint, str) else hint
                if get_origin(meant) is Annotated:
                    kind, domain = get_args(meant)
                    found[name] = (domain, NoneType in get_args(kind) or vars(part).get(name, part) is None)
    return found


@dataclass(frozen=True)
class Interval:
    """Ranges (low, high) of real numbers with low <= high, both ends in a domain.

    Attributes:
        ends: Domain of the ends.
    """

    ends: Domain | Count

    def check(self, name: str, value: object) -> tuple[float, float]:
        """Check a range.

        Raises:
            InputError: The value is not a pair, an end is outside the domain, or the ends are in the wrong order.
        """
        if isinstance(value, str) or not isinstance(value, Sequence) or len(value) != 2:
            raise InputError(f"{name} = {shown(value)}: must be a range (low, high), on the command line low..high")
        low, high = (self.ends.check(f"{name}, {end} end", v) for end, v in zip(("low", "high"), value, strict=True))
        if low > high:
            raise InputError(f"{name} = ({low:g}, {high:g}): must have its low end first, swap them")
        return low, high


@dataclass(frozen=True)
class Ends:
    """Distances of two ends, behind a point and ahead of it, both in a domain; one number stands for two equal ones.

    Attributes:
        distance: Domain of the distances.
    """

    distance: Domain

    @property
    def words(self) -> str:
        """Description of valid distances."""
        return f"one distance {self.distance}, or two, behind and ahead, as 0.05,0.15"

    def check(self, name: str, value: object) -> tuple[float, float]:
        """Check distances, given as a number, a pair, or a text such as "0.05,0.15".

        Raises:
            InputError: There are neither one nor two, or one is outside the domain.
        """
        given = map(parse_number, value.split(",")) if isinstance(value, str) else entries(value) or (value,)
        each = [as_float(end) for end in given]
        if len(each) not in (1, 2) or not all(self.distance.low <= end <= self.distance.high for end in each):
            raise InputError(f"{name} = {shown(value)}: must be {self.words}")
        return each[0], each[-1]


@dataclass(frozen=True)
class OneOrEach:
    """Numbers of a domain, one for each of several parts; a single number counts for all of them.

    Attributes:
        each: Domain of the numbers.
    """

    each: Domain

    def check(self, name: str, value: object) -> float | tuple[float, ...]:
        """Check a number, or a sequence of numbers.

        Raises:
            InputError: There is none, or one is outside the domain.
        """
        given = entries(value)
        if given is None:
            return self.each.check(name, value)
        if not given:
            raise InputError(f"{name} = {shown(value)}: must be one number {self.each}, or several")
        return tuple(self.each.check(f"{name}, number {k}", number) for k, number in enumerate(given, start=1))


@dataclass(frozen=True)
class Words:
    """Words, one of which is chosen.

    Attributes:
        valid: All of them.
    """

    valid: tuple[str, ...]

    @property
    def words(self) -> str:
        """Description of a valid word."""
        return f"one of {', '.join(self.valid)}"

    def check(self, name: str, value: object) -> str:
        """Check a word.

        Raises:
            InputError: It is none of the valid ones; the message suggests the nearest.
        """
        return known_name(name, value, self.valid)


def entries(value: object) -> tuple[Any, ...] | None:
    """Return the entries of a list, a tuple or an array; None for a single value, text or a mapping."""
    if isinstance(value, Iterable) and not isinstance(value, str | bytes | Mapping):
        with suppress(TypeError):  # an array of no dimension
            return tuple(value)
    return None


def known_name(what: str, name: object, valid: Iterable[str]) -> str:
    """Check that `name` is one of the `valid` names.

    Raises:
        InputError: It is not; the message lists the valid names and suggests the nearest.
    """
    names = tuple(valid)
    if isinstance(name, str) and name in names:
        return name
    raise InputError(f"unknown {what} {shown(name)}: valid are {', '.join(names) or 'none'}{nearest(name, names)}")


def nearest(name: object, valid: Iterable[str]) -> str:
    """Return the end of a message about an unknown name, such as "; did you mean 'rise'?"; empty if no name is near."""
    near = difflib.get_close_matches(name, tuple(valid), n=1) if isinstance(name, str) and len(name) < 100 else []
    return f"; did you mean {near[0]!r}?" if near else ""


# ---- the robot -------------------------------------------------------------------------------------------------------

LEG_MASS = Domain(1e-9, 1e6, "kg")  # as far as the simplest walker (docs/gaits.md) asks for
HIP_MASS = Domain(0.0, 1e6, "kg")
LENGTH = Domain(1e-9, 1e3, "m")
LEG = Domain(1e-3, 2e3, "m")
INERTIA = Domain(0.0, 1e12, "kg m^2")
FOOT_RADIUS = Domain(0.0, 1e3, "m")
GRAVITY = Domain(1e-3, 1e3, "m/s^2")
SOLE = Ends(Domain(0.0, 1e3, "m"))

# ---- its state -------------------------------------------------------------------------------------------------------

ANGLE = Domain(-1e3, 1e3, "rad")
RATE = Domain(-1e9, 1e9, "rad/s")
STATE = Domain(min(ANGLE.low, RATE.low), max(ANGLE.high, RATE.high), "rad or rad/s")
SLOPE = Domain(-1.57, 1.57, "rad")
SLOPE_DEG = Domain(-89.95, 89.95, "degrees")
ROLL = Domain(-0.5, 0.5, "rad")
ROLL_DEG = Domain(-28.6, 28.6, "degrees")
DOWNHILL = Domain(1e-12, SLOPE.high, "rad")
TIME = Domain(0.0, 1e9, "s")

# ---- a walk ----------------------------------------------------------------------------------------------------------

STEPS = Count(1, 1_000_000_000)
DISTANCE = Domain(1e-6, 1e7, "m")
TIMESTEP = Domain(1e-6, 4e-3, "s")
CONTROL_PERIOD = Domain(1e-6, 1e3, "s")
REACH = Domain(0.0, 2.0, "leg lengths")
WORKERS = Count(1, 1024)

# ---- references ------------------------------------------------------------------------------------------------------

SPEED = Domain(1e-3, 100.0, "m/s")
CLEARANCE = Domain(0.0, 100.0, "m")

# ---- its disturbances ------------------------------------------------------------------------------------------------

ANGLE_NOISE = Domain(0.0, 1.0, "rad")
TORQUE_LIMIT = Domain(0.0, 1e12, "N m")
MODEL_ERROR = Domain(1e-3, 1e3)
IMPULSE = Domain(0.0, 1e9, "N s")
PUSH = Domain(-IMPULSE.high, IMPULSE.high, "N s")

# ---- gains -----------------------------------------------------------------------------------------------------------

GAIN = Domain(1e-6, 1e6, "1/s")
SLOWEST_RATE = Domain(1e-9, 1e6, "rad/s")

# ---- the ground ------------------------------------------------------------------------------------------------------

PLACE = Domain(-1e5, 1e5, "m")
STRETCH = Domain(1e-6, 1e5, "m")
STEP = Domain(-0.5, 0.5, "m")
PROBABILITY = Domain(0.0, 1.0)
SEGMENTS = Count(1, 100_000)
SEED = Count(0, 2**64 - 1)

# ---- many walks and gaits --------------------------------------------------------------------------------------------

MAP_STEPS = Count(1, 1_000_000)
KEPT = Count(1, 20_000_000)
DOUBLINGS = Count(1, 6)
SLOPES = Count(4, 100_000)
GRID = Count(2, 10_000)
LIMIT = Count(1, 10_000)
WALKS = Count(1, 1_000_000)
STUDY_NUMBER = Domain(-1e18, 1e18)
STUDY_POSITIVE = Domain(1e-18, 1e18)
STUDY_EXACT = Count(-(2**53), 2**53)

# ---- pictures --------------------------------------------------------------------------------------------------------

PIXELS = Count(64, 4096)
FPS = Count(1, 120)
SLOW_MOTION = Domain(0.01, 100.0)
