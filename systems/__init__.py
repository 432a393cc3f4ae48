"""One Drake LeafSystem a file, each around an algorithm of the package."""
