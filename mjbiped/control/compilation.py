"""Compiles a controller's laws, by themselves; see `mjbiped.control.machine_code`."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

from mjbiped.control.controller import Law
from mjbiped.numerics.jit import kept_on_disk, prepared, raises
from mjbiped.numerics.records import NotPackableError, Packer

if TYPE_CHECKING:
    from mjbiped.control.machine_code import CompiledLaw

_POSTURES = "q1_old, q2_old, q1, q2, dq1, dq2"
_FAILED = 0  # index in a law's record: not zero once a law has raised an exception


class MachineCode:
    """The machine code of a law with the parameters of one controller, to be kept while engines call it.

    Attributes:
        law: Addresses, for compiled engines.
    """

    law: CompiledLaw

    def __init__(self, law: Law, states: int, memory_size: int, *, contract: bool) -> None:
        """Compile the law, or take it from the cache.

        Args:
            law: The controller's.
            states: Number of its integrated states.
            memory_size: Floats of its memory.
            contract: Whether products and sums may be made in one operation, with one rounding: faster, and not bitwise
                what plain Python computes.

        Raises:
            NotPackableError: `can_be_compiled` says no.
            NumbaError: The law cannot be compiled.
        """
        from mjbiped.control.machine_code import CompiledLaw

        packer = Packer()
        packer.add(0.0)  # _FAILED
        made = packer.add(law.parameters)
        self._record = packer.record()
        kind = (made, tuple(packer.classes.items()), 2 + states, memory_size, contract)
        self._functions = {name: _function(name, getattr(law, name), *kind) for name in law._fields[1:]}
        self.law = CompiledLaw(
            **{name: function.address for name, function in self._functions.items()},
            record=self._record.ctypes.data,
            values=(0.0,) * (2 + states),
        )

    @property
    def failed(self) -> bool:
        """Whether a law has raised an exception; its torques are no numbers since."""
        return bool(self._record[_FAILED])


def can_be_compiled(law: Law) -> bool:
    """Whether machine code could do what the law does.

    An exception that it raises would lose its message there, and a record holds only numbers, arrays of floats, and
    tuples of these.
    """
    try:
        Packer().add(law.parameters)
    except NotPackableError:
        return False
    return not raises((law.torque, law.touchdown, law.slope_estimate, law.next_discontinuity))


@lru_cache(maxsize=256)
def _function(
    name: str,
    law: Callable[..., Any],
    made: str,
    classes: tuple[tuple[str, type], ...],
    values: int,
    memory_size: int,
    contract: bool,
) -> Any:
    """One of the four C functions, for one kind of law and parameters. What did not change is not compiled again."""
    import numba

    from mjbiped.numerics import addresses

    written = "; ".join(f"o[{index}] = float(value_{index})" for index in range(values))
    names = ", ".join(f"value_{index}" for index in range(values))  # unpacked: their number is looked at
    # once a law has failed, be it at a touchdown, no torque is a number: the walk goes no further
    lost = f"if p[{_FAILED}] != 0.0: o[:] = NAN"
    arguments, before, call, after = {
        "torque": (
            "t, q1, q2, dq1, dq2, out",
            f"o = numbers(out, {values})",
            f"{names} = law(parameters, m, t, q1, q2, dq1, dq2); {written}",
            lost,
        ),
        "touchdown": (_POSTURES, "pass", f"law(parameters, m, {_POSTURES})", "pass"),
        "slope_estimate": ("t", "x = NAN", "x = float(law(parameters, m))", "return x"),
        "next_discontinuity": ("t", "x = NAN", "x = float(law(parameters, m, t))", "return x"),
    }[name]
    kinds = [(kind.__qualname__, getattr(kind, "_fields", ())) for _, kind in classes]
    digest = prepared((law,), inlined=(law,) if name == "torque" else ())
    known = (digest, name, made, kinds, values, memory_size, contract, numba.__version__)
    digest = hashlib.sha256(repr(known).encode()).hexdigest()
    source = f"""def bind(digest):
    def {name}_{digest[:16]}(record, memory, {arguments}):
        digest  # a cell that Numba's cache looks at
        p = numbers(record, {made.count("p[") + 1})
        {before}
        try:
            parameters, m = {made}, numbers(memory, {memory_size})
            {call}
        except Exception:  # such as an index into a tuple; it could not pass through C
            p[{_FAILED}] = 1.0
        {after}
    return {name}_{digest[:16]}
"""
    space: dict[str, Any] = {
        "__name__": __name__,
        "NAN": float("nan"),
        "numbers": addresses.numbers,
        "array": addresses.array,
        "law": law,
        **dict(classes),
    }
    exec(compile(source, __file__, "exec"), space)  # the cache lies where this file does
    word, number = numba.types.int64, numba.types.float64
    signature = {
        "torque": numba.types.void(word, word, *[number] * 5, word),
        "touchdown": numba.types.void(word, word, *[number] * 6),
    }.get(name, number(word, word, number))
    options: dict[str, Any] = {"_nrt": False, "error_model": "numpy", "boundscheck": not contract}
    if contract:
        options["fastmath"] = {"contract"}
    return kept_on_disk(partial(numba.cfunc, signature, **options), space["bind"](digest))
