"""`python -m fesloop`."""

import sys

from fesloop.cli import main

sys.exit(main())
