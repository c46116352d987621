"""Which small faults in the engines and laws the default tests notice: mutants, each with one expression changed.

Each mutant is made in a copy of the sources, and the tests of its module's own room are run there until one fails, then
those of other rooms that `ROOMS` names. The sample is drawn by a seed, evenly over all places of the rooms' modules.
Machine code is kept by digests of all that was compiled (`mjbiped.numerics.machine`), so that the copies share what is
kept of the original: of a mutant, only what it reaches is compiled anew. `make mutants` draws twenty; 24 took 28
minutes on two busy cores.

    python -m scripts.mutants --count 20 --seed 0
"""

from __future__ import annotations

import ast
import os
import random
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from queue import Queue
from typing import NamedTuple

import click

ROOT = Path(__file__).resolve().parents[1]
COPIED = ("mjbiped", "controllers", "models", "scripts", "tests", "docs", "pyproject.toml")
LIMIT = 600
"""Seconds of a processor's time for a folder of tests, whatever else the machine does; a mutant for which they are not
enough makes a test go on without end, and is noticed."""
WANTED = 0.95
"""Share of the mutants that the tests have to notice."""

_WALKS = ("engines/test_golden.py", "engines/conformance")
_NUMBERS = "test_numbers.py"
ROOMS = {
    "controllers": ("control_laws", "control", *_WALKS),
    "mjbiped/dynamics": ("dynamics", "robots", *_WALKS),
    "mjbiped/engines": ("engines", "dynamics", "robots", "disturbances", "rules", _NUMBERS),
    "mjbiped/envs": ("envs", _NUMBERS),
    "mjbiped/gaits": ("gaits", "control_laws", _NUMBERS),
    "mjbiped/records": ("records", "engines", "cli"),
    "mjbiped/robots": ("robots", "gaits", "engines", _NUMBERS),
    "mjbiped/rules": ("rules", "robots", "engines"),
    "mjbiped/studies": ("studies", "plotting", "cli"),
}
"""The rooms from which mutants are drawn, and what stands for them in tests/, in the order in which it is run."""

EQUIVALENT = {
    (each["module"], each["line"], each["mutated"]): each["why"]
    for each in tomllib.loads(Path(__file__).with_name("equal_mutants.toml").read_text())["mutant"]
}
"""Mutants that no test can notice, as (module, line, its line), and why: told in the report, and not counted."""


class Mutant(NamedTuple):
    """One changed expression.

    Attributes:
        module: Path of its file from the root.
        line: Number of the line.
        begin: Where the expression begins in the file, in bytes.
        end: Where it ends.
        text: What stands there instead.
    """

    module: str
    line: int
    begin: int
    end: int
    text: str

    def applied(self, source: str) -> str:
        """The module's source with the mutant."""
        raw = source.encode()
        return (raw[: self.begin] + self.text.encode() + raw[self.end :]).decode()

    def lines(self, source: str) -> tuple[str, str]:
        """The line as it is, and as the mutant has it."""
        place = self.line - 1
        changed = self.applied(source).splitlines()
        return source.splitlines()[place].strip(), changed[place].strip()


class Verdict(NamedTuple):
    """What the tests said of a mutant.

    Attributes:
        mutant: The mutant.
        noticed: Whether a test failed, or did not end.
    """

    mutant: Mutant
    noticed: bool


# --- mutants ----------------------------------------------------------------------------------------------------------

_BINARY: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
}
_COMPARED: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.GtE,
    ast.LtE: ast.Gt,
    ast.Gt: ast.LtE,
    ast.GtE: ast.Lt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
}
_NAMES = {"sin": "cos", "cos": "sin", "min": "max", "max": "min", "ceil": "floor", "floor": "ceil"}


