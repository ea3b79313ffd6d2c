"""The thesis' mechanism in SI and random scenes and states around it, far beyond what a run visits."""

import math

import numpy as np

INCH = 0.0254  # m
POUND = 4.4482216152605  # N
SLUGLET = POUND / INCH  # kg, one lbf s^2/in

#: Run 24 (thesis sections 3.2 and 5.3, table 5.1), with the damping that its speed of 16.617773 rad/s implies; names are
#: those of `examples/derive/quick_return.py`.
RUN_24 = {
    "pivot_distance": 18 * INCH,
    "crank_length": 4 * INCH,
    "crank_mass": 0.1 * SLUGLET,
    "crank_center_of_mass": 3 * INCH,
    "crank_inertia": 4.0e-4 * POUND * INCH,
    "crank_torque": 10 * POUND * INCH,
    "crank_damping": 0.60176535 * POUND * INCH,
    "base_inertia": 1.50e-4 * POUND * INCH,
    "base_damping": 2e-5 * POUND * INCH,
    "length": 25 * INCH,
    "mass_per_length": 4.75987e-5 * SLUGLET / INCH,
    "bending_stiffness": 2128.22 * POUND * INCH**2,
    "beam_damping": 2e-5 * POUND / INCH**2,
    "tip_mass": 2.90e-4 * SLUGLET,
    "tip_inertia": 1.96e-5 * POUND * INCH,
    "tip_center_of_mass": 0.0,
    "slider_mass": 0.0,
    "slider_inertia": 0.0,
    "gravity_1": 0.0,
    "gravity_2": 0.0,
    "force_1": 0.0,
    "force_2": 0.0,
}
#: Dampings are magnified in random scenes, where the thesis' values would hide a wrong sign behind the flywheel.
MAGNIFIED = {"base_damping": 1e4, "beam_damping": 10.0}
#: Largest magnitudes of what the thesis leaves out, SI; each is as large as what it competes with.
LEFT_OUT = {
    "tip_center_of_mass": 0.03,
    "slider_mass": 0.5,
    "slider_inertia": 5e-4,
    "gravity_1": 15.0,
    "gravity_2": 15.0,
    "force_1": 10.0,
    "force_2": 10.0,
}


def random_case(rng: np.random.Generator, *, present: float = 0.5) -> tuple[dict[str, float], dict[str, float]]:
    """A random scene and a random state of it, in SI.

    Lengths vary by 10 to 40 %, everything else by up to 50 % around run 24, dampings around its `MAGNIFIED` values. Tip slope is at
    most 0.5, |W'| below 0.5 everywhere, rates are those of a violent run; the slider stands anywhere between d - LA and d + LA from
    P, before or after the return, and on the beam. Each of `LEFT_OUT` differs from zero with the probability `present`.
    """
    while True:
        parameters = {name: value * MAGNIFIED.get(name, 1.0) * rng.uniform(0.5, 1.5) for name, value in RUN_24.items()}
        for name, spread in (("pivot_distance", 0.1), ("crank_length", 0.4), ("length", 0.15)):
            parameters[name] = RUN_24[name] * rng.uniform(1 - spread, 1 + spread)
        for name, largest in LEFT_OUT.items():
            sign = -1.0 if name not in ("slider_mass", "slider_inertia") and rng.random() < 0.5 else 1.0
            parameters[name] = sign * largest * rng.uniform(0.1, 1.0) if rng.random() < present else 0.0

        d, arm, length = parameters["pivot_distance"], parameters["crank_length"], parameters["length"]
        distance = rng.uniform(d - arm, d + arm)
        half_turn = math.acos(np.clip((d**2 + arm**2 - distance**2) / (2 * d * arm), -1.0, 1.0))
        deflection, slope = length * rng.uniform(-0.2, 0.2), rng.uniform(-0.5, 0.5)
        foreshortening = 0.6 * deflection**2 / length - 0.1 * deflection * slope + slope**2 * length / 15
        if distance + foreshortening < length:
            state = {
                "crank_angle": rng.choice([-1.0, 1.0]) * half_turn + 2 * math.pi * int(rng.integers(-2, 3)),
                "tip_deflection": deflection,
                "tip_slope": slope,
                "crank_speed": rng.uniform(-35.0, 35.0),
                "tip_deflection_rate": rng.uniform(-3.0, 3.0),
                "tip_slope_rate": rng.uniform(-15.0, 15.0),
            }
            return parameters, state
