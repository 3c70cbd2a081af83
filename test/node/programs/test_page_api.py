"""The page's OpenAPI description, web/openapi.yaml, matches the addresses that the server has."""
import os
import re

import yaml
from page_server import shelf
from page_server.handlers import Unknown
from page_server.live import Live
from page_server.server import application
from tornado.web import RequestHandler


def test_all_addresses_and_methods_are_described(package):
    with open(os.path.join(package, 'web', 'openapi.yaml')) as file:
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
    with open(os.path.join(package, 'web', 'openapi.yaml')) as file:
        pattern = yaml.safe_load(file)['paths']['/page/{file}']['get']['parameters'][0]['schema']['pattern']
    files = [name for name in os.listdir(os.path.join(package, 'web')) if not name.endswith('.html')]
    assert len(files) > 6 and all(re.search(pattern, name) for name in files)


def test_only_pictures_inside_the_folder_can_be_chosen(tmp_path):
    (tmp_path / 'images').mkdir()
    (tmp_path / 'secret.png').touch()
    for name in ('b.png', 'a.png', '.hidden.png', 'new\nline.png'):
        (tmp_path / 'images' / name).touch()
    (tmp_path / 'images' / 'folder').mkdir()
    (tmp_path / 'images' / 'out.png').symlink_to(tmp_path / 'secret.png')
    (tmp_path / 'images' / 'nowhere.png').symlink_to('missing.png')
    (tmp_path / 'images' / 'in.png').symlink_to('a.png')
    assert shelf.files_in(str(tmp_path / 'images')) == ['a.png', 'b.png', 'in.png']
    assert shelf.files_in(str(tmp_path / 'nowhere')) == []
