"""One module per subcommand of `quickreturn`, each with a click command called `command`.

A module imports nothing slow at its top: what a subcommand needs is imported when it runs, so that `--help` is instant.
"""
