"""The teaching page in a real browser, from the command line to the saved file; skipped where there is no chromium."""

import math
import os
import shutil
import signal
import subprocess
import sys
import time

import cv2
import pytest
from place_scenes import MOUNT
from taught_wall import HERE, METERS, RIG, TAUGHT, seen, write_pair

from stereo_landmark.files.place_file import load_place

pytestmark = pytest.mark.newest_set_only

CHROMIUM = next(filter(None, map(shutil.which, ('chromium', 'chromium-browser', 'google-chrome'))), None)
needs_browser = pytest.mark.skipif(CHROMIUM is None, reason='the page is tested in chromium: apt-get install chromium')


@pytest.fixture(scope='module')
def files(tmp_path_factory):
    folder = tmp_path_factory.mktemp('page')
    files = write_pair(folder)
    for side, image in zip(('left', 'right'), seen(TAUGHT)):
        cv2.imwrite(str(folder / f'taught_{side}.png'), image)
    return files


@pytest.fixture(scope='module')
def address(files):
    """Start the command in a process; it ends with 0 at Ctrl-C."""
    folder = files.places.parent
    options = ['--places', str(files.places), '--port', '0', '--camera-xyz', *map(str, MOUNT.xyz)]
    for side in ('left', 'right'):
        options += [f'--{side}', str(folder / f'taught_{side}.png'), str(files.images[side])]
        options += [f'--{side}-calibration', str(files.calibrations[side])]
    command = [sys.executable, '-m', 'stereo_landmark.commands.teach', *options]
    server = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=os.environ)
    line = server.stdout.readline()
    yield next(word for word in line.split() if word.startswith('http://'))
    server.send_signal(signal.SIGINT)
    assert server.wait(20.0) == 0


class Engineer:
    """Controls the page with mouse and keyboard, and reads its state."""

    def __init__(self, page, address):
        self.page, self.faults = page, []
        page.on('pageerror', lambda fault: self.faults.append(str(fault)))
        page.on('console', lambda said: self.faults.append(said.text) if said.type == 'error' else None)
        page.goto(address)
        # The first start compiles the numba kernels.
        self.wait('window.__state?.edges.left > 0', 240.0)

    def look(self, expression):
        return self.page.evaluate(expression)

    def wait(self, expression, timeout=60.0):
        # Not wait_for_function: the page's policy allows no eval.
        end = time.monotonic() + timeout
        while not self.look(expression):
            assert time.monotonic() < end, (expression, self.faults)
            time.sleep(0.03)

    def at(self, place):
        return self.look(f'window.__stage.onPage({list(place)})')

    def drag(self, begin, end):
        self.page.mouse.move(*begin)
        self.page.mouse.down()
        self.page.mouse.move(*((a + b) / 2 for a, b in zip(begin, end)))
        self.page.mouse.move(*end)
        self.page.mouse.up()

    def middle(self, testid):
        box = self.page.get_by_test_id(testid).bounding_box()
        return box['x'] + box['width'] / 2, box['y'] + box['height'] / 2


@pytest.fixture(scope='module')
def engineer(address):
    reason = 'the page is tested with playwright: pip install playwright'
    playwright = pytest.importorskip('playwright.sync_api', reason=reason)
    with playwright.sync_playwright() as started:
        browser = started.chromium.launch(executable_path=CHROMIUM, args=['--no-sandbox'])
        yield Engineer(browser.new_page(viewport={'width': 1440, 'height': 900}), address)
        browser.close()


def process_images(engineer):
    """The edges follow the slider, and a whole drag is one undo step."""
    page = engineer.page
    before = engineer.look('window.__state.edges.left')
    x, y = engineer.middle('slider-edges.threshold')
    engineer.drag((x - 10, y), (x + 120, y))
    engineer.wait(f'window.__state.edges.left < {before}')
    engineer.wait('window.__state.state.can_undo')
    page.keyboard.press('Control+z')
    engineer.wait('!window.__state.state.can_undo')
    engineer.wait(f'window.__state.edges.left === {before}')


