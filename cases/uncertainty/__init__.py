"""Parameters that are not known exactly: how they scatter a result, and what a recorded table says of them."""
