"""The public API changes only with a word in the changelog."""
import os
import sys

import pytest


@pytest.fixture
def api(package, monkeypatch):
    monkeypatch.syspath_prepend(os.path.join(package, 'docs'))
    import api
    yield api
    for name in 'api', 'generated':
        sys.modules.pop(name, None)


@pytest.mark.long
def test_every_change_of_the_api_is_named_in_the_changelog(package, api):
    record, changelog = (api.text_of(os.path.join(package, *path)) for path in (
        ('docs', 'reference', 'api.txt'), ('CHANGELOG.rst',)))
    now = api.promises()
    assert len(now) > 500
    # Name it under Forthcoming; if it breaks what others wrote, say what to do instead.
    assert api.unsaid(record.splitlines(), now, changelog) == []


@pytest.mark.parametrize('before, now, unsaid', [
    ([], ['exercise5_6 parameter: ~fit cover'], []),
    ([], ['exercise5_6 parameter: ~fits cover'], ['+ exercise5_6 parameter: ~fits cover']),
    (['all.launch argument: old 1'], [], ['- all.launch argument: old 1']),
    (['unit5/Tag field: id int32'], ['unit5/Tag field: id int64'], [
        '- unit5/Tag field: id int32', '+ unit5/Tag field: id int64']),
    (['aruco_ar name: Tag(id, corners)'], ['aruco_ar name: Tag(id, corners, likeness)'], []),
    (['aruco_ar name: Tag.center'], [], ['- aruco_ar name: Tag.center'])])
def test_what_the_changelog_does_not_name_is_found(api, before, now, unsaid):
    changelog = '''Changelog

Forthcoming
-----------
* ~fit of 5.6 takes another value, and Tag likeness.

0.1.0
-----
* old, id and ~fits
'''
    assert api.unsaid(before, now, changelog) == unsaid
