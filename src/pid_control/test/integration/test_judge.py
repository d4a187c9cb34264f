#!/usr/bin/env python3
"""Test of the judge: a diagnosis, its picture and its files."""

from xml.etree import ElementTree

from helpers.judge_rig import CONTROLLERS, JudgeCase

from nodekit.testing.running import rosrun


class Judge(JudgeCase):
    """Errors in arguments are in the unit tests, all else in test/extended."""

    def test_judge_windup_is_reported_drawn_and_written(self) -> None:
        picture, table = self.folder / "windup.svg", self.folder / "windup.csv"
        files = ["--picture", picture, "--csv", table]
        limits = self.folder / "limits.yaml"
        limits.write_text("windup: {peak_input: 0.5}\n")
        xml = self.folder / "windup.xml"
        text = self.assert_judged(
            1,
            "the integral keeps growing while the output is limited; stop it there",
            *[*files, "--limits", limits, "--only", "windup"],
            *[CONTROLLERS / "flaw_windup.py", f"--gtest_output=xml:{xml}", "__name:=judge"],
        )
        self.assertIn("windup: largest |input| 1, at most 0.5", text)
        self.assertIn("the input is within -1 and 1, but beyond the limit for it", text)
        self.assertTrue(text.endswith("failed: no clamp, windup\n"), text)
        self.assertIn("windup", ElementTree.parse(str(picture)).getroot()[-1][0].text)
        self.assertIn('failed,"no clamp, windup"', table.read_text())
        suite = ElementTree.parse(str(xml)).getroot()
        self.assertEqual((suite.get("tests"), suite.get("failures")), ("1", "1"))


if __name__ == "__main__":
    rosrun("pid_control", "judge", Judge)
