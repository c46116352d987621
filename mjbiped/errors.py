"""The package's exceptions: one base, so that `except MjbipedError` catches everything that is a user's to mend."""


class MjbipedError(Exception):
    """Base of every exception that mjbiped raises on purpose."""


class InputError(MjbipedError, ValueError):
    """A value from the user is outside its domain; raised before anything is computed."""


class GaitError(MjbipedError):
    """No passive gait exists, or none was found, for the robot and slope asked for."""


class RecordError(MjbipedError):
    """A record on disk cannot be written, or read as a walk."""


class RenderError(MjbipedError):
    """Nothing can be drawn: no GL platform, no video encoder, or nothing to show."""
