"""Functions as machine code that Numba makes, kept on disk; and what the words of `blocks` mean in machine code.

This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import hashlib
import pickle
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pathlib import Path
from types import FunctionType, SimpleNamespace
from typing import Any

from mjbiped.numerics import blocks
from mjbiped.numerics.cache import compilation_begins, described, load, store, with_callees

# Numba has no types
numba: Any = import_module("numba")
ir: Any = import_module("llvmlite.ir")
core: Any = numba.core
types: Any = numba.types
cgutils: Any = core.cgutils
# which Numba loads late
CFunc: Any = import_module("numba.core.ccallback").CFunc
populate_array: Any = import_module("numba.np.arrayobj").populate_array

_words: set[Callable[..., Any]] = set()  # functions that are `defined`
_jitted: set[Callable[..., Any]] = set()  # functions that Numba has been told of as they stand


def defined(function: Callable[..., Any], kinds: Callable[..., Any], generate: Callable[..., Any]) -> None:
    """Say what a plain function means in machine code.

    Args:
        function: The function.
        kinds: (types of the arguments) -> type of the result.
        generate: (context, builder, signature, arguments) -> value, as Numba's `lower_builtin` has it.
    """

    class Template(core.typing.templates.AbstractTemplate):  # type: ignore[misc]
        key = function

        def generic(self, given: Any, _named: Any) -> Any:
            return kinds(*given)(*given)

    core.typing.templates.infer_global(function, types.Function(core.typing.templates.infer(Template)))
    core.imputils.lower_builtin(function, types.VarArg(types.Any))(generate)
    _words.add(function)


def _address(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """Generate the address of an array's first entry; any other value is one."""
    if not isinstance(kind, types.Array):
        return value
    return builder.ptrtoint(context.make_array(kind)(context, builder, value).data, cgutils.intp_t)


def owning_nothing(context: Any, builder: Any, kind: Any, address: Any, count: Any) -> Any:
    """Generate the array of a kind that stands at an address."""
    made, size = context.make_array(kind)(context, builder), cgutils.intp_t(kind.dtype.bitwidth // 8)
    data = builder.inttoptr(address, made.data.type)
    populate_array(made, data=data, shape=[count], strides=[size], itemsize=size, meminfo=None)
    return made._getvalue()


def _view(function: Callable[..., Any], item: Any) -> None:
    """Say that a function makes an array (address, count), or that of a row of a table (address, index, count)."""
    kind = types.Array(item, 1, "C")

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        place, *index, count = arguments
        place, size = _address(context, builder, signature.args[0], place), cgutils.intp_t(item.bitwidth // 8)
        for rows in index:
            place = builder.add(place, builder.mul(builder.mul(rows, count), size))
        return owning_nothing(context, builder, kind, place, count)

    defined(function, lambda *_: kind, generate)


def _call(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
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


core.datamodel.register_default(_Block)(core.datamodel.models.RecordModel)


@cache
def _read(entry: Any) -> str:
    """Let machine code call what `blocks.reader` has made, and return the layout of its blocks."""
    layout = blocks.dtype_of(entry.kind)
    made = numba.from_dtype(layout)
    record = _Block([(name, field._asdict()) for name, field in made.fields.items()], made.size, made.aligned)

    def at(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
        offset = builder.mul(arguments[1], context.get_constant(types.int64, layout.itemsize))
        return builder.inttoptr(builder.add(arguments[0], offset), context.get_value_type(record))

    defined(entry, lambda *_: record, at)
    return str(layout)


class _Root(core.codegen.JITCodeLibrary):  # type: ignore[misc]
    """The code of a function that Python or C calls, and of all that it calls."""

    def _optimize_final_module(self) -> None:
        """Optimise; what it calls need not outlive its inlining, which makes machine code half as fast again."""
        for function in self._final_module.functions:
            if function.linkage.name == "linkonce_odr" and not function.is_declaration:
                function.linkage = "internal"
        super()._optimize_final_module()


class _Part(core.codegen.JITCodeLibrary):  # type: ignore[misc]
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


class _Pipeline(core.compiler.Compiler):  # type: ignore[misc]
    """Numba's compiler of a function, by which one that neither Python nor C can call becomes a `_Part`."""

    def compile_extra(self, func: Any) -> Any:
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

    def load_overload(self, _signature: Any, target: Any) -> Any:
        """Load the machine code; None if there is none."""
        stored = load(self._name)
        if stored is None:
            compilation_begins()
            return None
        target.refresh()
        return core.compiler.CompileResult._rebuild(target, *pickle.loads(stored))

    def save_overload(self, _signature: Any, made: Any) -> None:
        """Write the machine code to disk."""
        store(self._name, core.serialize.dumps(made._reduce()))


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
        made = CFunc(named, core.sigutils.normalize_signature(signature), {}, given, pipeline_class=_Pipeline)
    else:
        made = numba.njit(no_cfunc_wrapper=True, pipeline_class=_Pipeline, **given)(named)
    made._cache = _File(name)
    made.compile(*(() if for_c else (signature,)))
    return made


def _known(part: Any, *, checked: bool) -> Any:
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
_OPTIONS: dict[str, Any] = {"_nrt": False, "error_model": "numpy"}
_OWN = (
    Path(__file__).read_bytes(),
    numba.__version__,
    sys.version_info,
    core.registry.cpu_target.target_context.codegen().magic_tuple(),
)
