"""An Exudyn system under construction: parts that the flexible and the rigid follower share, and the list of what was built."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np

from quickreturn.engines.base import ModelDescription
from quickreturn.engines.exudyn.library import exu, items
from quickreturn.engines.start import Start
from quickreturn.reference_model.constants import drive_constants
from quickreturn.reference_model.joint import joint_in_words
from quickreturn.reference_model.mechanism import Mechanism, MotorCurve, PrescribedSpeed, Scene, TorqueDrive
from quickreturn.reference_model.spring import spring_tension
from quickreturn.reference_model.table import table_value
from quickreturn.reference_model.tip import slide_friction, tool_constants, tool_force

exu.config.printToConsole = False  # the command line prints JSON on stdout and nothing else there
exu.config.suppressWarnings = True

#: Mass (in the scene's unit) of a pinned body, which keeps the mass matrix regular; it lies in the pin and has no influence.
PINNED_MASS = 1.0

#: Mass of a compliant joint's carriage, in the scene's unit, which is near the follower's mass. Without it the initial accelerations are
#: undetermined along the tangent, and Exudyn silently begins with zeros: with a bent start the error of the tip deflection is then 1.5 %.
#: The influence of the mass is in proportion to it: 1e-3 kg change the tip deflection of run 24 by 9e-5 at 2e4 N/m.
CARRIAGE_MASS = 1e-9
CARRIAGE = f"slider: carriage of {CARRIAGE_MASS:g} of the follower's mass"


class Assembly:
    """Adds parts to a `MainSystem` and keeps the list of bodies, joints and constraint equations.

    Attributes:
        mbs: Exudyn's system.
        ground: object number of the ground, at O.
        ground_coordinate: marker of a coordinate that stays zero.
        pins: object numbers of the bearings, by the name of the body that turns there.
        begin: initializes a solver, by the function that it is given.
        drive_rate: gives what the multiplier of a prescribed motion is multiplied by as it is summed: the crank's speed if that varies.
    """

    def __init__(self, scene: Scene) -> None:
        self.scene = scene
        self.container = exu.SystemContainer()  # owns `mbs`, so it must live as long
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.AddObject(items.ObjectGround())
        self.ground_coordinate = self.coordinate_marker(self.mbs.AddNode(items.NodePointGround()), 0)
        self.pins: dict[str, Any] = {}
        self.begin: Callable[[Callable[[], bool]], bool] = lambda initialize: initialize()
        self.drive_rate: Callable[[], float] = lambda: 1.0
        self._bodies: list[str] = []
        self._joints: list[str] = []
        self._constraints = 0

    @property
    def mechanism(self) -> Mechanism:
        """The scene, which must have a crank and a slider."""
        assert self.scene.crank is not None
        return self.scene

    @property
    def joint_is_compliant(self) -> bool:
        """Whether the slider's joint has a spring."""
        return not self.scene.slider.is_rigid

    @property
    def joint_text(self) -> str:
        """The end of the slider's line in the list of joints: its springs and dampers; "" for a rigid joint."""
        return f", beside the crank tip: {joint_in_words(self.scene.slider)}" if self.joint_is_compliant else ""

    def listed_body(self, description: str) -> None:
        """Enter a body (or a group of elements) in the list of what was built."""
        self._bodies.append(description)

    def add_joint(self, description: str, joint: Any, equations: int) -> Any:
        """Add a joint with its number of independent constraint equations; returns its object number."""
        self._joints.append(description)
        self._constraints += equations
        return self.mbs.AddObject(joint)

    def describe(self) -> ModelDescription:
        """What was built; call after `mbs.Assemble()`."""
        return ModelDescription(tuple(self._bodies), tuple(self._joints), self.mbs.systemData.ODE2Size() - self._constraints)

    def coordinate_marker(self, node: Any, coordinate: int) -> Any:
        """Marker on one coordinate of a node."""
        return self.mbs.AddMarker(items.MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))

    def point_marker(self, body: Any, x: float, y: float = 0.0) -> Any:
        """Marker on a point of a body, in the body's frame."""
        return self.mbs.AddMarker(items.MarkerBodyPosition(bodyNumber=body, localPosition=[x, y, 0.0]))

    def frame_marker(self, body: Any, x: float = 0.0) -> Any:
        """Marker on a point of a rigid body together with the body's rotation."""
        return self.mbs.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0]))

    def rigid_body(
        self, place: Sequence[float], angle: float, velocity: Sequence[float], rate: float, mass: float, inertia: float
    ) -> tuple[Any, Any]:
        """Add a planar rigid body with its centre of mass at `place`; returns node and object number."""
        node = self.mbs.AddNode(items.NodeRigidBody2D(referenceCoordinates=[*place, angle], initialVelocities=[*velocity, rate]))
        return node, self.mbs.AddObject(items.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def pinned_body(self, name: str, pivot: float, angle: float, rate: float, inertia: float) -> tuple[Any, Any]:
        """Add a body that turns about the point (`pivot`, 0); `inertia` is about it. Returns node and object number."""
        node, body = self.rigid_body([pivot, 0.0], angle, [0.0, 0.0], rate, PINNED_MASS, inertia)
        self.listed_body(name)
        self.pin(name.split(":")[0], pivot, self.point_marker(body, 0.0))
        return node, body

    def pin(self, name: str, pivot: float, marker: Any) -> None:
        """Hold a marker of a body or node at the point (`pivot`, 0)."""
        joint = items.ObjectJointRevolute2D(markerNumbers=[self.point_marker(self.ground, pivot), marker])
        self.pins[name] = self.add_joint(f"pin of the {name}", joint, 2)

    def rotary_damper(self, node: Any, damping: float) -> None:
        """Add a viscous torque on the rotation of a rigid body's node, unless `damping` (N m s/rad) is zero."""
        if damping > 0.0:
            markers = [self.ground_coordinate, self.coordinate_marker(node, 2)]
            self.mbs.AddObject(items.ObjectConnectorCoordinateSpringDamper(markerNumbers=markers, damping=damping))

    def weight(self, body: Any, x: float, mass: float) -> None:
        """Add the weight of a `mass` (kg) at the distance `x` (m) along a body's axis, unless there is no gravity or no mass."""
        if self.scene.has_gravity and mass > 0.0:
            force = [mass * g for g in self.scene.gravity]
            self.mbs.AddLoad(items.LoadForceVector(markerNumber=self.point_marker(body, x), loadVector=[*force, 0.0]))

    def push_tip(self, marker: Any, crank_node: Any) -> None:
        """Add the force on the tip and the friction of the tool's slide; the marker there turns with the follower if the force does."""
        tip = self.scene.tip
        if tip is None:
            return
        given = tuple(tool_constants(tip).values())

        def acting(mbs: Any, _time: float, _load: Any) -> Any:
            share, *force = tool_force(mbs.GetNodeOutput(crank_node, exu.OutputVariableType.Rotation)[2], *given)
            return share * np.array([*force, 0.0])

        def rubbing(_mbs: Any, _time: float, _item: Any, _displacement: Any, velocity: Any, *_parameters: Any) -> Any:
            force = slide_friction(tip, np.array(complex(velocity[0], velocity[1])))
            return [-float(force.real), -float(force.imag), 0.0]

        if tip.is_forced:
            varies = {} if tip.force_table is None and tip.is_always_forced else {"loadVectorUserFunction": acting}
            load = [*given[:2], 0.0]
            self.mbs.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=load, bodyFixed=tip.follows, **varies))
        if tip.friction_force > 0.0:
            markers = [self.point_marker(self.ground, 0.0), marker]
            self.mbs.AddObject(items.ObjectConnectorCartesianSpringDamper(markerNumbers=markers, springForceUserFunction=rubbing))

    def hold(self, marker: Any) -> None:
        """Add the spring, at a marker on the follower, unless it has no force."""
        if (spring := self.scene.acting_spring) is None:
            return
        law, markers = spring.law, [self.point_marker(self.ground, *spring.anchor), marker]
        connector = items.ObjectConnectorSpringDamper(
            markerNumbers=markers, referenceLength=law.rest, stiffness=law.stiffness, damping=law.damping, force=law.preload
        )
        if law.stop > 0.0:
            connector.springForceUserFunction = lambda mbs, time, item, stretch, rate, *parameters: spring_tension(
                stretch + law.rest, rate, law
            )
        self.add_joint(spring.in_words, connector, 0)

    def crank(self, start: Start) -> tuple[Any, Any, Any]:
        """Add the crank with its drive; a slider's mass turns with the crank tip.

        Returns:
            Node and object number, and the object number of the constraint that prescribes the speed (None if it is free).
        """
        crank, slider = self.mechanism.crank, self.mechanism.slider
        name = "crank" if slider.mass == 0.0 else "crank: with the slider's mass at its tip"
        node, body = self.pinned_body(name, 0.0, start.crank_angle, start.crank_speed, self.mechanism.crank_inertia)
        self.weight(body, crank.center_of_mass, crank.mass)
        self.weight(body, crank.length, slider.mass)
        begin, way, period, rows = drive_constants(drive := crank.drive).values()
        if isinstance(drive, TorqueDrive):
            if drive.torque != 0.0:
                self.mbs.AddLoad(items.LoadTorqueVector(markerNumber=self.frame_marker(body), loadVector=[0.0, 0.0, drive.torque]))
            self.rotary_damper(node, drive.damping)
            return node, body, None
        axis = [self.ground_coordinate, self.coordinate_marker(node, 2)]
        if isinstance(drive, MotorCurve):
            motor = items.ObjectConnectorCoordinateSpringDamper(markerNumbers=axis)
            motor.springForceUserFunction = lambda mbs, time, item, angle, speed, *parameters: -table_value(speed, rows, 0.0)[0]
            self.mbs.AddObject(motor)
            return node, body, None
        held = items.ObjectConnectorCoordinate(markerNumbers=axis, offset=drive.initial_speed, velocityLevel=True)
        if isinstance(drive, PrescribedSpeed):
            return node, body, self.add_joint("prescribed crank speed", held, 1)

        def turning(mbs: Any) -> tuple[float, float]:
            return table_value(way * (mbs.GetNodeOutput(node, exu.OutputVariableType.Rotation)[2] - begin), rows, period)

        held.offsetUserFunction_t = lambda mbs, time, item, offset: turning(mbs)[0]
        constraint = self.add_joint("prescribed crank speed", held, 1)
        speed, slope = table_value(way * (start.crank_angle - begin), rows, period)
        self.drive_rate = lambda: turning(self.mbs)[0]
        load = self.mbs.AddLoad(items.LoadCoordinate(markerNumber=axis[1], load=0.0))
        self.begin = partial(self._accelerated, node, constraint, load, way * slope * speed)
        return node, body, constraint

    def _accelerated(self, node: Any, constraint: Any, load: Any, acceleration: float, initialize: Callable[[], bool]) -> bool:
        """Initialize a solver so that the crank begins with an acceleration.

        Exudyn takes a varying speed for constant as it looks for the first accelerations, which would set the whole machine ringing. So it
        finds them for a free crank under the torque that leads to this acceleration, in proportion to which that is.
        """
        found = list[float]()
        self.mbs.SetObjectParameter(constraint, "activeConnector", False)
        for torque in (0.0, 1.0):
            self.mbs.SetLoadParameter(load, "load", torque)
            initialize()
            found.append(float(self.mbs.GetNodeOutput(node, exu.OutputVariableType.AngularAcceleration)[2]))
        torque = (acceleration - found[0]) / (found[1] - found[0])
        self.mbs.SetLoadParameter(load, "load", torque)
        ready = initialize()
        self.mbs.SetLoadParameter(load, "load", 0.0)
        self.mbs.SetObjectParameter(constraint, "activeConnector", True)
        multipliers = self.mbs.systemData.GetAECoordinates()
        multipliers[self.mbs.systemData.GetObjectLTGAE(constraint)[0]] = -torque
        self.mbs.systemData.SetAECoordinates(multipliers)
        return ready
