"""What `show CASE --for-other-tools` prints is enough: a simulation written from it alone passes `compare`.

The simulation below knows nothing of the project: it takes its numbers from the text, and its equations are Newton's for a crank and a
rigid bar, solved by scipy.
"""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from tests.quickreturn.conftest import Call

Numbers = dict[str, dict[str, float]]


def numbers(text: str) -> Numbers:
    """Section or START -> name -> number, as a reader would take them from the text."""
    found: Numbers = {}
    section = ""
    for line in text.splitlines():
        row = re.fullmatch(r"  (\w+) +(\S+) +\S+.*", line)
        if not line.startswith("  "):
            section = line.split(" (")[0]
        elif row and re.fullmatch(r"-?[0-9.e+-]+", row[2]):
            found.setdefault(section, {})[row[1]] = float(row[2])
    return found


class RigidMechanism:
    """Crank and rigid follower, by hand."""

    def __init__(self, given: Numbers) -> None:
        crank, bar, tip = given["crank"], given["follower"], given["tip"]
        self.arm, self.pivot, self.length = crank["length"], np.array([given["mechanism"]["pivot_distance"], 0.0]), bar["length"]
        self.torque, self.friction, self.base_friction = crank["torque"], crank["damping"], given["base"]["damping"]
        self.about_o = crank["inertia"] + crank["mass"] * crank["center_of_mass"] ** 2
        self.about_p = given["base"]["inertia"] + bar["mass_per_length"] * bar["length"] ** 3 / 3.0
        self.about_p += tip["inertia"] + tip["mass"] * (bar["length"] + tip["center_of_mass"]) ** 2

    def motion(self, angle: float, speed: float) -> dict[str, float]:
        """Everything at an instant, with the crank's acceleration as "acceleration"."""
        out, turned = np.array([np.cos(angle), np.sin(angle)]), np.array([-np.sin(angle), np.cos(angle)])
        arm = self.arm * out - self.pivot
        s = float(np.hypot(*arm))
        along = arm / s
        across = np.array([-along[1], along[0]])
        velocity = self.arm * speed * turned
        rate = float(velocity @ across) / s
        per_acceleration = self.arm * float(turned @ across) / s
        without = (-self.arm * speed**2 * float(out @ across) - 2.0 * float(velocity @ along) * rate) / s
        lever = self.arm * float(out[0] * across[1] - out[1] * across[0])  # of the slider's force about O
        load = (self.about_p * without + self.base_friction * rate) / s
        acceleration = (self.torque - self.friction * speed - load * lever) / (self.about_o + self.about_p * per_acceleration / s * lever)
        follower_acceleration = per_acceleration * acceleration + without
        tip = self.pivot + self.length * along
        return {
            "acceleration": acceleration,
            "crank_angle [deg]": np.degrees(angle),
            "crank_speed [rpm]": speed * 30.0 / np.pi,
            "follower_angle [rad]": float(np.arctan2(along[1], along[0])) % (2.0 * np.pi),
            "slider_position [mm]": 1e3 * s,
            "tip_x [m]": tip[0],
            "tip_y [m]": tip[1],
            "tip_acceleration [m/s^2]": self.length * follower_acceleration,
            "slider_force [N]": (self.about_p * follower_acceleration + self.base_friction * rate) / s,
        }


