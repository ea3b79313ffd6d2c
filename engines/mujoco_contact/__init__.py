"""Engine `mujoco-contact`: the machine as users of MuJoCo build it, boxes on hinges and rollers in contact with them."""
