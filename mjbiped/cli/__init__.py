"""The command `mjbiped`."""

import sys

from mjbiped.utils.packages import hidden_laws

if _hidden := hidden_laws():  # nothing here could be imported
    print(f"Error: {_hidden}", file=sys.stderr)
    raise SystemExit(2)
