"""Coverage-guided fuzzing: libFuzzer mutates bytes, and keeps what reaches more of the code.

It begins with test/fuzz/corpus, which test/node replays, too. New inputs and
the logs are in build/fuzz. This reproduces a fault:
PYTHONPATH=test:$PYTHONPATH python3 test/fuzz/hunt.py --target=TARGET FILE
"""
import importlib.util
import os
import re
import subprocess
import sys

from rig import PACKAGE

FUZZ = os.path.join(PACKAGE, 'test', 'fuzz')
BUILD = os.path.join(PACKAGE, 'build', 'fuzz')
SECONDS = 60      # for each target
HANG_S = 60
MEMORY_MB = 1500  # the largest picture that is accepted needs about half of this
MAX_BYTES = 4096  # of one input: longer ones are slow, and reveal little more
FAULT = re.compile(r'^ === Uncaught Python exception: ===\n(.*)|^SUMMARY: (.*)', re.MULTILINE)


def run(seconds, seed):
    """Fuzz each target for its share of the time. Returns sentences about what was found."""
    if importlib.util.find_spec('atheris') is None:
        print('There is no atheris for this Python or this processor, so nothing is fuzzed.')
        return []
    from fuzz.targets import TARGETS
    share = SECONDS if seconds is None else max(1, round(seconds / len(TARGETS)))
    print('%d s for each target, seed %d; at most %d bytes, %d MB of memory, %d s for one input\n'
          % (share, seed, MAX_BYTES, MEMORY_MB, HANG_S))
    print('target           inputs      edges   features   corpus      new   found (target: nothing)')
    found = []
    for target in TARGETS:
        output, fault = fuzz(target, share, seed)
        places = re.findall(r'cov: (\d+) ft: (\d+) corp: (\d+)', output)
        numbers = dict(re.findall(r'^stat::(\w+):\s+(\d+)', output, re.MULTILINE))
        print('%-12s %10s %10s %10s %8s %8s   %s' % (
            target, numbers.get('number_of_executed_units', '-'), *(places[-1] if places else '---'),
            numbers.get('new_units_added', '-'), fault or 'nothing'), flush=True)
        if fault:
            found.append('%s: %s' % (target, fault))
    return found


def fuzz(target, seconds, seed):
    """Fuzz one target. Returns the output of libFuzzer, and the fault that it found, or None."""
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
        output = file.read()
    if done.returncode == 0:
        return output, None
    why = FAULT.search(output)
    where = re.search(r'Test unit written to (.*)', output)
    return output, '%s; the input is in %s, the log in %s' % (
        (why.group(1) or why.group(2)) if why else 'exit code %d' % done.returncode,
        where.group(1) if where else 'no file', log)
