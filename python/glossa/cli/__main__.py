"""``python -m glossa.cli``."""

import sys

from glossa.cli import main

if __name__ == "__main__":
    sys.exit(main())
