"""Compile plain Python functions with Numba, at first use: `import mjbiped` does not import Numba.

The functions themselves do not change, so that one source runs either way. Machine code is kept on disk (see
`mjbiped.numerics.cache`) under a digest of everything that was compiled: Numba itself would not notice a change in
another file.
"""

from __future__ import annotations

import dis
import hashlib
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache, lru_cache, partial
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

Function = Callable[..., Any]
_registered: set[Function] = set()
_quiet = False
_announcements: list[list[str]] = []  # sentences to print if something is compiled, one for each `announced`


@lru_cache(maxsize=64)
def compiled(
    function: Function,
    group: Callable[..., Any],
    functions: tuple[Function, ...],
    inlined: tuple[Function, ...],
    apart: tuple[Function, ...] = (),
) -> Function:
    """Compile `function` with its first argument bound to a group of functions; other threads run meanwhile.

    Args:
        function: A function of four arguments; it and all that it calls are at the top level of modules.
        group: The class of the group, a `NamedTuple`.
        functions: Members of the group; results of this function are called as the machine code that they are.
        inlined: Functions that are inlined into their caller, with all that they call: those of the innermost loop.
        apart: Functions called by these that are not inlined, nor what they call.

    Returns:
        A function of the three other arguments.
    """
    digest = prepared((function, *functions), inlined, apart)
    space = {"function": function, "members": _module_of(group, functions, f"members_{digest[:16]}")}
    source = "def entry(x, y, z):\n    return function(members, x, y, z)\n"
    result: Function = from_source(partial(jitted, nogil=True, **OPTIONS), "entry", source, space, digest)
    return result


# without Numba's runtime (nothing is allocated) passing an array costs no atomic reference count, which would be half
# of the time
OPTIONS: dict[str, Any] = {"_nrt": False, "error_model": "numpy", "boundscheck": False}
"""Numba's options for functions that engines call within a step. Sums and products are rounded one by one, as in plain
Python, so that both make the same bits."""
LAW_OPTIONS: dict[str, Any] = {**OPTIONS, "boundscheck": True}
"""The same for laws, whose indices nobody has checked."""
CALLED_WITHIN: dict[str, Any] = {"forceinline": True, "no_cpython_wrapper": True, **LAW_OPTIONS}
"""The same for a function that is only inlined into its caller."""


def jitted(function: Function, **given: Any) -> Any:
    """Let Numba compile a function at its first call, and keep it on disk; the options are those of `njit`.

    Python and machine code can call it; for C there is `c_function`.
    """
    import numba

    from mjbiped.numerics.cache import keep
    from mjbiped.numerics.one_module import pipeline

    given = {"no_cfunc_wrapper": True, "pipeline_class": pipeline(), **given}
    made = numba.njit(**given)(function)
    keep(made, function)
    return made


def c_function(function: Function, signature: Any, **given: Any) -> Any:
    """Compile a function that C can call, and keep it on disk; the options are those of Numba's `cfunc`."""
    from numba.core.ccallback import CFunc
    from numba.core.sigutils import normalize_signature

    from mjbiped.numerics.cache import keep
    from mjbiped.numerics.one_module import pipeline

    exact = normalize_signature(signature)  # type: ignore[no-untyped-call]  # Numba has no types
    made: Any = CFunc(function, exact, locals={}, options=given, pipeline_class=pipeline())
    keep(made, function)
    made.compile()
    return made


def prepared(
    roots: Sequence[Function], inlined: Sequence[Function], apart: Sequence[Function] = (), *, checked: bool = False
) -> str:
    """Register functions, and all that they call, for use in compiled code.

    Args:
        roots: Functions at the top level of modules, or results of `compiled`.
        inlined: Functions among these and their callees that are inlined into their caller, with all that they call.
        apart: Functions called by these that are not inlined, nor what they call.
        checked: Whether indices into arrays are checked, in functions that no other caller has registered before.

    Returns:
        A digest of all the functions.
    """
    from numba.extending import register_jitable

    from mjbiped.numerics.one_module import pipeline

    _listen()
    parts = {part: None for root in roots for part in _called(root, set())}
    hot = {part for root in inlined for part in _called(root, set(apart))}
    for part in parts:
        if part not in _registered:
            given = {"forceinline": part in hot, "no_cfunc_wrapper": True, "pipeline_class": pipeline()}
            register_jitable(boundscheck=checked, **given)(part)
            _registered.add(part)
    made = [root.__name__ for root in roots if not isinstance(root, FunctionType)]  # the name contains a digest
    made.append(_addresses())
    known = [(described(part), part in hot) for part in parts]
    return hashlib.sha256(repr([known, made, checked]).encode()).hexdigest()


def from_source(compiler: Callable[..., Any], name: str, source: str, space: dict[str, Any], known: Any) -> Any:
    """Compile a function from its source text, and keep it on disk.

    Args:
        compiler: Compiles a Python function.
        name: Name of the function that the text defines.
        source: The text.
        space: Globals of the function.
        known: What machine code depends on in the globals; with the text it identifies the code on disk.
    """
    given = dict(space)
    exec(compile(source, f"<compiled {name}>", "exec"), given)
    digest = hashlib.sha256(repr((source, known, _addresses())).encode()).hexdigest()
    unique = f"{name}_{digest[:16]}"
    return compiler(renamed(given[name], unique))


