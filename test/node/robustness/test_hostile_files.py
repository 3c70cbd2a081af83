"""Hostile files: each is accepted, or refused with a sentence, and takes little memory."""
import json
import os
import re
import signal
import subprocess
import sys

import pytest
from aruco_ar import InputError
from aruco_ar.base.files import write_whole
from aruco_ar.painting.sources import open_source
from hostile.files.png import png
from hostile.files.samples import GIGANTIC, animation, video

MAX_MB = 1000  # of the process that opens the files: a little more than the largest allowed picture needs


@pytest.fixture(scope='module')
def opened(tmp_path_factory, package):
    """The results of opening all hostile files, and the process that opened them."""
    test = os.path.join(package, 'test')
    environment = dict(os.environ, PYTHONPATH=os.pathsep.join([test, os.environ.get('PYTHONPATH', '')]))
    done = subprocess.run([sys.executable, os.path.join(test, 'hostile', 'files', 'open_all.py'),
                           str(tmp_path_factory.mktemp('hostile')), '1'],
                          capture_output=True, env=environment)
    results = [json.loads(line) for line in done.stdout.splitlines()]
    assert done.returncode == 0, 'after %s: %s' % (results[-1:], done.stderr.decode())
    return results, done


def shown(path):
    """How a sentence shows a path, at most its beginning."""
    return ''.join(each if each.isprintable() else each.encode('unicode_escape').decode()
                   for each in path)[:200]


def test_no_hostile_file_makes_a_loader_crash_or_hang(opened):
    assert len(opened[0]) > 500
    assert [result for result in opened[0] if result['fault']] == []


def test_bad_pictures_are_refused_and_odd_but_good_ones_are_accepted(opened):
    wrong = [(result['name'], result['refusal']) for result in opened[0] if result['loader'] == 'picture'
             and result['is_picture'] is not None and (result['refusal'] is None) != result['is_picture']]
    assert wrong == []


def test_no_hostile_file_is_accepted_as_yaml(opened):
    assert [(result['name'], result['loader']) for result in opened[0]
            if result['loader'] != 'picture' and result['refusal'] is None] == []


def test_each_refusal_is_a_sentence_that_names_the_file(opened):
    for result in opened[0]:
        refusal = result['refusal']
        if refusal is not None:
            assert shown(result['path']) in refusal, result
            assert (refusal[0].isupper() or refusal[0] == '"') and refusal[-1] == '.', refusal
            assert refusal.isprintable() and len(refusal) <= 500, refusal


def test_no_hostile_file_takes_much_memory(opened):
    most = max(opened[0], key=lambda result: result['peak_mb'])
    assert most['peak_mb'] < MAX_MB, most


def test_nothing_is_printed(opened):
    assert opened[1].stderr == b''


@pytest.fixture
def watchdog():
    """Fails the test if it hangs."""
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail('the test hangs'))
    signal.alarm(60)
    yield
    signal.alarm(0)


def gigantic(path):
    with open(path, 'r+b') as file:
        file.truncate(GIGANTIC)


def replace(path, data):
    with open(path + '.new', 'wb') as file:
        file.write(data)
    os.replace(path + '.new', path)


def pipe(path):
    os.unlink(path)
    os.mkfifo(path)


@pytest.mark.parametrize('kind, data', [('a.gif', animation('GIF')), ('a.webp', animation('WEBP')),
                                        ('a.mp4', video('.mp4', 'mp4v')), ('a.avi', video('.avi', 'MJPG'))])
@pytest.mark.parametrize('change', [
    os.unlink, pipe, gigantic, lambda path: os.truncate(path, 0), lambda path: os.truncate(path, 300),
    lambda path: replace(path, png(60000, 60000)), lambda path: replace(path, b'#EXTM3U\n'),
    lambda path: (os.unlink(path), os.mkdir(path))],
    ids=['deleted', 'a pipe', 'gigantic', 'empty', 'cut', 'a bomb', 'a list', 'a folder'])
def test_a_clip_whose_file_changes_plays_on_or_keeps_its_last_picture(tmp_path, watchdog, kind, data, change):
    path, sentences = str(tmp_path / kind), []
    replace(path, data)
    clip = open_source(path, sentences.append)
    shape = clip.at(0).shape
    change(path)
    assert all(clip.at(number * 0.1).shape == shape for number in range(20))
    assert len(sentences) <= 1
    assert all(path in sentence and 'last picture stays' in sentence for sentence in sentences)


@pytest.mark.parametrize('path, reason', [
    ('n' * 256, 'File name too long'), ('folder', 'Is a directory'), ('a\0b.png', 'null'),
    ('link/a.png', 'File exists|symbolic links'), ('file/a.png', 'Not a directory|File exists'),
    ('a\ud800.png', 'surrogates'),
    ('/proc/unit5/a.png', 'No such file')])
def test_a_file_that_cannot_be_written_is_explained_and_nothing_is_left(tmp_path, path, reason):
    (tmp_path / 'folder').mkdir()
    (tmp_path / 'file').write_bytes(b'before')
    os.symlink('link', str(tmp_path / 'link'))
    target = os.path.join(str(tmp_path), path)
    with pytest.raises(InputError, match=reason) as error:
        write_whole(target, b'after')
    assert shown(target) in str(error.value) and re.search('another place', str(error.value))
    assert sorted(os.listdir(str(tmp_path))) == ['file', 'folder', 'link']
    assert (tmp_path / 'file').read_bytes() == b'before'
