"""Run tests, and say how many passed, failed and were skipped. For script/test, which prepares what is needed.

run.py [--quick | NAME ...]
"""
import glob
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from xml.etree import ElementTree

PACKAGE = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
RESULTS = os.path.join(PACKAGE, 'build', 'test_results')
FOUND = os.path.join(RESULTS, 'unit5')
TIMEOUT_S = 600  # of a rostest; its own limit for the test in it is 300 s
MATRIX = 'test/node/package/test_matrix.py'
# A constant of a rostest that says why it runs alone, with nothing beside it.
ALONE = re.compile(r'^ALONE = ', re.MULTILINE)
SKIPPED = re.compile(r'^SKIPPED (?:\S*\.)?(\S+): (.+)$', re.MULTILINE)  # see test/rig/processes/skip.py


class Rostest:
    """NAME_test.py, in a folder of test/ros."""

    def __init__(self, path):
        self.name = os.path.basename(path)[:-len('_test.py')]
        self._launch = ['%s/%s.test' % (os.path.dirname(path), self.name)]
        if not os.path.exists(self._launch[0]):
            self._launch = ['test/ros/run.test', 'name:=' + self.name]
        with open(path) as source:
            self.is_alone = bool(ALONE.search(source.read()))

    def run(self, stream=None):
        """Run it; (Cases, seconds that it took). What it prints goes to ``stream``, or else to a file."""
        begin, log = time.monotonic(), '%s/%s.log' % (FOUND, self.name)
        command = ['rostest', '--results-base-dir', RESULTS, '--results-filename', self.name + '.xml']
        with open(log, 'w') as file, subprocess.Popen([*command, *self._launch], stdout=stream or file,
                                                      stderr=subprocess.STDOUT) as process:
            try:
                code = process.wait(TIMEOUT_S)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)  # at which it ends its nodes
                code = 'nothing within %d s' % TIMEOUT_S
        cases = Cases(self.name, '%s/rosunit-%s_test.xml' % (FOUND, self.name))
        if code and not cases.failed:
            where = '' if stream else '; what it printed is in ' + os.path.relpath(log)
            cases.failed.append((self.name, 'rostest returned %s%s' % (code, where)))
        return cases, time.monotonic() - begin


class Matrix:
    """The plain tests with other versions of Python and of libraries: on one processor, beside the rostests."""

    name, is_alone = 'matrix', False

    def run(self):
        """As Rostest.run."""
        begin = time.monotonic()
        with open('%s/matrix.log' % FOUND, 'w') as file:
            cases = run_pytest('matrix', '-q', MATRIX, stdout=file)
        return cases, time.monotonic() - begin


class Cases:
    """How the cases of a test went: their names, and why those failed or skipped that did."""

    def __init__(self, test, path):
        """``path``: of its results, as XML; without them it has failed."""
        self.test, self.passed, self.failed, self.skipped = test, [], [], []
        try:
            results = ElementTree.parse(path)
        except (OSError, ElementTree.ParseError) as error:
            self.failed.append((test, 'it crashed or never started, as there are no results: %s' % error))
            return
        told = {}  # rosunit's results do not say what was skipped
        for text in results.iter('system-out'):
            told.update(SKIPPED.findall(text.text or ''))
        self.skipped += told.items()
        for case in results.iter('testcase'):
            name = case.get('name')
            if name in told:
                continue
            fault, skipped = [next((child for child in case if child.tag in tags), None)
                              for tags in (('failure', 'error'), ('skipped',))]
            if fault is not None:
                self.failed.append((name, fault.text or fault.get('message')))
            elif skipped is not None:
                self.skipped.append((name, skipped.get('message')))
            else:
                self.passed.append(name)


def rostests():
    """{name: Rostest} of all."""
    return {test.name: test for test in map(Rostest, sorted(glob.glob('test/ros/*/*_test.py')))}


def pytests():
    """{name: path} of all test files for pytest."""
    return {os.path.basename(path)[len('test_'):-len('.py')]: path for folder in ('plain', 'node')
            for path in sorted(glob.glob('test/%s/**/test_*.py' % folder, recursive=True))}


def run_pytest(name, *arguments, stdout=None):
    """The Cases of pytest with these arguments."""
    path = '%s/%s.xml' % (FOUND, name)
    code = subprocess.run([sys.executable, '-m', 'pytest', '-p', 'no:cacheprovider', '--junit-xml=' + path,
                           *arguments], stdout=stdout).returncode
    cases = Cases(name, path)
    if code and not cases.failed:
        cases.failed.append((name, 'pytest returned %d' % code))
    return cases


def run_side_by_side(tests):
    """The Cases of each: as many side by side as there are processors, but for those that must be alone."""
    for is_alone in False, True:
        chosen = [test for test in tests if test.is_alone == is_alone]
        with ThreadPoolExecutor(1 if is_alone else os.cpu_count()) as pool:
            runs = [pool.submit(test.run) for test in chosen]
            try:
                for run in as_completed(runs):
                    cases, seconds = run.result()
                    print('%4d s  %-24s %s' % (seconds, cases.test, 'FAILED' if cases.failed else
                                               'passed' if cases.passed else 'skipped'), flush=True)
                    yield cases
            finally:  # at Ctrl-C no others are begun
                for run in runs:
                    run.cancel()


def run_named(names):
    """The Cases of some, one after the other; all that they print is shown."""
    for name in names:
        if name in rostests():
            yield rostests()[name].run(sys.stdout)[0]
        if name in pytests():
            yield run_pytest(name, '-v', pytests()[name])


def run_all():
    """The Cases of everything."""
    yield run_pytest('pytest', '-q', '-n', 'auto', '--ignore', MATRIX, 'test/plain', 'test/node')
    yield from run_side_by_side([Matrix(), *rostests().values()])


def main(names):
    os.chdir(PACKAGE)
    shutil.rmtree(RESULTS, ignore_errors=True)
    os.makedirs(FOUND)
    if names == ['--quick']:
        done = [run_pytest('plain', '-q', '-n', 'auto', 'test/plain')]
    else:
        done = list(run_named(names) if names else run_all())
    print()
    for cases in done:
        for name, reason in cases.skipped:
            print('skipped %s: %s: %s' % (cases.test, name, reason))
    for cases in done:
        for name, reason in cases.failed:
            print('FAILED %s: %s\n%s' % (cases.test, name, reason))
    passed, failed, skipped = [sum(len(getattr(cases, kind)) for cases in done)
                               for kind in ('passed', 'failed', 'skipped')]
    print('%d passed, %d failed, %d skipped' % (passed, failed, skipped))
    sys.exit(failed > 0 or passed == 0)


if __name__ == '__main__':
    main(sys.argv[1:])
