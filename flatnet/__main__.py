"""`python -m flatnet` is the command `flatnet`."""

import sys

from flatnet.cli import main

sys.exit(main())
