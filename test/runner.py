"""Run tests, and print how many passed, failed, and were skipped. Called by script/test after the setup.

runner.py [--quick | NAME ...]
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

import coverage

PACKAGE = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
RESULTS = os.path.join(PACKAGE, 'build', 'test_results')
REPORTS = os.path.join(RESULTS, 'unit5')
TIMEOUT_S = 2100  # for a rostest; the test in it has its own limit of 1,800 s
QUICK = 'not long and not clips'  # the tests of --quick and of the matrix, which need about a minute
MATRIX = 'test/node/package/test_matrix.py'
COVERAGE, LEAST_COVERED = 'test/coverage', 90.0  # percent of the lines of src
# A constant that gives the reason why a rostest must run alone.
ALONE = re.compile(r'^ALONE = ', re.MULTILINE)
SKIPPED = re.compile(r'^SKIPPED (?:\S*\.)?(\S+): (.+)$', re.MULTILINE)  # see test/rig/processes/skip.py


class Rostest:
    """A rostest: NAME_test.py in a folder of test/ros."""

    def __init__(self, path):
        self.name = os.path.basename(path)[:-len('_test.py')]
        self._launch = ['%s/%s.test' % (os.path.dirname(path), self.name)]
        if not os.path.exists(self._launch[0]):
            self._launch = ['test/ros/run.test', 'name:=' + self.name]
        with open(path) as source:
            self.is_alone = bool(ALONE.search(source.read()))

    def run(self, stream=None):
        """Run it. Returns (Cases, seconds). Its output goes to ``stream``, or to a file if that is None."""
        begin, log = time.monotonic(), '%s/%s.log' % (REPORTS, self.name)
        command = ['rostest', '--results-base-dir', RESULTS, '--results-filename', self.name + '.xml']
        with open(log, 'w') as file, subprocess.Popen([*command, *self._launch], stdout=stream or file,
                                                      stderr=subprocess.STDOUT) as process:
            try:
                code = process.wait(TIMEOUT_S)
            except subprocess.TimeoutExpired:
                process.send_signal(signal.SIGINT)  # rostest then stops its nodes
                code = 'nothing within %d s' % TIMEOUT_S
        cases = Cases(self.name, '%s/rosunit-%s_test.xml' % (REPORTS, self.name))
        if code and not cases.failed:
            where = '' if stream else '; its output is in ' + os.path.relpath(log)
            cases.failed.append((self.name, 'rostest returned %s%s' % (code, where)))
        return cases, time.monotonic() - begin


class Matrix:
    """The plain tests with other versions of Python and of libraries, all at once, beside the rostests."""

    name, is_alone = 'matrix', False

    def run(self):
        """Like Rostest.run."""
        begin = time.monotonic()
        with open('%s/matrix.log' % REPORTS, 'w') as file:
            cases = run_pytest('matrix', '-q', '-n', '2', MATRIX, stdout=file)
        return cases, time.monotonic() - begin


class Cases:
    """The results of a test: the names of its cases, and the reasons of those that failed or were skipped."""

    def __init__(self, test, path=None):
        """``path``: the XML file with the results, or None. It is a failure if that is not there."""
        self.test, self.passed, self.failed, self.skipped = test, [], [], []
        if path is None:
            return
        try:
            results = ElementTree.parse(path)
        except (OSError, ElementTree.ParseError) as error:
            self.failed.append((test, 'it crashed or never started, since there are no results: %s' % error))
            return
        reasons = {}  # rosunit's results do not say which cases were skipped
        for text in results.iter('system-out'):
            reasons.update(SKIPPED.findall(text.text or ''))
        self.skipped += reasons.items()
        for case in results.iter('testcase'):
            name = case.get('name')
            if name in reasons:
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
    """{name: Rostest} of all rostests."""
    # From the last folder to the first, since those that take longest are in the last ones.
    return {test.name: test for test in map(Rostest, sorted(glob.glob('test/ros/*/*_test.py'), reverse=True))}


def pytests():
    """{name: path} of all test files for pytest."""
    return {os.path.basename(path)[len('test_'):-len('.py')]: path for folder in ('plain', 'node')
            for path in sorted(glob.glob('test/%s/**/test_*.py' % folder, recursive=True))}


def measure():
    """From now on, all Python processes note which lines of src they run; see test/coverage."""
    folder = os.path.join(PACKAGE, COVERAGE)
    os.environ.update(UNIT5=PACKAGE, COVERAGE_PROCESS_START=os.path.join(folder, 'coverage.ini'),
                      PYTHONPATH=folder + os.pathsep + os.environ.get('PYTHONPATH', ''))


def covered():
    """Cases: whether enough of the lines of src have run. Prints which part, and writes a page about it."""
    os.environ.pop('COVERAGE_PROCESS_START')
    cases = Cases('coverage')
    measured = coverage.Coverage(config_file=COVERAGE + '/coverage.ini')
    try:
        measured.combine()  # without the file of a process that was killed while it wrote
        percent = measured.html_report(directory='build/coverage/html')
    except coverage.CoverageException as error:
        cases.failed.append(('coverage', str(error)))
        return cases
    said = '%.1f %% of the lines of src have run; see build/coverage/html/index.html' % percent
    print('\n' + said)
    if percent >= LEAST_COVERED:
        cases.passed.append('coverage')
    else:
        cases.failed.append(('coverage', '%s, but %g %% are promised' % (said, LEAST_COVERED)))
    return cases


def run_pytest(name, *arguments, stdout=None):
    """Run pytest with these arguments. Returns Cases."""
    path = '%s/%s.xml' % (REPORTS, name)
    code = subprocess.run([sys.executable, '-m', 'pytest', '-p', 'no:cacheprovider', '--junit-xml=' + path,
                           *arguments], stdout=stdout).returncode
    cases = Cases(name, path)
    if code and not cases.failed:
        cases.failed.append((name, 'pytest returned %d' % code))
    return cases


def run_in_parallel(tests):
    """Run two tests at a time per processor, since they mostly wait; then those that must run alone.

    Yields Cases.
    """
    for is_alone in False, True:
        chosen = [test for test in tests if test.is_alone == is_alone]
        with ThreadPoolExecutor(1 if is_alone else 2 * os.cpu_count()) as pool:
            runs = [pool.submit(test.run) for test in chosen]
            try:
                for run in as_completed(runs):
                    cases, seconds = run.result()
                    print('%4d s  %-24s %s' % (seconds, cases.test, 'FAILED' if cases.failed else
                                               'passed' if cases.passed else 'skipped'), flush=True)
                    yield cases
            finally:  # after Ctrl-C, no other tests start
                for run in runs:
                    run.cancel()


def run_named(names):
    """Run some tests one after the other, and show all their output. Yields Cases."""
    for name in names:
        if name in rostests():
            yield rostests()[name].run(sys.stdout)[0]
        if name in pytests():
            yield run_pytest(name, '-v', pytests()[name])


def run_all():
    """Run all tests. Yields Cases."""
    measure()
    yield run_pytest('pytest', '-q', '-n', 'auto', '--dist', 'loadgroup', '--ignore', MATRIX, 'test/plain',
                     'test/node')
    yield from run_in_parallel([Matrix(), *rostests().values()])
    yield covered()


def main(names):
    os.chdir(PACKAGE)
    for folder in RESULTS, os.path.join('build', 'coverage'):
        shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(REPORTS)
    if names == ['--quick']:
        done = [run_pytest('plain', '-q', '-n', 'auto', '-m', QUICK, 'test/plain')]
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
