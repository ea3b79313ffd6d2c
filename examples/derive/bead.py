"""A bead slides without friction: on a rod that spins in a horizontal plane, and on a pendulum."""

from quickreturn.derive import System, turned, vector


def bead_on_rod(prescribed: bool = False) -> System:
    """The rod spins freely, or at a prescribed speed; then the loop's force is the torque."""
    system = System("bead on a rod")
    p = system.constants(rod_inertia=(20, "g*m^2"), bead_mass=(100, "g"), speed=(2, "rad/s"))
    theta, r = system.coordinate("theta", "rad"), system.coordinate("r", "m")
    system.body("rod", inertia=p.rod_inertia, angle=theta)
    system.body("bead", mass=p.bead_mass, place=turned(theta, r))
    if prescribed:
        system.loop("motor", theta - p.speed * system.time, "rad", gives=[theta])
    momentum = (p.rod_inertia + p.bead_mass * r**2) * system.rate(theta)
    system.output("angular_momentum", momentum, "kg*m^2/s")
    return system


def bead_on_pendulum() -> System:
    """A spring holds the bead; the pendulum hangs down at the angle 0."""
    system = System("bead on a pendulum")
    p = system.constants(
        length=(1, "m"), rod_mass=(0.3, "kg"), bead_mass=(0.1, "kg"), stiffness=(20, "N/m")
    )  # fmt: skip
    system.gravity = vector(9.81, 0)  # n1 points down
    theta, r = system.coordinate("theta", "rad"), system.coordinate("r", "m", guess=0.5)
    middle, inertia = turned(theta, p.length / 2), p.rod_mass * p.length**2 / 12
    system.body("rod", mass=p.rod_mass, place=middle, inertia=inertia, angle=theta)
    system.body("bead", mass=p.bead_mass, place=turned(theta, r))
    system.spring("spring", r - p.length / 2, p.stiffness)
    return system
