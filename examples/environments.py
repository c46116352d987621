"""A picture of each Gymnasium environment after 3 s of small random actions."""

import gymnasium
import matplotlib.image

import mjbiped.envs  # registers the environments

for name in ("CompassWalk", "CompassWalkSlopes", "CompassWalkStairs", "CompassWalkRandom", "KneedWalkStairs"):
    env = gymnasium.make(f"mjbiped/{name}-v0", residual=True, render_mode="rgb_array")
    env.reset(seed=3)
    env.action_space.seed(3)
    for _ in range(150):
        env.step(0.1 * env.action_space.sample())
    matplotlib.image.imsave(f"environment_{name}.png", env.render())
