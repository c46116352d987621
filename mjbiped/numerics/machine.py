"""Functions as machine code that Numba makes, kept on disk; and what of `blocks` means in machine code.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import hashlib
import importlib
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from mjbiped.numerics import blocks, jit
from mjbiped.numerics.one_module import pipeline

# Numba has no types
numba: Any = importlib.import_module("numba")
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


def _owning_nothing(context: Any, builder: Any, item: Any, address: Any, count: Any) -> Any:
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
        return _owning_nothing(context, builder, item, address, count)

    defined(function, lambda values, _: values if isinstance(values, types.Array) else kind, generate)


def _row(context: Any, builder: Any, _signature: Any, arguments: Sequence[Any]) -> Any:
    """Make an array of the floats of one row of the table at an address."""
    first, index, count = arguments
    passed = builder.mul(builder.mul(index, count), context.get_constant(types.intp, 8))
    return _owning_nothing(context, builder, types.float64, builder.add(first, passed), count)


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


@cache
def compiled(function: Callable[..., Any], signature: str, *, for_c: bool = False) -> Any:
    """Compile a function, or take it from the disk.

    Args:
        function: Plain Python; it and all that it calls stand at the top level of modules.
        signature: Its types, integers (addresses among them) and floats, in Numba's words: "int64(int64, float64)".
        for_c: Whether C calls it; else Python does, and other threads run meanwhile.

    Returns:
        A function for Python, or, for C, what has an `address`.
    """
    parts = [*jit._called(function, set())]
    known = [meant(part) if hasattr(part, "meant") else _registered(part) for part in parts]
    digest = hashlib.sha256(repr((known, signature, jit.OPTIONS, numba.__version__, _OWN)).encode()).hexdigest()
    name = f"{function.__name__}_{digest[:16]}"
    made_here = jit.renamed(function, name)
    exact = importlib.import_module("numba.core.sigutils")._parse_signature_string(signature)
    if for_c:
        return jit.c_function(made_here, exact, **jit.OPTIONS)
    made = jit.jitted(made_here, nogil=True, **jit.OPTIONS)
    made.compile(exact)
    return made


def _registered(part: Any) -> Any:
    """Let machine code call a plain function; what determines what the function does."""
    if part not in jit._registered:
        extending.register_jitable(no_cfunc_wrapper=True, pipeline_class=pipeline())(part)
        jit._registered.add(part)
    return jit.described(part)


def meant(part: Any) -> Any:
    """Let machine code call a function of `blocks`; what determines what the function means."""
    if part.meant is not None:
        read(part)
        return str(blocks.dtype_of(part.meant))
    return part.__name__


_OWN = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()
