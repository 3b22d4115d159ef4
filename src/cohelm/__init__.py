"""cohelm: shared control for wheelchairs among people."""

from cohelm import numba_setup

numba_setup.prepare()
