"""Coverage-guided fuzzing: libFuzzer changes bytes, and keeps what leads it into more of the code.

It begins with test/fuzz/corpus, of which test/node replays each file. What it
finds besides, and what it says, is in build/fuzz; to see one fault again:
PYTHONPATH=test:$PYTHONPATH python3 test/fuzz/hunt.py --target=TARGET FILE
"""
import importlib.util
import os
import re
import subprocess
import sys

from benchmark import PACKAGE

FUZZ = os.path.join(PACKAGE, 'test', 'fuzz')
BUILD = os.path.join(PACKAGE, 'build', 'fuzz')
SECONDS = 60      # for each target
HANG_S = 60
MEMORY_MB = 1500  # the largest picture that is taken needs about half of that
MAX_BYTES = 4096  # of one try: long ones are slow, and say little that is new
FAULT = re.compile(r'^ === Uncaught Python exception: ===\n(.*)|^SUMMARY: (.*)', re.MULTILINE)


def run(seconds, seed):
    """Fuzz each target for its share of the time; what was found, as sentences."""
    if importlib.util.find_spec('atheris') is None:
        print('There is no atheris for this Python or this processor, so nothing is fuzzed.')
        return []
    from fuzz.targets import TARGETS
    share = SECONDS if seconds is None else max(1, round(seconds / len(TARGETS)))
    print('%d s for each target, seed %d; at most %d bytes, %d MB of memory, %d s for one try\n'
          % (share, seed, MAX_BYTES, MEMORY_MB, HANG_S))
    print('target            tries      edges   features   corpus      new   found (target: nothing)')
    found = []
    for target in TARGETS:
        said, fault = hunt(target, share, seed)
        places = re.findall(r'cov: (\d+) ft: (\d+) corp: (\d+)', said)
        numbers = dict(re.findall(r'^stat::(\w+):\s+(\d+)', said, re.MULTILINE))
        print('%-12s %10s %10s %10s %8s %8s   %s' % (
            target, numbers.get('number_of_executed_units', '-'), *(places[-1] if places else '---'),
            numbers.get('new_units_added', '-'), fault or 'nothing'), flush=True)
        if fault:
            found.append('%s: %s' % (target, fault))
    return found


def hunt(target, seconds, seed):
    """Fuzz one target; what libFuzzer said, and the fault that it found, or None."""
    corpus = os.path.join(BUILD, target)
    os.makedirs(corpus, exist_ok=True)
    log = corpus + '.log'
    with open(log, 'wb') as file:
        done = subprocess.run(
            [sys.executable, os.path.join(FUZZ, 'hunt.py'), '--target=' + target, corpus,
             os.path.join(FUZZ, 'corpus', target),
             '-max_total_time=%d' % seconds, '-seed=%d' % seed, '-timeout=%d' % HANG_S,
             '-max_len=%d' % MAX_BYTES, '-rss_limit_mb=%d' % MEMORY_MB, '-print_final_stats=1',
             '-artifact_prefix=%s-' % corpus],
            stdout=file, stderr=subprocess.STDOUT)
    with open(log, errors='replace') as file:
        said = file.read()
    if done.returncode == 0:
        return said, None
    why = FAULT.search(said)
    where = re.search(r'Test unit written to (.*)', said)
    return said, '%s; its bytes are in %s, more in %s' % (
        (why.group(1) or why.group(2)) if why else 'it ended with %d' % done.returncode,
        where.group(1) if where else 'no file', log)
