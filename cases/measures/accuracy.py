"""Accuracy of the first-mode measures on synthetic half cycles: `python -m cases.measures.accuracy`."""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from cases.measures.first_mode import fit_first_mode
from cases.measures.half_cycle import channel_half, half_cycle
from cases.measures.synthetic import synthetic_half
from cases.measures.time_scale import TimeScale, time_scale
from reference_model.mechanism import Base, Crank, Follower, Mechanism, Tip, TorqueDrive

INCH = 0.0254  # m
POUND_FORCE = 4.4482216152605  # N
RUNS = {  # crank length (in), tip mass (lbf s^2/in), tip inertia (lbf s^2 in), crank speed (rad/s): thesis, tables 5.1 and 5.2
    6: (6.0, 2.07e-4, 1.40e-5, 11.808269),
    10: (5.0, 4.10e-5, 2.80e-6, 19.696489),
    17: (4.0, 4.10e-5, 2.80e-6, 13.910073),
    24: (4.0, 2.90e-4, 1.96e-5, 16.617773),
}
VIBRATIONS = (1.0, 0.3, 0.1, 0.03, 0.0)  # over the slow part's peak


@dataclass(frozen=True)
class Accuracy:
    """Errors at one strength of vibration, relative; NaN where nothing was resolved.

    Attributes:
        vibration: over the slow part's peak.
        samples: half cycles drawn.
        resolvable: share of them that was measured at all.
        bias: mean error of the frequency.
        spread: standard deviation of the frequency's error.
        within: modulus of the frequency's error that 90 % stay below.
        amplitude_spread: standard deviation of the amplitude's error.
        claimed: mean claimed uncertainty of the frequency.
    """

    vibration: float
    samples: int
    resolvable: float
    bias: float
    spread: float
    within: float
    amplitude_spread: float
    claimed: float


def thesis_scene(run: int) -> tuple[Mechanism, float]:
    """The mechanism of a thesis run and its crank speed in rad/s."""
    crank_length, mass, inertia, speed = RUNS[run]
    mechanism = Mechanism(
        pivot_distance=18.0 * INCH,
        crank=Crank(
            length=crank_length * INCH,
            drive=TorqueDrive(torque=10.0 * POUND_FORCE * INCH, damping=10.0 * POUND_FORCE * INCH / speed, initial_speed=speed),
            mass=0.1 * POUND_FORCE / INCH,
            center_of_mass=3.0 * INCH,
            inertia=4.0e-4 * POUND_FORCE * INCH,
        ),
        base=Base(inertia=1.5e-4 * POUND_FORCE * INCH),
        follower=Follower(
            length=25.0 * INCH,
            mass_per_length=4.75987e-5 * POUND_FORCE / INCH**2,
            bending_stiffness=2128.22 * POUND_FORCE * INCH**2,
            thickness=0.125 * INCH,
            width=1.5 * INCH,
            strain_gauges=(6.25 * INCH, 12.5 * INCH, 18.75 * INCH),
        ),
        tip=Tip(mass=mass * POUND_FORCE / INCH, inertia=inertia * POUND_FORCE * INCH),
    )
    return mechanism, speed


def accuracy(vibration: float, samples: int, seed: int) -> Accuracy:
    """Measure `samples` half cycles, turn by turn from every scene, half and channel."""
    random = np.random.default_rng([seed, round(1000 * vibration)])
    frequency, amplitude, claimed = [], [], []
    for (scale, speed, half, channel), _ in zip(_turns(), range(samples), strict=False):
        drawn = synthetic_half(scale, channel, half, speed, vibration, random)
        grid = half_cycle(scale, drawn.time[0], drawn.time[-1], CubicSpline(drawn.time, drawn.crank_angle))
        mode = fit_first_mode(channel_half(scale, grid, channel, CubicSpline(drawn.time, drawn.signal)))
        if not mode.reason:
            frequency.append(mode.frequency / drawn.first_mode_frequency - 1.0)
            claimed.append(mode.frequency_uncertainty / mode.frequency)
            amplitude.append(mode.amplitude / drawn.first_mode_amplitude - 1.0 if vibration else np.nan)
    if not frequency:
        return Accuracy(vibration, samples, 0.0, *5 * (np.nan,))
    error = np.array(frequency)
    return Accuracy(
        vibration,
        samples,
        error.size / samples,
        float(error.mean()),
        float(error.std()),
        float(np.quantile(np.abs(error), 0.9)),
        float(np.std(amplitude)),
        float(np.mean(claimed)),
    )


def _turns() -> Iterator[tuple[TimeScale, float, str, str]]:
    scales = []
    for run in RUNS:
        mechanism, speed = thesis_scene(run)
        scale = time_scale(mechanism)
        assert scale is not None
        scales.append((scale, speed))
    while True:
        for scale, speed in scales:
            for channel in scale.channels:
                for half in ("pre", "post"):
                    yield scale, speed, half, channel


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=320, help="half cycles per row (default 320)")
    parser.add_argument("--seed", type=int, default=1, help="of the random numbers (default 1)")
    arguments = parser.parse_args()
    print("vibration  resolvable     bias   spread  90 % below  claimed  amplitude spread")
    for vibration in VIBRATIONS:
        row = accuracy(vibration, arguments.samples, arguments.seed)
        print(
            f"{row.vibration:9.2f}  {row.resolvable:10.1%}  {row.bias:7.2%}  {row.spread:7.2%}  {row.within:10.2%}  {row.claimed:7.2%}"
            f"  {row.amplitude_spread:16.1%}"
        )


if __name__ == "__main__":
    main()
