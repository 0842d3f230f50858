"""`python -m fesloop`."""

import sys

from fesloop.apps.cli import main

sys.exit(main())
