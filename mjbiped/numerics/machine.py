"""Functions as machine code that Numba makes, kept on disk; and what of `blocks` means in machine code.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import hashlib
import importlib
import pickle
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import FunctionType
from typing import Any

from mjbiped.numerics import blocks
from mjbiped.numerics.announcement import compilation_begins
from mjbiped.numerics.cache import load, store
from mjbiped.numerics.one_module import Pipeline
from mjbiped.numerics.sources import described, with_callees

# Numba has no types
numba: Any = importlib.import_module("numba")
serialize: Any = importlib.import_module("numba.core.serialize")
sigutils: Any = importlib.import_module("numba.core.sigutils")
target_context: Any = importlib.import_module("numba.core.registry").cpu_target.target_context
CFunc: Any = importlib.import_module("numba.core.ccallback").CFunc
CompileResult: Any = importlib.import_module("numba.core.compiler").CompileResult
extending: Any = importlib.import_module("numba.extending")
imputils: Any = importlib.import_module("numba.core.imputils")
cgutils: Any = importlib.import_module("numba.core.cgutils")
datamodel: Any = importlib.import_module("numba.core.datamodel")
templates: Any = importlib.import_module("numba.core.typing.templates")
ir: Any = importlib.import_module("llvmlite.ir")
populate_array: Any = importlib.import_module("numba.np.arrayobj").populate_array
types: Any = numba.types


def defined(function: Callable[..., Any], kinds: Callable[..., Any], generate: Callable[..., Any]) -> None:
    """Say what a plain function means in machine code.

    Args:
        function: The function.
        kinds: (types of the arguments) -> type of the result.
        generate: (context, builder, signature, arguments) -> value, as Numba's `lower_builtin` has it.
    """

    class Template(templates.AbstractTemplate):  # type: ignore[misc]  # Numba has no types
        key = function

        def generic(self, given: Any, _named: Any) -> Any:
            return kinds(*given)(*given)

    templates.infer_global(function, types.Function(templates.infer(Template)))
    imputils.lower_builtin(function, types.VarArg(types.Any))(generate)


def owning_nothing(context: Any, builder: Any, item: Any, address: Any, count: Any) -> Any:
    """Make an array of what stands at an address."""
    made, width = context.make_array(types.Array(item, 1, "C"))(context, builder), item.bitwidth // 8
    data, size = builder.inttoptr(address, made.data.type), context.get_constant(types.intp, width)
    populate_array(made, data=data, shape=[count], strides=[size], itemsize=size, meminfo=None)
    return made._getvalue()


def _array(function: Callable[..., Any], item: Any, *, cut: bool = False) -> None:
    """Say that a function makes an array of an address and a count; an array it returns, or cuts."""
    kind = types.Array(item, 1, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> Any:
        address, count = arguments
        if isinstance(signature.args[0], types.Array):
            if not cut:
                return address
            address = builder.ptrtoint(context.make_array(kind)(context, builder, address).data, cgutils.intp_t)
        return owning_nothing(context, builder, item, address, count)

    defined(function, lambda values, _: values if isinstance(values, types.Array) else kind, generate)


def _row(context: Any, builder: Any, _signature: Any, arguments: Sequence[Any]) -> Any:
    """Make an array of the floats of one row of the table at an address."""
    first, index, count = arguments
    passed = builder.mul(builder.mul(index, count), context.get_constant(types.intp, 8))
    return owning_nothing(context, builder, types.float64, builder.add(first, passed), count)


def _call(context: Any, builder: Any, signature: Any, arguments: Sequence[Any]) -> Any:
    """Call the C function at an address; of an array its address is passed."""
    passed = []
    for kind, value in zip(signature.args[1:], arguments[1:], strict=True):
        if isinstance(kind, types.Array):
            value = builder.ptrtoint(context.make_array(kind)(context, builder, value).data, cgutils.intp_t)
        passed.append(value)
    nothing = signature.return_type == types.void
    kind = ir.FunctionType(ir.VoidType() if nothing else ir.DoubleType(), [each.type for each in passed])
    called = builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), passed)
    return context.get_dummy_value() if nothing else called


for _each in (blocks.numbers, blocks.borrowed):
    _array(_each, types.float64)
_array(blocks.first, types.float64, cut=True)
_array(blocks.whole_numbers, types.int32)
_array(blocks.octets, types.uint8)
defined(blocks.give_back, lambda *_: types.void, lambda context, *_: context.get_dummy_value())
defined(blocks.row, lambda *_: types.Array(types.float64, 1, "C"), _row)
defined(blocks.call, lambda *_: types.void, _call)
defined(blocks.call_for_float, lambda *_: types.float64, _call)


class _Block(types.Record):  # type: ignore[misc]  # Numba has no types
    """The type of a block; Numba asks thousands of times for its description, and makes that of a record anew."""

    def __repr__(self) -> str:
        """Return the type's name."""
        return str(self.name)


