"""What tests of single walks and of many share."""

import pytest

from mjbiped.engines.base import Run


@pytest.fixture
def nothing_walks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Run, "go", lambda *_, **__: pytest.fail("it walks"))
