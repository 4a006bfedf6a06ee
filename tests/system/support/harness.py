"""What every system test begins with: the scripts' modules, a temporary folder, skipping.

A test file ends with `harness.main()`. CTest runs it in a network namespace of its own
(scripts/in_namespace), with VOX_BIN_DIR naming the programs; by hand: the same script, the same way.
"""

import faulthandler
import os
import pathlib
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
SCRIPTS = ROOT / "scripts"
sys.path.insert(0, str(SCRIPTS / "lib"))
SKIPPED = 77


class SystemTest(unittest.TestCase):
    """A test with a temporary folder, `self.folder`, shown with its logs if the test fails."""

    def setUp(self):
        self.folder = temporary_folder(self)
        self.addCleanup(self.show_logs_of_a_failure)

    def show_logs_of_a_failure(self):
        outcome = self._outcome.result
        if not any(test is self for test, _ in outcome.failures + outcome.errors):
            return
        for log in sorted(self.folder.glob("**/logs/*.log")):
            lines = log.read_text(encoding="utf-8", errors="replace").splitlines()[-30:]
            print(f"--- {log}", *lines, sep="\n", file=sys.stderr)


def temporary_folder(test):
    """A folder that goes when `test` (a case, or a class of cases) is over."""
    keeper = tempfile.TemporaryDirectory(prefix="voxatlas-test-")
    clean_up = test.addClassCleanup if isinstance(test, type) else test.addCleanup
    clean_up(keeper.cleanup)
    return pathlib.Path(keeper.name)


def multicast_here():
    """Whether this process has a network namespace of its own, with multicast on lo."""
    return os.environ.get("VOX_NAMESPACE") == "1"


def main():
    # CTest ends a test after 300 s: before that it says where it waits.
    faulthandler.dump_traceback_later(270, repeat=True)
    program = unittest.main(exit=False, verbosity=2)
    if not program.result.wasSuccessful():
        sys.exit(1)
    # A class that is skipped counts as one skipped, and none run.
    everything_skipped = len(program.result.skipped) >= program.result.testsRun
    sys.exit(SKIPPED if everything_skipped else 0)
