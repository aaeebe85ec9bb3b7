"""Whether a report works in a real browser: drawn, read out, zoomed into, narrow, dark, printed.

The browser is the program named by TORQUEWISE_CHROMIUM, or the first of PROGRAMS; without one the
tests are skipped, or fail where TORQUEWISE_BROWSER_REQUIRED=1.
"""

import json
import os
import shutil

import pytest

import torquewise

PROGRAMS = ("chromium", "chromium-browser", "google-chrome")
ARGUMENTS = (
    "--no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking "
    "--disable-component-update --disable-sync --disable-dev-shm-usage"
).split()
# What a hostile log may call a joint, and what a folder may call a log.
HOSTILE = '</script><img src=x onerror="throw 1">\''
HOSTILE_FILE = '<img src=x onerror="throw 1">\'.csv'

LINK = """<link name="link{0}"><inertial><origin xyz="0.1 0 0.05"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>"""
JOINT = """<joint name="joint{1}" type="revolute"><parent link="link{0}"/><child link="link{1}"/>
    <origin xyz="0.3 0 0" rpy="1.5708 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2" velocity="2" effort="99"/></joint>"""
JOINTS = "".join(JOINT.format(k, k + 1) for k in range(6))

# Waits until what was asked for is drawn.
SETTLE = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(() => done(0))))"
PIXELS = """window.pixels = (canvas) => {
    const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
    copy.drawImage(canvas, 0, 0);
    return copy.getImageData(0, 0, canvas.width, canvas.height).data; }; 0"""
# Charts whose canvas has any ink on it.
DRAWN = """[...document.querySelectorAll("figure.chart canvas")]
    .filter((canvas) => pixels(canvas).some((value) => value > 0)).length"""
# Whether the predicted torque of the first chart has left its colour there.
PREDICTED_INK = """(() => {
    const all = pixels(document.querySelector("#chart-1 canvas"));
    for (let k = 0; k < all.length; k += 4)
        if (all[k] === 0 && all[k + 1] === 114 && all[k + 2] === 178) return true;
    return false; })()"""
UNFOLD = 'document.querySelectorAll("details").forEach((own) => { own.open = true; })'
OVERFLOW = "document.documentElement.scrollWidth - innerWidth"
PLOTS = '[...document.querySelectorAll("figure.chart")].map((figure) => figure.plot)'
X_LIMITS = (
    f'{PLOTS}.filter((p) => p.linked === "time").map((p) => [p.scales.x.min, p.scales.x.max])'
)
READOUTS = '[...document.querySelectorAll(".readout:not([hidden])")].map((box) => box.textContent)'
# How the names at an axis stand, how many there are, whether each has its line and its length,
# and whether the curves keep their room.
NAMES = f"""{PLOTS}.map((plot) => {{
    const {{ _rotate, _values, _splits, _size }} = plot.axes[0];
    const shown = [..._values.keys()].filter((k) => _values[k]);
    const at = shown.map((k) => plot.valToPos(_splits[k], "x"));
    const apart = Math.min(...at.slice(1).map((x, k) => x - at[k]));
    const longest = Math.max(...shown.map((k) => _values[k].length));
    return [_rotate, shown.length, apart >= (_rotate ? 12 : longest * 5),
        !_rotate || _size > 4 * longest, plot.bbox.height > 100]; }})"""
COVERED_NAMES = """[...document.querySelectorAll(".bars .name")].filter((name) =>
    [...name.querySelectorAll("math")].some((math) => math.getBoundingClientRect().right >
        name.nextElementSibling.getBoundingClientRect().left)).length"""


def missing(what):
    if os.environ.get("TORQUEWISE_BROWSER_REQUIRED") == "1":
        pytest.fail(what)
    pytest.skip(what)


@pytest.fixture(scope="module")
def browser():
    try:
        from playwright.sync_api import sync_playwright
    except ImportError:
        missing("no playwright: pip install playwright")
    named = os.environ.get("TORQUEWISE_CHROMIUM")
    program = next(filter(None, map(shutil.which, filter(None, (named, *PROGRAMS)))), None)
    if program is None:
        missing("no Chromium: install it or name it in TORQUEWISE_CHROMIUM")
    with sync_playwright() as playwright:
        started = playwright.chromium.launch(executable_path=program, args=ARGUMENTS)
        yield started
        started.close()


