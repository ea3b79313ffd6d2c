"""Engines: ways of simulating the mechanism, all behind one interface (`engines.base.Engine`)."""
