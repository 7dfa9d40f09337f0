"""`python -m signorini`: the command line tool of the wheel."""

import os
import sys

from ._program import program

os.execv(program(), ["signorini", *sys.argv[1:]])