datamodel.register_default(_Block)(datamodel.models.RecordModel)


@cache
def read(entry: Callable[..., Any]) -> None:
    """Let machine code call what `blocks.reader` has made."""
    layout = blocks.dtype_of(entry.meant)  # type: ignore[attr-defined]
    made = numba.from_dtype(layout)
    record = _Block([(name, field._asdict()) for name, field in made.fields.items()], made.size, made.aligned)

    def at(context: Any, builder: Any, _signature: Any, arguments: Sequence[Any]) -> Any:
        offset = builder.mul(arguments[1], context.get_constant(types.int64, layout.itemsize))
        return builder.inttoptr(builder.add(arguments[0], offset), context.get_value_type(record))

    defined(entry, lambda *_: record, at)


class _File:
    """What Numba asks of a function's cache: here a file for one signature."""

    def __init__(self, name: str) -> None:
        self._name = name

    def load_overload(self, _signature: Any, target: Any) -> Any:
        """Load the machine code; None if there is none."""
        stored = load(self._name)
        if stored is None:
            compilation_begins()
            return None
        target.refresh()
        return CompileResult._rebuild(target, *pickle.loads(stored))

    def save_overload(self, _signature: Any, made: Any) -> None:
        """Write the machine code to disk."""
        store(self._name, serialize.dumps(made._reduce()))


@cache
def compiled(function: Callable[..., Any], signature: str, *, for_c: bool = False, checked: bool = False) -> Any:
    """Compile a function, or take it from the disk.

    Args:
        function: Plain Python; it and all that it calls stand at the top level of modules, or are free variables.
        signature: Its types, integers (addresses among them) and floats, in Numba's words: "int64(int64, float64)".
        for_c: Whether C calls it; else Python does, and other threads run meanwhile.
        checked: Whether indices into arrays are checked, in functions that were not compiled for others before.

    Returns:
        A function for Python, or, for C, what has an `address`.
    """
    known = [_known(part, checked=checked) for part in with_callees(function)]
    digest = hashlib.sha256(repr((known, signature, for_c, checked, _OWN)).encode()).hexdigest()
    name = f"{function.__name__}_{digest[:16]}"
    assert isinstance(function, FunctionType)
    code = function.__code__.replace(co_name=name, co_qualname=name)  # so are symbols of the machine code named
    named = FunctionType(code, function.__globals__, name, None, function.__closure__)
    given = {**_OPTIONS, "boundscheck": checked, "nogil": not for_c}
    if for_c:
        made = CFunc(named, sigutils.normalize_signature(signature), {}, given, pipeline_class=Pipeline)
    else:
        made = numba.njit(no_cfunc_wrapper=True, pipeline_class=Pipeline, **given)(named)
    made._cache = _File(name)
    made.compile(*(() if for_c else (signature,)))
    return made


_registered: set[FunctionType] = set()


def _known(part: Any, *, checked: bool) -> Any:
    """Let machine code call a function; what determines what it does."""
    if hasattr(part, "meant"):
        if part.meant is None:
            return part.__name__
        read(part)
        return str(blocks.dtype_of(part.meant))
    if part not in _registered:
        extending.register_jitable(no_cfunc_wrapper=True, boundscheck=checked, pipeline_class=Pipeline)(part)
        _registered.add(part)
    return described(part)


# without Numba's runtime (nothing is allocated) passing an array costs no atomic reference count, which would be half
# of the time; sums and products are rounded one by one, as in plain Python, so that both make the same bits
_OPTIONS: dict[str, Any] = {"_nrt": False, "error_model": "numpy"}
_OWN = Path(__file__).read_bytes(), numba.__version__, sys.version_info, target_context.codegen().magic_tuple()