class Tab:
    """A page that is open."""

    def __init__(self, page):
        self.page = page

    def value(self, expression):
        """Value of an expression in the page, once what was asked for before is drawn."""
        return self.page.evaluate(f"{SETTLE}.then(() => {expression})")

    def middle(self, selector):
        """Middle of an element, once it is in sight."""
        own = self.page.locator(selector).first
        own.evaluate('(own) => own.scrollIntoView({ block: "center", behavior: "instant" })')
        self.page.evaluate(SETTLE)
        box = own.bounding_box()
        return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2

    def click(self, selector):
        self.page.mouse.click(*self.middle(selector))

    def drag(self, start, end):
        self.page.mouse.move(*start)
        self.page.mouse.down()
        self.page.mouse.move(*end)
        self.page.mouse.up()

    def resize(self, width, height=800):
        self.page.set_viewport_size({"width": width, "height": height})


@pytest.fixture
def open_page(browser, tmp_path):
    """Opens a page; after the test, nothing was complained of and nothing else was asked for."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    page, complaints, requests = context.new_page(), [], []
    page.on("request", lambda request: requests.append(request.url))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on(
        "console",
        lambda said: said.type in ("error", "warning", "assert") and complaints.append(said.text),
    )

    def opened(html):
        path = tmp_path / "page.html"
        path.write_text(html, encoding="utf-8")
        page.goto(path.as_uri())
        page.wait_for_selector("html[data-ready]", state="attached", timeout=30_000)
        page.evaluate(PIXELS)
        return Tab(page)

    yield opened
    page.evaluate(SETTLE)
    context.close()
    assert complaints == []
    assert requests == [(tmp_path / "page.html").as_uri()]


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """Of a short log of an arm of two joints; the first one, and the file, have hostile names."""
    path = tmp_path_factory.mktemp("logs") / HOSTILE_FILE
    log = torquewise.simulate("planar-2", seconds=30, rate=100, case=2, seed=5)
    log["joints"][0] = HOSTILE
    torquewise.write_log(path, log)
    return torquewise.fit(path, progress=False).report(test=path, progress=False)


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """The report of a chain of six joints, whose axes stand across each other, 0.3 m apart."""
    path = tmp_path_factory.mktemp("arm") / "arm.urdf"
    path.write_text(f'<robot name="arm">{"".join(map(LINK.format, range(7)))}{JOINTS}</robot>')
    log = torquewise.simulate(path, seconds=20, rate=50, seed=1)
    found = torquewise.fit(log, urdf=path, friction="linear", progress=False)
    return found.report(test=log, progress=False)


def axis(label="", log=False, range=None, places=(), whole=False):
    return {"label": label, "log": log, "range": range, "places": places, "whole": whole}


def series(x, y, column=0, mark="line", low=(), high=()):
    own = {"label": mark, "colour": "series-1", "mark": mark, "column": column}
    return x, {**own, "y": y, "low": low, "high": high}


def page_of(report, charts):
    """The page of a report with other charts in its place; each is x, y, series and the rest."""
    figures = []
    for k, (x, y, curves, rest) in enumerate(charts, 1):
        spec = {"x": x, "y": y, "columns": [own for own, _ in curves]}
        spec |= {"series": [own for _, own in curves], "bands": [], "guides": [], "linked": None}
        figures.append(
            f'<figure class="chart" id="chart-{k}"><button class="reset" hidden></button>'
            '<div class="plot"></div><script type="application/json">'
            f"{json.dumps(spec | rest)}</script></figure>"
        )
    head, rest = report.split("<main>")
    tail = rest.split("</main>")[1]
    return f'{head}<main><div class="beside">{"".join(figures)}</div></main>{tail}'


def test_a_report_is_drawn(open_page, report):
    tab = open_page(report)

    charts = tab.value('document.querySelectorAll("figure.chart").length')
    assert charts >= 14
    assert tab.value(DRAWN) == charts
    assert tab.value(PREDICTED_INK), "not the axes alone"
    assert report.count("&lt;img src=x") > 1 and tab.value("document.images.length") == 0
    assert tab.value('document.querySelectorAll("math").length') > 10


def test_every_kind_of_chart_is_drawn_and_read_out(open_page, report):
    x = [*range(1, 40)]
    y = [10 ** (0.1 * (k % 20)) for k in x]
    rest = {
        "bands": [{"colour": "faded", "spans": [[3, 9]]}],
        "guides": [{"axis": "x", "at": 5}, {"axis": "y", "at": 20}],
    }
    marks = ("line", "broad", "dashed", "cloud", "rings", "dotted", "bars")
    others = series([0.5, 2.5, 3], [1, None, 40], 1)
    charts = []
    for mark in marks:
        own = series(x, y, 0, mark, [0.5 * v for v in y], [2 * v for v in y])
        for log in (False, True):
            charts.append((axis("x", log), axis("y", log), [own, others], rest))
    charts.append((axis(), axis(), [], {}))
    charts.append((axis(places=["case 1"]), axis(), [series([0], [1])], {}))

    tab = open_page(page_of(report, charts))

    assert tab.value(DRAWN) == 16
    for k in range(1, 15):
        x, y = tab.middle(f"#chart-{k} .u-over")
        read = set()
        for step in range(12):
            tab.page.mouse.move(x - 60 + 10 * step, y + 20)
            read.update(tab.value(READOUTS))
        assert read, f"chart {k}"


def test_a_gap_is_not_bridged_by_the_points_of_another_curve(open_page, report):
    dense = series([*range(9)], [0] * 9)
    broken = series([0.5, 1.5, 4.5, 6.5, 7.5], [1, 1, None, 1, 1], 1)

    tab = open_page(page_of(report, [(axis(), axis(), [dense, broken], {})]))

    # The gap itself, and the five rows of the other curve from x = 2 to x = 6.
    assert tab.value(f"{PLOTS}[0].data[2].filter((y) => y === null).length") == 6


def test_numbers_at_an_axis_are_round(open_page, report):
    curve = [series([1, 3], [1, 1])]
    axes = [
        (axis("count", whole=True, range=[1, 3]), [0.008, 20]),
        (axis("x", log=True, range=[1, 3]), [0.9, 12]),
        (axis("x", log=True, whole=True, range=[1, 3]), [3e-14, 2e-11]),
        (axis("x", range=[1, 3]), [0.98, 1.31]),
    ]
    charts = [(x, axis("y", log=True, range=ends), curve, {}) for x, ends in axes]

    tab = open_page(page_of(report, charts))

    ticks = tab.value(f"{PLOTS}.map(({{ axes }}) => axes.map((axis) => axis._values))")
    assert ticks[0] == [["1", "2", "3"], ["0.01", "0.1", "1", "10"]]
    assert ticks[1] == [["1.0", "1.5", "2.0", "2.5", "3.0"], ["1", "2", "5", "10"]]
    assert ticks[2] == [["1", "2", "3"], ["1e-13", "1e-12", "1e-11"]]
    assert ticks[3][1] == ["1.0", "1.1", "1.2", "1.3"]


def test_names_at_an_axis_turn_where_they_have_no_room(open_page, report):
    few = [f"case {k}" for k in (1, 2, 3)]
    many = [f"M{k} sin(2*q2)*cos(q3)" for k in range(40)]
    curve = [series([0, 1], [1, 2])]
    charts = [(axis("x", places=names), axis(), curve, {}) for names in (few, many)]
    tab = open_page(page_of(report, charts).replace('"beside"', '"alone"'))

    for width, most in ((1280, 40), (380, 20)):
        tab.resize(width)

        level, turned = tab.value(NAMES)
        assert level == [0, 3, True, True, True]
        assert turned[0] == 90 and turned[1] <= most and turned[2:] == [True, True, True]


def test_pointing_at_a_curve_reads_it_out(open_page, report):
    tab = open_page(report)
    tab.page.mouse.move(*tab.middle("#chart-1 .u-over"))

    (text,) = tab.value(READOUTS)  # One box only, though charts are linked.
    assert all(word in text for word in ("time", "measured", "predicted"))
    assert any(letter.isdigit() for letter in text)
    tab.page.mouse.move(1, 1)
    assert tab.value(READOUTS) == [], "gone with the pointer"


@pytest.mark.parametrize("undo", ["double click", "button"])
def test_dragging_zooms_all_charts_over_time_and_is_undone(open_page, report, undo):
    tab = open_page(report)
    tab.page.evaluate(UNFOLD)
    whole = tab.value(X_LIMITS)
    # The first two are of the test log.
    x, y = tab.middle("#chart-3 .u-over")

    assert tab.page.locator("#chart-3 .reset").is_hidden()
    tab.drag((x - 60, y), (x + 60, y))

    zoomed = tab.value(X_LIMITS)
    assert len(zoomed) >= 5 and all(own == zoomed[0] for own in zoomed)
    assert zoomed[0][1] - zoomed[0][0] < 0.5 * (whole[0][1] - whole[0][0])
    if undo == "button":
        tab.click("#chart-3 .reset")
    else:
        tab.page.mouse.dblclick(x, y)
    assert tab.value(X_LIMITS) == whole


def test_a_click_on_the_legend_hides_a_curve(open_page, report):
    tab = open_page(report)
    tab.click("#chart-1 button.key")

    assert tab.value(f"{PLOTS}[0].series.map((own) => own.show)") == [True, False, True]
    key = tab.page.locator("#chart-1 button.key").first
    assert key.get_attribute("aria-pressed") == "false"


def test_the_theme_follows_the_reader_and_the_button(open_page, report):
    ground = "getComputedStyle(document.body).backgroundColor"
    tab = open_page(report)
    light = tab.value(ground)

    tab.page.emulate_media(media="screen", color_scheme="dark")
    dark = tab.value(ground)
    tab.click("#theme")

    assert light == "rgb(255, 255, 255)" != dark
    assert tab.value(ground) == light, "the button turns it round"
    tab.click("#theme")
    assert tab.value(ground) == dark
    tab.page.emulate_media(media="print", color_scheme="dark")
    assert tab.value(ground) == light, "paper is light"


@pytest.mark.parametrize("of", ["report", "arm"])
def test_nothing_is_wider_than_a_narrow_screen(open_page, request, of):
    tab = open_page(request.getfixturevalue(of))

    for width in (380, 800, 1280):
        tab.resize(width)
        assert tab.value(OVERFLOW) == 0, "folded"
        assert tab.value(COVERED_NAMES) == 0, "names reach over bars"
        tab.page.evaluate(UNFOLD)

        assert tab.value(OVERFLOW) == 0
        widths = tab.value('[...document.querySelectorAll(".uplot")].map((own) => own.offsetWidth)')
        assert max(widths) <= width


def test_paper_shows_what_was_folded_and_the_screen_comes_back(open_page, report):
    state = f"""[document.querySelectorAll("details[open]").length, {PLOTS}[0].width,
        "printing" in document.documentElement.dataset]"""
    tab = open_page(report)
    before = tab.value(state)
    tab.page.evaluate("""addEventListener("beforeprint", () => {
        window.folded = document.querySelectorAll("details:not([open])").length; })""")

    pdf = tab.page.pdf(prefer_css_page_size=True)

    assert pdf.startswith(b"%PDF") and len(pdf) > 50_000
    assert tab.value("window.folded") == 0, "nothing is folded on paper"
    assert tab.value(state) == before


def test_six_joints_fit_a_short_page_with_its_contents_beside(open_page, arm):
    tab = open_page(arm)
    tab.resize(1400, 900)

    assert 3_000 < tab.value("document.documentElement.scrollHeight") < 12_000
    edge = lambda own, side: tab.value(
        f'document.querySelector("{own}").getBoundingClientRect().{side}'
    )
    assert edge("nav ol", "right") < edge("main", "left")
    tab.resize(400, 900)
    assert tab.value('document.querySelector("nav details").open') is False


def test_the_skeleton_is_moved_by_the_log_and_turned_by_dragging(open_page, arm):
    # Where its last axis is, and its picture.
    axes = 'document.querySelector(".skeleton").axes'
    lengths = f"""{axes}.slice(1).map(({{ origin }}, i) =>
        Math.hypot(...origin.map((x, k) => x - {axes}[i].origin[k])).toFixed(6))"""
    state = f'[{axes}.at(-1), document.querySelector(".skeleton canvas").toDataURL()]'
    tab = open_page(arm)
    tab.middle(".skeleton canvas")
    start = tab.value(state)

    tab.click(".player input")
    later = tab.value(state)
    x, y = tab.middle(".skeleton canvas")
    tab.drag((x, y), (x + 80, y + 20))
    turned = tab.value(state)
    tab.click(".player button")
    tab.page.wait_for_timeout(300)
    played = tab.value(state)

    assert start[0] != later[0] and start[1] != later[1], "the slider moves it"
    assert later[0] == turned[0] and later[1] != turned[1], "a drag turns the view alone"
    assert played[0] != turned[0], "it plays"
    assert tab.value(lengths) == ["0.300000"] * 5, "links keep their length"
