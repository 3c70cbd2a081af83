"""The page's OpenAPI description, page/openapi.yaml, matches the addresses that the server has."""
import asyncio
import os
import re
from threading import Event

import yaml
from page_server import picture_folder
from page_server.handlers import Unknown
from page_server.live import Live
from page_server.server import application
from rig.processes.started import WAIT_S
from tornado.web import RequestHandler


def test_all_addresses_and_methods_are_described(package):
    with open(os.path.join(package, 'page', 'openapi.yaml')) as file:
        paths = yaml.safe_load(file)['paths']
    described = {(path, method) for path, methods in paths.items() for method in methods}
    rules = application(None).wildcard_router.rules
    assert len(rules) > 6
    served = set()
    for rule in rules:
        path = re.sub(r'\((?!\?).*\)', '{file}', rule.matcher.regex.pattern.rstrip('$'))
        assert rule.target is not Unknown
        served |= {(path, method.lower()) for method in RequestHandler.SUPPORTED_METHODS
                   if getattr(rule.target, method.lower()) is not RequestHandler.options}
    assert ('/live', 'get') in served and Live.get is not RequestHandler.options
    assert described == served


def test_every_file_of_the_page_is_allowed_by_the_description(package):
    with open(os.path.join(package, 'page', 'openapi.yaml')) as file:
        pattern = yaml.safe_load(file)['paths']['/page/{file}']['get']['parameters'][0]['schema']['pattern']
    files = [name for name in os.listdir(os.path.join(package, 'page')) if not name.endswith('.html')]
    assert len(files) > 6 and all(re.search(pattern, name) for name in files)


def test_only_pictures_inside_the_folder_can_be_chosen(tmp_path, monkeypatch):
    (tmp_path / 'images').mkdir()
    (tmp_path / 'secret.png').touch()
    for name in ('b.png', 'a.png', '.hidden.png', 'new\nline.png'):
        (tmp_path / 'images' / name).touch()
    (tmp_path / 'images' / 'folder').mkdir()
    (tmp_path / 'images' / 'out.png').symlink_to(tmp_path / 'secret.png')
    (tmp_path / 'images' / 'nowhere.png').symlink_to('missing.png')
    (tmp_path / 'images' / 'in.png').symlink_to('a.png')
    monkeypatch.setattr(picture_folder, 'package_folder', lambda: str(tmp_path))
    assert picture_folder.PictureFolder(lambda: None).names == ['a.png', 'b.png', 'in.png']


def test_a_file_system_that_hangs_does_not_hang_the_server(monkeypatch):
    names = iter([['a.png'], ['a.png', 'b.png'], ['a.png', 'b.png', 'c.png'], ['a.png']])
    reached, goes_on = Event(), Event()

    def hang():
        if names.__length_hint__() < 4:
            reached.set()
            assert goes_on.wait(WAIT_S)
        return next(names)
    monkeypatch.setattr(picture_folder, 'list_names', hang)
    changed = Event()
    folder = picture_folder.PictureFolder(changed.set)
    for _ in range(3):
        folder.refresh()
    assert reached.wait(WAIT_S) and folder.names == ['a.png']  # the folder is being listed
    goes_on.set()
    assert changed.wait(WAIT_S) and folder.names == ['a.png', 'b.png']
    assert asyncio.run(folder.has('c.png')) and not asyncio.run(folder.has('d.png'))
