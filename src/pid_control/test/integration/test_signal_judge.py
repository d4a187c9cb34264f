#!/usr/bin/env python3
"""Test of the judge of the first coursework: a verdict, its cause, its picture and its files."""

from xml.etree import ElementTree

from helpers.coursework_cases import BELOW_ZERO, COURSEWORKS, make
from helpers.judge_rig import PACKAGE, JudgeCase

from nodekit.testing.running import extended, rosrun


class SignalJudge(JudgeCase):
    """Two courseworks; the others are in test/extended, errors in arguments in the unit tests."""

    program = PACKAGE / "scripts" / "judge_signals"

    @extended
    def test_good_coursework_passes(self) -> None:
        text = self.assert_judged(
            0,
            "passed: all 16 figures of 3 scenarios",
            *["--only", "launch,signal,process", COURSEWORKS / "sine_classes"],
        )
        self.assertIn("source.py is the signal generator, processor.py the process node", text)
        self.assertIn("signal: /lab/wave/level; output: /lab/processed/data", text)

    def test_negative_output_is_reported_drawn_and_written(self) -> None:
        picture, table, xml = (self.folder / name for name in ("x.svg", "x.csv", "x.xml"))
        text = self.assert_judged(
            1,
            BELOW_ZERO.says[0],
            *[
                "--picture",
                picture,
                "--csv",
                table,
                "--only",
                "process",
                make(BELOW_ZERO, self.folder),
            ],
            *[f"--gtest_output=xml:{xml}", "__name:=judge"],
        )
        self.assertTrue(text.endswith("failed: negative\n"), text)
        ElementTree.parse(str(picture))
        self.assertIn("/proc_signal/data", picture.read_text())
        self.assertIn(",failed,negative,", table.read_text())
        suite = ElementTree.parse(str(xml)).getroot()
        self.assertEqual((suite.get("tests"), suite.get("failures")), ("1", "1"))


if __name__ == "__main__":
    rosrun("pid_control", "signal_judge", SignalJudge)
