"""What tests read out of a report's page."""

import base64
import gzip
import json
import re
from typing import Any

import pytest


def packed(page: str) -> dict[str, Any]:
    """The figures and data in a page."""
    found = re.search(r'id="data-packed">([^<]*)<', page)
    assert found
    content: dict[str, Any] = json.loads(
        gzip.decompress(base64.b64decode(found[1])), parse_constant=lambda name: pytest.fail(f"{name} is not JSON")
    )
    return content
