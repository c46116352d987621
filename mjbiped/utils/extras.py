"""Optional packages, which extras of this package install."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType

from mjbiped.errors import InputError

_IN_WORDS = {"distributed": "Dask Distributed", "pyarrow": "PyArrow", "plotly": "Plotly", "jinja2": "Jinja"}


def needed(module: str, extra: str, what: str) -> ModuleType:
    """Import a module of an extra.

    Args:
        module: Full name of the module.
        extra: The extra of mjbiped that installs its package.
        what: Feature that needs the module; the message begins with it.

    Returns:
        The module.

    Raises:
        InputError: The package is not installed; the message says how to install it.
    """
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise InputError(
            f"{what} needs {_IN_WORDS.get(package, package)}, which is not installed: pip install 'mjbiped[{extra}]'"
        ) from error
