"""The periodic steady state that `reference` finds by a direct search."""

from dataclasses import dataclass

from quickreturn.engines.base import NoSteadyState, SteadyState
from quickreturn.engines.own.simulation import OwnSimulation
from quickreturn.engines.start import Start
from quickreturn.reference_model.cycles.periodic import NoPeriodicOrbit, PeriodicOrbit, largest_multiplier
from quickreturn.reference_model.model import BeamModel


@dataclass(frozen=True)
class FoundOrbit(SteadyState):
    """A periodic steady state of the explicit model."""

    simulation: OwnSimulation  # as in `SteadyState`
    orbit: PeriodicOrbit  # what the search found

    def simulation_again(self) -> OwnSimulation:
        """A new simulation in this state, so that the original one stays in it."""
        original = self.simulation
        return OwnSimulation(original.model, self.orbit.state, original.tolerance, original.setup_seconds)

    @property
    def start(self) -> Start:
        """The same state as a start for any engine."""
        start = self.simulation_again().present_start()
        assert start is not None
        return start

    def whole_multiplier(self) -> complex:
        """The largest multiplier by derivatives of the whole model. NoSteadyState: a cycle is broken."""
        assert isinstance(self.simulation.model, BeamModel)
        try:
            return largest_multiplier(self.simulation.model, self.orbit, self.simulation.tolerance)
        except NoPeriodicOrbit as reason:
            raise NoSteadyState(str(reason)) from reason
