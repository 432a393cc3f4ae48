"""`python -m vh_drake` is the command line."""

from vh_drake.cli import main

main()