def choose_targets(engineer):
    """A region, its primitives, their order."""
    page = engineer.page
    page.get_by_test_id('step-targets').click()
    engineer.wait("window.__state.step === 'targets'")
    engineer.drag(engineer.at((2, 60)), engineer.at((370, 120)))
    engineer.wait('window.__state.state.targets[0].region !== null')
    ellipses = "window.__state.state.found.filter((e) => e.kind === 'ellipse')"
    rims = engineer.look(f'{ellipses}.map((e) => e.outline[0][0])')
    assert len(rims) == len(METERS)
    for count, rim in enumerate(sorted(rims), start=1):
        page.mouse.click(*engineer.at(rim))
        engineer.wait(f'window.__state.state.targets[0].primitives.length === {count}')
    names = engineer.look('window.__state.state.targets[0].primitives.map((part) => part.name)')
    assert names == ['ellipse 1', 'ellipse 2', 'ellipse 3', 'ellipse 4']
    first = engineer.middle('chosen-0')
    engineer.drag(engineer.middle('handle-3'), (engineer.middle('handle-0')[0], first[1] - 30))
    engineer.wait("window.__state.state.targets[0].primitives[0].name === 'ellipse 4'")
    page.keyboard.press('Delete')
    engineer.wait('window.__state.state.targets[0].primitives.length === 3')
    page.keyboard.press('Control+z')
    engineer.wait('window.__state.state.targets[0].primitives.length === 4')
    page.mouse.move(*engineer.at((10, 130)))
    page.mouse.down()
    page.mouse.move(*engineer.at((200, 230)))
    page.keyboard.press('Escape')
    page.mouse.up()
    take_region_back(engineer)


def take_region_back(engineer):
    """Esc cancels one thing at a time, finally the region; a click with a small movement is still a click."""
    page, region = engineer.page, 'window.__state.state.targets[0].region'
    before = engineer.look(region)
    page.keyboard.press('Escape')
    if engineer.look(f'{region} !== null'):
        page.keyboard.press('Escape')
    engineer.wait(f'{region} === null')
    page.keyboard.press('Control+z')
    engineer.wait(f'{region} !== null')
    x, y = engineer.at((10, 10))
    engineer.drag((x, y), (x + 6, y + 2))
    page.keyboard.press('0')
    assert engineer.look(region) == before
    assert page.get_by_test_id('toast').is_hidden()


def click_on_refused_shapes(engineer):
    """A shape that cannot be used is not selected, the page says why; selected ones go with one button."""
    page, count = engineer.page, 'window.__state.state.targets[0].primitives.length'
    page.get_by_test_id('detector-parallel_lines').click()
    refused = "window.__state.state.found.find((e) => e.fault && e.kind === 'parallel_lines')"
    engineer.wait(f'Boolean({refused})')
    kind, number, fault = engineer.look(f'(({{ kind, number, fault }}) => [kind, number, fault])({refused})')
    page.get_by_test_id('shape-counts').click()
    page.get_by_test_id(f'shape-{kind} {number}').press('Enter')
    assert fault in page.locator('#reason').text_content()
    page.get_by_test_id('toast').get_by_text(fault).wait_for()
    assert engineer.look(count) == len(METERS)
    selected = f"'toggle', {{ kind: '{kind}', number: {number} }}"
    engineer.look(f"import('/static/app.js').then(({{ edit }}) => edit({selected})).then(() => null)")
    page.get_by_test_id('remove-refused').click()
    engineer.wait(f'{count} === {len(METERS)}')


def choose_outer_rims(engineer):
    """Of concentric rings the one with the outline under the pointer is selected."""
    rings = [[[[r * math.cos(k / 8), r * math.sin(k / 8)] for k in range(51)]] for r in (10.0, 12.0)]
    shapes = """async ([rings, place]) => {
        const { shapesAt } = await import('/static/geometry.js');
        return shapesAt([0, 1], (i) => rings[i], place, 8);
    }"""
    first = [engineer.page.evaluate(shapes, [rings, [x, 0.0]])[0] for x in (0.0, 9.5, 11.9)]
    assert first == [0, 0, 1]


def choose_points(engineer):
    """Points, one excluded and included again."""
    page = engineer.page
    page.keyboard.press('3')
    point = page.get_by_test_id('point-ellipse 2/centre')
    point.uncheck()
    engineer.wait("!window.__state.state.targets[0].points.find((p) => p.name === 'ellipse 2/centre').used")
    page.get_by_test_id('point-ellipse 2/centre').check()
    engineer.wait('window.__state.state.targets[0].points.every((p) => p.used)')
    assert '±' in page.get_by_test_id('expected').inner_text()


def check_tree(engineer):
    """The tree is checked as soon as it is shown."""
    page = engineer.page
    page.keyboard.press('4')
    engineer.wait('window.__state.checks[0]?.trials.length > 4')
    assert engineer.look("window.__state.checks[0].trials.every((t) => t.outcome === 'found')")
    assert page.get_by_test_id('tree').locator('.node').count() == len(METERS) ** 2


