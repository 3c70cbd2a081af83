"""The base of the rostests that open the page in Chromium."""
import os
import shutil

from rig.page.server import ServerTest
from rig.processes.skip import skip
from rig.processes.started import WAIT_S

BROWSERS = 'chromium', 'chromium-browser', 'google-chrome'
WAIT_MS = 1000 * WAIT_S
OPTIONS = ['--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
           '--disable-component-update', '--disable-sync']


def browser_path():
    """The path of the browser, or None if it is not installed."""
    return next(filter(None, map(shutil.which, BROWSERS)), None)


class BrowserTest(ServerTest):
    """Opens the page as ``page``. ``tiles``: how many tiles it has.

    An error on its console fails the test unless it contains ``expected``.
    """

    tiles = 6

    @classmethod
    def setUpClass(cls):
        path = browser_path()
        if path is None:
            skip(cls.__name__, 'Chromium is not installed')
        from playwright.sync_api import sync_playwright
        super().setUpClass()
        cls.playwright = sync_playwright().start()
        sandbox = ['--no-sandbox'] if os.getuid() == 0 else []
        cls.browser = cls.playwright.chromium.launch(executable_path=path, args=OPTIONS + sandbox,
                                                     timeout=WAIT_MS)

    @classmethod
    def tearDownClass(cls):
        cls.browser.close()
        cls.playwright.stop()
        super().tearDownClass()

    def setUp(self):
        self.page = self.browser.new_page(viewport={'width': 1400, 'height': 900})
        self.page.set_default_timeout(WAIT_MS)
        self.errors, self.requested, self.expected = [], [], ''
        self.page.on('pageerror', lambda error: self.errors.append(str(error)))
        self.page.on('console', lambda line: self.errors.append(line.text) if line.type == 'error' else None)
        self.page.on('request', lambda request: self.requested.append(request.url))
        self.page.goto('http://localhost:%d/' % self.port)
        self.page.wait_for_function(
            '''(tiles) => document.querySelectorAll('.tile .why[hidden]').length == tiles &&
                     [...document.querySelectorAll('.latency')].every(
                         (text) => /^[0-9]/.test(text.textContent))''', arg=self.tiles)

    def tearDown(self):
        self.assertEqual([each for each in self.errors if not self.expected or self.expected not in each], [])
        self.page.close()

    def wait_for_text(self, selector, words):
        """Wait until all elements that match the selector contain these words; there must be at least one."""
        self.page.wait_for_function(
            '''([selector, words]) => {
                 const texts = [...document.querySelectorAll(selector)].map((element) => element.textContent);
                 return texts.length > 0 && texts.every((text) => text.includes(words));
               }''', arg=[selector, words])
