"""Bags looked at by many, with Dask: what is to do, and who does it."""
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

PATIENCE_S = 10  # with a scheduler
BEGIN_S = 30     # that processes here may take to begin
# Of the processes here: what they would log is said here; notes of their time would take ever more memory.
QUIET = {'DASK_LOGGING__DISTRIBUTED': 'critical', 'DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED': 'False'}
_ENDED = 'The processes that looked at it have ended, several times. Is there enough memory?'


@contextmanager
def workers(scheduler, count):
    """A Client of that scheduler or, where it is None, of so many processes here. Raises InputError."""
    logging.disable(logging.CRITICAL)  # what the end of a worker or of the scheduler means is said here
    if scheduler is None:
        with _processes(count) as client:
            yield client
        return
    try:
        client = Client(scheduler, timeout=PATIENCE_S)
    except Exception as error:  # OSError, and of an odd address others
        raise InputError('The scheduler %s does not answer (%s). Start it: dask scheduler'
                         % (scheduler, _sentence(error))) from None
    with client:
        _await_one(client, PATIENCE_S, 'The scheduler %s has no workers. Start some: dask worker %s '
                                       '--nthreads 1' % (scheduler, scheduler))
        yield client


@contextmanager
def _processes(count):
    os.environ.update(QUIET)
    # They inherit that Ctrl-C is not for them: it goes to all processes of a terminal, and this one ends them.
    resource_tracker.ensure_running()  # which would unblock it again
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    with LocalCluster(n_workers=0, threads_per_worker=1, dashboard_address='127.0.0.1:0',
                      host='127.0.0.1', death_timeout=BEGIN_S) as cluster, Client(cluster) as client:
        cluster.scale(count)
        _await_one(client, BEGIN_S, 'The processes that look at bags do not begin. Is there enough memory?')
        signal.pthread_sigmask(signal.SIG_UNBLOCK, [signal.SIGINT])
        yield client


def _await_one(client, seconds, sentence):
    try:
        client.wait_for_workers(1, timeout=seconds)
    except asyncio.TimeoutError:
        raise InputError(sentence) from None


def work(jobs, client, folder):
    """Do Jobs, and write the table of all that is in their folder; prints what becomes of each.

    Returns how many frames were looked at, and whether all Jobs are done. Raises InputError if the table
    cannot be written, or the scheduler is gone.
    """
    for job in jobs:
        if job.is_done():
            tell('%s is done already' % job.bag)
    frames = _Work(client).do([job for job in jobs if not job.is_done()])
    write_table(folder)
    return frames, all(job.is_done() for job in jobs)


class _Work:
    """Jobs on their way."""

    def __init__(self, client):
        self._client, self._frames, self._failed, self._said = client, 0, set(), set()

    def do(self, jobs):
        """Do them; how many frames were looked at."""
        plans = dict(self._done({self._submit(job.pieces): job for job in jobs}, 'bags, to look into'))
        # In the order in which they were given, not that in which their plans were made.
        pieces = {self._submit(job.annotate, piece): job for job in jobs for piece in plans.get(job, [])}
        left, joins = {job: len(plan) for job, plan in plans.items()}, {}
        for job, (frames, faults) in self._done(pieces, 'pieces'):
            self._frames += frames
            for fault in faults:
                if (job, fault) not in self._said:
                    self._said.add((job, fault))
                    tell('Of the bag "%s": %s' % (job.path, fault))
            left[job] -= 1
            if not left[job]:
                # Before further pieces: until then this bag takes its place on the disk twice.
                joins[self._submit(job.join, plans[job], priority=1)] = job
        for job, _ in self._done(joins, 'bags, to put together'):
            tell('Wrote %s' % job.bag)
        return self._frames

    def _submit(self, work, *arguments, priority=0):
        return self._client.submit(_tried, work, *arguments, pure=False, priority=priority)

    def _done(self, futures, title):
        """(job, result) of futures, {future: job}, as they come; the first that fails of a job is said."""
        for future in progress(as_completed(futures), title, len(futures)):
            job = futures[future]
            if future.status not in ('finished', 'error'):
                raise InputError('The scheduler is gone. When it is back, the same command goes on where this '
                                 'one was.')
            error = future.exception()  # of a worker, not of what it did
            result, sentence = (None, _sentence(error)) if error else future.result()
            if sentence is None:
                yield job, result
            elif job not in self._failed:
                self._failed.add(job)
                tell('The bag "%s" cannot be done: %s' % (job.path, sentence))


def _tried(work, *arguments):
    """What work returns, and None; or None, and what was wrong. Dask would print all that it knows of that."""
    try:
        return work(*arguments), None
    except Exception as error:
        return None, _sentence(error)


def _sentence(error):
    return _ENDED if isinstance(error, KilledWorker) else ' '.join(str(error).split()) or type(error).__name__