def try_and_save(engineer):
    """The other pair, and saving."""
    page = engineer.page
    page.keyboard.press('5')
    engineer.wait('window.__state.test?.is_fix')
    found = engineer.look('[window.__state.test.x, window.__state.test.y, window.__state.test.yaw]')
    assert found == pytest.approx([HERE[0], HERE[1], HERE[3]], abs=0.02)
    page.get_by_test_id('test-all').click()
    engineer.wait("document.querySelectorAll('.plan .found').length === 2")
    page.get_by_test_id('tilt-pitch').fill('1')
    page.keyboard.press('Tab')
    engineer.wait('window.__state.test?.tilt[1] > 0.01')
    for step in ('targets', 'points', 'tree', 'test'):
        page.get_by_test_id(f'step-{step}').click()
        for width in (390, 768, 1440):
            page.set_viewport_size({'width': width, 'height': 900})
            assert engineer.look('document.scrollingElement.scrollWidth') <= width
    page.get_by_test_id('place').fill('a wall')
    page.keyboard.press('Tab')
    page.get_by_test_id('toast').get_by_text('is not a valid place name').wait_for()
    page.get_by_test_id('place').fill('wall')
    page.keyboard.press('Tab')
    engineer.wait("window.__state.state.place === 'wall'")
    page.keyboard.press('Control+s')
    engineer.wait("window.__state.save_status === 'saved'")


def name_while_saving(engineer):
    """Ctrl+S submits a name that is still being typed, Esc cancels it, and an invalid name prevents saving."""
    page, field = engineer.page, engineer.page.get_by_test_id('place')
    field.fill('given_up')
    page.keyboard.press('Escape')
    assert field.input_value() == 'wall'
    field.fill('no name')
    page.keyboard.press('Control+s')
    page.get_by_test_id('toast').get_by_text('is not a valid place name').wait_for()
    page.get_by_test_id('save').click()
    assert field.input_value() == 'no name'
    assert engineer.look('[window.__state.state.place, window.__state.save_status]') == ['wall', 'saved']
    field.fill('wall_2')
    page.keyboard.press('Control+s')
    engineer.wait("window.__state.state.place === 'wall_2' && window.__state.save_status === 'saved'")


def see_what_is_not_saved(engineer, address):
    """Reset is an unsaved change, and other pages are notified."""
    page = engineer.page
    page.keyboard.press('1')
    page.get_by_test_id('slider-edges.threshold').press('ArrowRight')
    engineer.wait("window.__state.save_status === 'unsaved'")
    page.keyboard.press('Control+s')
    engineer.wait("window.__state.save_status === 'saved'")
    page.get_by_text('Reset').first.click()
    engineer.wait("window.__state.save_status === 'unsaved'")
    assert page.get_by_test_id('save').inner_text() == 'Save •'
    other = Engineer(page.context.browser.new_page(), address)
    assert other.look('[window.__state.save_status, window.__state.test]') == ['unsaved', None]
    page.keyboard.press('Control+z')
    other.wait("window.__state.save_status === 'saved'")
    assert other.page.get_by_test_id('save').inner_text() == 'Saved ✓'
    assert other.faults == []
    other.page.close()


@needs_browser
@pytest.mark.timeout(400)
def test_an_engineer_teaches_a_place_in_the_browser(engineer, address, files):
    process_images(engineer)
    choose_targets(engineer)
    click_on_refused_shapes(engineer)
    choose_outer_rims(engineer)
    choose_points(engineer)
    check_tree(engineer)
    try_and_save(engineer)
    name_while_saving(engineer)
    see_what_is_not_saved(engineer, address)
    place = load_place(files.places / 'wall.yaml')
    assert [part.name for part in place.targets[0].primitives] == [f'ellipse {k}' for k in (4, 1, 2, 3)]
    assert place.rig == RIG
    assert engineer.faults == []


def test_a_port_in_use_is_reported_in_one_line(address, files):
    port = address.rstrip('/').rpartition(':')[2]
    command = [sys.executable, '-m', 'stereo_landmark.commands.teach', *files.options('--port', port)]
    refused = subprocess.run(command, capture_output=True, text=True, check=False)
    assert refused.returncode == 1
    (line,) = refused.stderr.splitlines()
    assert 'choose another --host or --port' in line
