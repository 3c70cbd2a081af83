"""Parameters: every one of every node set to what it must not be, and to the utmost that it may be."""
import os
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import rosgraph
from aruco_ar.base.files import package_folder
from aruco_ar.base.progress import progress
from aruco_node.parameters.parameters import parameters_of
from aruco_node.parameters.settings import AREA_ENTRIES, PictureSettings
from hostile.parameters import validation as reading
from hostile.parameters import values
from hostile.parameters.configs import set_parameter
from live_parameters import Live
from master import Master
from rig.nodes.case import NODES
from rig.page.server import free_port
from rig.processes.started import Started

STARTS, WISHES = 3, 40  # of each parameter: values at the start of a node, and while it runs
AT_ONCE = 3
PATIENCE_S = 30


def run(seconds, seed):
    """Set all parameters; returns a sentence for each thing found. See torture."""
    end = time.monotonic() + (seconds or 0)
    kinds = {node: reading.settings_of(node) for node in NODES}
    counts, found = Counter(), {}
    with Master(), tempfile.TemporaryDirectory() as folder:
        while True:
            random = np.random.RandomState(seed)
            _read(kinds, random, folder, counts, found)
            _start(kinds, random, values.pipe(folder), counts, found)
            with Live(kinds, counts, found) as live:
                live.wish(random, WISHES)
            seed += 1
            if time.monotonic() >= end:
                break
    _print(kinds, counts)
    return ['%s (%s)' % item for item in found.items()]


def _print(kinds, counts):
    print('%d nodes, %d parameters, of which %d can be changed in a running node' % (
        len(kinds), sum(len(parameters_of(kind)) for kind in kinds.values()),
        sum(parameter.live for kind in kinds.values() for parameter in parameters_of(kind).values())))
    for where, what in (('read', 'values read without a node'), ('start', 'nodes started with a value'),
                        ('live', 'wishes to running nodes'), ('odd', 'odd messages to running nodes')):
        print('%6d %s: %d taken, %d refused with a sentence' % (
            counts[where], what, counts[where, 'taken'], counts[where, 'refused']))
    print('%6d frames and pages answered in between' % counts['answers'])
    for fault in 'tracebacks', 'deaths', 'hangs', 'bad sentences', 'others':
        print('%6d %s (0)' % (counts[fault], fault))


def _note(counts, found, kind, node, name, value, what):
    """Take note of a fault, once for a parameter and its kind."""
    counts[kind] += 1
    found.setdefault('%s: ~%s %s' % (node, name, what), 'with ' + ascii(value)[:80])


def _given(name, parameter, random, pipe):
    """All values for a parameter, and where it may be a path, a pipe."""
    given = values.values(parameter, random)
    return given + [pipe] if 'path' in parameter.kind.allowed else given


def _refusal(take, *arguments):
    """As reading.refusal, but what takes too long or too much memory raises an error."""
    with reading.bounded():
        return reading.refusal(take, *arguments)


def _read(kinds, random, folder, counts, found):
    """Read all values of all parameters, and of the entries of a file of areas, without nodes."""
    parameters = {(kind.__name__, name): (node, kind, name, parameter) for node, kind in kinds.items()
                  for name, parameter in parameters_of(kind).items()}  # once, what several nodes share
    for node, kind, name, parameter in progress(parameters.values(), 'read'):
        for value in _given(name, parameter, random, values.pipe(folder)):
            _read_one(node, name, value, counts, found, reading.taken, kind, name, value)
    path, entries = os.path.join(folder, 'areas.yaml'), parameters_of(PictureSettings)
    for name in progress(AREA_ENTRIES, 'areas'):
        for value in values.short(_given(name, entries[name], random, values.pipe(folder))):
            _read_one('areas', name, value, counts, found, reading.area_taken, path, name, value)


def _read_one(node, name, value, counts, found, *take):
    counts['read'] += 1
    try:
        sentence = _refusal(*take)
    except reading.Stuck as error:
        _note(counts, found, 'hangs', node, name, value, 'hangs: %s' % error)
        return
    except Exception as error:
        _note(counts, found, 'tracebacks', node, name, value, 'raises %s' % type(error).__name__)
        return
    counts['read', 'refused' if sentence else 'taken'] += 1
    fault = sentence and reading.fault_of(sentence)
    if fault:
        _note(counts, found, 'bad sentences', node, name, value, 'is refused with a bad sentence: %s' % fault)


def _start(kinds, random, pipe, counts, found):
    """Start nodes with some of the values of each parameter."""
    jobs = []
    for node, kind in kinds.items():
        for name, parameter in parameters_of(kind).items():
            given = _given(name, parameter, random, pipe)
            some = [given[index] for index in random.permutation(len(given)) if values.as_xml(given[index])]
            jobs += [(node, kind, name, value) for value in some[:STARTS]]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        outcomes = [pool.submit(_started, node, name, value, 'tortured_%d' % number)
                    for number, (node, kind, name, value) in enumerate(jobs)]
        for (node, kind, name, value), outcome in progress(list(zip(jobs, outcomes)), 'start'):
            told, code, lines = outcome.result()
            if not told:  # the master itself does not take it
                continue
            counts['start'] += 1
            for fault, what in _faults_of_start(kind, name, told, code, lines):
                _note(counts, found, fault, node, name, value, what)
            counts['start', 'taken' if code is None else 'refused'] += 1


def _faults_of_start(kind, name, told, code, lines):
    """[(kind of fault, what it is)] of a node that was started so."""
    if code == 'hangs':
        return [('hangs', 'neither starts nor ends')]
    if any('Traceback' in line for line in lines):
        return [('tracebacks', 'shows a traceback: %s' % lines[-1].strip())]
    if code is None:
        must = told[0] is not None and _refusal(reading.taken, kind, name, told[0])
        return [('others', 'is taken at the start and must not be')] if must else []
    said = [line.partition(']: ')[2].rstrip('\n') for line in lines if '[FATAL]' in line]
    if code != 1 or len(said) != 1:
        return [('others', 'ends it with exit code %s and %d sentences' % (code, len(said)))]
    fault = reading.fault_of(said[0])
    return [('bad sentences', 'ends it with a bad sentence: %s' % fault)] if fault else []


def _started(node, name, value, alias):
    """What becomes of a node with that value: ([the value as the master tells it], exit code, lines).

    The list is empty where the master itself does not take the value, and has
    None where it cannot tell it. The code is None where the node starts.
    """
    parameter = '/%s/%s' % (alias, name)
    master = rosgraph.Master('/torture')
    if not set_parameter(parameter, value):
        return [], None, []
    try:
        told = master.getParam(parameter)
    except Exception:  # whatever its client raises
        told = None
    port = ['_port:=%d' % free_port()] * (node == 'page' and name != 'port')
    program = os.path.join(package_folder(), 'src', node + '.py')
    process = Started(sys.executable, program, '__name:=' + alias, *port)
    end, code = time.monotonic() + PATIENCE_S, 'hangs'
    while time.monotonic() < end and code == 'hangs':
        time.sleep(0.1)
        code = process.process.poll()
        if code is None:
            try:
                master.lookupService('/%s/set_parameters' % alias)
            except rosgraph.MasterError:
                code = 'hangs'
    process.stop()
    process.ends()
    master.deleteParam('/' + alias)
    return [told], code, process.lines
