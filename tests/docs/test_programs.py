"""Every program on the pages runs as it stands there, one block after the other, and is well typed."""

import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from documentation import PAGES, ROOT, Block, blocks, text


def programs(page: str) -> list[Block]:
    return [block for block in blocks(page) if block.language == "python" and "notest" not in block.marks]


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """What a page writes goes into a folder of its own, from which it imports as a program beside its files does."""
    monkeypatch.chdir(tmp_path)
    path, modules = [*sys.path], {*sys.modules}
    sys.path.insert(0, str(tmp_path))
    yield
    sys.path[:] = path
    for name in {*sys.modules} - modules:
        if (getattr(sys.modules[name], "__file__", None) or "").startswith(str(tmp_path)):
            del sys.modules[name]


def write_files(page: str) -> None:
    """Write the blocks that are files into the working folder."""
    for block in blocks(page):
        if block.file:
            Path(block.file).write_text(block.code, encoding="utf-8")


def execute(page: str, *, slow: bool) -> None:
    space: dict[str, object] = {"__name__": "__main__"}
    write_files(page)
    if any("envs.load(" in block.code for block in programs(page)):
        pytest.importorskip("dm_control", reason="the page needs dm_control, which pip does not install on 3.13")
    for block in programs(page):
        if slow or "slow" not in block.marks:
            # empty lines before it: a traceback names the page's line
            exec(compile("\n" * (block.line - 1) + block.code, page, "exec"), space)


LONG = {f"docs/{name}.md" for name in ("controller", "environments", "exports", "reports", "studies")}
"""Pages whose programs take seconds."""


@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=pytest.mark.slow) if page in LONG else page
        for page in PAGES
        if any("slow" not in block.marks for block in programs(page))
    ],
)
def test_programs_run(page: str, capsys: pytest.CaptureFixture[str]) -> None:
    execute(page, slow=False)
    shown = [block.code.strip() for block in blocks(page) if block.language == "text" and "output" in block.marks]
    said = capsys.readouterr().out
    for output in shown:
        assert output in said, f"{page} shows what its programs print"


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if any("slow" in block.marks for block in programs(page))])
def test_long_programs_run(page: str) -> None:
    execute(page, slow=True)


def test_every_block_says_its_language() -> None:
    for page in PAGES:
        fences = [line for line in text(page).splitlines() if line.startswith("```")]
        assert all(len(fence) > 3 for fence in fences[::2]), page
        assert set(fences[1::2]) <= {"```"}, page


# what a program does with packages that have no types is not checked
UNTYPED = "[mypy]\ncheck_untyped_defs = true\nignore_missing_imports = true\nno_incremental = true\n"


@pytest.mark.slow  # the type checker reads all packages anew
def test_programs_are_well_typed_by_what_the_package_says_of_its_types() -> None:
    Path("mypy.ini").write_text(UNTYPED)
    names = []
    for page in PAGES:
        write_files(page)
        if code := "\n".join(block.code for block in programs(page) if not block.file):
            names.append(f"page_{Path(page).stem}.py")
            Path(names[-1]).write_text(code, encoding="utf-8")
    environment = {"MYPYPATH": str(ROOT), "PATH": "", "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-m", "mypy", *names]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