def changes(node: ast.AST) -> Iterator[ast.expr | ast.stmt]:
    """What may stand in place of a node: other signs, comparisons and branches, a term less, another number."""
    match node:
        case ast.BinOp(left, op, right) if type(op) in _BINARY:
            yield ast.BinOp(left, _BINARY[type(op)](), right)
            if isinstance(op, (ast.Add, ast.Sub)):
                yield left
        case ast.UnaryOp(ast.USub(), operand) if not isinstance(operand, ast.Constant):
            yield operand
        case ast.Compare(left, [op], right) if type(op) in _COMPARED:
            yield ast.Compare(left, [_COMPARED[type(op)]()], right)
        case ast.BoolOp(op, values):
            yield ast.BoolOp(ast.And() if isinstance(op, ast.Or) else ast.Or(), values)
        case ast.IfExp(test, body, orelse):
            yield ast.IfExp(test, orelse, body)
        case ast.Constant(bool(value)):
            yield ast.Constant(not value)
        case ast.Constant(int(value)):
            yield ast.Constant(1 - value if value in (0, 1) else value + 1)
        case ast.Constant(float(value)):
            yield ast.Constant(2.0 * value if value else 1.0)
        case ast.Name(name, ast.Load()) if name in _NAMES:
            yield ast.Name(_NAMES[name], ast.Load())
        case ast.Attribute(value, name, ast.Load()) if name in _NAMES:
            yield ast.Attribute(value, _NAMES[name], ast.Load())
        case ast.AugAssign(target, op, value) if type(op) in _BINARY:
            yield ast.AugAssign(target, _BINARY[type(op)](), value)


@cache
def mutants_of(module: str, source: str) -> tuple[Mutant, ...]:
    """All mutants of a module, in the order of its lines: of what its functions compute, not of what they say."""
    offsets = [0]
    for line in source.encode().splitlines(keepends=True):
        offsets.append(offsets[-1] + len(line))
    found = []
    for node in _computed(ast.parse(source), inside=False):
        for change in changes(node):
            assert isinstance(node, (ast.expr, ast.stmt))
            assert node.end_lineno is not None
            assert node.end_col_offset is not None
            begin = offsets[node.lineno - 1] + node.col_offset
            end = offsets[node.end_lineno - 1] + node.end_col_offset
            text = ast.unparse(change)
            found.append(Mutant(module, node.lineno, begin, end, text if isinstance(change, ast.stmt) else f"({text})"))
    return tuple(sorted(found))


def _computed(node: ast.AST, inside: bool) -> Iterator[ast.AST]:
    """The nodes within functions, without annotations, texts, and errors that are raised."""
    if isinstance(node, (ast.JoinedStr, ast.Raise, ast.Assert)):
        return
    if isinstance(node, ast.Compare):  # numbers beside a comparison are mostly those that flags are told apart by
        yield node
        for part in (node.left, *node.comparators):
            if not isinstance(part, ast.Constant):
                yield from _computed(part, inside)
        return
    if isinstance(node, (ast.FunctionDef, ast.Lambda)):
        for statement in node.body if isinstance(node, ast.FunctionDef) else [node.body]:
            yield from _computed(statement, inside=True)
        return
    if inside:
        yield node
    if isinstance(node, ast.keyword) and node.arg == "strict":  # `zip` refuses by it what never comes
        return
    for name, value in ast.iter_fields(node):
        if name in ("annotation", "decorator_list", "bases"):
            continue
        for part in value if isinstance(value, list) else [value]:
            if isinstance(part, ast.AST):
                yield from _computed(part, inside)


def sample(count: int, seed: int, chosen: Sequence[str]) -> list[Mutant]:
    """So many mutants of the modules, drawn by the seed."""
    known = [mutant for module in chosen for mutant in mutants_of(module, (ROOT / module).read_text())]
    return sorted(random.Random(seed).sample(known, min(count, len(known))))


# --- trials -----------------------------------------------------------------------------------------------------------


def copied(to: Path) -> Path:
    """A copy of the sources, whose links lead to the copy's own files."""
    to.mkdir()
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, to / name, symlinks=True, ignore=shutil.ignore_patterns("*.nbt"))
        else:
            shutil.copy2(source, to / name)
    return to


def modules() -> list[str]:
    """Paths of all modules in `ROOMS` from the root."""
    return sorted(str(file.relative_to(ROOT)) for room in ROOMS for file in (ROOT / room).rglob("*.py"))


def tests_of(module: str) -> list[str]:
    """The files and folders in tests/ that stand for a module: those of its own name, of its folder, of its room."""
    path = Path(module)
    tests, own = next((tests, path.relative_to(room)) for room, tests in ROOMS.items() if path.is_relative_to(room))
    near = ROOT / "tests" / tests[0] / own
    nearest = [file for file in (near.with_name(f"test_{own.name}"), near.parent) if file.exists()]
    return list(dict.fromkeys([*(str(file.relative_to(ROOT / "tests")) for file in nearest), *tests]))


