"""The hand-derived, explicit pseudo-coordinate model of the flexible-follower quick-return mechanism.

This package knows no file format, no engine and no plot. The equations are derived in `DERIVATION.md`, those of the
thesis' model in `thesis/DERIVATION.md`; the code cites their numbers.
"""
