"""Runs the learner's file. Started as a script by ../process.py, which says what to do.

What is to be done comes over standard input, and what came of it goes back over standard output: lines of JSON,
each followed by as many bytes as it says. The learner's code has neither: it reads nothing, and what it prints
goes to standard error.
"""
import faulthandler
import importlib.util
import json
import os
import sys
import time

leave = os._exit  # the learner's code gets another one


def load(name):
    """A module of this folder, under a name that nobody imports."""
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), name + '.py')
    spec = importlib.util.spec_from_file_location('_trial_' + name, path)
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module
    spec.loader.exec_module(module)
    return module


class Wire:
    """Standard input and output, which the learner's code gets no hold of."""

    def __init__(self):
        self._input = os.fdopen(os.dup(0), 'rb')
        self._output = os.fdopen(os.dup(1), 'wb')
        self._process = os.getpid()
        nothing = os.open(os.devnull, os.O_RDONLY)
        os.dup2(nothing, 0)
        os.close(nothing)
        os.dup2(2, 1)

    def job(self):
        """(job, arrays): what to do, and the arrays that it names by their numbers."""
        import numpy as np
        job = json.loads(self._input.readline())
        arrays = []
        for kind, shape in job['arrays']:
            array = np.empty(shape, kind)
            self._input.readinto(memoryview(array).cast('B') if array.size else bytearray())
            arrays.append(array)
        return job, arrays

    def send(self, record, arrays=()):
        """Tell the other process. A copy of this one, which the learner's code has forked, ends here."""
        if os.getpid() != self._process:
            leave(0)
        record['arrays'] = [(array.dtype.str, array.shape) for array in arrays]
        self._output.write(json.dumps(record).encode() + b'\n')
        for array in arrays:
            self._output.write(memoryview(array).cast('B'))
        self._output.flush()


def limit(memory):
    """Let this process take no more memory than it has plus this many bytes, where the system can do that."""
    try:
        import resource
    except ImportError:
        return  # Windows
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        with open('/proc/self/statm', 'rb') as file:
            taken = int(file.read().split()[0]) * resource.getpagesize()
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (taken + memory, most))
    except (OSError, ValueError):
        pass  # macOS does not limit it, and another limit may be lower already


def unlimit():
    """Let this process take memory again, to tell that it had too little."""
    try:
        import resource
        _, most = resource.getrlimit(resource.RLIMIT_AS)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    except (ImportError, OSError, ValueError):
        pass


class Child:
    """The learner's file, with what is told about it."""

    def __init__(self, wire, job, arrays, trace):
        self._wire = wire
        self._job = job
        self._arrays = arrays
        self._trace = trace
        self._describe = load('describe')
        self._stand_ins = load('stand_ins')
        self._path = job['path']

    def _watch(self, seconds):
        """From now on, the code may take this long. Then the place where it is gets written, and all ends."""
        faulthandler.dump_traceback_later(seconds, exit=True, file=self._trace)

    def _tell_error(self, error, stage, call=0):
        """Tell what the learner's code raised."""
        faulthandler.cancel_dump_traceback_later()
        unlimit()
        record = self._describe.error(error, self._path, self._stand_ins.unread)
        record.update(say='error', stage=stage, call=call)
        self._wire.send(record)

    def _tell_exit(self, status=0):
        """What the learner's code gets as os._exit: tells the line before it leaves."""
        self._wire.send({'say': 'left', 'line': self._describe.line_now(self._path)})
        leave(status if isinstance(status, int) else 1)

    def run(self):
        """Do the job, and tell whatever comes of it."""
        self._stand_ins.put_in(self._path)
        os._exit = self._tell_exit
        sys.dont_write_bytecode = True
        folder = os.path.dirname(self._path)
        sys.path[0] = folder
        sys.argv = [self._path]
        own = os.path.splitext(os.path.basename(self._path))[0]
        name = '__main__' if self._job['function'] is None else own
        module = type(sys)(name)
        module.__file__ = self._path
        sys.modules[name] = module
        self._wire.send({'say': 'ready'})
        self._watch(self._job['load'])
        try:
            with open(self._path, 'rb') as file:
                source = file.read()
            exec(compile(source, self._path, 'exec'), module.__dict__)
        except SystemExit as error:
            if self._job['function'] is not None or error.code not in (None, 0):
                return self._tell_error(error, 'load')
        except BaseException as error:
            return self._tell_error(error, 'load')
        faulthandler.cancel_dump_traceback_later()
        if self._job['function'] is None:
            self._wire.send({'say': 'end', 'baseline': 0.0, 'written': self._stand_ins.written,
                             'refused': self._stand_ins.refused})
            return None
        function = getattr(module, self._job['function'], None)
        if not callable(function):
            self._wire.send({'say': 'missing', 'there': [
                name for name, value in vars(module).items()
                if callable(value) and getattr(value, '__module__', None) == module.__name__][:50]})
            return None
        return self._call(function)

    def _call(self, function):
        """Call the function for each of the calls, and tell what it returned."""
        for number, arguments in enumerate(self._job['calls'], 1):
            values = [self._arrays[value] if is_array else value for is_array, value in arguments]
            if arguments and arguments[0][0]:
                values[0] = values[0].copy()  # what is drawn on a frame must not be on the next
            self._wire.send({'say': 'call', 'call': number})
            self._watch(self._job['call'])
            begin = time.perf_counter()
            try:
                result = function(*values)
                seconds = time.perf_counter() - begin
                faulthandler.cancel_dump_traceback_later()
                images, what = self._describe.images(result, self._job['outputs'])
            except BaseException as error:
                return self._tell_error(error, 'call', number)
            if images is None:
                self._wire.send({'say': 'value', 'call': number, 'what': what})
                return None
            self._wire.send({'say': 'images', 'call': number, 'seconds': seconds}, images)
        self._wire.send({'say': 'end', 'baseline': self._baseline()})
        return None

    def _baseline(self):
        """The median seconds in which OpenCV finds the tags in a frame; 0.0 without frames."""
        import cv2
        import numpy as np
        if not hasattr(cv2, 'aruco'):
            return 0.0
        dictionary = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_6X6_250)
        if hasattr(cv2.aruco, 'ArucoDetector'):
            detect = cv2.aruco.ArucoDetector(dictionary, cv2.aruco.DetectorParameters()).detectMarkers
        else:
            def detect(gray):
                return cv2.aruco.detectMarkers(gray, dictionary)
        seconds = []
        for arguments in self._job['calls'][:5]:
            if not arguments or not arguments[0][0]:
                break
            frame = self._arrays[arguments[0][1]]
            gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY) if frame.ndim == 3 else frame
            begin = time.perf_counter()
            detect(gray)
            seconds.append(time.perf_counter() - begin)
        return float(np.median(seconds)) if seconds else 0.0


def main():
    """Do the one job that comes."""
    wire = Wire()
    import cv2
    import numpy as np
    np.random.seed(0)
    cv2.setRNGSeed(0)
    job, arrays = wire.job()
    with open(sys.argv[1], 'wb', buffering=0) as trace:
        faulthandler.enable(file=trace)
        if hasattr(faulthandler, 'register'):
            import signal
            faulthandler.register(signal.SIGUSR1, file=trace)
        child = Child(wire, job, arrays, trace)
        limit(job['memory'])
        child.run()
        sys.stdout.flush()
        sys.stderr.flush()
        leave(0)  # threads that still run do not hold it up


main()
