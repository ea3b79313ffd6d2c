"""quickreturn: what notebooks, engine authors and the command line use."""
