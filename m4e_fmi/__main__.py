"""`python -m m4e_fmi` is the command `m4e-fmi`."""

import sys

from m4e_fmi.cli import main

if __name__ == "__main__":
    sys.exit(main())
