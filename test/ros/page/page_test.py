#!/usr/bin/env python3
"""The page in a real browser: moving pictures, and choosing what is painted."""
import os
import re
import tempfile

import cv2
import numpy as np
import rospy
import rostest
from aruco_ar import Area
from geometry_msgs.msg import PolygonStamped
from rig.nodes.case import change
from rig.nodes.topics import until
from rig.page.browser import BrowserTest
from rig.processes.started import WAIT_S

PAINTED = '.tile[data-topic="/exercise5_6/image"]'


class Page(BrowserTest):
    def screenshot(self, selector):
        """A screenshot of an element, (h, w, 3) BGR."""
        png = self.page.locator(selector).screenshot()
        return cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)

    def painted(self):
        """The page's picture of exercise 5.6 in its original size, and the true Area in it."""
        corners = rospy.wait_for_message('/wall_camera/area', PolygonStamped, WAIT_S).polygon.points
        shot = cv2.resize(self.screenshot(PAINTED + ' canvas'), (640, 480))
        return shot, Area(np.float32([(point.x, point.y) for point in corners]))

    def colors(self, *pixels):
        """What is painted of these pixels of the picture of the earth, (x, y): a list of (3,) BGR."""
        shot, area = self.painted()
        seen = cv2.perspectiveTransform(np.float64([pixels]), area.homography(960, 640))[0]
        return [shot[y - 1:y + 2, x - 1:x + 2].mean(axis=(0, 1)) for x, y in np.int32(np.round(seen))]

    def wait_for_color(self, color):
        """Wait until the middle of the area of exercise 5.6 has about this color, (blue, green, red)."""
        self.page.wait_for_function(
            '''([selector, x, y, [blue, green, red]]) => {
                 const picture = document.querySelector(selector).getContext('2d');
                 const [r, g, b] = picture.getImageData(x, y, 1, 1).data;
                 return Math.abs(r - red) + Math.abs(g - green) + Math.abs(b - blue) < 60;
               }''', arg=[PAINTED + ' canvas', *self.middle(), list(color)])

    def wait_for_chosen(self, name):
        self.page.wait_for_function("(name) => document.querySelector(`input[value='${name}']`).checked",
                                    arg=name)

    def middle(self):
        return [int(value) for value in self.painted()[1].corners.mean(axis=0)]

    def test_the_pictures_move_and_the_earth_has_its_colors(self):
        for tile in self.page.locator('.tile').all():
            topic = tile.get_attribute('data-topic')
            selector = '.tile[data-topic="%s"] canvas' % topic
            first = self.screenshot(selector)
            self.assertGreater(first.std(), 20, topic)
            until(lambda: np.any(self.screenshot(selector) != first))
        self.page.get_by_text('earth', exact=True).click()  # another test may have chosen another picture

        def shows_the_earth():
            atlantic, sahara, sea = self.colors((330, 330), (430, 270), (60, 320))
            return (atlantic[0] > atlantic[2] + 25 and sahara[2] > sahara[1] > sahara[0] and sahara[2] > 130
                    and sea.max() < 70)
        until(shows_the_earth)

    def test_each_picture_has_its_rate_latency_and_tags_and_all_files_are_local(self):
        self.wait_for_text('.tile .tags', 'tags 1 2 3 4')
        for tile in self.page.locator('.tile').all():
            for name, unit in ('rate', 'fps'), ('latency', 'ms'):
                text = tile.locator('.' + name)
                until(lambda: re.match(r'\d+ %s$' % unit, text.inner_text()))
        own = 'http://localhost:%d/' % self.port
        own_urls = own, 'data:', 'ws' + own[4:]
        self.assertEqual([url for url in self.requested if not url.startswith(own_urls)], [])

    def test_everything_has_a_name_for_a_screen_reader(self):
        nameless = self.page.evaluate(
            '''[...document.querySelectorAll('button, input, canvas, section, select')].filter((element) =>
                 !element.ariaLabel && !element.getAttribute('aria-labelledby')
                 && !element.closest('label')?.textContent.trim()).map((element) => element.outerHTML)''')
        self.assertEqual(nameless, [])
        for name in ('Forward', 'Backward', 'Turn left', 'Turn right', '5.6 A picture in its place: enlarge'):
            self.assertEqual(self.page.get_by_role('button', name=name).count(), 1, name)
        self.assertEqual(self.page.get_by_role('radio', name='earth', exact=True).count(), 1)
        self.assertEqual(self.page.get_by_role('slider', name='Noise').count(), 1)
        self.wait_for_text('#status', 'Live')

    def test_a_click_enlarges_a_picture_and_the_others_pause(self):
        small = self.screenshot(PAINTED)
        self.page.get_by_role('button', name='5.6 A picture in its place').click()
        self.assertGreater(self.screenshot(PAINTED).shape[1], 2 * small.shape[1])
        # Only 5.6 is visible now, so the page unsubscribes from the other nodes.
        self.wait_for_subscriptions(['/exercise5_6/image/compressed'])
        self.page.keyboard.press('Escape')
        self.assertEqual(self.screenshot(PAINTED).shape[1], small.shape[1])
        self.wait_for_subscriptions(['/exercise5_%d/image/compressed' % number for number in range(2, 7)])

    def wait_for_subscriptions(self, topics):
        """Wait until the page subscribes to exactly these pictures of the exercises."""
        def connected():
            listened = rospy.get_master().getSystemState()[2][1]
            return sorted(topic for topic, nodes in listened if topic.endswith('image/compressed')
                          and '/page' in nodes and topic.startswith('/exercise'))
        until(lambda: connected() == topics)

    def test_choosing_a_picture_changes_what_is_painted(self):
        self.page.get_by_text('turning earth').click()
        self.wait_for_chosen('turning_earth.mp4')
        turned = [self.screenshot(PAINTED + ' canvas')]
        until(lambda: turned.append(self.screenshot(PAINTED + ' canvas')) or
              np.abs(turned[-1].astype(int) - turned[0]).max() > 60)
        png = cv2.imencode('.png', np.full((20, 30, 3), (10, 200, 30), np.uint8))[1].tobytes()
        green = {'name': 'green.png', 'mimeType': 'image/png', 'buffer': png}
        self.page.locator('#file').set_input_files(green)
        self.wait_for_color((10, 200, 30))
        self.wait_for_text('#status', 'green.png is painted now.')
        blue = cv2.imencode('.png', np.full((20, 30, 3), (220, 30, 10), np.uint8))[1].tolist()
        self.page.evaluate(
            '''(bytes) => {
                 const dataTransfer = new DataTransfer();
                 dataTransfer.items.add(new File([new Uint8Array(bytes)], 'blue.png', { type: 'image/png' }));
                 document.querySelector('h1').dispatchEvent(
                   new DragEvent('drop', { bubbles: true, cancelable: true, dataTransfer }));
               }''', np.ravel(blue).tolist())
        self.wait_for_color((220, 30, 10))
        self.expected = '422'  # the browser logs this status on its console
        self.page.locator('#file').set_input_files({'name': 'no.png', 'mimeType': 'image/png', 'buffer': b'no'})
        self.wait_for_text('#status', 'This file is not a picture')
        self.wait_for_color((220, 30, 10))
        self.page.get_by_text('earth', exact=True).click()
        self.wait_for_chosen('earth.jpg')
        self.page.get_by_text('dropped 2').click()  # the dropped picture is still there
        self.wait_for_color((220, 30, 10))
        self.page.get_by_text('earth', exact=True).click()
        self.wait_for_chosen('earth.jpg')

    def test_a_state_from_before_a_choice_does_not_take_it_back(self):
        self.page.add_init_script(
            '''window.WebSocket = class extends WebSocket {
                 constructor(...args) {
                   super(...args);
                   window.socket = this;
                   this.addEventListener('message', ({ data }) => {
                     const isState = typeof data === 'string' && data.includes('"picture": "earth.jpg"');
                     if (isState) window.before = data;
                   });
                 }
               };''')
        self.page.reload()
        self.page.get_by_text('turning earth').click()
        until(lambda: rospy.get_param('/exercise5_6/picture') == 'images/turning_earth.mp4')
        self.page.get_by_text('earth', exact=True).click()
        self.page.wait_for_function('() => window.before')
        self.page.get_by_text('turning earth').click()
        self.page.evaluate('() => window.socket.onmessage({ data: window.before })')
        self.assertTrue(self.page.get_by_role('radio', name='turning earth').is_checked())
        until(lambda: rospy.get_param('/exercise5_6/picture') == 'images/turning_earth.mp4')

    def test_switches_change_how_the_picture_looks(self):
        for label, name, off, on in (('People stay in front', 'exercise5_6/foreground', 'paint', 'keep'),
                                     ("It takes the wall's light", 'exercise5_6/light', 'full', 'match'),
                                     ('It is as soft', 'exercise5_6/grain', 'clean', 'match'),
                                     ('The tags are hidden', 'exercise5_6/tags', 'show', 'hide'),
                                     ('Somebody walks past', 'wall_camera/visitor', 'nobody', 'person')):
            switch = self.page.get_by_label(label)
            self.assertFalse(switch.is_checked())
            for value, turn in (on, switch.check), (off, switch.uncheck):
                turn()
                until(lambda: rospy.get_param('/' + name) == value)

    def test_a_wall_is_remembered_in_a_file_and_forgotten(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        change('/exercise5_6', folder=folder.name)
        switch = self.page.get_by_label('The wall is remembered')

        def wall():
            return rospy.get_param('/exercise5_6/wall')

        def is_remembered():
            switch.check()
            until(lambda: wall() != 'learn' or not switch.is_checked())  # unchecked: it is not known well yet
            return wall() != 'learn'
        until(is_remembered)
        path = wall()
        self.assertEqual([path], [os.path.join(folder.name, name) for name in os.listdir(folder.name)])
        until(lambda: rospy.get_param('/exercise5_5/wall') == path)
        self.assertTrue(switch.is_checked())
        switch.uncheck()
        until(lambda: wall() == rospy.get_param('/exercise5_5/wall') == 'learn')

    def test_fields_change_how_the_area_is_filled_and_which_tags_count(self):
        fit = self.page.get_by_label('How it fills the area')
        self.assertEqual(fit.input_value(), 'stretch')
        opacity = self.page.get_by_role('slider', name='Opacity')
        for value in 'cover', 'stretch':
            fit.select_option(value)
            until(lambda: rospy.get_param('/exercise5_6/fit') == value)
        for _ in range(2):  # by keyboard, the field keeps the arrow keys, which else would drive the robot
            fit.press('ArrowDown')
            self.assertTrue(fit.evaluate('(field) => field === document.activeElement'))
        until(lambda: rospy.get_param('/exercise5_6/fit') == 'cover')
        fit.select_option('stretch')
        self.page.get_by_text('earth', exact=True).click()
        self.wait_for_chosen('earth.jpg')
        for value in 0, 1:  # the pale wall, and then the dark sea
            opacity.fill(str(value))
            until(lambda: (self.colors((60, 320))[0].max() > 110) == (value == 0))
        ids = self.page.get_by_label('Ids of the four tags')
        self.assertEqual(ids.input_value(), 'any')
        ids.fill('1,2,3')
        ids.press('Enter')
        self.wait_for_text('#status', 'The parameter ~ids is "1,2,3"; it must be')
        until(lambda: ids.input_value() == 'any')
        ids.fill('1, 2,3 ,4')
        ids.press('Enter')
        until(lambda: all(rospy.get_param('/exercise5_%d/ids' % number) == '1,2,3,4' for number in range(2, 7)))
        until(lambda: ids.input_value() == '1,2,3,4')
        ids.fill('any')
        ids.press('Enter')
        until(lambda: rospy.get_param('/exercise5_6/ids') == 'any')

    def test_tags_of_another_dictionary_are_told_of_on_the_picture_until_it_is_chosen(self):
        dictionary = self.page.get_by_label('Dictionary')
        self.assertEqual(dictionary.input_value(), 'DICT_6X6_250')
        dictionary.select_option('DICT_4X4_50')
        self.wait_for_text(PAINTED + ' .advice:not([hidden])', 'dictionary:=DICT_6X6_')
        dictionary.select_option('DICT_6X6_250')
        self.page.wait_for_selector(PAINTED + ' .advice', state='hidden')
        self.wait_for_text(PAINTED + ' .tags', 'tags 1 2 3 4')

    def test_on_a_phone_nothing_is_wider_than_the_screen(self):
        self.page.set_viewport_size({'width': 360, 'height': 740})
        self.assertEqual(self.page.evaluate('document.documentElement.scrollWidth'), 360)
        self.assertTrue(self.page.get_by_role('button', name='Forward').is_visible())
        columns = {round(tile.bounding_box()['x']) for tile in self.page.locator('.tile').all()}
        self.assertEqual(len(columns), 2)


if __name__ == '__main__':
    rospy.init_node('page_test')
    rostest.rosrun('unit5', 'page_test', Page)
