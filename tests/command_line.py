"""The command line as tests run it."""

from click.testing import CliRunner, Result

from mjbiped.cli import main as cli


def run(*words: object) -> Result:
    """Run a command line in this process; whatever is no exit is raised."""
    result = CliRunner().invoke(cli.main, [str(word) for word in words])
    if result.exception is not None and not isinstance(result.exception, SystemExit):
        raise result.exception
    return result
