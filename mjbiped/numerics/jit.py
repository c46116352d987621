"""Compiles plain Python functions with Numba, at first use: `import mjbiped` neither imports Numba nor waits for it.

The functions stay what they are, so that one source runs either way. Machine code is kept on disk where Numba can write
(beside this file, else in the user's cache); its key holds a digest of all that was compiled, since Numba itself would
not notice a change in another file than this one.
"""

from __future__ import annotations

import dis
import hashlib
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import cache, lru_cache
from itertools import pairwise
from pathlib import Path
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any

Function = Callable[..., Any]
_registered: set[Function] = set()
_announcements: list[list[str]] = []  # what waits to be said if something is compiled, one for each `announced`


@lru_cache(maxsize=64)
def compiled(
    function: Function,
    group: Callable[..., Any],
    functions: tuple[Function, ...],
    inlined: tuple[Function, ...],
    apart: tuple[Function, ...] = (),
    *,
    contract: bool = True,
) -> Function:
    """`function` with its first argument fixed to a group of functions, as machine code that lets other threads run.

    Args:
        function: A function, as all that it calls, at the top level of a module; three arguments follow the first.
        group: The class of the group, a `NamedTuple`.
        functions: Its members; what this function has made before is called as the machine code that it is.
        inlined: Functions that become part of their caller, with all that they call: those of the innermost loop.
        apart: Those that do not, though these call them, nor what they call.
        contract: See `options`.

    Returns:
        A function of the arguments that are left.
    """
    digest = prepared((function, *functions), inlined, apart)
    entry = _bound(function, group, functions, digest if contract else f"exact_{digest}")
    result: Function = jitted(entry, nogil=True, **options(contract))
    return result


def options(contract: bool) -> dict[str, Any]:
    """Numba's options for what engines call within a step.

    Args:
        contract: Whether products and sums may be made in one operation, with one rounding: faster, and not bitwise
            what plain Python computes. Indices are then not checked.
    """
    # without Numba's runtime (nothing is allocated), handing an array over costs no atomic reference count: half of the
    # time otherwise
    made: dict[str, Any] = {"_nrt": False, "error_model": "numpy", "boundscheck": not contract}
    return {**made, "fastmath": {"contract"}} if contract else made


def jitted(function: Function, **given: Any) -> Any:
    """A function that Numba compiles when it is called, kept on disk; the options are those of its `njit`."""
    import numba

    from mjbiped.numerics.cache import keep

    made = numba.njit(**given)(function)
    keep(made, function)
    return made


def c_function(function: Function, signature: Any, **given: Any) -> Any:
    """A compiled function that C can call, kept on disk; the options are those of Numba's `cfunc`."""
    from numba.core.ccallback import CFunc
    from numba.core.sigutils import normalize_signature

    from mjbiped.numerics.cache import keep

    exact = normalize_signature(signature)  # type: ignore[no-untyped-call]  # Numba has no types
    made: Any = CFunc(function, exact, locals={}, options=given)
    keep(made, function)
    made.compile()
    return made


def prepared(roots: Sequence[Function], inlined: Sequence[Function], apart: Sequence[Function] = ()) -> str:
    """Let compiled functions call the roots and all that these call; returns a digest of all of it.

    Args:
        roots: Functions at the top level of modules, or what `compiled` has made of such.
        inlined: Those of them, or of what they call, that become part of their caller with all that they call.
        apart: Those of these that do not, with what they call.
    """
    from numba.extending import register_jitable

    _listen()
    parts = {part: None for root in roots for part in _called(root, set())}
    hot = {part for root in inlined for part in _called(root, set(apart))}
    for part in parts:
        if part not in _registered:
            register_jitable(forceinline=part in hot, no_cfunc_wrapper=True)(part)
            _registered.add(part)
    made = [root.__name__ for root in roots if not isinstance(root, FunctionType)]  # with a digest in it
    made.append(_addresses())
    known = [(described(part), part in hot) for part in parts]
    return hashlib.sha256(repr([known, made]).encode()).hexdigest()