@pytest.mark.parametrize("change", [(), ("--set", "crank.length=5 in", "--set", "crank.initial_angle=200 deg")])
@pytest.mark.verify
def test_a_simulation_written_from_the_text_passes(call: Call, change: tuple[str, ...]) -> None:
    text = call("show", "rigid", *change, "--for-other-tools").output
    given = numbers(text)
    mechanism, start = RigidMechanism(given), given["START"]
    times = np.linspace(0.0, 1.2, 601)
    found = solve_ivp(
        lambda _, state: [state[1], mechanism.motion(*state)["acceleration"]],
        (0.0, 1.2),
        [start["crank_angle"], start["crank_speed"]],
        method="DOP853",
        t_eval=times,
        rtol=1e-10,
        atol=1e-12,
    )
    rows = [mechanism.motion(*state) for state in found.y.T]
    names = [name for name in rows[0] if name != "acceleration"]
    lines = [",".join(["time [ms]", *names])]
    lines += [
        ",".join(map(repr, [1e3 * float(time), *(float(row[name]) for name in names)])) for time, row in zip(times, rows, strict=True)
    ]
    Path("scipy.csv").write_text("\n".join(lines))
    answer = call("compare", "rigid", "scipy.csv", *change, "--engine", "reference", "--set", "engine.tolerance=1e-9", "--json")
    assert answer.code == 0, answer
    (case,) = json.loads(answer.output)["cases"]
    assert case["turn"] == (3 if not change else 2)  # whole turns begin at 180 deg
    # both are integrated to 1e-9; the scene has no other error
    assert max(case["differences"]["scipy.csv"]["reference"].values()) < 1e-7
    assert len(case["checks"]) == 28


@pytest.mark.verify
def test_the_start_that_is_printed_is_the_engines_first_row(call: Call) -> None:
    change = ("--set", "crank.initial_angle=200 deg")
    start = numbers(call("show", "thesis-24", *change, "--for-other-tools").output)["START"]
    call("simulate", "thesis-24", *change, "--engine", "reference", "--duration", "0.01 s", "--output", "out.csv")
    heads, first = [line.split(",") for line in Path("out.csv").read_text().splitlines()[:2]]
    row = dict(zip(heads, map(float, first), strict=True))
    rates = {"follower_speed", "slider_speed"}
    assert {name: start[name] for name in start.keys() - rates} == pytest.approx(
        {name: row[name] for name in start.keys() - rates}, abs=1e-6
    )


@pytest.mark.parametrize("case", ["thesis-24", "shaper-cutting", "hard-joint-1e5", "hard-gravity", "hard-slider-inertia", "example"])
def test_the_heading_is_accepted_and_lines_are_readable(call: Call, case: str, tmp_path: Path) -> None:
    from quickreturn.cases.files.recorded import read_table

    text = call("show", case, "--for-other-tools").output
    (header,) = (line for line in text.splitlines() if line.startswith("time ["))
    columns = header.split(",")
    (tmp_path / "table.csv").write_text(f"{header}\n{','.join(['0'] * len(columns))}\n")
    assert len(read_table(str(tmp_path / "table.csv")).columns) == len(columns)
    assert max(len(line) for line in text.splitlines() if line != header) <= 140
    assert f"quickreturn compare {case} " in text


@pytest.mark.verify
def test_a_table_of_another_program_is_compared_by_its_mapping(call: Call) -> None:
    call("simulate", "rigid", "--engine", "reference", "--duration", "1 s", "--output", "own.csv")
    heads, *rows = [line.split(",") for line in Path("own.csv").read_text().splitlines()]
    kept = [heads.index(name) for name in ("time", "crank_angle", "slider_position")]
    lines = [
        ";".join(f"{number:.9g}".replace(".", ",") for number in (float(row[kept[0]]), -float(row[kept[1]]), 1e3 * float(row[kept[2]])))
        for row in rows
    ]
    Path("export.csv").write_text("\n".join(["Time;phi;s", *lines]))
    refused = call("compare", "rigid", "export.csv", "--engine", "reference")
    assert refused.code == 2
    assert "--write-mapping" in refused.errors
    assert call("compare", "rigid", "export.csv", "--write-mapping").code == 0
    text = Path("export.toml").read_text()
    assert '"Time" = "time"' in text
    Path("export.toml").write_text(
        re.sub(r'"phi" = .*', '"phi" = "-crank_angle"', re.sub(r'"s" = .*', '"s" = "slider_position [mm]"', text))
    )
    answer = call("compare", "rigid", "export.csv", "--engine", "reference", "--json")
    assert answer.code == 0, answer
    assert "read as: semicolons, decimal comma, columns by export.toml, 1,001 rows" in answer.errors
    # nine digits of the position
    assert json.loads(answer.output)["cases"][0]["differences"]["export.csv"]["reference"]["slider_position"] < 1e-7
    assert call("compare", "rigid", "export.csv", "--write-mapping").code == 2
