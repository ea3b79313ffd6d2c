"""A tool of one page: the mechanism with a rigid follower, by scipy alone."""

import numpy as np
from scipy.integrate import solve_ivp

# The scene, in SI units. Everything about a pivot: inertias of crank and follower.
d = 0.4572  # pivot_distance
LA = 0.1016  # crank length
torque, damping = 1.129848290276167, 0.06799035518449392
crank = 4.519393161104668e-05 + 17.512683524647638 * 0.0762**2  # about O

L = 0.635
base, base_damping = 1.6947724354142506e-05, 2.259696580552334e-06
arm = 0.32818148397033287 * L**3 / 3
tip = 2.2145026489412874e-06 + 0.05078678222147815 * L**2
follower = base + arm + tip  # about P


def motion(q1, speed):
    """Crank acceleration, and what is recorded."""
    # Unit vectors along the crank and across it.
    a1, a2 = np.array([np.cos(q1), np.sin(q1)]), np.array([-np.sin(q1), np.cos(q1)])
    # A rigid follower points from P to the slider, a distance s away.
    chord = LA * a1 - [d, 0]
    s = np.hypot(*chord)
    b1 = chord / s
    b2 = np.array([-b1[1], b1[0]])

    # The crank's end moves across the crank. Its part across the follower turns the follower,
    # its part along the follower is the speed of sliding.
    rate = LA * speed * (a2 @ b2) / s
    slide = LA * speed * (a2 @ b1)

    # The follower's acceleration is gain times that of the crank, and a rest from the crank's
    # centripetal and the slider's Coriolis acceleration.
    gain = LA * (a2 @ b2) / s
    rest = (-LA * speed**2 * (a1 @ b2) - 2 * slide * rate) / s

    # The slider presses on the follower at the arm s, and back on the crank at this lever.
    lever = LA * (a1[0] * b2[1] - a1[1] * b2[0])
    load = (follower * rest + base_damping * rate) / s
    moment = torque - damping * speed - load * lever
    acceleration = moment / (crank + follower * gain / s * lever)

    alpha = gain * acceleration + rest
    force = (follower * alpha + base_damping * rate) / s
    angle = np.arctan2(b1[1], b1[0]) % (2 * np.pi)
    row = (np.degrees(q1), speed * 30 / np.pi, np.degrees(angle), 1e3 * s, L * alpha, force)
    return acceleration, row


def rates(t, state):
    q1, speed = state
    return [speed, motion(q1, speed)[0]]


times = np.linspace(0, 2, 1001)
start = [np.pi, 16.617773]
solution = solve_ivp(rates, (0, 2), start, method="DOP853", rtol=1e-10, atol=1e-12, t_eval=times)

# Any units will do, as long as the headings name them.
headings = [
    "time [ms]",
    "crank_angle [deg]",
    "crank_speed [rpm]",
    "follower_angle [deg]",
    "slider_position [mm]",
    "tip_acceleration [m/s^2]",
    "slider_force [N]",
]
with open("tool.csv", "w") as table:
    table.write("# version = tool 1.0\n")
    table.write(",".join(headings) + "\n")
    for t, q1, speed in zip(times, *solution.y, strict=True):
        row = (1e3 * t, *motion(q1, speed)[1])
        table.write(",".join(f"{number:.12g}" for number in row) + "\n")