def renamed(function: Function, name: str, **space: Any) -> Function:
    """Copy a function under a name that contains its digest, with further globals, as a function of this module.

    Functions of one name share an index file of Numba's, and one program's types, written there, would keep every other
    program from reading it.
    """
    assert isinstance(function, FunctionType)
    code = function.__code__.replace(co_name=name, co_qualname=name)
    return FunctionType(code, {**function.__globals__, **space, "__name__": __name__}, name)


@cache
def _addresses() -> str:
    """Digest of `numerics.addresses`, whose functions generate machine code: there is no Python code to describe."""
    return hashlib.sha256(Path(__file__).with_name("addresses.py").read_bytes()).hexdigest()


def announce(*, wanted: bool) -> None:
    """Say whether compilations are announced from now on, as they are unless said otherwise."""
    global _quiet
    _quiet = not wanted


@contextmanager
def announced(what: str, seconds: float) -> Iterator[None]:
    """Print one line on stderr if something has to be compiled within the block.

    Args:
        what: What is compiled, such as "PassiveController for the engine mujoco".
        seconds: How long it takes at most, s.
    """
    sentence = [] if _quiet else [f"compiling {what}, once; it takes some {max(seconds, 1.0):.0f} s ..."]
    _announcements.append(sentence)
    try:
        yield
    finally:
        _announcements[:] = [other for other in _announcements if other is not sentence]


@cache
def _listen() -> None:
    """Listen for compilations by Numba; loading machine code from disk is none."""
    from numba.core import event

    class Compiling(event.Listener):
        def on_start(self, _: Any) -> None:
            from tqdm.auto import tqdm

            for waiting in _announcements:
                while waiting:
                    # above the progress bar of a terminal; elsewhere there is none to be drawn again
                    (tqdm.write if sys.stderr.isatty() else print)(waiting.pop(), file=sys.stderr)

        def on_end(self, _: Any) -> None:
            """Required by Numba."""

    event.register("numba:compile", Compiling())  # type: ignore[no-untyped-call]  # Numba has no types


@lru_cache(maxsize=64)
def raises(roots: tuple[Function, ...]) -> bool:
    """Whether the functions, or anything that they call, contain a `raise` or `assert`."""
    return any(step.opname == "RAISE_VARARGS" for step in _instructions(roots))


@lru_cache(maxsize=64)
def takes_powers(roots: tuple[Function, ...]) -> bool:
    """Whether the functions, or anything that they call, contain `**`, whose last bit is another in machine code."""
    return any(step.argrepr in ("**", "**=") or step.argval == "pow" for step in _instructions(roots))


def _instructions(roots: tuple[Function, ...]) -> Iterator[dis.Instruction]:
    for part in {part for root in roots for part in _called(root, set())}:
        if isinstance(part, FunctionType):
            yield from dis.get_instructions(part)


def _module_of(group: Any, functions: tuple[Function, ...], name: str) -> ModuleType:
    """Make a module whose members are functions, under the names of the group's fields.

    As a tuple, they would be as many arguments of each call that is not inlined; a module is one, and Numba looks up
    its members while it compiles.
    """
    from numba.extending import register_jitable

    members = ModuleType(name)
    for field, member in zip(group._fields, functions, strict=True):
        if not isinstance(member, FunctionType):
            # machine code has an address, which cannot be kept on disk: pass a function that calls it
            member = register_jitable(_calling(member))
        setattr(members, field, member)
    return members


def _calling(machine_code: Function) -> Function:
    """Return a function that calls machine code."""
    return lambda *given: machine_code(*given)


def _called(function: Function, known: set[Function]) -> Iterator[Function]:
    """A function, and all functions that it calls, directly or indirectly, those that a user has jitted included."""
    if not isinstance(function, FunctionType) or function in known:
        return
    known.add(function)
    yield function
    for _, value in (*_globals_of(function), *_free(function)):
        yield from _called(getattr(value, "py_func", value), known)


def _globals_of(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Global names that a function uses, and attributes of modules, with their values."""
    names = function.__code__.co_names
    for name in names:
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType):
            yield from ((part, vars(value)[part]) for part in names if part in vars(value))
        elif value is not None:
            yield name, value


def described_with_callees(functions: tuple[Function, ...]) -> list[Any]:
    """`described` for functions and all that they call."""
    known: set[Function] = set()
    return [described(part) for function in functions for part in _called(function, known)]


def described(function: Function) -> Any:
    """Everything that determines what a function does: code, defaults, and constant globals and free variables."""
    assert isinstance(function, FunctionType)
    given = [*_globals_of(function), *_free(function)]
    constants = [(name, _constant(value)) for name, value in given if not callable(value)]
    defaults = _constant(function.__defaults__ or ())
    return function.__module__, function.__qualname__, _code(function.__code__), defaults, sorted(constants, key=str)


def _free(function: FunctionType) -> list[tuple[str, Any]]:
    """The free variables of a nested function, with their values."""
    cells = function.__closure__ or ()
    return [(name, cell.cell_contents) for name, cell in zip(function.__code__.co_freevars, cells, strict=True)]


def _constant(value: Any) -> Any:
    """Describe a value so that different values have different descriptions; `repr` abridges arrays."""
    if isinstance(value, tuple):
        return type(value).__qualname__, [_constant(part) for part in value]
    if hasattr(value, "tobytes"):
        return value.dtype.str, getattr(value, "shape", ()), hashlib.sha256(value.tobytes()).hexdigest()
    return repr(value)


def _code(code: CodeType) -> Any:
    constants = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return code.co_code.hex(), constants, code.co_names, code.co_varnames
