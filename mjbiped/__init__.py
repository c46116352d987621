"""A laboratory for underactuated biped walking on rough ground.

`walk(controller, terrain)` simulates a biped in MuJoCo or in the hybrid model and returns its record, a `Walk`;
`walk_many` simulates many at once. The control laws are in `mjbiped.controllers`, or `controllers` for
short. A public name is imported when it is first used; `__init__.pyi` tells from where.
"""

import lazy_loader

from mjbiped.version import __version__ as __version__

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