def passes(tree: Path, tests: Sequence[str]) -> bool:
    """Whether the default tests in some files and folders of a copy pass, up to the first that fails."""
    pytest = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--no-header", "--tb=no"]
    limited = ["sh", "-c", f'ulimit -t {LIMIT}; exec "$@"', "sh"]
    environment = {**os.environ, "PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    return all(
        subprocess.run([*limited, *pytest, f"tests/{file}"], cwd=tree, env=environment, capture_output=True).returncode
        == 0
        for file in tests
    )


def tried(mutant: Mutant, tree: Path) -> Verdict:
    """Run the tests of a mutant's room in a copy, which is then as it was."""
    file, original = tree / mutant.module, ROOT / mutant.module
    file.write_text(mutant.applied(original.read_text()))
    try:
        return Verdict(mutant, not passes(tree, tests_of(mutant.module)))
    finally:
        shutil.copy2(original, file)


def verdicts(mutants: Sequence[Mutant], workers: int) -> Iterator[Verdict]:
    """What the tests say of each mutant, in their order.

    Raises:
        click.ClickException: The tests fail without any mutant.
    """
    with tempfile.TemporaryDirectory(prefix="mutants-") as folder:
        trees: Queue[Path] = Queue()
        for worker in range(workers):
            trees.put(copied(Path(folder) / str(worker)))
        wanted = list(dict.fromkeys(file for mutant in mutants for file in tests_of(mutant.module)))

        def checked(file: str) -> bool:
            tree = trees.get()
            try:
                return passes(tree, [file])
            finally:
                trees.put(tree)

        def judged(mutant: Mutant) -> Verdict:
            tree = trees.get()
            try:
                return tried(mutant, tree)
            finally:
                trees.put(tree)

        with ThreadPoolExecutor(workers) as pool:
            for file, passed in zip(wanted, pool.map(checked, wanted), strict=True):
                if not passed:
                    raise click.ClickException(f"tests/{file} fails without any mutant: mend that first")
            yield from pool.map(judged, mutants)


def reason(mutant: Mutant) -> str | None:
    """Why no test can notice a mutant, if that has been argued."""
    return EQUIVALENT.get((mutant.module, *mutant.lines((ROOT / mutant.module).read_text())))


def told(verdict: Verdict) -> str:
    """A verdict in lines of text."""
    mutant = verdict.mutant
    before, after = mutant.lines((ROOT / mutant.module).read_text())
    why = reason(mutant)
    word = "noticed " if verdict.noticed else "equal   " if why else "SURVIVED"
    lines = [f"{word}  {mutant.module}:{mutant.line}", f"    - {before}", f"    + {after}"]
    return "\n".join(lines + ([f"    {why}"] if why and not verdict.noticed else []))


def share(found: Sequence[Verdict]) -> float:
    """Share of the mutants that were noticed, of those that can be."""
    counted = [verdict.noticed for verdict in found if verdict.noticed or reason(verdict.mutant) is None]
    return sum(counted) / len(counted) if counted else 1.0


@click.command(help=(__doc__ or "").split("\n\n")[0])
@click.option("--count", default=20, show_default=True, type=click.IntRange(1), help="How many mutants.")
@click.option("--seed", default=0, show_default=True, help="By which they are drawn.")
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1), help="Processes at a time.")
@click.argument("chosen", nargs=-1, type=click.Choice(modules()), metavar="[MODULE]...")
def main(count: int, seed: int, workers: int, chosen: tuple[str, ...]) -> None:
    """Draw mutants, try them, and tell which survive."""
    found = []
    for verdict in verdicts(sample(count, seed, chosen or modules()), workers):
        found.append(verdict)
        click.echo(told(verdict))
    click.echo(f"noticed: {share(found):.0%} of {len(found)} mutants of seed {seed}, without those argued to be equal")
    if share(found) < WANTED:
        raise click.ClickException(f"fewer than {WANTED:.0%}: a test is missing where one survived")


if __name__ == "__main__":
    main()
