"""Parts of the program that can be deleted: each folder is a plugin (`engines.plugins`), with its tests and its documentation."""
