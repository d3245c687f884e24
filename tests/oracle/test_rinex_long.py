#!/usr/bin/env python3
"""Every observable of every shared RINEX file, beside georinex: some minutes (georinex reads about 300 kB/s)."""

import sys

sys.dont_write_bytecode = True
import test_rinex

if __name__ == "__main__":
    if not (test_rinex.DATA / test_rinex.OBSERVATIONS[0]).exists():
        print(f"skipped: no files in {test_rinex.DATA}")
        sys.exit(test_rinex.SKIPPED)
    test_rinex.values(0)