@lru_cache(maxsize=1024)
def kept_apart(function: Function, contract: bool, types: tuple[str, ...] = ()) -> tuple[Function, str]:
    """A function as machine code that becomes part of its caller, as does all that it calls; each is kept by itself.

    When one of a law's functions has changed, the others need not be compiled again.

    Args:
        function: A function, as all that it calls, at the top level of a module.
        contract: See `options`.
        types: Of its arguments, those that not every program knows; what is kept for them has a name of its own.

    Returns:
        The compiled function, and a digest of all that it consists of.
    """
    _listen()
    assert isinstance(function, FunctionType)
    known: list[Any] = [described(function), contract, _addresses(), *types]

    def alike(part: Any) -> Any:
        part = getattr(part, "py_func", part)  # one that the user has compiled is compiled with the rest
        if not isinstance(part, FunctionType):
            return part
        made, digest = kept_apart(part, contract, types)
        known.append(digest)
        return made

    space = dict(function.__globals__)
    for name, attribute in _named_in(function):
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType) and attribute in vars(value):
            if space[name] is value:
                space[name] = ModuleType(value.__name__)
                vars(space[name]).update(vars(value))
            setattr(space[name], attribute, alike(vars(value)[attribute]))
        elif name in space:
            space[name] = alike(value)
    closure = tuple(CellType(alike(value)) for _, value in _free(function))
    digest = hashlib.sha256(repr(known).encode()).hexdigest()
    name = f"{function.__name__}_{digest[:16]}"
    made = FunctionType(_renamed(function.__code__, name), _here(space), name, function.__defaults__, closure)
    return jitted(made, **called_within(contract)), digest


def _named_in(function: FunctionType) -> list[tuple[str, str]]:
    """Global names that a function's code uses, each with the attribute that it takes of it, or an empty name."""
    steps = list(dis.get_instructions(function))
    return list(
        dict.fromkeys(
            (step.argval, after.argval if after.opname in ("LOAD_ATTR", "LOAD_METHOD") else "")
            for step, after in pairwise(steps)
            if step.opname == "LOAD_GLOBAL"
        )
    )


def called_within(contract: bool) -> dict[str, Any]:
    """Numba's options for a function that becomes part of its caller, and is called by nobody else; see `options`."""
    return {"forceinline": True, "no_cpython_wrapper": True, "no_cfunc_wrapper": True, **options(contract)}


def from_source(compiler: Callable[..., Any], name: str, source: str, space: dict[str, Any], known: Any) -> Any:
    """A function of a text, compiled and kept on disk.

    Args:
        compiler: What makes machine code of a function.
        name: Of the function that the text defines.
        source: The text.
        space: Its globals.
        known: What they are, as far as machine code depends on it; with the text it names what is kept.
    """
    given = dict(space)
    exec(compile(source, f"<compiled {name}>", "exec"), given)
    digest = hashlib.sha256(repr((source, known, _addresses())).encode()).hexdigest()
    unique = f"{name}_{digest[:16]}"
    return compiler(FunctionType(_renamed(given[name].__code__, unique), _here(given), unique))


def _renamed(code: CodeType, name: str) -> CodeType:
    """Code under a name that has its digest in it.

    Functions of one name share a file of Numba's that lists what is kept, and one program's types, written there, would
    keep every other program from reading it.
    """
    return code.replace(co_name=name, co_qualname=name)


def _here(space: dict[str, Any]) -> dict[str, Any]:
    """Globals of a function that is to belong to this module."""
    return {**space, "__name__": __name__}


@cache
def _addresses() -> str:
    """Digest of `numerics.addresses`, whose functions write machine code themselves: there is no Python to describe."""
    return hashlib.sha256(Path(__file__).with_name("addresses.py").read_bytes()).hexdigest()


@contextmanager
def announced(what: str, *, wanted: bool) -> Iterator[None]:
    """If something has to be compiled meanwhile, say so in one line on stderr, be it a terminal or not.

    Args:
        what: Is compiled, such as "PassiveController for the engine mujoco".
        wanted: Whether to say it.
    """
    sentence = [f"compiling {what}, once; it takes up to half a minute ..."] if wanted else []
    _announcements.append(sentence)
    try:
        yield
    finally:
        _announcements[:] = [other for other in _announcements if other is not sentence]


