"""Engine `mujoco`: the follower as a chain of rigid links in MuJoCo, with the slider as an exact constraint on a smooth centre line."""
