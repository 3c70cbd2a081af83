"""What a browser shows of a camera: how old it is, by a time code in it, and how many bytes it takes."""
import asyncio
import os
import threading
import time
from functools import partial

import cv2
import numpy as np
from aruco_ar.settings.settings import PictureSettings
from aruco_desk.page import HERE, DeskSite
from aruco_desk.studio import Studio
from page_server.server import listen
from playwright.sync_api import sync_playwright
from rig.accuracy.drives import LIVELY, drive
from rig.page.browser import browser_path
from rig.page.server import free_port

RATE = 20          # frames per second
SECONDS = 15
BITS, BLOCK_PX = 20, 24  # of the time code, in milliseconds, in the top left of the frame; dark is 0
CAMERA, PAINTED = '/camera/rgb/image_raw', '/exercise5_6/image'
# Reads the time code of a tile whenever something has been drawn: the ages of what is shown, milliseconds.
WATCH = '''([topic, bits]) => {
  const canvas = document.querySelector(`[data-topic="${topic}"] canvas`);
  const context = canvas.getContext('2d');
  window.ages = [];
  let last = null;
  const look = () => {
    const side = 24 * canvas.width / 640;
    let code = 0;
    const row = context.getImageData(0, 0, Math.ceil(bits * side), Math.ceil(side));
    for (let bit = 0; bit < bits; bit++) {
      const at = 4 * (Math.floor(side / 2) * row.width + Math.floor((bit + .5) * side));
      code = 2 * code + (row.data[at] > 127);
    }
    if (code !== last) {
      last = code;
      window.ages.push((Date.now() - code) & ((1 << bits) - 1));
    }
    requestAnimationFrame(look);
  };
  requestAnimationFrame(look);
}'''


def run():
    """Measure the page with JPEG and with H.264, of a simulated drive, and print the table."""
    frames = [frame.image for frame in drive(LIVELY, 20 * RATE, noise=2.0)]
    port = free_port()
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=serve, args=(loop, port, frames), daemon=True)
    thread.start()
    print('\nThe page of aruco-ar in headless Chromium on the same machine: one image of 640 x 480 at %d Hz.\n'
          'The age is that of the time code in what is shown, from the camera to the screen.\n' % RATE)
    print('%-9s %-18s %9s %14s %11s %8s %10s' % (
        'sent as', 'image', 'frames/s', 'age, median', '99 %', 'kbit/s', 'server, %'))
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=browser_path(),
                                       args=['--no-sandbox'] * (os.getuid() == 0))
        for name, query in ('JPEG', ''), ('H.264', '?h264'):
            for topic in CAMERA, PAINTED:
                ages, rate, load = watch(browser, 'http://localhost:%d/%s' % (port, query), topic)
                print('%-9s %-18s %9.1f %11.0f ms %8.0f ms %8.0f %10.0f' % (
                    name, topic.rpartition('/')[0][1:], len(ages) / SECONDS, np.median(ages),
                    np.percentile(ages, 99), rate, load))
        browser.close()
    loop.call_soon_threadsafe(loop.stop)
    thread.join()


def serve(loop, port, frames):
    """Serve the page of a camera that shows frames with a time code, until the loop is stopped."""
    asyncio.set_event_loop(loop)
    site = DeskSite(partial(Studio, partial(filmed, frames), PictureSettings(), True, None), loop)
    server = listen(site, HERE, port)
    loop.run_forever()
    server.stop()
    site.end()


def filmed(frames):
    """(seconds, frame) at RATE, again and again, each with the time in it."""
    began = time.monotonic()
    for number in range(10**9):
        time.sleep(max(0.0, began + number / RATE - time.monotonic()))
        stamp = time.time()
        yield stamp, with_code(frames[number % len(frames)], round(1000 * stamp))


def with_code(frame, code):
    """A copy of a frame with the last BITS of a number in its top left corner."""
    frame = frame.copy()
    bits = [code >> bit & 1 for bit in reversed(range(BITS))]
    row = np.uint8(bits) * 255
    frame[:BLOCK_PX, :BITS * BLOCK_PX] = cv2.resize(row[None], None, fx=BLOCK_PX, fy=BLOCK_PX,
                                                    interpolation=cv2.INTER_NEAREST)[..., None]
    return frame


def watch(browser, address, topic):
    """Look at one enlarged image: the ages of what is shown, milliseconds, kbit/s, and the server's load, %."""
    page, received = browser.new_page(viewport={'width': 1000, 'height': 800}), []
    page.on('websocket', lambda socket: socket.on('framereceived', lambda data: received.append(len(data))))
    page.goto(address)
    page.wait_for_selector('[data-topic="%s"] .why' % topic, state='hidden')
    page.click('[data-topic="%s"] .view' % topic)
    page.wait_for_function('''(topic) =>
        document.querySelector(`[data-topic="${topic}"] canvas`).width >= 640''', arg=topic)
    page.evaluate(WATCH, [topic, BITS])
    page.wait_for_timeout(2000)
    received.clear()
    page.evaluate('() => { window.ages = []; }')
    spent, began = time.process_time(), time.monotonic()
    page.wait_for_timeout(1000 * SECONDS)
    ages, seconds = page.evaluate('() => window.ages'), time.monotonic() - began
    load = 100 * (time.process_time() - spent) / seconds
    page.close()
    return ages, 8e-3 * sum(received) / seconds, load
