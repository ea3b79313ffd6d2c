"""The verification ladder: closed forms, then terms at one state, then trajectories, each for every engine that can climb the rung.

A difference between engines is to be found where it starts. `statics_and_modes` compares with closed forms that share nothing with the
engines, `terms` the parts of the equations of motion at one given state, `trajectories` what solutions converge to.
"""
