"""Parameters: each one of each node is set to invalid and to extreme values."""
import os
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import rosgraph
from aruco_ar.base.progress import progress
from aruco_ar.settings.declaration import parameters_of
from aruco_node.parameters.settings import AREA_ENTRIES, PictureSettings
from hostile.parameters import validation, values
from hostile.parameters.configs import set_parameter
from rig.nodes.case import NODES
from rig.nodes.master import Master
from rig.page.server import free_port
from rig.processes.started import Started, program

from .live_parameters import Live

# Values of each parameter: at the start of a node, and while it runs.
START_VALUES, LIVE_VALUES = 3, 40
MAX_NODES = 3  # at a time
TIMEOUT_S = 30


def run(seconds, seed):
    """Set all parameters. Returns a sentence for each fault found."""
    end = time.monotonic() + (seconds or 0)
    kinds = {node: validation.settings_of(node) for node in NODES}
    counts, found = Counter(), {}
    with Master(), tempfile.TemporaryDirectory() as folder:
        while True:
            random = np.random.RandomState(seed)
            _read(kinds, random, folder, counts, found)
            _start(kinds, random, values.pipe(folder), counts, found)
            with Live(kinds, counts, found) as live:
                live.set_values(random, LIVE_VALUES)
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
                        ('live', 'requests to running nodes'), ('odd', 'odd requests to running nodes')):
        print('%6d %s: %d accepted, %d refused with a sentence' % (
            counts[where], what, counts[where, 'accepted'], counts[where, 'refused']))
    print('%6d frames and pages answered in between' % counts['answers'])
    for fault in 'tracebacks', 'deaths', 'hangs', 'bad sentences', 'others':
        print('%6d %s (target: 0)' % (counts[fault], fault))


def _note(counts, found, kind, node, name, value, what):
    """Count a fault, and report it once for each parameter and kind."""
    counts[kind] += 1
    found.setdefault('%s: ~%s %s' % (node, name, what), 'with ' + ascii(value)[:80])


def _values_for(name, parameter, random, pipe):
    """All values to try for a parameter. If it may be a path, a pipe is one of them."""
    given = values.values(parameter, random)
    return given + [pipe] if 'path' in parameter.kind.allowed else given


def _refusal(read, *arguments):
    """Like validation.refusal, but raises an error if it takes too long or too much memory."""
    with validation.bounded():
        return validation.refusal(read, *arguments)


def _read(kinds, random, folder, counts, found):
    """Read all values of all parameters, and of the entries of a file of areas, without nodes."""
    parameters = {(kind.__name__, name): (node, kind, name, parameter) for node, kind in kinds.items()
                  for name, parameter in parameters_of(kind).items()}  # those that nodes share, only once
    for node, kind, name, parameter in progress(parameters.values(), 'read'):
        for value in _values_for(name, parameter, random, values.pipe(folder)):
            _read_one(node, name, value, counts, found, validation.taken, kind, name, value)
    path, entries = os.path.join(folder, 'areas.yaml'), parameters_of(PictureSettings)
    for name in progress(AREA_ENTRIES, 'areas'):
        for value in values.short(_values_for(name, entries[name], random, values.pipe(folder))):
            _read_one('areas', name, value, counts, found, validation.area_taken, path, name, value)


def _read_one(node, name, value, counts, found, *read):
    counts['read'] += 1
    try:
        sentence = _refusal(*read)
    except validation.Stuck as error:
        _note(counts, found, 'hangs', node, name, value, 'hangs: %s' % error)
        return
    except Exception as error:
        _note(counts, found, 'tracebacks', node, name, value, 'raises %s' % type(error).__name__)
        return
    counts['read', 'refused' if sentence else 'accepted'] += 1
    fault = sentence and validation.fault_of(sentence)
    if fault:
        _note(counts, found, 'bad sentences', node, name, value, 'is refused with a bad sentence: %s' % fault)


def _start(kinds, random, pipe, counts, found):
    """Start nodes with some of the values of each parameter."""
    jobs = []
    for node, kind in kinds.items():
        for name, parameter in parameters_of(kind).items():
            given = _values_for(name, parameter, random, pipe)
            some = [given[index] for index in random.permutation(len(given)) if values.as_xml(given[index])]
            jobs += [(node, kind, name, value) for value in some[:START_VALUES]]
    with ThreadPoolExecutor(MAX_NODES) as pool:
        outcomes = [pool.submit(_start_node, node, name, value, 'tortured_%d' % number)
                    for number, (node, kind, name, value) in enumerate(jobs)]
        for (node, kind, name, value), outcome in progress(list(zip(jobs, outcomes)), 'start'):
            stored, code, lines = outcome.result()
            if not stored:  # the master itself refuses the value
                continue
            counts['start'] += 1
            for fault, what in _faults_of_start(kind, name, stored, code, lines):
                _note(counts, found, fault, node, name, value, what)
            counts['start', 'accepted' if code is None else 'refused'] += 1


def _faults_of_start(kind, name, stored, code, lines):
    """[(kind of fault, description)] of the start of a node. For the arguments, see _start_node."""
    if code == 'hangs':
        return [('hangs', 'neither starts nor ends')]
    if any('Traceback' in line for line in lines):
        return [('tracebacks', 'prints a traceback: %s' % lines[-1].strip())]
    if code is None:
        refusal = stored[0] is not None and _refusal(validation.taken, kind, name, stored[0])
        return [('others', 'is accepted at the start, but must not be')] if refusal else []
    sentences = [line.partition(']: ')[2].rstrip('\n') for line in lines if '[FATAL]' in line]
    if code != 1 or len(sentences) != 1:
        return [('others', 'ends the node with exit code %s and %d sentences' % (code, len(sentences)))]
    fault = validation.fault_of(sentences[0])
    return [('bad sentences', 'ends the node with a bad sentence: %s' % fault)] if fault else []


def _start_node(node, name, value, alias):
    """Start a node with that value: ([the value that the master has stored], exit code, lines).

    The list is empty if the master itself refuses the value, and has None if
    the master cannot return it. The exit code is None if the node starts.
    """
    parameter = '/%s/%s' % (alias, name)
    master = rosgraph.Master('/torture')
    if not set_parameter(parameter, value):
        return [], None, []
    try:
        stored = master.getParam(parameter)
    except Exception:  # its client may raise anything
        stored = None
    port = ['_port:=%d' % free_port()] * (node == 'page' and name != 'port')
    process = Started(sys.executable, program(node + '.py'), '__name:=' + alias, *port)
    end, code = time.monotonic() + TIMEOUT_S, 'hangs'
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
    return [stored], code, process.lines
