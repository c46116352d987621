"""Functions as machine code that Numba makes, kept on disk; and the functions of `blocks` in machine code.

This module imports Numba, which takes long: import the module only where something is compiled.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from types import FunctionType, SimpleNamespace
from typing import Any

import numba
from llvmlite import ir as ir
from llvmlite.ir import IRBuilder, Value
from numba import types as types
from numba.core import ccallback, codegen, compiler, datamodel, imputils, serialize, sigutils, typing
from numba.core import cgutils as cgutils
from numba.core.base import BaseContext
from numba.core.compiler import CompileResult
from numba.core.registry import cpu_target
from numba.core.typing.templates import AbstractTemplate, Signature
from numba.np.arrayobj import populate_array

from mjbiped.numerics import blocks
from mjbiped.numerics.cache import Function, compilation_begins, described, load, store, with_callees

Values = Sequence[Value]
Generate = Callable[[BaseContext, IRBuilder, Signature, Values], Value]
"""Generates the code of a call, as Numba's `lower_builtin` has it."""

_words: set[Function] = set()  # functions that are `defined`
_jitted: set[Function] = set()  # functions that Numba has been told of as they stand


def defined(function: Function, kinds: Callable[..., types.Type], generate: Generate) -> None:
    """Say what a plain function means in machine code.

    Args:
        function: The function.
        kinds: (types of the arguments) -> type of the result.
        generate: Generates the code of a call.
    """

    class Template(AbstractTemplate):  # type: ignore[misc]
        key = function

        def generic(self, given: Sequence[types.Type], _named: object) -> Signature:
            return kinds(*given)(*given)

    typing.templates.infer_global(function, types.Function(typing.templates.infer(Template)))
    imputils.lower_builtin(function, types.VarArg(types.Any))(generate)
    _words.add(function)


def _address(context: BaseContext, builder: IRBuilder, kind: types.Type, value: Value) -> Value:
    """Generate the address of an array's first entry; any other value is one."""
    if not isinstance(kind, types.Array):
        return value
    return builder.ptrtoint(context.make_array(kind)(context, builder, value).data, cgutils.intp_t)


