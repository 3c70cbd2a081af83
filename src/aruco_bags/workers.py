"""Processes bags in several processes, or on a cluster, with Dask."""
import asyncio
import logging
import os
import signal
from contextlib import contextmanager
from multiprocessing import resource_tracker

from aruco_ar.base.errors import InputError
from aruco_ar.base.progress import progress, tell
from distributed import Client, KilledWorker, LocalCluster, as_completed

from .job import write_table

SCHEDULER_S = 10  # time limit for a scheduler to answer, and to have a worker
START_S = 30      # time limit for the processes on this machine to start
# For the processes on this machine. This module prints what matters of their logs; a profile of their work
# would take ever more memory.
QUIET = {'DASK_LOGGING__DISTRIBUTED': 'critical', 'DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED': 'False'}
_CRASHED = 'The processes that worked on it have crashed several times. Is there enough memory?'


@contextmanager
def workers(scheduler, count):
    """A context manager with a Dask Client: of a scheduler or, if that is None, of ``count`` processes here.

    Raises InputError if there are no workers.
    """
    logging.disable(logging.CRITICAL)  # this module says what it means when a worker or the scheduler ends
    if scheduler is None:
        with _processes(count) as client:
            yield client
        return
    try:
        client = Client(scheduler, timeout=SCHEDULER_S)
    except Exception as error:  # OSError, or another one if the address is malformed
        raise InputError('The scheduler %s does not answer (%s). Start it: dask scheduler'
                         % (scheduler, _sentence(error))) from None
    with client:
        _await_worker(client, SCHEDULER_S, 'The scheduler %s has no workers. Start some: dask worker %s '
                                           '--nthreads 1' % (scheduler, scheduler))
        yield client


@contextmanager
def _processes(count):
    os.environ.update(QUIET)
    # The processes inherit the blocked signal. Ctrl-C goes to all processes of a terminal, but only this one
    # must react: it ends the others.
    resource_tracker.ensure_running()  # now, since starting it later would unblock the signal
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    with LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address='127.0.0.1:0',
                      host='127.0.0.1', death_timeout=START_S) as cluster, Client(cluster) as client:
        cluster.scale(count)
        _await_worker(client, START_S, 'The processes that work on bags do not start. Is there enough memory?')
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        yield client


def _await_worker(client, seconds, sentence):
    try:
        client.wait_for_workers(1, timeout=seconds)
    except asyncio.TimeoutError:
        raise InputError(sentence) from None


def work(jobs, client, folder):
    """Do Jobs, and write the table of all bags in their folder. Prints how each Job ends.

    Returns how many frames were processed, and whether all Jobs are done. Raises InputError if the table
    cannot be written, or if the scheduler has ended.
    """
    for job in jobs:
        if job.is_done():
            tell('%s is done already' % job.bag)
    frames = _Work(client).do([job for job in jobs if not job.is_done()])
    write_table(folder)
    return frames, all(job.is_done() for job in jobs)


class _Work:
    """Submits the parts of Jobs, and collects their results."""

    def __init__(self, client):
        self._client, self._frames, self._failed, self._printed = client, 0, set(), set()

    def do(self, jobs):
        """Do the Jobs. Returns how many frames were processed."""
        plans = {}
        for job, (plan, notes) in self._done({self._submit(job.pieces): job for job in jobs}, 'bags, to index'):
            plans[job] = plan
            self._tell_once(job, notes)
        # In the order in which the bags were given, not in which they were indexed.
        pieces = {self._submit(job.annotate, piece): job for job in jobs for piece in plans.get(job, [])}
        left, joins = {job: len(plan) for job, plan in plans.items()}, {}
        for job, (frames, faults) in self._done(pieces, 'pieces'):
            self._frames += frames
            self._tell_once(job, faults)
            left[job] -= 1
            if not left[job]:
                # Before further pieces, since until then this bag's output is on the disk twice.
                joins[self._submit(job.join, plans[job], priority=1)] = job
        for job, _ in self._done(joins, 'bags, to join'):
            tell('Wrote %s' % job.bag)
        return self._frames

    def _tell_once(self, job, sentences):
        for sentence in sentences:
            if (job, sentence) not in self._printed:
                self._printed.add((job, sentence))
                tell('Bag "%s": %s' % (job.path, sentence))

    def _submit(self, work, *arguments, priority=0):
        return self._client.submit(_tried, work, *arguments, pure=False, priority=priority)

    def _done(self, futures, title):
        """(job, result) of futures, {future: job}, as they finish. Prints the first failure of each Job."""
        for future in progress(as_completed(futures), title, len(futures)):
            job = futures[future]
            if future.status not in ('finished', 'error'):
                raise InputError('The scheduler has ended. When it runs again, the same command continues from '
                                 'here.')
            error = future.exception()  # of a worker; errors of the work are in the result
            result, sentence = (None, _sentence(error)) if error else future.result()
            if sentence is None:
                yield job, result
            elif job not in self._failed:
                self._failed.add(job)
                tell('The bag "%s" cannot be processed: %s' % (job.path, sentence))


def _tried(work, *arguments):
    """(what ``work`` returns, None), or (None, a sentence) if it raises.

    Dask would print the whole traceback.
    """
    try:
        return work(*arguments), None
    except Exception as error:
        return None, _sentence(error)


def _sentence(error):
    return _CRASHED if isinstance(error, KilledWorker) else ' '.join(str(error).split()) or type(error).__name__
