"""Numba's compiler, by which what is only called within machine code is optimised and emitted with its caller alone.

Numba itself optimises and emits each function on the way, with all that it calls, and then again within each of its
callers. Here a function that neither Python nor C can call (it has no wrapper) keeps its unoptimised code. The function
at the root gets one LLVM module of itself and all that it calls, which is optimised and emitted once. The order and the
rounding of operations are those of the source either way.

Only functions that are compiled with `Pipeline` are concerned, by Numba's own parameter `pipeline_class`; a user's
functions may call them. This module imports Numba: import it where something is compiled, not before.
"""

from __future__ import annotations

import importlib
from types import SimpleNamespace
from typing import Any

# Numba has no types
codegen: Any = importlib.import_module("numba.core.codegen")
compiler: Any = importlib.import_module("numba.core.compiler")
lookup_environment: Any = importlib.import_module("numba.core.environment").lookup_environment
Linkage: Any = importlib.import_module("llvmlite.binding").Linkage


class Pipeline(compiler.Compiler):  # type: ignore[misc]  # Numba has no types
    """Numba's compiler of a function, with a library of our own for the code."""

    def compile_extra(self, func: Any) -> Any:
        """Compile a Python function."""
        state = self.state
        if state.library is None:
            kind = _Part if state.flags.no_cpython_wrapper and state.flags.no_cfunc_wrapper else _Root
            state.library = kind(state.targetctx.codegen(), func.__qualname__)
            state.library.enable_object_caching()
        return super().compile_extra(func)


class _Root(codegen.JITCodeLibrary):  # type: ignore[misc]  # Numba has no types
    """The code of a function that Python or C calls, and of all that it calls."""

    def finalize(self) -> None:
        """Link, optimise and emit all of the code."""
        _link_below(self, self._final_module)
        self._linking_libraries: list[Any] = []
        super().finalize()

    def _optimize_final_module(self) -> None:
        """Optimise; functions that come from other libraries need not outlive their inlining."""
        for function in self._final_module.functions:
            if function.linkage == Linkage.linkonce_odr and not function.is_declaration:
                function.linkage = Linkage.internal
        super()._optimize_final_module()

    def _finalize_final_module(self) -> None:
        """Emit, and tell all functions their environments, as Numba does where it loads machine code from disk."""
        super()._finalize_final_module()
        for variable in self._final_module.global_variables:
            environment = lookup_environment(variable.name)
            if environment is not None:
                self.codegen.set_env(variable.name, environment)


class _Part(codegen.JITCodeLibrary):  # type: ignore[misc]  # Numba has no types
    """The unoptimised code of a function that is only called within machine code."""

    _shared_module: Any

    @property
    def codegen(self) -> Any:
        """What Numba tells the address of the function's environment: no address, before a root has been emitted."""
        return SimpleNamespace(set_env=lambda _name, _environment: None)

    def finalize(self) -> None:
        """Let several callers in one module share the code, and leave the rest to the root."""
        for function in self._final_module.functions:
            if function.linkage == Linkage.external and not function.is_declaration:
                function.linkage = Linkage.linkonce_odr
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return the code with that of all that it calls, which Numba's own libraries expect."""
        if self._shared_module is None:
            whole = self._final_module.clone()
            _link_below(self, whole)
            self._shared_module = whole
        return self._shared_module

    def serialize_using_object_code(self) -> Any:
        """Return what is kept on disk: there is no machine code."""
        return self.name, "bitcode", self._get_module_for_linking().as_bitcode()


def _link_below(library: Any, module: Any) -> None:
    """Link what a function calls, directly or indirectly, into a module, each once and after one of its callers."""
    found = {library: None}
    waiting = [library]
    for each in waiting:  # which grows
        if each is library or isinstance(each, _Part):
            new = [callee for callee in each._linking_libraries if callee not in found]
            found.update(dict.fromkeys(new))
            waiting += dict.fromkeys(new)
    for callee in waiting[1:]:
        library._reload_init.update(callee._reload_init)
        part = isinstance(callee, _Part)
        module.link_in(callee._final_module if part else callee._get_module_for_linking(), preserve=True)
