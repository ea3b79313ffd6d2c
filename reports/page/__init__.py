"""The page: the moving first screen, the chapters, and the file that contains them."""
