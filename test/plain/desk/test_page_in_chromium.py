"""The page of aruco-ar in a browser, which decodes H.264, and whose camera films for the page."""
import os
import sys
from contextlib import contextmanager

import cv2
import numpy as np
import pytest
from aruco_ar.simulation.robot import Path, Pose
from rig.accuracy.drives import drive
from rig.page.browser import WAIT_MS, browser_path
from rig.page.server import free_port
from rig.processes.started import Started

pytestmark = pytest.mark.long
PAINTED = '[data-topic="/exercise5_6/image"]'
GREEN = (0, 200, 0)
# Whether a canvas is green in the middle of the area.
IS_GREEN = '''([selector, x, y]) => {
  const canvas = document.querySelector(selector + ' canvas');
  const [red, green, blue] = canvas.getContext('2d').getImageData(
      x * canvas.width, y * canvas.height, 1, 1).data;
  return red < 20 && Math.abs(green - 200) < 20 && blue < 20;
}'''


@pytest.fixture(scope='module')
def wall(tmp_path_factory):
    """A clip of a simulated wall that stands still, and the middle of its area, as shares of the frame."""
    frame = next(drive(Path(Pose(-1.6, 0.0, 0.0), ((1, 0, 0),)), 1))
    path = str(tmp_path_factory.mktemp('camera') / 'camera.mjpeg')  # Chromium reads no other kinds
    with open(path, 'wb') as file:
        for _ in range(100):
            file.write(cv2.imencode('.jpg', frame.image, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes())
    return path, (frame.corners.mean(axis=0) / frame.image.shape[1::-1]).tolist()


@contextmanager
def opened(folder, clip, query, *options):
    """The page of aruco-ar with these options in Chromium, whose camera shows a clip."""
    playwright = pytest.importorskip('playwright.sync_api')
    if browser_path() is None:
        pytest.skip('Chromium is not installed')
    cv2.imwrite(str(folder / 'green.png'), np.full((30, 40, 3), GREEN, np.uint8))
    port = free_port()
    command = Started(sys.executable, '-c', 'import sys; from aruco_desk.command import main; sys.exit(main())',
                      'paint', '--picture', str(folder / 'green.png'), '--port', str(port), *options)
    try:
        address = command.wait_for(':%d' % port)
        with playwright.sync_playwright() as play:
            browser = play.chromium.launch(executable_path=browser_path(), args=[
                '--disable-gpu', '--use-fake-ui-for-media-stream', '--use-fake-device-for-media-stream',
                '--use-file-for-fake-video-capture=' + clip, *['--no-sandbox'] * (os.getuid() == 0)])
            context = browser.new_context(ignore_https_errors=True, permissions=['camera'])
            page = context.new_page()
            page.set_default_timeout(WAIT_MS)
            scheme = 'https' if 'https' in address else 'http'
            page.goto('%s://localhost:%d/%s' % (scheme, port, query))
            yield page
            browser.close()
    finally:
        command.stop()


def test_the_browser_decodes_h264(tmp_path, wall):
    clip, middle = wall
    with opened(tmp_path, clip, '?h264', '--camera', clip) as page:
        page.evaluate('''() => {
            const decode = VideoDecoder.prototype.decode;
            VideoDecoder.prototype.decode = function (chunk) {
                window.decoded = true;
                return decode.call(this, chunk);
            };
        }''')
        page.wait_for_function(IS_GREEN, arg=[PAINTED, *middle])
        page.wait_for_function('() => window.decoded')
        page.click(PAINTED + ' .view')  # another size, so the stream begins anew
        page.wait_for_function('''(selector) =>
            document.querySelector(selector + ' canvas').width >= 640''', arg=PAINTED)
        page.wait_for_function(IS_GREEN, arg=[PAINTED, *middle])


def test_the_browser_films(tmp_path, wall):
    clip, middle = wall
    with opened(tmp_path, clip, '', '--phone') as page:
        page.click('#film button')
        page.wait_for_function(IS_GREEN, arg=[PAINTED, *middle])
        page.click('#film button')
        page.wait_for_function('''(selector) =>
            document.querySelector(selector + ' .why').textContent.includes('No phone films')''', arg=PAINTED)
