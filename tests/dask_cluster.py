"""A Dask cluster on this machine, for tests of `--scheduler`."""

import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from command_line import environment

_PROGRAM = """
import sys
from distributed import LocalCluster

if __name__ == "__main__":
    cluster = LocalCluster(n_workers=2, threads_per_worker=2, processes=True, dashboard_address=None)
    pids = [worker.process.pid for worker in cluster.workers.values()]
    print(cluster.scheduler_address, *pids, flush=True)
    sys.stdin.read()
    cluster.close()
"""


@contextmanager
def two_workers(folder: Path) -> Iterator[tuple[str, list[int]]]:
    """Two worker processes in a process of their own.

    Args:
        folder: To put their program into.

    Yields:
        The scheduler's address, and the workers' process ids.
    """
    program = folder / "cluster.py"
    program.write_text(_PROGRAM)
    with subprocess.Popen(
        [sys.executable, str(program)],
        env=environment(),
        stdin=subprocess.PIPE,  # closed, it ends the cluster
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,  # full of workers that are killed
        text=True,
    ) as dask:
        assert dask.stdout is not None
        address, *pids = dask.stdout.readline().split()
        yield address, [int(pid) for pid in pids]
