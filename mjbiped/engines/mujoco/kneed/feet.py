"""What the feet of the biped with knees can meet."""

from __future__ import annotations

from mjbiped.engines.mujoco.callbacks import Places, beside, meets
from mjbiped.engines.mujoco.kneed.state import Scene


def stand(places: Places, scene: Scene, leg: int, x: float, z: float) -> None:
    """A foot stands at x, z: it meets all ground but what stands beside it, and risers as any foot does."""
    for index in range(len(scene.ground)):
        geom = int(scene.ground[index])
        met = meets(places, x, z, geom) if places.risers[geom] >= 0.0 else not beside(places, x, z, geom)
        scene.bits[leg, index] = 1 if met else 0


def swing(places: Places, scene: Scene, leg: int, x: float, z: float) -> None:
    """A foot moves at x, z: it is a point, which meets the piece that it is over, and a riser beside it."""
    for index in range(len(scene.ground)):
        scene.bits[leg, index] = 1 if meets(places, x, z, int(scene.ground[index])) else 0


def write_collisions(scene: Scene, lifted: int) -> None:
    """Let the feet meet what was said; that of the leg `lifted`, -1 for none, passes through all.

    See `mjbiped.engines.mujoco.callbacks.refuses`; here bits in `geom_conaffinity` say it, one for each foot.
    """
    for index in range(len(scene.ground)):
        left = 0 if lifted == 0 else scene.bits[0, index]
        right = 0 if lifted == 1 else scene.bits[1, index]
        scene.geom_conaffinity[scene.ground[index]] = left + 2 * right