@cache
def _listen() -> None:
    """Hear when Numba begins to compile a function, which it does not where its machine code is on disk."""
    from numba.core import event

    class Compiling(event.Listener):
        def on_start(self, _: Any) -> None:
            from tqdm.auto import tqdm

            for waiting in _announcements:
                while waiting:
                    tqdm.write(waiting.pop(), file=sys.stderr)  # above a bar that is there

        def on_end(self, _: Any) -> None:
            """Nothing waits for it."""

    event.register("numba:compile", Compiling())  # type: ignore[no-untyped-call]  # Numba has no types


@lru_cache(maxsize=64)
def raises(roots: tuple[Function, ...]) -> bool:
    """Whether a `raise` or `assert` stands in the roots or in anything that they call."""
    parts = [part for root in roots for part in _called(root, set())]
    codes = [part.__code__ for part in parts if isinstance(part, FunctionType)]
    return any(step.opname == "RAISE_VARARGS" for code in codes for step in dis.get_instructions(code))


def _bound(function: Function, group: Callable[..., Any], functions: tuple[Function, ...], digest: str) -> Function:
    """Numba can pass a function on that stands in a closure's cell; it cannot be given one from outside.

    The digest is in the name as well: functions of one name share a file of Numba's that lists what is kept, and one
    program's types, written there, would keep every other program from reading it.
    """
    from numba.extending import register_jitable

    name = f"entry_{digest[:16]}"
    names = [f"function_{place}" for place in range(len(functions))]
    members = dict(zip(names, functions, strict=True))
    made = {name: member for name, member in members.items() if not isinstance(member, FunctionType)}
    cells = [name for name in names if name not in made]
    source = f"""def bind({", ".join(["function", "group", "digest", *cells])}):
    def {name}(x, y, z):
        digest  # a cell that Numba's cache looks at
        return function(group({", ".join(names)}), x, y, z)
    return {name}
"""
    # machine code has an address, with which nothing can be kept on disk: what is handed on is a function that calls it
    source += "".join(f"def {name}(*given):\n    return made_{name}(*given)\n" for name in made)
    space: dict[str, Any] = {"__name__": __name__, **{f"made_{name}": member for name, member in made.items()}}
    exec(compile(source, f"<compiled {name}>", "exec"), space)
    for calling in made:
        register_jitable(space[calling])
    bound: Function = space["bind"](function, group, digest, *(members[name] for name in cells))
    return bound


def _called(function: Function, known: set[Function]) -> Iterator[Function]:
    """The function and all functions at the top level of modules that it calls, directly or not."""
    if function in known or not isinstance(function, FunctionType):
        return
    known.add(function)
    yield function
    for _, value in _globals_of(function):
        if isinstance(value, FunctionType):
            yield from _called(value, known)


def _globals_of(function: FunctionType) -> Iterator[tuple[str, Any]]:
    """Global names that a function uses, with their values, those of its modules' attributes too."""
    names = function.__code__.co_names
    for name in names:
        value = function.__globals__.get(name)
        if isinstance(value, ModuleType):
            yield from ((part, vars(value)[part]) for part in names if part in vars(value))
        elif value is not None:
            yield name, value


def described(function: Function) -> Any:
    """What a function does, as text: its code, its defaults, and the constants among its globals and free variables."""
    assert isinstance(function, FunctionType)
    given = [*_globals_of(function), *_free(function)]
    constants = [(name, _constant(value)) for name, value in given if not callable(value)]
    defaults = _constant(function.__defaults__ or ())
    return function.__module__, function.__qualname__, _code(function.__code__), defaults, sorted(constants, key=str)


def _free(function: FunctionType) -> list[tuple[str, Any]]:
    """The free variables of a function that stands within another, with their values."""
    cells = function.__closure__ or ()
    return [(name, cell.cell_contents) for name, cell in zip(function.__code__.co_freevars, cells, strict=True)]


def _constant(value: Any) -> Any:
    """A value as text that is another where the value is another: arrays are not shown whole."""
    if isinstance(value, tuple):
        return type(value).__qualname__, [_constant(part) for part in value]
    if hasattr(value, "tobytes"):
        return value.dtype.str, getattr(value, "shape", ()), hashlib.sha256(value.tobytes()).hexdigest()
    return repr(value)


def _code(code: CodeType) -> Any:
    constants = [_code(c) if isinstance(c, CodeType) else repr(c) for c in code.co_consts]
    return code.co_code.hex(), constants, code.co_names, code.co_varnames
