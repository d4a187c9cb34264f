"""Computing modules of the page, called individually in the browser."""

import math
import random
from typing import Any, Dict, List

import numpy
from browsing.page_test import BrowserTest, PageTest

from topic_scope.analysis.ring import Samples
from topic_scope.page.view import LiveView
from topic_scope.protocol.requests import View


class Modules(BrowserTest):
    """Numbers, bins, sliders and the layout of the graph."""

    ARGUMENTS = PageTest.ARGUMENTS

    @classmethod
    def setUpClass(cls) -> None:
        super().setUpClass()
        cls.browser.open(cls.scope.url)
        cls.addClassCleanup(cls.leave_page)

    def test_ticks_are_round_and_inside(self) -> None:
        ranges = [[0, 1], [-5, 0], [1e-6, 3e-6], [999.9, 1000.1], [-2e7, 3e7], [-0.03, 0.02]]
        answers = self.browser.call(
            "base/numbers.js", "a[0].map(([low, high]) => module.ticks(low, high, 8))", ranges
        )
        self.assertEqual(len(answers), len(ranges))
        for (low, high), ticks in zip(ranges, answers):
            span = high - low
            self.assertTrue(2 <= len(ticks) <= 9, ticks)
            for tick in ticks:
                self.assertTrue(low - 1e-6 * span <= tick["v"] <= high + 1e-6 * span, ticks)
                self.assertAlmostEqual(
                    float(tick["label"].replace("−", "-")), tick["v"], delta=span * 1e-3
                )
            self.assertEqual(len({tick["label"] for tick in ticks}), len(ticks), ticks)
            step = f"{ticks[1]['v'] - ticks[0]['v']:.3e}"
            self.assertIn(step[:5], ("1.000", "2.000", "5.000"), ticks)

    def test_steps_are_the_next_round_numbers(self) -> None:
        steps = {
            0.3: 0.5,
            1.0: 1.0,
            1.01: 2.0,
            2.1: 5.0,
            3.5: 5.0,
            4.0: 5.0,
            5.01: 10.0,
            40.0: 50.0,
        }
        found = self.browser.call("base/numbers.js", "a[0].map(module.niceStep)", list(steps))
        for step, expected in zip(found, steps.values()):
            self.assertAlmostEqual(step, expected)
        self.assertEqual(len(found), len(steps))

    def test_figures_have_five_digits(self) -> None:
        cases = {
            0.0: "0.0000",
            3.14159265: "3.1416",
            -1234.5678: "−1234.6",
            0.012345: "0.0123",
            1.23e-7: "1.230e-7",
            -4.5e9: "−4.500e+9",
        }
        answers = self.browser.call(
            "base/numbers.js", "a[0].map((x) => module.figure(x))", list(cases)
        )
        self.assertEqual(answers, list(cases.values()))
        self.assertEqual(self.browser.call("base/numbers.js", "module.figure(null)"), "–")

    def test_the_uncertainty_of_a_figure_decides_its_digits(self) -> None:
        cases = [
            (2.00802, 0.00023, "2.00802 ± 0.00023"),
            (0.00038123, 0.0000127, "0.000381 ± 0.000013"),
            (10.1609, 0.051, "10.161 ± 0.051"),
            (-12.3456, 1.96, "−12.3 ± 2.0"),
            (-12.3456, 0.0996, "−12.35 ± 0.10"),
            (123456.7, 1234.0, "123500 ± 1200"),
            (1.0, 5e-5, "1.000000 ± 0.000050"),
            (3.1e-9, 2.04e-11, "3.100e-9 ± 2.0e-11"),
            (4.56789e9, 1.2e6, "4.5679e+9 ± 1.2e+6"),
            (0.0, 0.05, "0.000 ± 0.050"),
            (3.14159265, 0.0, "3.1416 ± "),
        ]
        write = "a[0].map(([x, u]) => Object.values(module.measuredText(x, u)).join(' ± '))"
        answers = self.browser.call("base/numbers.js", write, cases)
        self.assertEqual(answers, [text for *_, text in cases])

    def test_the_table_writes_small_uncertainties_and_short_times(self) -> None:
        measured = {
            "rise": 0.00038,
            "uncertainty": {"rise": 0.0000127},
            "latency": 0.00038,
            "vpp": 2,
        }
        texts = (
            "['rise', 'latency'].map((key) => "
            "[module.figureText(a[0], key), module.certainty(a[0], key)])"
        )
        answers = self.browser.call("measure/statistics.js", texts, measured)
        self.assertEqual(answers, [["0.000380", "± 0.000013"], ["0.000380", ""]])

    def test_figures_have_as_many_digits_as_their_trace_needs(self) -> None:
        # Value, and peak-to-peak value of the trace.
        cases = [(1e6, 2e-3, "1000000.00000"), (1e6 + 1e-3, 2e-3, "1000000.00100")]
        cases += [(2.0, 4.0, "2.0000"), (-1.7e9, 20.0, "−1700000000.0"), (5.0, 0.0, "5.0000")]
        answers = self.browser.call(
            "base/numbers.js", "a[0].map(([x, spread]) => module.figure(x, 5, spread))", cases
        )
        self.assertEqual(answers, [text for *_, text in cases])
        labels = self.browser.call("base/numbers.js", "module.ticks(1e6 - 1e-3, 1e6 + 1e-3, 8)")
        self.assertEqual(len({tick["label"] for tick in labels}), len(labels), labels)

    def test_no_plot_is_empty_and_an_axis_stays_with_its_plot(self) -> None:
        free = {"title": "", "low": None, "high": None}
        first, third = {**free, "title": "first"}, {**free, "high": 3}
        axes = {"x": {"title": "s"}, "y": first, "y2": free, "y.3": third, "y2.4": first}
        # Fields, settings of traces; expected plots of the traces, and axes.
        cases = [
            (["/a", "/b"], {"/b": 3}, [1, 2], {"y": first, "y2": free, "y.2": third}),
            (["/b"], {"/a": 1, "/b": 3}, [1], {"y": third, "y2": free}),
            (
                ["/a", "/b", "/c"],
                {"/b": 4, "/c": 4},
                [1, 2, 2],
                {"y": first, "y2": free, "y2.2": first},
            ),
            # The fields of a topic are in the plot of the topic.
            (["/a", "/t/x", "/t/y", "/tt"], {"/t": 2}, [1, 2, 2, 1], {"y": first, "y2": free}),
        ]
        answers = self.browser.call(
            "state/traces.js",
            "a[0].map(([fields, plots]) => { const axes = a[1];"
            " const traces = module.readTraces("
            "Object.fromEntries(Object.entries(plots).map(([f, plot]) => [f, { plot }])));"
            " const now = module.arranged({ fields, traces, axes });"
            " return { plots: [...now.traces.values()].map(({ plot }) => plot),"
            " fields: [...now.traces.keys()], axes: now.axes }; })",
            [case[:2] for case in cases],
            axes,
        )
        self.assertEqual(len(answers), len(cases))
        for (fields, _, expected, axes_then), reply in zip(cases, answers):
            self.assertEqual((reply["fields"], reply["plots"]), (fields, expected))
            self.assertEqual(reply["axes"], {"x": axes["x"], **axes_then})

    def test_quotes_and_brackets_in_names_may_have_any_characters(self) -> None:
        level, odd = "/d/status[name=v1.5 a@b-/c]/level", '"/ORB-SLAM"/pose'
        available = [
            {"field": level, "datatype": "uint8", "topic": "/d"},
            {"field": f"{odd}/x", "datatype": "float64", "topic": "/ORB-SLAM"},
            {"field": '"/ORB-SLAM"/header/stamp', "datatype": "time", "topic": "/ORB-SLAM"},
            {"field": "/ORB/header/stamp", "datatype": "time", "topic": "/ORB"},
        ]
        parted, sources, computed, stepped, names = self.browser.call(
            "choose/timestamp_source.js",
            "await (async () => { const [available, fields] = a;"
            " const traces = await import('/static/js/state/traces.js');"
            " const { inTopic } = await import('/static/js/base/names.js');"
            " const values = { available, traces: new Map() };"
            " return [fields.map(module.splitSource), module.sourcesOf(available, '/ORB-SLAM'),"
            " fields.map(traces.isComputed),"
            " fields.map((field) => traces.isStepped(values, field)),"
            " available.map(inTopic)]; })()",
            available,
            [level, f"{level}@stamp", f"{odd}/x", f"/a/x-{odd}/x"],
        )
        self.assertEqual(parted[:3], [[level, ""], [level, "stamp"], [f"{odd}/x", ""]])
        self.assertEqual(sources, ["received", "stamp"])
        self.assertEqual(computed, [False, False, False, True])
        self.assertEqual(stepped, [True, True, False, False])
        expected = ["status[name=v1.5 a@b-/c]/level", "pose/x", "header/stamp", "header/stamp"]
        self.assertEqual(names, expected)

    def test_axis_that_ends_before_it_begins_is_explained(self) -> None:
        said = self.browser.call(
            "plot/axes.js",
            """(() => {
              const y = { title: "", low: null, high: 1 };
              const values = { axes: { x: { title: "" }, y, y2: y }, fields: [],
                traces: new Map(), window: 5, history: 60 };
              const setAxis = (name, changes) => Object.assign(values.axes[name], changes);
              module.startAxes({ values, setAxis })();
              const input = document.querySelector("[aria-label='left axis, from']");
              input.value = "5";
              input.dispatchEvent(new Event("change"));
              document.getElementById("axes").close();
              const said = document.getElementById("notice").textContent;
              input.value = "wide";
              input.dispatchEvent(new Event("change"));
              return [said, document.querySelector("[aria-label='left axis, from']").value];
            })()""",
        )
        text = "The left axis cannot go from 5 to 1: its range is automatic."
        self.assertEqual(said, [text, "5"])  # an invalid number is replaced by the last valid one

    def test_set_end_of_an_axis_acts_wherever_the_samples_are(self) -> None:
        cases = [
            ((None, None), [0, 2]),
            ((1, None), [1, 2]),
            ((5, None), [5, 7]),
            ((2, None), [2, 4]),
            ((None, 1), [0, 1]),
            ((None, -5), [-7, -5]),
            ((0.5, 9), [0.5, 9]),
            ((9, 0.5), [0, 2]),
        ]
        ranges = self.browser.call(
            "plot/dygraph_view.js",
            "a[0].map(([low, high]) => module.Plot.prototype.rangeFor.call({ number: 1,"
            " state: { values: { axes: { y: { low, high } }, references: [] } },"
            " shown: { buffer: { extent: () => [0, 2] }, reference: 0, from: 0, to: 1 },"
            " auto: { y: { update: (...ends) => ends.slice(0, 2) } } }, 'y', []))",
            [ends for ends, _ in cases],
        )
        self.assertEqual(ranges, [expected for _, expected in cases])

    def test_references_stay_when_their_timestamp_source_changes(self) -> None:
        now = self.browser.call(
            "choose/timestamp_source.js",
            """await (async () => {
              const { State } = await import("/static/js/state/store.js");
              const { TraceBuffer } = await import("/static/js/state/buffer.js");
              const references = await import("/static/js/state/references.js");
              const buffer = new TraceBuffer();
              buffer.apply({ now: 102, bin: 1, reset: true, first: 100,
                traces: { "/f/x": [1, 1, 2, 2], "/g/x": [7, 7, 8, 8] },
                lasts: { "/f/x": [1, 2] } }, 2);
              const state = new State();
              state.set({ fields: ["/f/x", "/g/x"] });
              references.startReferences(state);
              const shown = { buffer, reference: 102, from: 100, to: 102 };
              for (const field of ["/f/x", "/g/x"]) {
                references.keepReference(state, shown, field, new Map());
              }
              module.setSource(state, "/f/x", "received");
              references.moveReference(state, "R1", { later: 0, offset: 10 });
              return state.values.references.map((one) => [one.name, one.field,
                references.valueOf(one, -1.5).low, Math.max(...one.lines.get(one.field).points),
                one.lines.get(one.field).steps]);
            })()""",
        )
        self.assertEqual(now, [["R1", "/f/x@received", 11, 12, True], ["R2", "/g/x", 7, 8, False]])

    def test_choice_of_a_timestamp_source_keeps_the_focus(self) -> None:
        focused = self.browser.call(
            "choose/timestamp_source.js",
            """await (async () => {
              const { State } = await import("/static/js/state/store.js");
              const state = new State();
              const table = document.createElement("div");
              document.body.append(table);
              state.on(["fields"], ({ fields }) => table.replaceChildren(
                ...fields.map((field) => module.timestampChoice(state, field, () => {}).element)));
              state.set({ fields: ["/f/x", "/g/x"] });
              const select = table.children[1];
              select.append(new Option("received"));
              select.focus();
              select.value = "received";
              select.dispatchEvent(new Event("change"));
              const label = document.activeElement.getAttribute("aria-label");
              table.remove();
              return [label, state.values.fields];
            })()""",
        )
        expected = ["timestamp source of /g/x@received", ["/f/x", "/g/x@received"]]
        self.assertEqual(focused, expected)

    def test_trace_settings_are_read_back(self) -> None:
        chosen = {
            "/a": {"plot": 2},
            "/b": {"slot": 7, "dash": "dotted", "drawn": "steps", "gain": 2.5, "offset": -1},
        }
        wrong = [{"plot": 9}, {"plot": 1.5}, {"slot": -1}, {"dash": "wavy"}, {"drawn": "dots"}]
        wrong += [{"gain": "2"}, {"offset": 1e301}, {"other": 1}, {"toString": 1}, None]
        reply = self.browser.call(
            "state/traces.js",
            "(() => { const written = module.writeTraces(module.readTraces(a[0]));"
            " const isAccepted = (one) => {"
            " try { return module.isTraces({'/c': one}); } catch { return false; } };"
            " return [written, module.isTraces(written), a[1].map(isAccepted)]; })()",
            chosen,
            wrong,
        )
        self.assertEqual(reply, [chosen, True, [False] * len(wrong)])

    def test_forty_traces_differ_and_keep_their_style(self) -> None:
        looks, after, written = self.browser.call(
            "state/colours.js",
            "await (async () => { const traces = await import('/static/js/state/traces.js');"
            " const axes = { x: {} }, colours = new Map(), theme = 'light';"
            " const names = Array.from({ length: 40 }, (_, index) => `/t/x${index}`);"
            " const of = (values) => values.fields.map((field) => [field, JSON.stringify("
            " [module.colourOf({ values }, field), module.dashOf({ values }, field)])]);"
            " const shown = (fields, known) => ({ fields, colours, theme,"
            " ...traces.arranged({ fields, axes, traces: known }) });"
            " const all = shown(names, new Map());"
            " const some = shown([...names.slice(5), '/new'], all.traces);"
            " return [of(all), of(some), traces.writeTraces(all.traces)]; })()",
        )
        self.assertEqual(len({look for _, look in looks}), 40)
        self.assertEqual(written, {})  # all settings are defaults
        # Remaining traces keep their styles, and a new one gets a freed style.
        self.assertEqual(after[:-1], looks[5:])
        self.assertEqual(after[-1][1], looks[0][1])

    def test_the_clock_is_local(self) -> None:
        moments = [0, 1.7e9, 1.72e9 + 0.25, 1.72e9 + 59.9999]
        zone = "Emulation.setTimezoneOverride"
        self.addCleanup(self.browser.driver.execute_cdp_cmd, zone, {"timezoneId": ""})
        self.browser.driver.execute_cdp_cmd(zone, {"timezoneId": "America/St_Johns"})
        names = self.browser.call("base/clock.js", "a[0].map(module.zoneText)", [1.7e9, 1.72e9])
        self.assertEqual(names, ["UTC−03:30", "UTC−02:30"])  # in winter, and in summer
        self.assertEqual(
            self.browser.call("base/clock.js", "module.dateText(1.7e9 + 2e4)"), "2023-11-15"
        )
        found = self.browser.call(
            "base/clock.js",
            "a[0].map((time) => [module.clockText(time, 1),"
            " new Date(Math.round(time) * 1e3).toLocaleTimeString('en-GB'),"
            " module.clockText(time, 0.01).slice(8),"
            " module.clockTicks(time, time + 10, 8).map(({v}) => (v - time) % 2 + time % 2)])",
            moments,
        )
        self.assertEqual([row[0] for row in found], [row[1] for row in found])
        self.assertEqual([row[2] for row in found], [".00", ".00", ".25", ".00"])
        for *_, steps in found:
            self.assertTrue(len(steps) >= 5 and all(abs(one % 2) < 1e-6 for one in steps), steps)

    def test_zoom_keeps_the_point_under_the_pointer(self) -> None:
        code = """(() => {
          const camera = new module.Camera();
          Object.assign(camera, { width: 800, height: 400 });
          camera.fit([[-3, -1], [5, 3]]);
          const corners = [camera.toPicture(-3, -1), camera.toPicture(5, 3)];
          const before = camera.toWorld(100, 50);
          camera.zoom(3, 100, 50);
          const after = camera.toWorld(100, 50);
          camera.pan(30, -40);
          return { corners, before, after, panned: camera.toWorld(130, 10), scale: camera.scale };
        })()"""
        reply = self.browser.call("robots/camera.js", code)
        (left, bottom), (right, top) = reply["corners"]
        self.assertTrue(0 < left < right < 800 and 0 < top < bottom < 400, reply)
        self.assertAlmostEqual((right - left) / 8, (bottom - top) / 4)  # one scale, y is up
        self.assertAlmostEqual((left + right) / 2, 400.0)  # in the middle
        self.assertAlmostEqual((top + bottom) / 2, 200.0)
        for name in ("after", "panned"):
            for value, expected in zip(reply[name], reply["before"]):
                self.assertAlmostEqual(value, expected, places=9)

    def test_the_wheel_sends_a_stop_with_each_release_and_no_limit_reverses_it(self) -> None:
        code = """a[0].map((text) => {
          const sent = [];
          const wheel = new module.Teleop((message) => sent.push(message));
          wheel.onSteering({ topic: "/cmd_vel", datatype: "geometry_msgs/Twist" });
          const limit = document.getElementById("drive-speed");
          const before = limit.value;
          limit.value = text;
          wheel.hold("w", 1, 0);
          wheel.hold("a", 0, 1);
          wheel.command();
          wheel.drop("w");
          const count = sent.length;
          wheel.drop("a");
          limit.value = before;
          return { held: sent.slice(0, count), released: sent.slice(count) };
        })"""
        limits = {"0.5": 0.5, "-0.5": 0.0, "fast": 0.0}
        answers = self.browser.call("robots/teleop.js", code, list(limits))
        self.assertEqual(len(answers), len(limits))
        for (limit, speed), reply in zip(limits.items(), answers):
            with self.subTest(limit=limit):
                held, released = (
                    [(each["speed"], each["turn"]) for each in reply[name]]
                    for name in ("held", "released")
                )
                self.assertEqual((held, released), ([(speed, 0.0), (speed, 1.0)], [(0.0, 0.0)]))

    def test_equal_scales_keep_the_shape_of_a_path(self) -> None:
        code = """(() => {
          const element = document.createElement("div");
          element.style.cssText = "position: fixed; width: 500px; height: 300px";
          document.body.append(element);
          const chart = new module.Chart(element, () => "#123456", () => []);
          const line = { field: "/a", xs: [0, 10, 10], ys: [0, 0, 1], marks: [] };
          const draw = (isEqual) => {
            chart.draw({ lines: [line], titles: { x: "", y: "" }, isEqual, exact: false });
            return line.xs.map((x, index) => chart.place(x, line.ys[index]));
          };
          const { fillText } = CanvasRenderingContext2D.prototype;
          const aligned = new Map(); // alignments, by the horizontal places of texts
          CanvasRenderingContext2D.prototype.fillText = function (text, x, y) {
            aligned.set(x, this.textAlign);
            fillText.call(this, text, x, y);
          };
          const places = [draw(true), draw(false)];
          CanvasRenderingContext2D.prototype.fillText = fillText;
          element.remove();
          return [...places, [...aligned.values()]];
        })()"""
        equal, filled, aligned = self.browser.call("plot/canvas_chart.js", code)
        self.assertEqual(set(aligned), {"center", "right"})  # below, and beside the axis
        sizes = [(b[0] - a[0], b[1] - c[1]) for a, b, c in (equal, filled)]  # y is down
        self.assertAlmostEqual(sizes[0][0] / sizes[0][1], 10.0)
        self.assertLess(sizes[1][0] / sizes[1][1], 4.0)

    def test_repositioned_robot_starts_a_new_trail(self) -> None:
        code = """(() => {
          const trails = new module.Trails();
          const go = (x) => trails.add([{ topic: "/odom", x, y: 0 }]);
          [0, 0.01, 0.1, 0.2, 5, 5.1].forEach(go);
          const lines = trails.of("/odom").map((line) => line.map(([x]) => x));
          for (const y of [0, 0.1, 0.2]) trails.add([{ topic: "/side", x: 0, y }]);
          const side = trails.of("/side").map((line) => line.map(([, y]) => y));
          for (let n = 0; n < 12000; n += 1) go(5.1 + 0.03 * n);
          const count = trails.of("/odom").reduce((sum, line) => sum + line.length, 0);
          return { lines, side, count, others: trails.of("/other").length };
        })()"""
        reply = self.browser.call("robots/trails.js", code)
        self.assertEqual(reply["lines"], [[0, 0.1, 0.2], [5, 5.1]])
        self.assertEqual(reply["side"], [[0, 0.1, 0.2]])
        self.assertLessEqual(reply["count"], 5001)
        self.assertEqual(reply["others"], 0)

    def test_reconnection_delays_grow_to_a_limit_and_restart(self) -> None:
        code = """(() => {
          const sockets = [], waits = [], reasons = [];
          const native = globalThis.WebSocket;
          globalThis.WebSocket = class {
            constructor() { this.events = {}; sockets.push(this); }
            addEventListener(name, listener) { this.events[name] = listener; }
            close() {}
          };
          const connection = new module.Connection(
            "ws://nowhere", () => {}, (state, wait, reason) => {
              if (state === "lost") { waits.push(wait); reasons.push(reason); } });
          for (let number = 0; number < 9; number += 1) {
            connection.connect();
            const socket = sockets[sockets.length - 1];
            if (number === 7) socket.events.message({ data: "{}" });
            socket.events.close({ reason: number < 8 ? "full" : "" });
          }
          clearTimeout(connection.timer);
          globalThis.WebSocket = native;
          return [waits, reasons];
        })()"""
        waits, reasons = self.browser.call("base/connection.js", code)
        self.assertEqual(reasons, [*["full"] * 8, ""])
        expected = [
            250,
            500,
            1000,
            2000,
            4000,
            5000,
            5000,
            250,
            500,
        ]  # ms, and up to a quarter more
        self.assertEqual(len(waits), len(expected))
        for wait, least in zip(waits, expected):
            self.assertTrue(least <= wait <= 1.25 * least, waits)

    def test_silent_server_and_former_connection_are_closed(self) -> None:
        code = """(() => {
          const sockets = [], timers = [], states = [];
          const natives = { WebSocket, setTimeout };
          globalThis.WebSocket = class {
            constructor() { this.events = {}; this.closed = false; sockets.push(this); }
            addEventListener(name, listener) { this.events[name] = listener; }
            close() { this.closed = true; this.events.close({ reason: "" }); }
          };
          globalThis.setTimeout = (work, wait) => timers.push({ work, wait });
          const connection = new module.Connection(
            "ws://nowhere", (message) => states.push(message), (state) => states.push(state));
          connection.connect();
          timers[0].work();
          connection.connect();
          connection.connect();
          sockets[1].events.message({ data: "1" });
          sockets[2].events.message({ data: "2" });
          Object.assign(globalThis, natives);
          return [states, timers[0].wait, sockets.map(({ closed }) => closed)];
        })()"""
        states, wait, closed = self.browser.call("base/connection.js", code)
        self.assertEqual(states, ["connecting", "lost", "connecting", "connecting", "connected", 2])
        self.assertEqual((wait, closed), (10000, [True, True, False]))

    def test_timeout_grows_after_a_lost_connection(self) -> None:
        code = """(() => {
          const sockets = [], timers = [], waits = [];
          const natives = { WebSocket, setTimeout };
          globalThis.WebSocket = class {
            constructor() { this.events = {}; sockets.push(this); }
            addEventListener(name, listener) { this.events[name] = listener; }
            close() {}
          };
          globalThis.setTimeout = (work, wait) => timers.push({ work, wait });
          const connection = new module.Connection("ws://nowhere", () => {}, () => {});
          for (let times = 0; times < 5; times += 1) {
            connection.connect();
            waits.push(timers.at(-1).wait);
            connection.expectMore();
            sockets.at(-1).events.message({ data: "1" });
            timers.at(-1).work();
          }
          Object.assign(globalThis, natives);
          return waits;
        })()"""
        waits = self.browser.call("base/connection.js", code)
        self.assertEqual(waits, [10000, 20000, 40000, 60000, 60000])

    def test_typed_numbers(self) -> None:
        texts = ["1.5", " -2.25 ", "−3", "1e3", "", "fast", "1,000", "2,5"]
        answers = self.browser.call("base/numbers.js", "a[0].map(module.readNumber)", texts)
        self.assertEqual(answers[:5], [1.5, -2.25, -3, 1000, None])
        self.assertEqual(answers[5:], [None] * 3)  # NaN, as it travels
        said = self.browser.call("base/numbers.js", "a[0].map(module.ambiguity)", texts)
        self.assertEqual(said[:6], [""] * 6)
        for text, sentence in zip(texts[6:], said[6:]):
            self.assertTrue(sentence.startswith(f"{text} is ambiguous"), sentence)

    def test_number_with_a_comma_is_rejected(self) -> None:
        said = self.browser.call(
            "base/numbers.js",
            """(() => {
              const input = document.createElement("input");
              input.inputMode = "decimal";
              input.value = a[0];
              document.body.append(input);
              input.dispatchEvent(new Event("change", { bubbles: true }));
              input.remove();
              return document.getElementById("notice").textContent;
            })()""",
            "1,000",
        )
        self.assertIn("1,000 is ambiguous", said)

    def test_range_grows_immediately_and_shrinks_later(self) -> None:
        steps = [[-1, 1, 0], [-1, 3, 0.1], [-0.1, 0.1, 0.2], [-0.1, 0.1, 1.0], [-0.1, 0.1, 5.0]]
        steps.append([-0.02, 0.02, 5.1])
        first, grown, waiting, still, shrunk, again = self.browser.call(
            "base/numbers.js",
            "(() => { const range = new module.AutoRange();"
            " return a[0].map((step) => range.update(...step)); })()",
            steps,
        )
        self.assertTrue(first[0] < -1 and 1 < first[1] <= 1.5, first)
        self.assertTrue(3 < grown[1] <= 4, grown)
        self.assertEqual([waiting, still], [grown, grown])
        self.assertTrue(0.1 < shrunk[1] < 0.2, shrunk)
        self.assertEqual(again, shrunk)

    def test_end_of_a_line_is_nan(self) -> None:
        frame = {"now": 10, "bin": 1, "reset": True, "first": 5}
        traces = {"f": [1, 2, False, False, None, None, 3, 4]}
        # dygraphs connects across null, but not across NaN.
        found = self.browser.call(
            "state/buffer.js",
            "(() => { const buffer = new module.TraceBuffer(); buffer.apply(a[0], 10);"
            " return [buffer.rows(['f'], 0).map((row) => String(row[1])), buffer.filled('f'),"
            " buffer.extent(['f'], 0, 100),"
            " [5.5, 6.5, 7.5, 8.5].map((time) => buffer.at('f', time)).map((one) => one &&"
            " [one.low, one.high])]; })()",
            {**frame, "traces": traces},
        )
        rows = ["1", "2", "NaN", "3", "4"]
        self.assertEqual(found, [rows, 2, [1, 4], [[1, 2], None, None, [3, 4]]])

    def test_a_line_has_a_value_between_its_ends_and_a_step_beside_them(self) -> None:
        bins = [None, None, 1, None, 3, None, None, None, False, 5, None, 7, None]
        found = self.browser.call(
            "state/buffer.js",
            "(() => { const buffer = new module.TraceBuffer(); buffer.apply(a[0], 20);"
            " return a[1].map((time) => buffer.at('f', time)?.low ?? null); })()",
            {
                **{"now": 13, "bin": 1, "reset": True, "first": 0},
                "traces": {"f": [value for value in bins for _ in "lh"]},
            },
            [number + 0.5 for number in range(len(bins))],
        )
        # Between two samples the value is on the drawn line.
        self.assertEqual(found, [1, 1, 1, 2, 3, 3, 3, None, None, 5, 6, 7, 7])

    def test_readings_equal_the_drawn_line(self) -> None:
        """Samples at known places of their bins, and a bin with more than are drawn."""
        frame = {
            **{"now": 8, "bin": 1, "reset": True, "first": 0},
            "traces": {"f": [0, 0, 8, 8, None, None, 16, 16, -2, 5, 1, 1, None, None, None, None]},
            "places": {"f": [0, 0, 4, 4, -1, -1, 0, 0, -1, -1, 7, 7, -1, -1, -1, -1]},
            "counts": {"f": [1, 1, 0, 1, 7, 1, 0, 0]},
        }
        times = [0.0625, 0.8125, 1.5625, 2.3125, 3.0625, 4.2, 4.9, 5.9375, 7.9]
        found = self.browser.call(
            "state/buffer.js",
            "(() => { const buffer = new module.TraceBuffer(); buffer.apply(a[0], 20);"
            " const read = a[1].map((time) => buffer.at('f', time));"
            " return [read.map((one) => one && [one.low, one.high]), buffer.rows(['f'], 0),"
            " read.map((one) => one?.count ?? 0), read.map((one) => one?.uncertainty ?? 0)]; })()",
            frame,
            times,
        )
        read, rows, counts, uncertainties = found
        self.assertEqual(counts, [0, 0, 0, 0, 0, 7, 7, 0, 0])
        line = [(time, value) for time, value in rows if value is not None]
        for time, reading in zip(times[:4], read):
            drawn = numpy.interp(time, [at for at, _ in line], [value for _, value in line])
            self.assertAlmostEqual(reading[0], drawn)
            self.assertEqual(reading[0], reading[1])
        self.assertEqual(read[:4], [[0, 0], [4, 4], [8, 8], [12, 12]])
        self.assertEqual(read[4:], [[16, 16], [-2, 5], [-2, 5], [1, 1], None])
        # Places are rounded to an eighth: the slope is at most 8 in 1.375 bins, or beside the full
        # bin unknown.
        self.assertAlmostEqual(uncertainties[1], 8 / 1.375 / 16)
        self.assertEqual((uncertainties[4], uncertainties[5], uncertainties[8]), (11, 0, 0))
        texts = self.browser.call(
            "base/numbers.js",
            "a[0].map((one) => module.readingText(one, 2))",
            [
                {"low": -0.9511, "high": 0.951, "count": 20},
                {"low": 1.5, "high": 1.5, "uncertainty": 0},
                {"low": 1.5, "high": 1.5, "uncertainty": 0.025},
                None,
            ],
        )
        expected = [
            ("20 samples, −0.9511 … 0.9510", ""),
            ("1.5000", ""),
            ("1.500", "0.025"),
            ("–", ""),
        ]
        self.assertEqual([(one["value"], one["uncertainty"]) for one in texts], expected)

    def test_the_last_value_of_a_bin_holds_in_steps(self) -> None:
        frames = [
            {
                **{"now": 9, "bin": 1, "reset": True, "first": 5},
                "traces": {"f": [0, 5, None, None, 1, 1, 7, 7], "g": [1, 2, 3, 4, 5, 6, 7, 8]},
                "lasts": {"f": [3, None, 1, 7]},
            },
            {
                **{"now": 12, "bin": 1, "reset": False, "first": 8},
                "traces": {"f": [7, 8, None, None, False, False], "g": [7, 8] * 3},
                "lasts": {"f": [8, None, None]},
            },
        ]
        rows, held, bins = self.browser.call(
            "state/buffer.js",
            "(() => { const buffer = new module.TraceBuffer();"
            " a[0].forEach((frame) => buffer.apply(frame, 4));"
            " const rows = buffer.rows(['f', 'g'], 0);"
            " return [rows.map((row) => row.map(String)),"
            " [7.5, 8.1, 9.9, 10.5, 4.9].map((time) => buffer.at('f', time)?.low ?? null),"
            " buffer.copy().lasts.get('f')]; })()",
            frames,
        )
        # Four bins and two spare ones: the line covers all, and then holds the last value.
        self.assertEqual([row[1] for row in rows[:3]], ["0", "5", "3"])
        self.assertEqual([row[1] for row in rows[3:11]], ["null"] * 2 + ["1"] * 3 + ["7", "8", "8"])
        self.assertEqual([row[2] for row in rows[:3]], ["1", "2", "null"])
        self.assertEqual({row[0] for row in rows[:3]}, {"5.5"})
        self.assertEqual(held, [1, 8, 8, None, None])
        self.assertEqual(bins, [3, None, 1, 8, None, None])

    def test_page_of_another_version_asks_for_a_reload(self) -> None:
        read, text, is_shown = self.browser.call(
            "base/link.js",
            "(() => { const version = 1;"
            " const read = [{ type: 'fields' }, { type: 'hello', protocol: version },"
            " { type: 'hello', protocol: version + 1 }, { type: 'frame' }].map(module.isReadable);"
            " const shown = [document.getElementById('banner-text').textContent,"
            " !document.getElementById('banner').hidden];"
            " module.isReadable({ type: 'hello', protocol: version });"
            " module.showMaster({ text: '' });"
            " return [read, ...shown]; })()",
        )
        self.assertEqual(read, [True, True, False, False])
        self.assertTrue(is_shown)
        self.assertIn("another version than the scope: reload the page", text)

    def test_integers_are_drawn_in_steps(self) -> None:
        types = ["bool", "uint8", "int64", "byte", "char", "float32", "float64", "time", "duration"]
        names = [f"/{name}" for name in types]
        more = ["/int64[12]@stamp", "/int64.difference", "/int64.derivative", "/unknown"]
        stepped, scaled = self.browser.call(
            "state/traces.js",
            "(() => { const [names, more] = a; const available = [...names, '/int64[0]'].map("
            " (field) => ({ field, datatype: field.match(/\\w+/)[0] }));"
            " const traces = module.readTraces({ '/bool': { drawn: 'line', gain: -0.5 },"
            " '/time': { drawn: 'steps', offset: -2e-7 } });"
            " const values = { available, traces, fields: [...names, ...more] };"
            " const { traces: scales } = module.scalingOf(values);"
            " return [Object.keys(scales).filter((field) => scales[field].steps),"
            " ['/bool', '/time', '/int64'].map((field) => module.scaledText(values, field))]; })()",
            names,
            more,
        )
        self.assertEqual(stepped, [*names[1:5], "/time", *more[:2]])
        self.assertEqual(scaled, ["scaled × −0.5", "scaled − 2e−7", ""])

    def test_frames_are_joined_and_forgotten(self) -> None:
        frames = [
            {
                **{"now": 10, "bin": 1, "reset": True, "first": 5},
                **{"traces": {"f": [1, 2, 3, 4]}, "counts": {"f": [3, 4]}},
            },
            # The last bin is replaced, one is added, and a trace is new.
            {
                **{"now": 11, "bin": 1, "reset": False, "first": 6},
                **{"traces": {"f": [3, 9, 5, 6]}, "counts": {"f": [5, 6]}},
            },
            {
                "now": 12,
                "bin": 1,
                "reset": False,
                "first": 8,
                "traces": {"f": [7, 8], "g": [0, 0]},
            },
        ]
        answers = self.browser.call(
            "state/buffer.js",
            "(() => { const buffer = new module.TraceBuffer();"
            " const values = (field) => buffer.traces.get(field)?.slice() ?? null;"
            " return a[0].map((frame) => { buffer.apply(frame, 1);"
            " return [buffer.first, values('f'), values('g'), buffer.at('f', 6.5).count]; }); })()",
            frames,
        )
        self.assertEqual(answers[0], [5, [1, 2, 3, 4], None, 4])
        self.assertEqual(answers[1], [5, [1, 2, 3, 9, 5, 6], None, 5])
        # A second and two more bins are kept: the oldest bin is dropped.
        self.assertEqual(answers[2], [6, [3, 9, 5, 6, 7, 8], [None] * 4 + [0, 0], 5])

    def test_sweep_is_held_once_complete(self) -> None:
        for mode in ("normal", "single"):
            held, values = self.browser.call(
                "state/sweep.js",
                "(() => { const values = {window: 2, end: null, reference: null,"
                " trigger: {mode: a[0], field: 'f', edge: 'rising'}};"
                " const sweep = new module.Sweep("
                "{values, on() {}, set(changes) { Object.assign(values, changes); }});"
                " const seen = []; const frame = (first, count) => {"
                " sweep.onFrame({now: (first + count) / 10, bin: 0.1, reset: !seen.length, first,"
                " traces: {f: Array(2 * count).fill(first)}});"
                " const {buffer, from, to, reference} = sweep.shown;"
                " seen.push([from, to, reference, buffer.at('f', from + 0.05)?.low,"
                " buffer.at('f', to - 0.05)?.low]); };"
                " frame(70, 31); sweep.onTrigger({state: 'triggered', time: 10});"
                " frame(101, 8); frame(109, 1); frame(110, 10); frame(120, 10);"
                " return [seen, values]; })()",
                mode,
            )
            self.assertEqual([round(to, 6) for _, to, *_ in held], [10.1, 10.9, 11, 11, 11])
            self.assertEqual([round(one, 6) for one in held[2]], [9, 11, 10, 70, 109])
            if mode == "normal":  # held despite new frames; a single sweep gets no more frames
                self.assertEqual(held[3:], held[2:3] * 2)
            self.assertEqual(values["end"], 11 if mode == "single" else None)

    def test_next_crossing_does_not_discard_the_sweep_of_the_last_one(self) -> None:
        times = self.browser.call(
            "state/sweep.js",
            "(() => { const values = {window: 2, end: null, trigger: {mode: 'normal'}};"
            " const sweep = new module.Sweep({values, on() {}});"
            " const frame = (now) => { sweep.onFrame({now, bin: 0.1, reset: false,"
            " first: Math.round(10 * now), traces: {f: [0, 1]}});"
            " return sweep.held?.time ?? null; };"
            " sweep.onTrigger({state: 'triggered', time: 10}); const held = [frame(10.9)];"
            " sweep.onTrigger({state: 'triggered', time: 11}); return [...held,"
            " ...[11, 11.9, 12].map(frame)]; })()",
        )
        self.assertEqual(times, [None, 10, 10, 11])

    def test_held_sweep_is_released_by_another_scale_only(self) -> None:
        position, held = self.browser.call(
            "state/sweep.js",
            """await (async () => {
              const { State } = await import("/static/js/state/store.js");
              const state = new State();
              const { position } = state.values.trigger;
              const sweep = new module.Sweep(state);
              state.set({ fields: ["/a"] });
              const plain = { gain: 1, offset: 0 };
              const higher = { gain: 2, offset: 0 };
              const held = [plain, higher, { ...higher, dash: "dotted" }].map((one) => {
                sweep.held = {};
                state.set({ traces: new Map([["/a", one]]) });
                return sweep.held !== null;
              });
              return [position, held];
            })()""",
        )
        self.assertEqual((position, held), (0.5, [True, False, True]))

    def test_late_image_of_another_topic_is_not_shown(self) -> None:
        shown = self.browser.call(
            "measure/images.js",
            """await (async () => {
              const native = globalThis.fetch;
              const description = JSON.stringify({ time: 1, known: "7", text: "an image" });
              globalThis.fetch = async () => ({ ok: true, status: 200, blob: async () => new Blob(),
                headers: new Map([["Image-Description", description]]) });
              const panel = { topic: "/b", known: "", picture: document.createElement("img") };
              const { load: method } = module.Images.prototype;
              const load = (topic) => method.call(panel, topic, { time: null });
              await load("/a");
              const before = panel.known;
              await load("/b");
              globalThis.fetch = native;
              return [before, panel.known];
            })()""",
        )
        self.assertEqual(shown, ["", "7"])

    def test_each_mask_shows_its_limits_once_and_stops_at_its_first_failure(self) -> None:
        changes = self.browser.call(
            "measure/mask.js",
            """(() => {
              const native = globalThis.fetch, changes = [];
              globalThis.fetch = () => Promise.reject();
              const state = { values: { fields: ["/a", "/b"], window: 4 },
                set: (change) => changes.push(change) };
              const mask = module.startMask(state, () => {});
              mask.choose("/a");
              for (const first of [10, 20]) {
                document.getElementById("mask-begin").click();
                for (const time of [first, first + 1]) {
                  mask.onResult({ text: "", first: time, limits: [`/limit${first}`] });
                }
              }
              document.getElementById("mask-end").click();
              globalThis.fetch = native;
              return changes;
            })()""",
        )
        expected = [
            change
            for first in (10, 20)
            for change in ({"fields": ["/a", "/b", f"/limit{first}"]}, {"end": first + 1})
        ]
        self.assertEqual(changes, expected)

    def test_mask_is_offered_around_numbers_only(self) -> None:
        offered = self.browser.call(
            "measure/mask.js",
            """(() => {
              const values = { fields: ["/a", "/mode/data.state", "=/a * 2"] };
              module.startMask({ values }, () => {}).choose("/a");
              const around = document.getElementById("mask-around");
              return [...around.options].map(({ value }) => value);
            })()""",
        )
        self.assertEqual(offered, ["=/a * 2"])

    def test_two_fingers_zoom_until_one_is_lifted_or_cancelled(self) -> None:
        found = self.browser.call(
            "base/pointers.js",
            """a[0].map(([end, places]) => {
              const element = document.createElement("div");
              const found = [];
              module.startTwoFingers(element, ({ factor, x, y, across, upright }) =>
                found.push([factor, x, y, across, upright]));
              const touch = (type, pointerId, clientX, clientY) => element.dispatchEvent(
                new PointerEvent(type, { pointerId, clientX, clientY, pointerType: "touch" }));
              touch("pointerdown", 1, ...places[0]);
              touch("pointerdown", 2, ...places[1]);
              touch("pointermove", 2, ...places[2]);
              touch(end, 2, ...places[2]);
              touch("pointermove", 1, 50, 0);
              return found;
            })""",
            [
                ("pointerup", [(0, 0), (100, 20), (150, 20)]),
                ("pointercancel", [(100, 20), (0, 0), (-50, 0)]),
                ("pointerup", [(0, 100), (10, 20), (10, 60)]),
            ],
        )
        self.assertEqual(
            found,
            [
                [[1.5, 75, 10, 25, False]],
                [[1.5, 25, 10, -25, False]],
                [[0.5, 5, 80, 0, True]],
            ],
        )

    def test_one_turn_of_a_wheel_zooms_by_a_limited_factor(self) -> None:
        factors = self.browser.call(
            "base/pointers.js",
            "a[0].map(([deltaMode, deltaY]) => module.wheelFactor({ deltaMode, deltaY }))",
            [(0, 100), (0, 300), (0, 9000), (0, -9000), (1, 1), (0, 33)],
        )
        small, most, huge, back, lines, pixels = factors
        self.assertTrue(1.0 < small < most, factors)
        self.assertEqual((huge, lines), (most, pixels))  # a line is 33 pixels
        self.assertAlmostEqual(back * most, 1.0)

    def test_two_fingers_above_each_other_zoom_the_values_alone(self) -> None:
        changes = self.browser.call(
            "plot/gestures.js",
            """(() => {
              const stage = document.createElement("div");
              stage.setPointerCapture = () => {};
              const changes = [];
              const note = (name) => (...values) => changes.push([name, ...values]);
              const view = { state: { values: { fields: ["/a"], traces: new Map(), end: 1,
                axes: { x: {}, y: {}, y2: {} }, right: new Set() } },
                zoomX: note("zoomX"), zoomY: note("zoomY"),
                panX: note("panX"), panY: note("panY") };
              const plot = { number: 1, at: () => ({ across: 0.5, up: 0.25 }),
                area: { w: 100, h: 50 } };
              const plots = { under: () => plot, plotOf: () => plot, area: { w: 100, h: 200 } };
              module.startGestures(stage, plots, view);
              const touch = (type, pointerId, clientX, clientY) => stage.dispatchEvent(
                new PointerEvent(type, { pointerId, clientX, clientY, pointerType: "touch" }));
              touch("pointerdown", 1, 0, 0);
              touch("pointerdown", 2, 0, 50);
              touch("pointermove", 2, 0, 100);
              const mouse = (type, clientY) => stage.dispatchEvent(
                new PointerEvent(type, { clientY, shiftKey: true, pointerType: "mouse" }));
              mouse("pointerdown", 0);
              mouse("pointermove", 25);
              return changes;
            })()""",
        )
        names = {name for name, *_ in changes}
        self.assertEqual(names, {"zoomY", "panY"})
        zoomed = [rest for name, *rest in changes if name == "zoomY"]
        self.assertEqual({(factor, up) for _, factor, up in zoomed}, {(0.5, 0.25)})
        # Half of the height of its own plot, not of all plots.
        moved = [rest for name, *rest in changes if name == "panY"]
        self.assertEqual({part for _, part in moved}, {0.5})

    def test_stacked_plots_share_widths_and_limit_values(self) -> None:
        widths, values, seen = self.browser.call(
            "plot/stack.js",
            """(() => {
              const { widths, valueAt, draw } = module.Plots.prototype;
              const list = [
                { onlyRight: false, hasRight: true, widths: { y: 20, y2: 70 } },
                { onlyRight: true, hasRight: true, widths: { y: 90, y2: 30 } },
                { onlyRight: false, hasRight: false, widths: { y: 40, y2: 95 } },
              ];
              const lower = { range: () => [10, 20], spanOf: () => ({ low: 0, high: 0.5 }) };
              const seen = [];
              const plots = { list: [], isArranged: true, shown: "before",
                listeners: [() => seen.push(plots.shown)] };
              draw.call(plots, "now");
              return [widths.call({ list }),
                [-1, 0, 0.25, 0.5, 0.9].map((place) => valueAt.call(lower, "y", place)), seen];
            })()""",
        )
        self.assertEqual(widths, {"y": 40, "y2": 70})
        self.assertEqual(values, [10, 10, 15, 20, 20])
        self.assertEqual(seen, ["now"])

    def test_view_runs_from_the_present_and_is_reset_around_its_trigger(self) -> None:
        answers = self.browser.call(
            "state/view.js",
            """(() => {
              const of = (values, held) => {
                const state = { values, on() {}, setTrigger() {},
                  set: (changes) => Object.assign(values, changes) };
                return new module.View(state, { held, release() {} }, {});
              };
              const trigger = { mode: "normal", position: 0.25 };
              const paused = () => ({ end: 30, reference: 20, trigger, baseWindow: 8, window: 1,
                axes: { x: { title: "s" }, y: { low: 1, high: 2 } } });
              const running = paused(), around = paused(), plain = paused();
              of(running, {}).run();
              of(around, {}).reset();
              of(plain, null).reset();
              return [running, around, plain].map(({ end, reference, window, axes }) =>
                [end, reference, window, axes.y.low, axes.y.high]);
            })()""",
        )
        automatic = [None, None]
        self.assertEqual(
            answers, [[None, None, 1, 1, 2], [26, 20, 8, *automatic], [20, 20, 8, *automatic]]
        )

    def test_a_bag_sets_the_clock_of_a_fresh_page_only(self) -> None:
        clocks = self.browser.call(
            "page/playback.js",
            """a[0].map((fresh) => {
              const changes = [];
              const page = { place: {}, state: { set() {},
                setAxis: (name, change) => changes.push([name, change]) } };
              const { onHello } = module.Playback.prototype;
              onHello.call(page, { bag: { name: "x.bag", start: 5, end: 8 } }, fresh);
              onHello.call(page, {}, fresh);
              return [changes, page.place.max];
            })""",
            [True, False],
        )
        self.assertEqual(clocks, [[[["x", {"clock": True}]], 3], [[], 3]])

    def test_line_moved_by_keys_stays_inside(self) -> None:
        places = self.browser.call(
            "plot/handle.js",
            """(() => {
              const places = [];
              const handle = new module.Handle(document.createElement("div"),
                { kind: "level", name: "", label: "", move: (part) => places.push(part) });
              for (const [part, key, shiftKey] of a[0]) {
                handle.place(part, 0, "");
                handle.element.dispatchEvent(new KeyboardEvent("keydown", { key, shiftKey }));
              }
              return places;
            })()""",
            [(0.5, "ArrowUp", False), (0.99, "ArrowUp", True), (0.001, "ArrowDown", False)],
        )
        self.assertEqual(places, [0.505, 1, 0])

    def test_level_cursors_name_their_trace_and_press_their_button(self) -> None:
        pressed, text, rest = self.browser.call(
            "measure/level_cursors.js",
            """(() => {
              const button = document.getElementById("level-cursors");
              const overlay = document.createElement("div");
              const traces = new Map([["/a", { gain: 2, offset: 0 }]]);
              const values = { levels: null, fields: ["/a"], traces };
              const plot = { axisOf: () => "y", placeOf: () => 0.5, onDrawn() {} };
              const cursors = new module.LevelCursors(overlay, { values, on() {} }, plot);
              values.levels = { field: "/a", c: 1.25, d: 3 };
              cursors.place();
              const shown = [button.getAttribute("aria-pressed"), overlay.textContent];
              values.levels = null;
              cursors.place();
              return [...shown, button.getAttribute("aria-pressed")];
            })()""",
        )
        self.assertEqual((pressed, rest), ("true", "false"))
        self.assertIn("C 1.2500   D 3.0000   C − D −1.7500   on the axis of /a scaled × 2", text)

    def test_oldest_sweep_is_dropped_first(self) -> None:
        times = self.browser.call(
            "state/persistence.js",
            """(() => {
              const listeners = [];
              const kept = new module.Persistence({ on: (_, act) => listeners.push(act) });
              listeners[0]({ persistence: 2 });
              for (const time of [1, 2, 3]) {
                const rows = () => [-0.09, 0, 0.5, 1.09, 1.2].map((at) => [at, time]);
                const buffer = { traces: new Map([["/a", []]]), lasts: new Map(), rows };
                kept.keep({ buffer, time }, 0, 1);
              }
              const lines = kept.sweeps.map((sweep) => [...sweep.get("/a").points]);
              listeners[0]({ persistence: 1 });
              return [lines, kept.sweeps.map((sweep) => sweep.get("/a").points[1])];
            })()""",
        )
        # A line reaches a tenth of the window beyond both edges.
        expected = [[-0.09, n, 0, n, 0.5, n, 1.09, n] for n in (2, 3)]
        self.assertEqual(times, [expected, [3]])

    def test_spectrum_lines_begin_at_their_first_frequency(self) -> None:
        drawn = self.browser.call(
            "plot/kinds.js",
            "['linear', 'dB'].map((scale) => module.spectra(a[0], ['/a', '/b'], scale))"
            ".map(({ lines: [one] }) => [one.xs, one.ys, one.marks.map(({ x, y }) => [x, y])])",
            {"/a": {"first": 2, "step": 0.5, "values": [1, 0.1, None], "peaks": [[2, 1, 0.1, ""]]}},
        )
        frequencies = [2, 2.5, 3]
        expected = [[1, 0.1, None], [[2, 1]]], [[0, -20, None], [[2, 0]]]
        self.assertEqual(drawn, [[frequencies, *rest] for rest in expected])

    def test_averages_are_requested_as_a_number(self) -> None:
        averages = self.browser.call(
            "plot/kinds.js",
            """await (async () => {
              const { State } = await import("/static/js/state/store.js");
              const state = new State();
              const requests = { chart: {}, sendChart: (message) => { requests.chart = message; } };
              module.startCharts(state, requests, () => "#123456");
              state.change("chart", { kind: "spectrum" });
              const select = document.querySelector("[aria-label='spectrum averages']");
              select.value = "4";
              select.dispatchEvent(new Event("change"));
              const { averages } = requests.chart;
              state.change("chart", { kind: "time" });
              return averages;
            })()""",
        )
        self.assertEqual(averages, 4)

    def test_labels_of_the_floor_are_muted(self) -> None:
        labels = self.browser.call(
            "robots/drawing.js",
            """await (async () => {
              const { Camera } = await import("/static/js/robots/camera.js");
              const camera = new Camera();
              Object.assign(camera, { width: 800, height: 400 });
              camera.fit([[-3, -1], [5, 3]]);
              const context = document.createElement("canvas").getContext("2d");
              const labels = [];
              context.fillText = (text) => labels.push([text, context.fillStyle]);
              const style = (name) => (name === "muted" ? "#112233" : "#445566");
              new module.Drawing(context, camera, style).clear(1);
              return labels;
            })()""",
        )
        self.assertTrue({"0", "2"} <= {text for text, _ in labels}, labels)
        self.assertEqual({colour for _, colour in labels}, {"#112233"})

    def test_faint_robot_leaves_the_others_bright(self) -> None:
        alphas = self.browser.call(
            "robots/drawing.js",
            """(() => {
              const canvas = document.createElement("canvas");
              const context = canvas.getContext("2d");
              const drawing = new module.Drawing(context, {}, () => "#000000");
              drawing.pixel = 0.01;
              const alphas = [];
              drawing.disc = () => alphas.push(context.globalAlpha);
              for (const isFaint of [true, false]) {
                drawing.robot({ x: 0, y: 0, heading: 0 }, "#ff0000", isFaint);
                alphas.push(context.globalAlpha);
              }
              return alphas;
            })()""",
        )
        self.assertAlmostEqual(alphas[0], 0.35, places=2)
        self.assertEqual(alphas[1:], [1, 1, 1])

    def test_resized_view_of_robots_keeps_what_the_user_has_chosen(self) -> None:
        fitted = self.browser.call(
            "robots/scene_view.js",
            """a[0].map((touched) => {
              let fitted = 0;
              const view = { canvas: document.createElement("canvas"), camera: {}, touched,
                fit: () => { fitted += 1; }, refresh() {} };
              const [, Kind] = Object.entries(module).find(([, one]) => one.prototype?.resize);
              Kind.prototype.resize.call(view);
              return fitted;
            })""",
            [True, False],
        )
        self.assertEqual(fitted, [0, 1])

    def test_rate_of_a_silent_topic_is_zero_and_an_unknown_one_is_empty(self) -> None:
        texts = self.browser.call(
            "graph/topology.js",
            """(() => {
              const graph = { all: { checked: true }, rates: new Map(), drawn: "", draw(_, links) {
                for (const { from, to } of links) {
                  this.rates.set(`${from} ${to}`, document.createElement("b"));
                }
              } };
              const edges = Object.entries(a[0]).map(([topic, rate]) =>
                ({ from: "/n", to: "/m", topic, rate }));
              const topics = Object.keys(a[0]).map((name) => ({ name, datatype: "a/B" }));
              module.Graph.prototype.show.call(graph, { nodes: ["/n", "/m"], topics, edges });
              return [...graph.rates.values()].map((one) => one.textContent);
            })()""",
            {"/p": 0, "/q": None, "/r": 9.87, "/s": 123.4},
        )
        self.assertEqual(set(texts), {"0 Hz", "", "9.9 Hz", "123 Hz"})

    def test_invalid_setup_is_named(self) -> None:
        said = self.browser.call(
            "page/setup.js",
            "a[0].map((one) => { try { return Object.keys(module.read(one)); }"
            " catch (error) { return error.message; } })",
            [None, 3, {"window": -1}, {"other": 1}, {"window": 2}],
        )
        expected = ["a set-up must be a JSON object"] * 2
        expected += ["the set-up has an invalid window", "the set-up has an invalid other"]
        self.assertEqual(said, [*expected, ["window"]])

    def test_shown_figures_have_one_order(self) -> None:
        keys = self.browser.call(
            "measure/statistics.js",
            "module.shownFigures({ measures: { figures: a[0] } }).map(([key]) => key)",
            ["max", "rate", "mean"],
        )
        self.assertEqual(keys, ["rate", "max", "mean"])

    def test_plot_without_a_size_requests_a_usable_width(self) -> None:
        widths = self.browser.call(
            "page/requests.js",
            """a[0].map((w) => {
              const requests = { timer: null, plot: { area: { w } },
                state: { values: { view: "scope", window: 5, end: null } },
                send: (message) => { requests.sent = message; } };
              module.Requests.prototype.sendView.call(requests);
              return requests.sent.width;
            })""",
            [0, 801.4, 9000],
        )
        self.assertEqual(widths, [50, 801, 4000])

    def test_states_are_read_as_they_are_sent(self) -> None:
        states = {
            "until": 9.0,
            "traces": {
                "/m/data.state": {
                    "texts": ["idle", "drive"],
                    "spans": [[1.0, 3.0, 0, 1], [4.0, 6.0, -1, 7], [6.0, None, 1, 1]],
                    "earlier": True,
                }
            },
        }
        reply = self.browser.call(
            "state/states.js",
            "(() => { const spans = module.spansOf(a[0], '/m/data.state');"
            " return a[1].map((time) => { const one = module.spanAt(spans, time);"
            " return one ? [one.text, one.from, one.to, one.isOpen, one.isEarlier] : null;"
            " }); })()",
            states,
            [0.5, 1.0, 2.9, 3.0, 5.0, 6.0, 9.0, 9.1],
        )
        idle, several, drive = (
            ["idle", 1, 3, False, True],
            ["7 states", 4, 6, False, False],
            ["drive", 6, 9, True, False],
        )
        self.assertEqual(reply, [None, idle, idle, None, several, drive, drive, None])

    def test_states_are_recognised_and_coloured_by_text(self) -> None:
        names = ["/a/b.state", "/a/b.state@stamp", "/a/state", "/a/b.yaw", "=/a/b.state", "/a/b"]
        reply = self.browser.call("state/states.js", "module.numbersOf(a[0])", names)
        self.assertEqual(reply, names[2:])
        places = self.browser.call(
            "state/states.js", "a[0].map(module.placeOf)", ["OK", "WARN", "OK", ""]
        )
        self.assertEqual(places[0], places[2])
        self.assertNotEqual(places[0] % 10, places[1] % 10)

    def test_cursors_show_the_inverse_of_their_distance(self) -> None:
        answers = self.browser.call(
            "measure/cursors.js",
            "a[0].map(([from, to]) => { const values = {cursors: null};"
            " const overlay = document.createElement('div');"
            " const cursors = new module.Cursors(overlay, {values, on() {}, set() {}},"
            " {times: [0, 10], onDrawn() {}});"
            " const count = () => overlay.querySelectorAll('.handle:not([hidden])').length;"
            " cursors.place(); const before = count();"
            " values.cursors = {a: from, b: to}; cursors.place();"
            " const ends = cursors.valuesBy((time) =>"
            " ({ low: time, high: 2 * time, uncertainty: 0.5 }));"
            " return [overlay.querySelector('.readout').textContent, [before, count()],"
            " Object.values(ends.difference)]; })",
            [[2, 2.5], [2.5, 2], [3, 3], [0, 8]],
        )
        self.assertEqual(
            [text.partition("1/Δt ")[2] for text, *_ in answers],
            ["2.0000 Hz", "2.0000 Hz", "– Hz", "0.1250 Hz"],
        )
        self.assertEqual([counts for _, counts, _ in answers], [[0, 2]] * 4)
        self.assertEqual(answers[0][2], [2.5 - 4, 5 - 2, 1])  # lowest, highest, uncertainty

    def test_few_samples_are_drawn_at_their_times(self) -> None:
        """At rates around the bin rate, the drawn line of a sine is the curve itself."""
        width, start, last = 0.0105, 1.7e9, 1.7e9 + 3.0
        rates = {30.0: True, 95.0: True, 100.0: True, 180.0: True, 1e3: False}
        signals, runs = [], []
        for rate in rates:
            times = start + numpy.arange(0.0, 3.0, 1.0 / rate)
            # With a slope, so that all values differ.
            values = numpy.sin(2.0 * math.pi * (times - start)) + 0.1 * (times - start)
            view = LiveView(View(200 * width, 200, None))
            view.select(["/f"])

            def until(moment: float) -> Samples:
                return times[times <= moment], values[times <= moment]

            moments = numpy.append(numpy.arange(start, last, 0.03), last).tolist()
            signals.append(dict(zip(values.tolist(), times.tolist())))
            runs.append(
                [
                    view.frame(moment, lambda *_: until(moment), lambda since: since)
                    for moment in moments
                ]
            )
        answers = self.browser.call(
            "state/buffer.js",
            "a[0].map((frames) => { const buffer = new module.TraceBuffer();"
            " frames.forEach((frame) => frame && buffer.apply(frame, 2.1));"
            " return buffer.rows(['/f'], a[1]); })",
            runs,
            start,
        )
        self.assertEqual(len(answers), len(rates))
        for (rate, is_exact), known, rows in zip(rates.items(), signals, answers):
            drawn = numpy.array(rows, float)
            self.assertGreater(len(drawn), 0.8 * min(rate * 2.1, 400))
            self.assertTrue((numpy.diff(drawn[:, 0]) >= 0.0).all())
            apart = [abs(start + time - known[value]) / width for time, value in drawn.tolist()]
            self.assertLess(max(apart), 0.07 if is_exact else 1.0, rate)

    def test_references_are_named_and_limited_to_eight(self) -> None:
        values = [0, 0, 1, 1, 2, 2, 3, 3]
        texts, can_keep, found = self.browser.call(
            "state/references.js",
            "await (async () => { const { State } = await import('/static/js/state/store.js');"
            " const { TraceBuffer } = await import('/static/js/state/buffer.js');"
            " const buffer = new TraceBuffer(); buffer.apply({ now: 104, bin: 1, reset: true,"
            " first: 100, traces: { f: a[0] } }, 4); const state = new State(); const can = [];"
            " const shown = { buffer, reference: 104, from: 100, to: 104 };"
            " for (let count = 0; count < 8; count += 1) {"
            " can.push(module.canKeep(state.values, 'f'));"
            " module.keepReference(state, shown, 'f', new Map()); }"
            " can.push(module.canKeep(state.values, 'f')); module.removeReference(state, 'R1');"
            " module.moveReference(state, 'R3', { later: 1.5, offset: -10 });"
            " module.keepReference(state, shown, 'f', new Map());"
            " const { references } = state.values;"
            " return [references.map((one) => module.referenceText(one).replace(/kept [\\d:]+/,"
            " 'kept')), can, [-3.5, -0.5, -2, 0.9, 1.6].map((time) =>"
            " module.valueOf(references[1], time)?.low ?? null)]; })()",
            values,
        )
        plain = [f"R{number}: f, kept" for number in (2, 4, 5, 6, 7, 8, 1)]
        self.assertEqual(texts, [plain[0], "R3: f, kept, − 10, 1.5 s later", *plain[1:]])
        self.assertEqual(can_keep, [True] * 8 + [False])
        # Moved by 1.5 s: no value before or after, and interpolated in between.
        expected = [None, -8.5, -10, -7.1, None]
        self.assertEqual([one if one is None else round(one, 6) for one in found], expected)

    def test_answer_about_an_earlier_text_is_not_used(self) -> None:
        problems = self.browser.call(
            "choose/formula.js",
            """(() => {
              const state = { values: { fields: ["/a"] } };
              const entry = new module.FormulaEntry(state, () => {}, () => {});
              const seen = () => entry.answer?.text ?? null;
              entry.ask("=a");
              entry.take({ text: "=a", functions: [] });
              const known = seen();
              entry.ask("=2*a");
              const asked = seen();
              entry.take({ text: "=a", functions: [] });
              return [known, asked, seen()];
            })()""",
        )
        self.assertEqual(problems, ["=a", None, None])

    def test_button_of_a_managed_node_keeps_the_focus(self) -> None:
        focused = self.browser.call(
            "controls/managed.js",
            """(() => {
              const show = module.startManaged({ values: { readonly: false } }, () => {});
              const nodes = (state) => ["/a", "/b"].map((node) =>
                ({ node, state, transitions: ["configure", "shutdown"] }));
              show({ nodes: nodes("unconfigured") });
              document.querySelector("[aria-label='/b: shutdown']").focus();
              show({ nodes: nodes("inactive") });
              const label = document.activeElement.getAttribute("aria-label");
              show({ nodes: [] });
              return label;
            })()""",
        )
        self.assertEqual(focused, "/b: shutdown")

    def test_legend_of_a_picture_has_the_dashes_of_the_traces(self) -> None:
        strokes, states = self.browser.call(
            "measure/picture.js",
            """(() => {
              const cursor = document.createElement("div");
              cursor.className = "handle cursor";
              document.getElementById("overlay").append(cursor);
              const { prototype } = CanvasRenderingContext2D;
              const { save, restore } = prototype;
              let states = 0; // that are saved and not restored
              prototype.save = function () { states += 1; save.call(this); };
              prototype.restore = function () { states -= 1; restore.call(this); };
              const strokes = a[0].map((dash) => {
              const row = document.createElement("tr");
              row.dataset.field = "/a";
              document.getElementById("legend").append(row);
              const element = document.createElement("div");
              element.style.cssText = "position: fixed; width: 500px; height: 50px";
              document.body.append(element);
              const style = { colourOf: () => "#ff0000", dashOf: () => dash,
                labelOf: (field) => field, notes: [] };
              const drawn = { element, canvases: [], redraw() {} };
              const canvas = module.picture(drawn, ["/a"], style, 0);
              row.remove();
              element.remove();
              const { width, height } = canvas;
              const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
              const isRed = (x, y) => data[4 * (y * width + x)] > 250 &&
                data[4 * (y * width + x) + 1] < 5;
              const starts = (y) => Array.from({ length: width - 1 }, (_, x) => x + 1)
                .filter((x) => isRed(x, y) && !isRed(x - 1, y)).length;
              return Math.max(...Array.from({ length: height }, (_, y) => starts(y)));
              });
              Object.assign(prototype, { save, restore });
              cursor.remove();
              return [strokes, states];
            })()""",
            [[], [9, 4]],
        )
        self.assertEqual((strokes, states), ([1, 2], 0))

    def test_layers_behind_a_trace_have_the_scale_of_its_axis(self) -> None:
        heights = self.browser.call(
            "plot/dygraph_view.js",
            """(() => {
              const drawn = [];
              const draw = (_context, _area, _lines, fields, { up }) => {
                drawn.push(...fields.map((field) => up(field, 1)));
              };
              const plot = { shown: { earlier: [new Map()] }, earlier: { draw },
                fields: ["/left", "/right"],
                state: { values: { references: [], right: new Set(["/right"]) } } };
              const graph = { toDomYCoord: (value, axis) => value + 10 * axis };
              module.Plot.prototype.drawBehind.call(plot, null, {}, graph);
              return drawn;
            })()""",
        )
        self.assertEqual(heights, [1, 11])

    def test_reference_is_drawn_inside_the_plot_only(self) -> None:
        painted = self.browser.call(
            "plot/reference_lines.js",
            """(() => {
              const canvas = document.createElement("canvas");
              Object.assign(canvas, { width: 100, height: 50 });
              const context = canvas.getContext("2d");
              const lines = new Map([["/a", { points: [0, 25, 100, 25], steps: false }]]);
              const plot = { colourOf: () => "#ff0000", across: (x) => x, up: (_, y) => y };
              module.drawReferences(context, { x: 20, y: 5, w: 60, h: 40 },
                [{ name: "", field: "/a", lines }], ["/a"], plot);
              const isPainted = (x) => context.getImageData(x, 24, 1, 2).data.some((part) => part);
              return a[0].map(isPainted);
            })()""",
            [10, 25, 75, 90],
        )
        self.assertEqual(painted, [False, True, True, False])

    def test_goal_without_a_heading_points_away_from_the_robot(self) -> None:
        sent = self.browser.call(
            "robots/goals.js",
            """(() => {
              const sent = [];
              const robot = { x: 1, y: 1, frame: "map" };
              const goals = new module.Goals((goal) => sent.push(goal), () => robot, () => {});
              for (const heading of ["", "-90"]) {
                for (const [name, text] of Object.entries({ x: "1", y: "3", heading })) {
                  document.getElementById(`goal-${name}`).value = text;
                }
                goals.sendTyped();
              }
              return sent.map(({ x, y, heading, frame }) =>
                [x, y, (heading * 180) / Math.PI, frame]);
            })()""",
        )
        self.assertEqual(sent, [[1, 3, 90, "map"], [1, 3, -90, "map"]])

    def test_line_through_bins_is_short(self) -> None:
        values = [0, 1, 1, 2, None, None, 0, 1.5]  # up, and down again
        rows = self.browser.call(
            "state/buffer.js",
            "(() => { const buffer = new module.TraceBuffer(); buffer.apply("
            "{now: 4, bin: 1, reset: true, first: 0, traces: {f: a[0]}}, 9);"
            " return buffer.rows(['f'], 4); })()",
            values,
        )
        self.assertEqual([row[1] for row in rows], [0, 1, 1, 2, 1.5, 0])
        self.assertEqual([row[0] for row in rows], [-3.5, -3.5, -2.5, -2.5, -0.5, -0.5])

    def test_slider_range_contains_the_value(self) -> None:
        cases: List[Dict[str, Any]] = [
            {"kind": "float", "minimum": 0, "maximum": 1e9, "value": 2.0},
            {"kind": "float", "minimum": -1e6, "maximum": 1e6, "value": -6.28},
            {"kind": "float", "above": 0, "below": 1, "value": 0.5},
            {"kind": "int", "minimum": 1, "maximum": 8, "value": 3},
            {"kind": "float", "value": 0},
            {"kind": "float", "minimum": 100, "maximum": 1e6, "value": 150},
        ]
        answers = self.browser.call(
            "controls/slider.js", "a[0].map((one) => module.travel(one, one.value))", cases
        )
        self.assertEqual(len(answers), len(cases))
        for case, travel in zip(cases, answers):
            low, high = travel["low"], travel["high"]
            self.assertTrue(low <= case["value"] <= high, (case, travel))
            self.assertTrue(case.get("minimum", low) <= low < high <= case.get("maximum", high))
            self.assertTrue(case.get("above", low - 1) < low and high < case.get("below", high + 1))
            self.assertLess(high - low, 50 * max(abs(case["value"]), 1), (case, travel))
            self.assertGreater((high - low) / travel["step"], 6, (case, travel))

    def test_slider_ignores_the_reply_to_an_earlier_value(self) -> None:
        ends = {"minimum": 0, "maximum": 10, "labels": []}
        parameter = {"name": "level", "kind": "float", "value": 1, **ends}
        places = self.browser.call(
            "controls/parameter.js",
            "(() => { const it = new module.Parameter(a[0], false, () => {});"
            " const placeAfter = (value) => { it.update(value); return it.slider.value; };"
            " const anybodys = placeAfter(4);"
            " it.slider.value = 3;"
            " it.slider.dispatchEvent(new Event('change'));"
            " return [anybodys, placeAfter(2), placeAfter(3), it.control.value]; })()",
            parameter,
        )
        self.assertEqual(places, ["4", "3", "3", "3"])

    def test_escape_withdraws_a_rejected_value(self) -> None:
        parameter = {"name": "level", "kind": "float", "value": 1, "labels": []}
        reply = self.browser.call(
            "controls/parameter.js",
            "(() => { const sent = [];"
            " const it = new module.Parameter(a[0], false, (value) => sent.push(value));"
            " it.control.value = '7'; it.control.dispatchEvent(new Event('change'));"
            " it.refuse('must be below 5', true);"
            " it.control.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }));"
            " const first = [...sent];"
            " it.control.value = '8';"
            " it.control.dispatchEvent(new KeyboardEvent('keydown', { key: 'Escape' }));"
            " return [first, it.control.value, it.refusal.hidden, sent.length]; })()",
            parameter,
        )
        self.assertEqual(reply, [[7, 1], "1", True, 2])  # a typed value has not been sent

    def test_long_names_are_broken_after_their_parts(self) -> None:
        wrapped = self.browser.call(
            "measure/picture.js",
            "a.map(([name, most]) => module.wrapped(name, most, (text) => text.length))",
            ["/robot/joint_states/position", 14],
            ["/robot/x", 30],
            ["/" + "y" * 20, 8],
        )
        self.assertEqual(
            wrapped,
            [
                ["/robot", "/joint_states", "/position"],
                ["/robot/x"],
                ["/yyyyyyy", "y" * 8, "y" * 5],
            ],
        )

    def test_names_are_in_natural_order(self) -> None:
        names = ["/group10/a", "/group2/b", "/group2/a", "/group2", "/group2_b/a", "/a/10", "/a/9"]
        order = ["/a/9", "/a/10", "/group2", "/group2/a", "/group2/b", "/group2_b/a", "/group10/a"]
        self.assertEqual(
            self.browser.call("base/names.js", "a[0].sort(module.byName)", names), order
        )

    def test_choices_are_grouped_with_useful_fields_first(self) -> None:
        types = {
            "/rosout": "rosgraph_msgs/Log",
            "/n/parameter_updates": "dynamic_reconfigure/Config",
            "/robot10/j": "sensor_msgs/JointState",
            "/robot2/j": "sensor_msgs/JointState",
            "/scan": "sensor_msgs/LaserScan",
        }
        fields = ["/rosout/level", "/n/parameter_updates/ints[0]/value"]
        for robot in ("/robot10/j", "/robot2/j"):
            fields += [f"{robot}/header/stamp", f"{robot}/position[arm]", f"{robot}/position[leg]"]
        fields += ["/scan/header/seq", "/scan/ranges[0]", "/scan/ranges[1]"]
        choices = [
            {
                "field": field,
                "datatype": "float64",
                "topic": next(topic for topic in types if field.startswith(topic + "/")),
            }
            for field in fields
        ]

        robot = ["/robot2/j/position[arm]", "/robot2/j/position[leg]", "/robot2/j/header/stamp"]
        # Typed text, whether all are shown, the first results of each group, and the hidden count.
        firsts = [robot[0], "/robot10/j/position[arm]", "/scan/ranges[0]"]
        cases: List[Any] = [("", False, firsts, 2), ("rosout", False, [], 1)]
        cases += [("rosout", True, ["/rosout/level"], 0)]
        # Any element can be found, by its index or by its name.
        cases += [("ranges[359]", False, ["/scan/ranges[359]"], 0)]
        cases += [("robot2 LEG", False, ["/robot2/j/position[leg]"], 0)]
        cases += [("robot2 [tail]", False, ["/robot2/j/position[tail]"], 0)]
        cases += [("laserscan seq", False, ["/scan/header/seq"], 0), ("", True, None, 0)]
        answers = self.browser.call(
            "choose/field_list.js",
            "a[2].map(([text, all]) => module.found(a[0], a[1], text, all))",
            choices,
            types,
            [case[:2] for case in cases],
        )
        groups = [
            [[one["field"] for one in group["fields"]] for group in reply["groups"]]
            for reply in answers
        ]
        self.assertEqual(len(answers), len(cases))
        for (text, _, expected, hidden), reply, found in zip(cases, answers, groups):
            self.assertEqual(reply["hidden"], hidden, text)
            self.assertEqual(reply["count"], sum(map(len, found)), text)
            if expected is not None:
                self.assertEqual([group[0] for group in found], expected, text)
        self.assertEqual(groups[0][0], robot)
        self.assertTrue(all(len(group) == 1 for found in groups[2:-1] for group in found), groups)
        self.assertEqual(len(groups[-1]), 5)
        nested = {"field": "/m/poses[0]/joints[0]/angle", "datatype": "float64", "topic": "/m"}
        for typed, field in (
            ("[7]", "/m/poses[7]/joints[7]/angle"),
            ("[7] [8]", "/m/poses[7]/joints[8]/angle"),
        ):
            reply = self.browser.call(
                "choose/field_list.js",
                "module.found(a[0], a[2], a[1], true)",
                [nested],
                typed,
                {"/m": "a/B"},
            )
            self.assertEqual(reply["groups"][0]["fields"][0]["field"], field)

    def test_layers_are_ordered_except_backward_edges(self) -> None:
        items = [{"id": name} for name in "abcd"]
        edges = [{"from": a, "to": b} for a, b in ("ab", "bc", "ca", "ad", "cd")]
        layers = self.browser.call(
            "graph/layout.js", "Object.fromEntries(module.layersOf(a[0], a[1]))", items, edges
        )
        self.assertEqual(layers, {"a": 0, "b": 1, "c": 2, "d": 3})

    def test_odometries_are_grouped_by_namespace_and_frame(self) -> None:
        reply = [("/a/ground_truth", "base"), ("/a/odom", "base"), ("/b/odom", "base")]
        reply += [("/c/x", ""), ("/c/y", ""), ("/d/x", "base"), ("/d/y", "base")]
        robots = self.browser.call(
            "robots/odometries.js",
            "module.robotsOf(a[0].map(([topic, body]) => ({ topic, body })))"
            ".map(({ topic, others }) => [topic, ...others.map((other) => other.topic)])",
            reply,
        )
        once = [["/a/odom", "/a/ground_truth"], ["/b/odom"], ["/c/x"], ["/c/y"], ["/d/x", "/d/y"]]
        self.assertEqual(robots, once)

    def test_nothing_overlaps_in_the_graph(self) -> None:
        dice = random.Random(8)
        graphs = [_random_graph(dice) for _ in range(150)]
        layouts = self.browser.call(
            "graph/layout.js",
            "a[0].map(([items, edges]) => { const made = module.layOut(items, edges);"
            " return {...made, places: Object.fromEntries(made.places),"
            " routes: Object.fromEntries(made.routes)}; })",
            graphs,
        )
        self.assertEqual(len(layouts), len(graphs))
        for (items, edges), layout in zip(graphs, layouts):
            boxes = {name: _box(place) for name, place in layout["places"].items()}
            self.assertEqual(set(boxes), {item["id"] for item in items})
            names = sorted(boxes)
            for index, one in enumerate(names):
                for other in names[:index]:
                    self.assertFalse(_overlap(boxes[one], boxes[other]), (items, edges))
            frames = {
                group["name"]: (
                    group["x"],
                    group["y"],
                    group["x"] + group["width"],
                    group["y"] + group["height"],
                )
                for group in layout["groups"]
            }
            for item in items:
                for name, frame in frames.items():
                    inside = item["group"] == name or item["group"].startswith(name + "/")
                    self.assertEqual(_overlap(boxes[item["id"]], frame), inside, (items, edges))
                    if inside:  # and below its title
                        self.assertGreater(boxes[item["id"]][1], frame[1] + 16.0)
            for way, stops in layout["routes"].items():
                for stop in stops:  # a long edge does not cross a box
                    place = stop["x"], stop["y"], stop["x"], stop["y"]
                    self.assertFalse(
                        any(_overlap(place, box) for box in boxes.values()), (way, items, edges)
                    )
            for x1, y1, x2, y2 in [*boxes.values(), *frames.values()]:
                self.assertTrue(0 <= x1 and x2 <= layout["width"])
                self.assertTrue(0 <= y1 and y2 <= layout["height"])


def _random_graph(dice: random.Random) -> Any:
    groups = ["", "/a", "/a/b", "/a/b/c", "/ab", "/z"]
    items = [
        {
            "id": f"i{number}",
            "group": dice.choice(groups),
            "width": dice.randint(40, 200),
            "height": dice.randint(30, 50),
        }
        for number in range(dice.randint(1, 14))
    ]
    names = [item["id"] for item in items]
    count = dice.randint(0, 2 * len(items))
    edges = [{"from": dice.choice(names), "to": dice.choice(names)} for _ in range(count)]
    return items, edges


def _box(place: Dict[str, float]) -> Any:
    wide, high = place["width"] / 2, place["height"] / 2
    return place["x"] - wide, place["y"] - high, place["x"] + wide, place["y"] + high


def _overlap(one: Any, other: Any) -> bool:
    return bool(one[0] < other[2] and other[0] < one[2] and one[1] < other[3] and other[1] < one[3])