def owning_nothing(context: BaseContext, builder: IRBuilder, kind: types.Type, address: Value, count: Value) -> Value:
    """Generate the array of a kind that stands at an address."""
    made, size = context.make_array(kind)(context, builder), cgutils.intp_t(kind.dtype.bitwidth // 8)
    data = builder.inttoptr(address, made.data.type)
    populate_array(made, data=data, shape=[count], strides=[size], itemsize=size, meminfo=None)
    return made._getvalue()


def _view(function: Function, item: types.Type) -> None:
    """Say that a function makes an array (address, count), or that of a row of a table (address, index, count)."""
    kind = types.Array(item, 1, "C")

    def generate(context: BaseContext, builder: IRBuilder, signature: Signature, arguments: Values) -> Value:
        place, *index, count = arguments
        place, size = _address(context, builder, signature.args[0], place), cgutils.intp_t(item.bitwidth // 8)
        for rows in index:
            place = builder.add(place, builder.mul(builder.mul(rows, count), size))
        return owning_nothing(context, builder, kind, place, count)

    defined(function, lambda *_: kind, generate)


def _call(context: BaseContext, builder: IRBuilder, signature: Signature, arguments: Values) -> Value:
    """Call the C function at an address; arrays are passed as addresses."""
    passed = [_address(context, builder, *each) for each in zip(signature.args[1:], arguments[1:], strict=True)]
    nothing = signature.return_type == types.void
    kind = ir.FunctionType(ir.VoidType() if nothing else ir.DoubleType(), [each.type for each in passed])
    called = builder.call(builder.inttoptr(arguments[0], kind.as_pointer()), passed)
    return context.get_dummy_value() if nothing else called


for _each in (blocks.numbers, blocks.borrowed, blocks.first, blocks.row):
    _view(_each, types.float64)
_view(blocks.whole_numbers, types.int32)
_view(blocks.octets, types.uint8)
defined(blocks.give_back, lambda *_: types.void, lambda context, *_: context.get_dummy_value())
defined(blocks.call, lambda *_: types.void, _call)
defined(blocks.call_for_float, lambda *_: types.float64, _call)


class _Block(types.Record):  # type: ignore[misc]
    """The type of a block; Numba asks thousands of times for its description, and makes that of a record anew."""

    def __repr__(self) -> str:
        """Return the type's name."""
        return str(self.name)


datamodel.register_default(_Block)(datamodel.models.RecordModel)


@cache
def _read(entry: Any) -> str:
    """Let machine code call what `blocks.reader` has made, and return the layout of its blocks."""
    layout = blocks.dtype_of(entry.kind)
    made = numba.from_dtype(layout)
    record = _Block([(name, field._asdict()) for name, field in made.fields.items()], made.size, made.aligned)

    def at(context: BaseContext, builder: IRBuilder, _signature: Signature, arguments: Values) -> Value:
        offset = builder.mul(arguments[1], context.get_constant(types.int64, layout.itemsize))
        return builder.inttoptr(builder.add(arguments[0], offset), context.get_value_type(record))

    defined(entry, lambda *_: record, at)
    return str(layout)


class _Root(codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of a function that Python or C calls, and of all that it calls."""

    def _optimize_final_module(self) -> None:
        """Optimise; what it calls need not outlive its inlining, which makes machine code half as fast again."""
        for function in self._final_module.functions:
            if function.linkage.name == "linkonce_odr" and not function.is_declaration:
                function.linkage = "internal"
        super()._optimize_final_module()


class _Part(codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of a function that is only called within machine code: its callers optimise and emit it with theirs.

    Numba itself optimises and emits each function, with all that it calls, and then again within each of its callers,
    which takes three times as long for the hybrid engine. The order and the rounding of operations are those of the
    source either way.
    """

    codegen = property(lambda _: SimpleNamespace(set_env=lambda *_: None))  # of the address that it has not

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalized = True


class _Pipeline(compiler.Compiler):  # type: ignore[misc]
    """Numba's compiler of a function, by which one that neither Python nor C can call becomes a `_Part`."""

    def compile_extra(self, func: FunctionType) -> CompileResult:
        """Compile a Python function."""
        flags = self.state.flags
        kind = _Part if flags.no_cpython_wrapper and flags.no_cfunc_wrapper else _Root
        self.state.library = kind(self.state.targetctx.codegen(), func.__qualname__)
        self.state.library.enable_object_caching()
        return super().compile_extra(func)


class _File:
    """What Numba asks of a function's cache: here a file for one signature."""

    def __init__(self, name: str) -> None:
        self._name = name

    def load_overload(self, _signature: object, target: BaseContext) -> CompileResult | None:
        """Load the machine code; None if there is none."""
        stored = load(self._name)
        if stored is None:
            compilation_begins()
            return None
        target.refresh()
        return CompileResult._rebuild(target, *pickle.loads(stored))

    def save_overload(self, _signature: object, made: CompileResult) -> None:
        """Write the machine code to disk."""
        store(self._name, serialize.dumps(made._reduce()))


@cache
def compiled(function: Function, signature: str, *, for_c: bool = False, checked: bool = False) -> Any:
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
        made: Any = ccallback.CFunc(named, sigutils.normalize_signature(signature), {}, given, pipeline_class=_Pipeline)
    else:
        made = numba.njit(no_cfunc_wrapper=True, pipeline_class=_Pipeline, **given)(named)
    made._cache = _File(name)
    made.compile(*(() if for_c else (signature,)))
    return made


def _known(part: FunctionType, *, checked: bool) -> object:
    """Let machine code call a function; what determines what it does."""
    if hasattr(part, "kind"):
        return _read(part)
    if part in _words:
        return part.__name__
    if part not in _jitted:
        numba.extending.register_jitable(no_cfunc_wrapper=True, boundscheck=checked, pipeline_class=_Pipeline)(part)
        _jitted.add(part)
    return described(part)


# without Numba's runtime (nothing is allocated) passing an array costs no atomic reference count, which would be half
# of the time; sums and products are rounded one by one, as in plain Python, so that both make the same bits
_OPTIONS: dict[str, bool | str] = {"_nrt": False, "error_model": "numpy"}
_OWN = (
    Path(__file__).read_bytes(),
    numba.__version__,
    sys.version_info,
    cpu_target.target_context.codegen().magic_tuple(),
)
