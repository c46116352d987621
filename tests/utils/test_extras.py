"""Packages of extras: imported where they are, else named with the way to install them."""

import math

import pytest

from mjbiped.errors import InputError
from mjbiped.utils.extras import needed


def test_what_is_there_is_imported() -> None:
    assert needed("math", "data", "this") is math


def test_what_is_missing_is_named_with_its_extra() -> None:
    with pytest.raises(InputError, match=r"^a flight needs wings_of_wax, .*pip install 'mjbiped\[fly\]'$"):
        needed("wings_of_wax.left", "fly", "a flight")
