"""Engine `mujoco-contact`: the machine as users of MuJoCo build it, links on hinges and a pin in contact with the walls of their slot."""
